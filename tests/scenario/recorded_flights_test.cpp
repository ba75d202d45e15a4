/// The recorded flights beside the checkout (folder shared/): figures that the range paper's method must reach there.
#include <gtest/gtest.h>

#include <unistd.h>
#include <algorithm>
#include <archive/import_csv.hpp>
#include <archive/replay.hpp>
#include <cmath>
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

sim::Summary score(const Imported& flight, const RangeConfig& range) {
  std::vector<sim::TruthSample> samples;
  Name target;
  Time liftoff = flight.report.liftoff;
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
  sim::Scorer scorer(range, target, [&](Time t) { return truth.at(t); }, liftoff, {{"flight", 0, 600}});
  ResultSink& sink = scorer.open_run("fused");
  Engine engine(range, {}, sink);
  archive::EventSource source(flight.path());
  while (const auto event = source.next()) {
    // Planted outliers are kilometres or degrees off: further from the truth than any bias.
    if (const auto* p = std::get_if<RadarTspi>(&*event)) {
      const auto radar =
          std::find_if(range.radars.begin(), range.radars.end(), [&](const auto& r) { return r.id == p->sensor; });
      if (const auto state = truth.at(p->epoch)) {
        const Polar q = polar_from_enu(radar->site.enu_of(state->position));
        const double angle =
            std::max(std::abs(wrap_pi(p->measured.azimuth_rad - q.azimuth_rad)) * std::cos(q.elevation_rad),
                     std::abs(p->measured.elevation_rad - q.elevation_rad));
        if (std::abs(p->measured.range_m - q.range_m) > 200 || angle > 0.6 * std::numbers::pi / 180)
          scorer.mark_outlier(p->sensor, p->sequence);
      }
    }
    engine.handle(engine.admit(*event));
  }
  return scorer.summary();
}

const sim::PositionScore& whole_flight(const sim::Summary& summary, const std::string& part) {
  for (const auto& t : summary.trajectories)
    if (t.label.find(part) != std::string::npos) return t.phases.front();
  throw std::runtime_error("no trajectory labelled " + part);
}

TEST(RecordedFlights, FalconHeavyDemo) {
  DOWNRANGE_NEEDS_FLIGHT("falcon_heavy_demo");
  const Imported flight("falcon_heavy_demo");
  const sim::Summary summary = score(flight, range_of("cape.toml"));
  EXPECT_LE(whole_flight(summary, "song2015").rms_m, whole_flight(summary, "uncorrected").rms_m / 3);
  int scored = 0;
  for (const auto& radar : summary.radars) {
    if (radar.sensor == Name("downrange")) continue;  // sees through refraction that is not modelled yet
    ++scored;
    EXPECT_LE(radar.after.range_m, 0.6 * radar.before.range_m) << radar.sensor.view();
    EXPECT_LE(radar.after.azimuth_rad, 0.6 * radar.before.azimuth_rad) << radar.sensor.view();
    EXPECT_LE(radar.after.elevation_rad, 0.6 * radar.before.elevation_rad) << radar.sensor.view();
  }
  EXPECT_EQ(scored, 2);
  EXPECT_FALSE(summary.pointing.empty());
  for (const auto& antenna : summary.pointing) EXPECT_LT(antenna.p95_rad, 0.2 * std::numbers::pi / 180);
}

TEST(RecordedFlights, Falcon9Crs11) {
  DOWNRANGE_NEEDS_FLIGHT("falcon9_crs11");
  const Imported flight("falcon9_crs11");
  const sim::Summary summary = score(flight, range_of("cape.toml"));
  EXPECT_LE(whole_flight(summary, "song2015").rms_m, 0.55 * whole_flight(summary, "uncorrected").rms_m);
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
