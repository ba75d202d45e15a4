/// The recorded flights beside the checkout (folder shared/): figures that the methods must reach there, with
/// everything, without GPS and without each radar (ALGORITHMS.md section 10, last rows).
#include <gtest/gtest.h>

#include <unistd.h>
#include <algorithm>
#include <archive/import_csv.hpp>
#include <archive/replay.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <downrange/stage/engine.hpp>
#include <filesystem>
#include <map>

#include "../support/vectors.hpp"
#include "config/load.hpp"
#include "sim/score.hpp"

namespace downrange {
namespace {

namespace fs = std::filesystem;

/// Imports a flight into a file of this process's own.
class Imported {
 public:
  explicit Imported(const std::string& name)
      : path_(fs::temp_directory_path() / ("downrange-" + name + "-" + std::to_string(getpid()) + ".mcap")) {
    archive::ImportOptions options;
    options.folder = test::shared_folder() / "data" / name;
    options.writer.overwrite = true;
    report = archive::import_csv(fs::path(DOWNRANGE_SOURCE_DIR) / "tools" / "imports" / (file_of(name) + ".toml"),
                                 path_, options);
  }
  ~Imported() { fs::remove(path_); }
  Imported(const Imported&) = delete;
  Imported& operator=(const Imported&) = delete;

  [[nodiscard]] const fs::path& path() const { return path_; }
  archive::ImportReport report;

