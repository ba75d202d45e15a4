#pragma once
/// A simulated flight, run through ingest, a method per chain and the Judge: who is accused of what, and when.

#include <downrange/stage/range_config.hpp>
#include <downrange/stage/source_table.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "allocations.hpp"
#include "sim/simulation.hpp"
#include "small_range.hpp"
#include "stage/ingest.hpp"
#include "stage/integrity/judge.hpp"
#include "stage/integrity_text.hpp"
#include "stage/methods.hpp"

namespace downrange::test {

inline constexpr SourceId goheung = 0;
inline constexpr SourceId jeju = 1;

/// small_range with its pad and the default method; with `third`, a radar in the east.
inline RangeConfig judged_range(bool third = false) {
  RangeConfig c = small_range();
  c.pad = PadConfig{.site = pad()};
  c.fuse.methods = {"joint"};
  if (third) {
    RadarConfig r = c.radars[1];
    r.id = "busan";
    r.site = Site({35.1 * deg, 129.1 * deg, 200});
    r.rate_hz = 10;
    c.radars.push_back(r);
  }
  return c;
}

/// The launch of the example range: biases drawn per seed, coloured errors, outliers, dropouts, latencies.
inline sim::Scenario judged_launch(const RangeConfig& range, double end_s) {
  sim::Scenario s;
  s.name = "launch";
  s.target = "kslv";
  s.liftoff = liftoff;
  s.start_s = -20;
  s.end_s = end_s;
  s.profile = sim::naro_launch_profile();
  const double begin_s[] = {20, 48, 55};
  for (std::size_t i = 0; i < range.radars.size(); ++i) {
    sim::RadarScenario r;
    r.id = range.radars[i].id;
    r.site = range.radars[i].site;
    r.sigma = range.radars[i].sigma;
    r.rate_hz = range.radars[i].rate_hz;
    r.phase_s = 0.013 + 0.018 * static_cast<double>(i);
    r.track = {begin_s[i], end_s};
    r.range_max_m = 4e6;
    r.dropout_probability = 0.02;
    r.outlier_probability = 0.002;
    r.outlier_range_m = 1500;
    r.outlier_angle_rad = 0.5 * deg;
    r.coloured_angle_sigma_rad = 0.004 * deg;
    r.latency_s = 0.06;
    r.latency_jitter_s = 0.02;
    r.bias_sigma.offset = {30, 0.03 * deg, 0.03 * deg};
    r.bias_sigma.scale = {3e-5, 2e-4, 2e-4};
    r.bias_sigma.time_tag_s = 0.005;
    s.radars.push_back(r);
  }
  s.gps.active = {-20, end_s};
  s.gps.sigma_enu_m = {5, 5, 8};
  s.gps.coloured_sigma_enu_m = {2, 2, 2};
  s.gps.sigma_velocity_m_s = 0.2;
  s.gps.latency_s = 0.25;
  for (const TelemetryConfig& station : range.telemetry) {
    sim::StationScenario t;
    t.id = station.id;
    t.site = station.site;
    t.elevation_min_rad = -90 * deg;
    t.delay_s = 0.15;
    t.delay_jitter_s = 0.07;
    t.loss_probability = 0.02;
    s.stations.push_back(t);
  }
  return s;
}

/// A change of a verdict.
struct Said {
  double t_s = 0;  ///< after lift-off
  SourceId source = 0;
  Judgement judgement;
};

struct JudgedFlight {
  std::vector<Said> said;
  double largest_value = 0;  ///< of all pairs and ticks, in units of the threshold
  double largest_at_s = 0;
  std::size_t allocations = 0;  ///< of the Judge, after its construction

