#include "source_monitor.hpp"

#include <algorithm>
#include <cmath>

namespace downrange {
namespace {

constexpr int distrusted_after = 10;  ///< rejected this often in a row, a source is not to be trusted

}  // namespace

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

SourceMonitor::SourceMonitor(const RangeConfig& config) : sources_(config), accounts_(sources_.size()) {}

void SourceMonitor::count(const Observation& o) {
  const SourceKind kind = kind_of(o.measured);
  const SourceId source = sources_.find(kind, o.sensor);
  Account& account = source == no_source ? unknown_ : accounts_[static_cast<std::size_t>(source)];
  ++account.messages;
  ++account.count[static_cast<std::size_t>(o.verdict)];
  if (plausible(o.received)) account.newest = o.received;
  // A station whose every fix another one relayed before does its work.
  const bool good = o.verdict == Reason::Accepted || (kind == SourceKind::Telemetry && o.verdict == Reason::Duplicate);
  account.rejected_in_row = good ? 0 : account.rejected_in_row + 1;
  if (!good) account.rejected_for = o.verdict;
  if (o.verdict == Reason::UnknownSource) return;
  account.target = o.target;
  if (o.verdict != Reason::Accepted) return;  // a rejected sample's epoch may be anything
  constexpr double weight = 1.0 / 20;         // latency: mean over about the last 20 messages
  const double latency = (o.received - o.epoch).seconds();
  account.latency_s += (account.seen ? weight : 1.0) * (latency - account.latency_s);
  account.seen = true;
}

void SourceMonitor::report(Time tick, const Method* method, ResultSink& sink) {
  for (SourceId id = 0; id < static_cast<SourceId>(sources_.size()); ++id) {
    Account& account = accounts_[static_cast<std::size_t>(id)];
    SourceHealth h = health(tick, sources_[id].name, account);
    int gated_in_row = 0;
    if (method != nullptr) {
      const SourceAccount& of_method = method->account(id);
      add(of_method, account, h);
      gated_in_row = of_method.rejected_in_row;
    }
    qualify(tick, sources_[id], account, gated_in_row, h);
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

void SourceMonitor::add(const SourceAccount& of_method, Account& account, SourceHealth& health) {
  const std::uint64_t rejected = of_method.gated + of_method.frozen;
  auto& accepted = health.count[static_cast<std::size_t>(Reason::Accepted)];
  accepted -= std::min(rejected, accepted);
  health.count[static_cast<std::size_t>(Reason::Gated)] = of_method.gated;
  health.count[static_cast<std::size_t>(Reason::Frozen)] = of_method.frozen;
  health.residual_mean = of_method.residual.mean;
  const double variance = of_method.residual.mean_square - of_method.residual.mean * of_method.residual.mean;
  health.residual_sigma = std::sqrt(std::max(variance, 0.0));
  health.nis = of_method.residual.nis_per_dof;
  health.nis_inside_95 = of_method.mismatch.share();
  health.nis_count = of_method.mismatch.innovations();
  health.mismatch = of_method.mismatch.rings();
  account.frozen = of_method.rejected_in_row > 0 && (account.frozen || of_method.frozen != account.reported_frozen);
  account.reported_frozen = of_method.frozen;
}

void SourceMonitor::qualify(Time tick, const Source& source, const Account& account, int gated_in_row,
                            SourceHealth& health) {
  const auto rejected = [&](Reason reason) {
    health.why = Disqualification::Rejected;
    health.rejected_for = reason;
  };
  if (account.messages == 0 || tick - account.newest > source.silent_after) {
    health.why = Disqualification::Silent;
  } else if (account.rejected_in_row >= distrusted_after) {
    rejected(account.rejected_for);
  } else if (account.frozen) {
    rejected(Reason::Frozen);
  } else if (gated_in_row >= distrusted_after) {
    rejected(Reason::Gated);
  }
  health.qualified = health.why == Disqualification::None;
}

}  // namespace downrange