 private:
  static std::string file_of(const std::string& name) { return name == "gnss_juno3" ? "juno3" : name; }
  fs::path path_;
};

RangeConfig range_of(const std::string& file) {
  return config::load(std::string(DOWNRANGE_SOURCE_DIR) + "/config/" + file).range;
}

#define DOWNRANGE_NEEDS_FLIGHT(name) \
  if (!fs::exists(test::shared_folder() / "data" / name)) GTEST_SKIP() << "no recorded flight " << name << " here"

constexpr double mdeg = std::numbers::pi / 180e3;

/// What a flight came to.
struct Scored {
  sim::Summary summary;
  int outliers = 0;           ///< planted in plots that were fused
  int outliers_rejected = 0;  ///< by the first method's gate
  int plots = 0;
  int plots_rejected = 0;  ///< good ones, likewise
  std::map<Name, double> time_tag_s;
  std::map<Name, std::vector<BiasState>> states;
};

/// Feeds the flight but for the sources in `without`, and counts what the gate of the first method did.
Scored score(const Imported& flight, RangeConfig range, const std::vector<Name>& methods,
             const std::vector<Name>& without = {}, std::pair<double, double> window = {0, 600}) {
  range.fuse.methods = methods;
  std::vector<sim::TruthSample> samples;
  Name target;
  {
    archive::Reader reader(flight.path());
    while (const auto entry = reader.next()) {
      if (const auto* t = std::get_if<archive::Truth>(&entry->record)) {
        target = t->target;
        samples.push_back({t->epoch, {t->position, t->velocity}});
      }
    }
  }
  const sim::TruthTable truth(std::move(samples));
  sim::Scorer scorer(range, target, [&](Time t) { return truth.at(t); }, flight.report.liftoff,
                     {{"flight", window.first, window.second}});
  Scored scored;
  struct Sink final : ResultSink {
    Sink(ResultSink& to, Scored& counts, const Name& primary) : to_(to), counts_(counts), primary_(primary) {}
    void emit(const Result& result) override {
      to_.emit(result);
      if (const auto* h = std::get_if<SourceHealth>(&result))
        gated_[h->sensor] = static_cast<int>(h->count[static_cast<std::size_t>(Reason::Gated)]);
      const auto* bias = std::get_if<SensorBias>(&result);
      if (bias == nullptr || bias->method != primary_) return;
      counts_.states[bias->sensor].assign(bias->state.begin(), bias->state.begin() + bias->terms);
      for (int i = 0; i < bias->terms; ++i) {
        const auto k = static_cast<std::size_t>(i);
        if (bias->term[k] == BiasTerm::TimeTag) counts_.time_tag_s[bias->sensor] = bias->value[k];
      }
    }
    [[nodiscard]] int gated(const std::vector<RadarConfig>& radars) const {
      int sum = 0;
      for (const RadarConfig& radar : radars)
        if (const auto found = gated_.find(radar.id); found != gated_.end()) sum += found->second;
      return sum;
    }
    ResultSink& to_;
    Scored& counts_;
    Name primary_;
    std::map<Name, int> gated_;
  } sink(scorer.open_run("fused"), scored, methods.front());
  Engine engine(range, {}, sink);
  Time last;
  archive::EventSource source(flight.path());
  while (const auto event = source.next()) {
    const auto* p = std::get_if<RadarTspi>(&*event);
    const auto* fix = std::get_if<GpsFix>(&*event);
    const auto left_out = [&](const Name& sensor) { return std::ranges::find(without, sensor) != without.end(); };
    if ((p != nullptr && left_out(p->sensor)) || (fix != nullptr && left_out(fix->station))) continue;
    if (p != nullptr) {
      // Planted outliers are hundreds of metres or half a degree off: further from the truth than any bias.
      const auto radar = std::ranges::find(range.radars, p->sensor, &RadarConfig::id);
      if (const auto state = truth.at(p->epoch)) {
        const Polar q = polar_from_enu(radar->site.enu_of(state->position));
        const double angle =
            std::max(std::abs(wrap_pi(p->measured.azimuth_rad - q.azimuth_rad)) * std::cos(q.elevation_rad),
                     std::abs(p->measured.elevation_rad - q.elevation_rad));
        const bool outlier = std::abs(p->measured.range_m - q.range_m) > 200 || angle > 600 * mdeg;
        if (outlier) scorer.mark_outlier(p->sensor, p->sequence);
        ++(outlier ? scored.outliers : scored.plots);
      }
    }
    const Event admitted = engine.admit(*event);
    engine.handle(admitted);
    last = received_of(admitted);
  }
  engine.advance_to(last + seconds(2));  // health of the last second
  const int gated = sink.gated(range.radars);
  scored.outliers_rejected = std::min(gated, scored.outliers);
  scored.plots_rejected = gated - scored.outliers_rejected;
  scored.summary = scorer.summary();
  return scored;
}

const sim::PositionScore& flight_of(const Scored& scored, const std::string& part) {
  for (const auto& t : scored.summary.trajectories)
    if (t.label.find(part) != std::string::npos) return t.phases.front();
  throw std::runtime_error("no trajectory labelled " + part);
}

void print(const std::string& what, const sim::PositionScore& s) {
  std::printf("%-44s rms %7.2f m  p95 %7.2f m  worst %7.1f m  inside 95 %% %.3f%s\n", what.c_str(), s.rms_m, s.p95_m,
              s.worst_m, s.inside_95, s.inside_95 > 0.99 ? "  (above 0.99: wider than the errors are)" : "");
}

void print(const Scored& scored) {
  for (const auto& t : scored.summary.trajectories) print(t.label, t.phases.front());
  for (const auto& r : scored.summary.radars) {
    if (r.plots == 0) continue;
    std::printf("  %-10s left %6.2f m %6.2f mdeg %6.2f mdeg of %6.1f m %6.1f mdeg %6.1f mdeg; states", r.sensor.c_str(),
                r.after.range_m, r.after.azimuth_rad / mdeg, r.after.elevation_rad / mdeg, r.before.range_m,
                r.before.azimuth_rad / mdeg, r.before.elevation_rad / mdeg);
    if (const auto states = scored.states.find(r.sensor); states != scored.states.end())
      for (const BiasState state : states->second) std::printf(" %s,", std::string(to_string(state)).c_str());
    std::printf("\n");
  }
  std::printf("  outliers rejected %d of %d, good plots rejected %d of %d\n", scored.outliers_rejected, scored.outliers,
              scored.plots_rejected, scored.plots);
}

/// What section 10 asks of one flight.
struct Asked {
  std::string flight;
  double rms_m, p95_m, outage_m, inside_95, time_tag_s, without_gps_m;
};

class RecordedFlight : public testing::TestWithParam<Asked> {};
INSTANTIATE_TEST_SUITE_P(Flights, RecordedFlight,
                         testing::Values(Asked{"falcon_heavy_demo", 5, 6, 14, 0.85, 2e-3, 100},
                                         Asked{"falcon9_crs11", 6, 8, 13, 0.60, 1.5e-3, 25}),
                         [](const auto& flight) { return flight.param.flight; });

const std::vector<Name> telemetry{"telemetry"};

TEST_P(RecordedFlight, ReachesItsFiguresWithEverything) {
  const Asked& asked = GetParam();
  DOWNRANGE_NEEDS_FLIGHT(asked.flight);
  const Imported flight(asked.flight);
  const Scored all = score(flight, range_of("cape.toml"), {"joint", "schmidt", "song2015", "uncorrected"});
  print(all);
  EXPECT_LE(flight_of(all, "joint").rms_m, asked.rms_m);
  EXPECT_LE(flight_of(all, "joint").p95_m, asked.p95_m);
  EXPECT_GE(flight_of(all, "joint").inside_95, asked.inside_95);
  EXPECT_LE(flight_of(all, "song2015").rms_m, 0.55 * flight_of(all, "uncorrected").rms_m);
  EXPECT_LE(flight_of(all, "schmidt").rms_m, flight_of(all, "song2015").rms_m);
  EXPECT_EQ(all.outliers_rejected, all.outliers);
  EXPECT_LE(all.plots_rejected, all.plots / 1000);
  EXPECT_NEAR(all.time_tag_s.at("merritt"), -0.006, asked.time_tag_s);
  for (const auto& radar : all.summary.radars) {
    if (radar.plots == 0) continue;
    EXPECT_LE(radar.after.range_m, 4) << radar.sensor.view();
    EXPECT_LE(radar.after.azimuth_rad, 12 * mdeg) << radar.sensor.view();
    EXPECT_LE(radar.after.elevation_rad, 10 * mdeg) << radar.sensor.view();
  }
  for (const auto& antenna : all.summary.pointing) EXPECT_LT(antenna.p95_rad, 200 * mdeg);

  const Scored outage = score(flight, range_of("cape.toml"), {"joint"}, {}, {160, 184});
  print("joint, GPS outage 160-184 s", flight_of(outage, "joint"));
  EXPECT_LE(flight_of(outage, "joint").rms_m, asked.outage_m);
}

/// Each source alone and all but one: the fusion is not worse than its best single source.
TEST_P(RecordedFlight, KeepsItsTrackWithoutGpsAndWithoutEachRadar) {
  const Asked& asked = GetParam();
  DOWNRANGE_NEEDS_FLIGHT(asked.flight);
  const Imported flight(asked.flight);
  const RangeConfig range = range_of("cape.toml");
  const Scored radars_only = score(flight, range, {"joint", "schmidt", "song2015", "uncorrected"}, telemetry);
  std::printf("without GPS:\n");
  print(radars_only);
  EXPECT_LE(flight_of(radars_only, "joint").rms_m, asked.without_gps_m);
  EXPECT_EQ(radars_only.outliers_rejected, radars_only.outliers);

  std::vector<Name> names;
  for (const RadarConfig& radar : range.radars) names.push_back(radar.id);
  // On the same ticks, before and after the outage that GPS alone does not survive.
  RangeConfig on_ticks = range;
  on_ticks.fuse.publish_on_data = false;
  for (const auto& window : {std::pair{20.0, 155.0}, std::pair{190.0, 600.0}}) {
    const double all = flight_of(score(flight, on_ticks, {"joint"}, {}, window), "joint").rms_m;
    const double gps_alone = flight_of(score(flight, on_ticks, {"joint"}, names, window), "joint").rms_m;
    std::printf("%.0f-%.0f s: GPS alone rms %.2f m, everything rms %.2f m\n", window.first, window.second, gps_alone,
                all);
    EXPECT_LE(all, 1.10 * gps_alone);
  }
  for (const Name& left_out : names) {
    std::printf("without %s:\n", left_out.c_str());
    const Scored rest = score(flight, range, {"joint", "schmidt", "song2015"}, {left_out});
    print(rest);
    EXPECT_LE(flight_of(rest, "joint").rms_m, 1.5 * asked.rms_m);
    std::vector<Name> others = telemetry;
    for (const Name& name : names)
      if (name != left_out) others.push_back(name);
    const Scored alone = score(flight, range, {"joint"}, others);
    if (alone.plots == 0) continue;  // this radar does not see this flight
    std::printf("%s alone:\n", left_out.c_str());
    print(alone);
  }
}

struct Fixes final : ResultSink {
  void emit(const Result& result) override {
    if (const auto* o = std::get_if<Observation>(&result)) ++verdicts[o->verdict];
    if (const auto* c = std::get_if<SlavingCommand>(&result)) {
      ++commands;
      // The rocket flew 3.2 km high from 1.4 km: nothing may point as if it were elsewhere.
      if (c->range_m > 6000 || !(c->sigma_elevation_rad >= 0)) ++wild;
    }
  }
  std::map<Reason, int> verdicts;
  int commands = 0;
  int wild = 0;
};

TEST(RecordedFlights, AReceiverWhoseClockStepsBackwardsDoesNotCorruptTheTrack) {
  DOWNRANGE_NEEDS_FLIGHT("gnss_juno3");
  const Imported flight("gnss_juno3");
  ASSERT_EQ(flight.report.files.size(), 1u);
  const auto& file = flight.report.files.front();
  EXPECT_EQ(file.epoch_backwards.count, 6u);  // as its provenance says
  EXPECT_EQ(file.epoch_repeated.count, 3u);
  Fixes fixes;
  Engine engine(range_of("spaceport.toml"), {}, fixes);
  archive::EventSource source(flight.path());
  while (const auto event = source.next()) engine.handle(engine.admit(*event));
  EXPECT_GT(fixes.verdicts[Reason::ClockStep], 0);
  EXPECT_GT(fixes.verdicts[Reason::Duplicate], 0);
  EXPECT_GT(fixes.verdicts[Reason::Accepted], 350);
  EXPECT_GT(fixes.commands, 100);
  EXPECT_EQ(fixes.wild, 0);
}

}  // namespace
}  // namespace downrange
