#include "source_monitor.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace downrange {
namespace {

constexpr int mostly = 10;  ///< rejected this often in a row, a source is not to be trusted

}  // namespace

std::string_view why_not_qualified(const SourceHealth& health) {
  switch (health.why) {
    case Disqualification::Silent:
      return "silent";
    case Disqualification::Rejected:
      return to_string(health.rejected_for);
    case Disqualification::None:
      break;
  }
  return {};
}

SourceMonitor::SourceMonitor(const RangeConfig& config) {
  for (const downrange::Source& configured : SourceTable(config)) {
    Source s;
    s.sensor = configured.name;
    s.kind = configured.kind;
    s.account = static_cast<int>(sources_.size());
    s.silent_after = configured.silent_after;
    sources_.push_back(s);
  }
  Source unknown;
  unknown.sensor = "(not configured)";
  sources_.push_back(unknown);
}

void SourceMonitor::count(const Observation& o) {
  // Sources of one name are of different kinds (an unknown station may call itself as a radar does).
  const auto found = std::find_if(sources_.begin(), std::prev(sources_.end()),
                                  [&](const Source& s) { return s.kind == kind_of(o.kind) && s.sensor == o.sensor; });
  Source* source = &*found;  // the last one: whoever is not configured
  ++source->messages;
  ++source->count[static_cast<std::size_t>(o.verdict)];
  if (plausible(o.received)) source->newest = o.received;
  // A station whose every fix another one relayed before does its work.
  const bool good = o.verdict == Reason::Accepted || (o.kind == ObservationKind::Gps && o.verdict == Reason::Duplicate);
  source->rejected_in_row = good ? 0 : source->rejected_in_row + 1;
  if (!good) source->rejected_for = o.verdict;
  if (o.verdict == Reason::UnknownSource) return;
  source->target = o.target;
  if (o.verdict != Reason::Accepted) return;  // a rejected sample's epoch may be anything
  constexpr double weight = 1.0 / 20;         // latency: mean over about the last 20 messages
  const double latency = (o.received - o.epoch).seconds();
  source->latency_s += (source->seen ? weight : 1.0) * (latency - source->latency_s);
  source->seen = true;
}

void SourceMonitor::report(Time tick, const Method* method, ResultSink& sink) {
  for (Source& s : sources_) {
    const auto messages = static_cast<double>(s.messages - s.reported_messages);
    s.reported_messages = s.messages;
    if (s.messages == 0) continue;
    SourceHealth h;
    h.sensor = s.sensor;
    h.target = s.target;
    h.time = tick;
    h.rate_hz = messages;
    h.latency_s = s.latency_s;
    h.count = s.count;
    int gated_in_row = 0;
    if (method != nullptr && s.account >= 0) {
      const SourceAccount& account = method->account(s.account);
      add(account, s, h);
      gated_in_row = account.rejected_in_row;
    }
    qualify(tick, s, gated_in_row, h);
    sink.emit(h);
  }
}

void SourceMonitor::add(const SourceAccount& account, Source& source, SourceHealth& health) {
  const std::uint64_t rejected = account.gated + account.frozen;
  auto& accepted = health.count[static_cast<std::size_t>(Reason::Accepted)];
  accepted -= std::min(rejected, accepted);
  health.count[static_cast<std::size_t>(Reason::Gated)] = account.gated;
  health.count[static_cast<std::size_t>(Reason::Frozen)] = account.frozen;
  health.residual_mean = account.residual.mean;
  const double variance = account.residual.mean_square - account.residual.mean * account.residual.mean;
  health.residual_sigma = std::sqrt(std::max(variance, 0.0));
  health.nis = account.residual.nis_per_dof;
  health.nis_inside_95 = account.mismatch.share();
  health.nis_count = account.mismatch.innovations();
  health.mismatch = account.mismatch.rings();
  source.frozen = account.rejected_in_row > 0 && (source.frozen || account.frozen != source.reported_frozen);
  source.reported_frozen = account.frozen;
}

void SourceMonitor::qualify(Time tick, const Source& source, int gated_in_row, SourceHealth& health) {
  const auto rejected = [&](Reason reason) {
    health.why = Disqualification::Rejected;
    health.rejected_for = reason;
  };
  if (source.account < 0) {
    rejected(Reason::UnknownSource);
  } else if (tick - source.newest > source.silent_after) {
    health.why = Disqualification::Silent;
  } else if (source.rejected_in_row >= mostly) {
    rejected(source.rejected_for);
  } else if (source.frozen) {
    rejected(Reason::Frozen);
  } else if (gated_in_row >= mostly) {
    rejected(Reason::Gated);
  }
  health.qualified = health.why == Disqualification::None;
}

}  // namespace downrange