  /// The first of the kind after `from_s`; none: never.
  [[nodiscard]] std::optional<double> first(SourceId source, IntegrityVerdict verdict, double from_s = -1e9) const {
    for (const Said& s : said) {
      if (s.source == source && s.judgement.verdict == verdict && s.t_s >= from_s) return s.t_s;
    }
    return std::nullopt;
  }
};

/// All that was said, for the message of a test that fails.
inline std::string described(const JudgedFlight& flight) {
  std::string text;
  for (const Said& s : flight.said)
    text += "T" + std::to_string(s.t_s) + " source " + std::to_string(s.source) + " verdict " +
            std::to_string(static_cast<int>(s.judgement.verdict)) + ", onset T" +
            std::to_string((s.judgement.onset - liftoff).seconds()) + ": " + std::string(to_string(s.judgement.why)) +
            ", " + distance_text(s.judgement.apart_m) + "\n";
  return text;
}

/// `without`: a further chain that does not hear these sources; it is followed from the time that one of them is
/// excluded.
inline JudgedFlight judged(const RangeConfig& range, const std::vector<Event>& events, SourceSet without = 0) {
  const SourceTable sources(range);
  Ingest ingest(range);
  Judge judge(range, sources, 0);
  const SourceSet all = (SourceSet{1} << sources.size()) - 1;
  SourceSet stations = 0;
  for (SourceId id = 0; id < static_cast<SourceId>(sources.size()); ++id) {
    if (sources[id].kind == SourceKind::Telemetry) stations |= set_of(id);
  }
  struct Run {
    SourceSet mask;
    std::unique_ptr<Methods> methods;
  };
  std::vector<Run> runs;
  runs.push_back({all, std::make_unique<Methods>(range)});
  if (without != 0) runs.push_back({all & ~without, std::make_unique<Methods>(range)});
  if (without != 0 && without != stations) runs.push_back({all & ~stations, std::make_unique<Methods>(range)});

  JudgedFlight flight;
  std::vector<IntegrityVerdict> known(sources.size(), IntegrityVerdict::Agrees);
  std::vector<ChainState> chains(runs.size());
  std::vector<BiasEstimate> biases(range.radars.size() + range.angle_sensors.size());
  const Duration step = milliseconds(100);
  std::optional<Time> next;
  std::size_t selected = 0;
  const auto tick = [&](Time t) {
    SourceSet excluded = 0;
    for (std::size_t s = 0; s < sources.size(); ++s) {
      if (known[s] == IntegrityVerdict::Excluded) excluded |= set_of(static_cast<int>(s));
    }
    // The chain that never heard the liar becomes the one that is followed; it hears it when it is believed again.
    if (runs.size() > 1 && (excluded & without) != 0) selected = 1;
    runs[selected].mask = all & ~excluded;
    for (std::size_t i = 0; i < runs.size(); ++i) {
      chains[i].sources = runs[i].mask;
      chains[i].estimate = runs[i].methods->primary().fused(0, t);
      if (chains[i].estimate && t - chains[i].estimate->data_epoch > milliseconds(5000)) chains[i].estimate.reset();
    }
    for (std::size_t r = 0; r < biases.size(); ++r)
      biases[r] = runs[selected].methods->primary().bias(static_cast<int>(r));
    std::span<const Judgement> judgements;
    const JudgedTick at{.epoch = t, .in_flight = ingest.left_pad("kslv", t), .liftoff = ingest.mission().liftoff()};
    flight.allocations += allocations_of([&] { judgements = judge.judge(at, chains, biases); });
    const double t_s = (t - liftoff).seconds();
    for (std::size_t i = 0; i < judge.pair_count(); ++i) {
      if (judge.pair(i).value <= flight.largest_value) continue;
      flight.largest_value = judge.pair(i).value;
      flight.largest_at_s = t_s;
    }
    for (std::size_t s = 0; s < judgements.size(); ++s) {
      if (judgements[s].verdict == known[s]) continue;
      known[s] = judgements[s].verdict;
      flight.said.push_back({t_s, static_cast<SourceId>(s), judgements[s]});
    }
  };
  const auto observe = [&](const Observation& o) {
    const SourceId id = sources.find(kind_of(o.measured), o.sensor);
    if (id == no_source) return;
    flight.allocations += allocations_of([&] { judge.note(id, o); });
    if (o.verdict != Reason::Accepted) return;
    for (Run& run : runs) {
      if (contains(run.mask, id)) run.methods->process(o, ingest.left_pad(o.target, o.epoch));
    }
  };
  for (const Event& event : events) {
    const Time received = received_of(event);
    if (!next) next = ceil_to_grid(received, step);
    for (; *next <= received; next = *next + step) tick(*next);
    if (const auto* mark = std::get_if<MissionEvent>(&event)) ingest.note(*mark);
    if (const auto* plot = std::get_if<RadarTspi>(&event)) observe(ingest.judge(*plot));
    if (const auto* fix = std::get_if<GpsFix>(&event)) observe(ingest.judge(*fix));
    if (const auto* angles = std::get_if<AngleTspi>(&event)) observe(ingest.judge(*angles));
  }
  return flight;
}

/// What a fault does to each message; `t_s` is the message's epoch after lift-off.
using Fault = std::function<void(Event&, double t_s)>;

inline std::vector<Event> with_fault(const sim::Simulation& flight, const Fault& fault) {
  std::vector<Event> events = flight.events();
  for (Event& event : events) {
    if (const auto* plot = std::get_if<RadarTspi>(&event)) fault(event, (plot->epoch - liftoff).seconds());
    if (const auto* fix = std::get_if<GpsFix>(&event)) fault(event, (fix->epoch - liftoff).seconds());
  }
  return events;
}

}  // namespace downrange::test
