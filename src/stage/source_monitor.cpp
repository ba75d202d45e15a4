#include "source_monitor.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace downrange {

SourceMonitor::SourceMonitor(const RangeConfig& config) {
  const auto add = [&](const auto& entries, ObservationKind kind) {
    for (const auto& entry : entries) {
      Source s;
      s.sensor = entry.id;
      s.kind = kind;
      s.account = static_cast<int>(sources_.size());
      sources_.push_back(s);
    }
  };
  add(config.radars, ObservationKind::Radar);
  add(config.angle_sensors, ObservationKind::Angles);
  add(config.telemetry, ObservationKind::Gps);
  Source unknown;
  unknown.sensor = "(not configured)";
  sources_.push_back(unknown);
}

void SourceMonitor::count(const Observation& o) {
  // A radar and a station may share a name: look only among the sources of the observation's kind.
  const auto found = std::find_if(sources_.begin(), std::prev(sources_.end()),
                                  [&](const Source& s) { return s.kind == o.kind && s.sensor == o.sensor; });
  Source* source = &*found;  // the last one: whoever is not configured
  ++source->messages;
  ++source->count[static_cast<std::size_t>(o.verdict)];
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
    bool trusted = true;
    if (method != nullptr && s.account >= 0) {
      const SourceAccount& account = method->account(s.account);
      const std::uint64_t rejected = account.gated + account.frozen;
      auto& accepted = h.count[static_cast<std::size_t>(Reason::Accepted)];
      accepted -= std::min(rejected, accepted);
      h.count[static_cast<std::size_t>(Reason::Gated)] = account.gated;
      h.count[static_cast<std::size_t>(Reason::Frozen)] = account.frozen;
      h.residual_mean = account.residual.mean;
      const double variance = account.residual.mean_square - account.residual.mean * account.residual.mean;
      h.residual_sigma = std::sqrt(std::max(variance, 0.0));
      h.nis = account.residual.nis_per_dof;
      constexpr int mostly = 10;  // rejected this often in a row, a source is not to be trusted
      trusted = account.rejected_in_row < mostly;
    }
    h.qualified = trusted && messages > 0 && s.account >= 0;
    sink.emit(h);
  }
}

}  // namespace downrange
