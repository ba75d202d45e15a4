#include "source_monitor.hpp"

#include <algorithm>
#include <cmath>

namespace downrange {
namespace {

/// Everything rejected for so long, and at least so often: not to be trusted. The same for every source: by counts
/// alone a fast radar would ring long before GPS does.
constexpr Duration distrusted_after = milliseconds(2000);
constexpr int distrusted_count = 3;

bool distrusted(Time tick, Time since, int in_row) {
  return in_row >= distrusted_count && tick - since >= distrusted_after;
}

}  // namespace

double figure_of_merit(const SourceHealth& health) {
  constexpr double right = 0.95;
  if (!health.qualified) return 0;
  const double inside = health.nis_count > 0 ? std::min(health.nis_inside_95 / right, 1.0) : 1;
  return inside / std::max(std::ranges::max(health.sigma_ratio), 1.0);
}

std::string_view why_not_qualified(const SourceHealth& health) {
  switch (health.why) {
    case Disqualification::Silent:
      return std::ranges::all_of(health.count, [](std::uint64_t n) { return n == 0; }) ? "silent since start"
                                                                                       : "silent";
    case Disqualification::Rejected:
      return to_string(health.rejected_for);
    case Disqualification::Inhibited:
      return "inhibited";
    case Disqualification::Excluded:
      return "excluded";
    case Disqualification::None:
      break;
  }
  return {};
}

SourceMonitor::SourceMonitor(const RangeConfig& config)
    : sources_(config), accounts_(sources_.size()), verdicts_(config.targets.size() * sources_.size()) {
  for (const TargetConfig& target : config.targets) targets_.push_back(target.id);
}

void SourceMonitor::note(const Integrity& record) {
  const std::optional<std::size_t> first = verdicts_of(record.target);
  if (!first) return;
  for (const SourceIntegrity& source : record.sources) {
    const SourceId id = sources_.find(source.sensor);
    if (id == no_source) continue;
    verdicts_[*first + static_cast<std::size_t>(id)] = {source.verdict, source.since, source.by};
  }
}

std::optional<std::size_t> SourceMonitor::verdicts_of(const Name& target) const {
  const auto found = std::ranges::find(targets_, target);
  if (found == targets_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - targets_.begin()) * sources_.size();
}

bool SourceMonitor::doubted(const Observation& o) const {
  const std::optional<std::size_t> first = verdicts_of(o.target);
  const SourceId source = sources_.find(kind_of(o.measured), o.sensor);
  return first && source != no_source &&
         verdicts_[*first + static_cast<std::size_t>(source)].verdict != IntegrityVerdict::Agrees;
}

const SourceMonitor::Verdict& SourceMonitor::verdict_on(SourceId source) const {
  // Agrees, suspect, ambiguous, excluded.
  const auto rank = [](const Verdict& v) {
    return v.verdict == IntegrityVerdict::Excluded ? 4 : static_cast<int>(v.verdict);
  };
  std::size_t worst = static_cast<std::size_t>(source);
  for (std::size_t i = worst; i < verdicts_.size(); i += sources_.size()) {
    if (rank(verdicts_[i]) > rank(verdicts_[worst])) worst = i;
  }
  return verdicts_[worst];
}

void SourceMonitor::count(const Observation& o) {
  const SourceKind kind = kind_of(o.measured);
  const SourceId source = sources_.find(kind, o.sensor);
  Account& account = source == no_source ? unknown_ : accounts_[static_cast<std::size_t>(source)];
  ++account.messages;
  ++account.count[static_cast<std::size_t>(o.verdict)];
  if (plausible(o.received)) account.newest = o.received;
  // A station whose every fix another one relayed before does its work.
  const bool good = o.verdict == Reason::Accepted || (kind == SourceKind::Telemetry && o.verdict == Reason::Duplicate);
  if (!good && account.rejected_in_row == 0) account.rejected_since = account.newest;
  account.rejected_in_row = good ? 0 : account.rejected_in_row + 1;
  if (!good) account.rejected_for = o.verdict;
  account.was_good = account.was_good || good;
  if (o.verdict == Reason::UnknownSource) return;
  account.target = o.target;
  if (o.verdict != Reason::Accepted) return;  // a rejected sample's epoch may be anything
  constexpr double weight = 1.0 / 20;         // latency: mean over about the last 20 messages
  const double latency = (o.received - o.epoch).seconds();
  account.latency_s += (account.seen ? weight : 1.0) * (latency - account.latency_s);
  account.seen = true;
}

void SourceMonitor::report(Time tick, const Views& views, ResultSink& sink) {
  for (SourceId id = 0; id < static_cast<SourceId>(sources_.size()); ++id) {
    Account& account = accounts_[static_cast<std::size_t>(id)];
    SourceHealth h = health(tick, sources_[id].name, account);
    const bool excluded = verdict_on(id).verdict == IntegrityVerdict::Excluded;
    if (views.method != nullptr) add(tick, views.method->account(id), excluded, account, h);
    if (views.residuals != nullptr) {
      const ResidualSize size = views.residuals->of(id);
      h.residual_m = size.m;
      h.expected_m = size.expected_m;
      h.residual_rad = size.rad;
      h.expected_rad = size.expected_rad;
    }
    qualify(tick, sources_[id], account, h);
    overrule(id, views.orders, h);
    tell_acknowledged(views.orders != nullptr ? views.orders->acknowledgement_of(id) : nullptr, account, h);
    tell_since(views.orders != nullptr ? views.orders->of(id) : nullptr, verdict_on(id), account, h);
    sink.emit(h);
  }
  if (unknown_.messages == 0) return;
  SourceHealth h = health(tick, "(not configured)", unknown_);
  h.why = Disqualification::Rejected;
  h.rejected_for = Reason::UnknownSource;
  sink.emit(h);
}

SourceHealth SourceMonitor::health(Time tick, const Name& name, Account& account) {
  SourceHealth h;
  h.sensor = name;
  h.target = account.target;
  h.time = tick;
  h.rate_hz = static_cast<double>(account.messages - account.reported_messages);
  h.latency_s = account.latency_s;
  h.count = account.count;
  account.reported_messages = account.messages;
  return h;
}

void SourceMonitor::add(Time tick, const SourceAccount& of_method, bool excluded, Account& account,
                        SourceHealth& health) {
  const std::uint64_t frozen_before = account.frozen_count.counted();
  const std::uint64_t gated = account.gated_count.total(of_method.gated, excluded);
  const std::uint64_t frozen = account.frozen_count.total(of_method.frozen, excluded);
  auto& accepted = health.count[static_cast<std::size_t>(Reason::Accepted)];
  accepted -= std::min(gated + frozen, accepted);
  health.count[static_cast<std::size_t>(Reason::Gated)] = gated;
  health.count[static_cast<std::size_t>(Reason::Frozen)] = frozen;
  health.residual_mean = of_method.residual.mean;
  const double variance = of_method.residual.mean_square - of_method.residual.mean * of_method.residual.mean;
  health.residual_sigma = std::sqrt(std::max(variance, 0.0));
  health.nis = of_method.residual.nis_per_dof;
  health.nis_inside_95 = of_method.mismatch.share();
  health.nis_count = of_method.mismatch.innovations();
  health.mismatch = of_method.mismatch.rings();
  for (std::size_t i = 0; i < health.sigma_ratio.size(); ++i)
    health.sigma_ratio[i] = of_method.noise.sigma_ratio(static_cast<int>(i));
  account.frozen = of_method.rejected_in_row > 0 && (account.frozen || of_method.frozen != frozen_before);
  // What the account shows came within the second before.
  if (of_method.rejected_in_row == 0)
    account.gated_since = tick;
  else if (account.gated_in_row == 0 || of_method.accepted != account.reported_accepted)
    account.gated_since = tick - seconds(1);
  account.reported_accepted = of_method.accepted;
  account.gated_in_row = of_method.rejected_in_row;
}

void SourceMonitor::qualify(Time tick, const Source& source, const Account& account, SourceHealth& health) {
  const auto rejected = [&](Reason reason) {
    health.why = Disqualification::Rejected;
    health.rejected_for = reason;
  };
  if (account.messages == 0 || tick - account.newest > source.silent_after) {
    health.why = Disqualification::Silent;
  } else if ((!account.was_good && account.rejected_in_row > 0) ||  // it has told nothing yet that could be used
             distrusted(tick, account.rejected_since, account.rejected_in_row)) {
    rejected(account.rejected_for);
  } else if (account.frozen) {
    rejected(Reason::Frozen);
  } else if (distrusted(tick, account.gated_since, account.gated_in_row)) {
    rejected(Reason::Gated);
  }
  health.qualified = health.why == Disqualification::None;
}

void SourceMonitor::overrule(SourceId source, const Orders* orders, SourceHealth& health) const {
  const Verdict& verdict = verdict_on(source);
  const StandingOrder* order = orders != nullptr ? orders->of(source) : nullptr;
  health.forced = order != nullptr && order->order == OperatorOrder::Force;
  if (order != nullptr) health.reason = order->reason;
  if (order != nullptr && order->order == OperatorOrder::Inhibit) {
    health.why = Disqualification::Inhibited;
    health.by = order->by;
  } else if (verdict.verdict == IntegrityVerdict::Excluded && health.why != Disqualification::Silent) {
    health.why = Disqualification::Excluded;
    health.by = verdict.by;
  } else if (verdict.verdict != IntegrityVerdict::Agrees) {
    health.suspect = true;
    health.by = verdict.by;
  } else if (health.forced) {
    health.by = order->by;
  }
  health.qualified = health.why == Disqualification::None;
}

void SourceMonitor::tell_acknowledged(const StandingOrder* acknowledgement, Account& account, SourceHealth& health) {
  const bool same =
      health.why == account.why && health.suspect == account.suspect && health.mismatch == account.mismatch;
  if (!same) account.alarm_since = health.time;
  account.mismatch = health.mismatch;
  const bool rings = !health.qualified || health.suspect || health.mismatch;
  if (rings && acknowledgement != nullptr && acknowledgement->since >= account.alarm_since)
    health.acknowledged_by = acknowledgement->by;
}

void SourceMonitor::tell_since(const StandingOrder* order, const Verdict& verdict, Account& account,
                               SourceHealth& health) {
  const bool same = health.why == account.why && health.suspect == account.suspect && health.by == account.by;
  if (!same || account.since == Time{}) {
    account.since = health.time;
    if (health.why == Disqualification::Silent && account.messages > 0) account.since = account.newest;
    if (health.why == Disqualification::Rejected)
      account.since = account.rejected_in_row > 0 ? account.rejected_since : account.gated_since;
    if (health.why == Disqualification::Inhibited) account.since = order->since;
    if (health.why == Disqualification::Excluded || health.suspect) account.since = verdict.since;
  }
  account.why = health.why;
  account.suspect = health.suspect;
  account.by = health.by;
  health.since = account.since;
}

}  // namespace downrange
