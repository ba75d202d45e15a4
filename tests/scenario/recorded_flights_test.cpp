/// The recorded flights beside the checkout (folder shared/): `downrange experiment flights` reaches its figures there
/// (est/THEORY.md section 10, last rows), and what else must hold of them.
#include <gtest/gtest.h>

#include <unistd.h>
#include <algorithm>
#include <archive/import_csv.hpp>
#include <archive/replay.hpp>
#include <cstdio>
#include <downrange/stage/engine.hpp>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <set>
#include <source_dir.hpp>

#include "app/downrange/recorded_flights.hpp"
#include "config/load.hpp"
#include "experiment/flights.hpp"
#include "experiment/report.hpp"
#include "score/errors.hpp"
#include "score/truth.hpp"
#include "sim/faults.hpp"

namespace downrange {
namespace {

namespace fs = std::filesystem;
using experiment::flights::FlightResult;
using experiment::flights::Flown;
using experiment::flights::RecordedFlight;

#define DOWNRANGE_NEEDS_FLIGHT(name)                 \
  if (!fs::exists(app::flights_folder("") / (name))) \
  GTEST_SKIP() << "no recorded flight " << (name) << " in " << app::flights_folder("")

constexpr double mdeg = std::numbers::pi / 180e3;

/// (radar, sequence) of the plots that the CSV files mark as planted outliers; the import leaves that column out.
std::set<std::pair<std::string, std::uint64_t>> planted(const fs::path& folder) {
  std::set<std::pair<std::string, std::uint64_t>> all;
  for (const char* radar : {"cape", "merritt", "downrange"}) {
    std::ifstream in(folder / ("radar_" + std::string(radar) + ".csv"));
    std::string line;
    std::getline(in, line);
    for (std::uint64_t row = 1; std::getline(in, line); ++row) {
      line.erase(line.find_last_not_of('\r') + 1);
      if (line.ends_with(",1")) all.emplace(radar, row);
    }
  }
  return all;
}

struct Asked {
  const char* flight;
  double without_a_radar_m;  ///< rms of joint: half as much again as with all of them
};

class RecordedFlightTest : public testing::TestWithParam<Asked> {};
INSTANTIATE_TEST_SUITE_P(Flights, RecordedFlightTest,
                         testing::Values(Asked{"falcon_heavy_demo", 7.5}, Asked{"falcon9_crs11", 9}),
                         [](const auto& asked) { return std::string(asked.param.flight); });

TEST_P(RecordedFlightTest, ReachesItsFigures) {
  DOWNRANGE_NEEDS_FLIGHT(GetParam().flight);
  const RecordedFlight flight = app::load_flight(app::flights_folder(""), GetParam().flight);
  experiment::ExperimentOptions options;
  options.jobs = 2;
  const std::vector<FlightResult> flown = experiment::flights::fly(std::span(&flight, 1), options);
  const experiment::ExperimentResult result = experiment::flights_result(flown);
  std::printf("%s", experiment::format_text(result).c_str());
  EXPECT_GE(std::ranges::count_if(result.figures, [](const experiment::Figure& f) { return !f.reach.empty(); }), 16);
  for (const experiment::Figure& figure : result.figures) {
    EXPECT_TRUE(figure.reached) << figure.what << ' ' << figure.measured << ' ' << figure.reach;
    EXPECT_LE(figure.what.size(), experiment::figure_name_width) << figure.what;
  }

  const Flown& all = *flown.front().find("everything");
  EXPECT_LE(all.position("song2015").rms_m, 0.55 * all.position("uncorrected").rms_m);
  EXPECT_LE(all.position("schmidt").rms_m, all.position("song2015").rms_m);
  ASSERT_FALSE(all.summary.pointing.empty());
  for (const auto& antenna : all.summary.pointing) EXPECT_LT(antenna.p95_rad, 200 * mdeg);
  const Flown& without_gps = *flown.front().find("without GPS");
  EXPECT_EQ(without_gps.gate.outliers_rejected, without_gps.gate.outliers);
  for (const Name& radar : flown.front().radars) {
    const Flown& without = *flown.front().find("without " + std::string(radar.view()));
    EXPECT_LE(without.position("joint").rms_m, GetParam().without_a_radar_m) << radar.view();
    EXPECT_EQ(without.gate.outliers_rejected, without.gate.outliers) << radar.view();
  }
}

TEST_P(RecordedFlightTest, OutliersAreThoseThatWerePlanted) {
  DOWNRANGE_NEEDS_FLIGHT(GetParam().flight);
  const fs::path folder = app::flights_folder("");
  const RecordedFlight flight = app::load_flight(folder, GetParam().flight);
  std::set<std::pair<std::string, std::uint64_t>> told;
  for (const auto& [radar, sequence] : experiment::flights::outliers_of(flight)) told.emplace(radar.view(), sequence);
  EXPECT_FALSE(told.empty());
  EXPECT_EQ(told, planted(folder / GetParam().flight));
}

/// What a flight with a fault is judged by.
struct Frozen final : ResultSink {
  explicit Frozen(const RecordedFlight& f) : flight(f), truth(f.truth) {}
  void emit(const Result& result) override {
    if (const auto* judged = std::get_if<Integrity>(&result)) {
      for (const SourceIntegrity& s : judged->sources) {
        if (s.verdict == IntegrityVerdict::Agrees) continue;
        if (!accused_s) accused_s = (judged->time - flight.liftoff).seconds();
        accused.insert(std::string(s.sensor.view()));
      }
    }
    if (const auto* h = std::get_if<SourceHealth>(&result); h != nullptr && h->sensor == Name("telemetry"))
      refused = h->count[static_cast<std::size_t>(Reason::Frozen)];
    const auto* t = std::get_if<Trajectory>(&result);
    if (t == nullptr || !t->primary) return;
    const auto true_state = truth.at(t->epoch);
    if (!true_state) return;
    const double t_s = (t->epoch - flight.liftoff).seconds();
    const Gaussian<3> x = score::position_at(*t, t->epoch);
    const double error_m = (x.mean - true_state->position.m).norm();
    worst_sigmas = std::max(worst_sigmas, error_m / std::sqrt(x.cov.trace()));
    if (t_s > 25) worst_after_m = std::max(worst_after_m, error_m);
  }
  const RecordedFlight& flight;
  score::TruthTable truth;
  std::optional<double> accused_s;
  std::set<std::string> accused;
  std::uint64_t refused = 0;
  double worst_sigmas = 0;
  double worst_after_m = 0;
};

/// Its receiver repeats the fix of T+1.5 s until T+20 s, while the vehicle leaves the pad: of the equal ones two are
/// taken, the third and all later ones are refused and said, and its next true fix is taken at once.
TEST_P(RecordedFlightTest, AReceiverThatFreezesAtLiftoffIsNotFollowed) {
  DOWNRANGE_NEEDS_FLIGHT(GetParam().flight);
  RecordedFlight flight = app::load_flight(app::flights_folder(""), GetParam().flight);
  std::erase_if(flight.events, [&](const Event& e) { return received_of(e) > flight.liftoff + seconds(60); });
  sim::Fault frozen;
  frozen.lasts_s = 18;
  frozen.actions = {{.sources = {"gps"}, .effect = sim::Freeze{}}};
  const sim::Injected injected =
      sim::inject({}, frozen, {.range = flight.range, .liftoff = flight.liftoff, .begin_s = 2}, flight.events);
  ASSERT_GT(injected.touched, 30u);
  flight.range.fuse.methods.resize(1);
  flight.range.antennas.clear();
  Frozen judged(flight);
  Engine engine(flight.range, {}, judged);
  for (const Event& event : injected.events) engine.handle(engine.admit(event));
  EXPECT_EQ(judged.refused, injected.touched - 1);
  ASSERT_TRUE(judged.accused_s);
  EXPECT_LE(*judged.accused_s, 4.5);
  EXPECT_EQ(judged.accused, std::set<std::string>{"telemetry"});
  EXPECT_LE(judged.worst_sigmas, 3);
  EXPECT_LE(judged.worst_after_m, 10);
}

TEST(RecordedFlights, AreTheSameOnAnyNumberOfThreads) {
  DOWNRANGE_NEEDS_FLIGHT("falcon9_crs11");
  RecordedFlight flight = app::load_flight(app::flights_folder(""), "falcon9_crs11");
  std::erase_if(flight.events, [&](const Event& e) { return received_of(e) > flight.liftoff + seconds(60); });
  experiment::ExperimentOptions options;
  options.methods = {"joint", "uncorrected"};
  const auto page = [&](int jobs) {
    options.jobs = jobs;
    const std::vector results{experiment::run_flights(options, std::span(&flight, 1))};
    return experiment::format_json(results);
  };
  EXPECT_EQ(page(1), page(3));
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
  const fs::path archive = fs::temp_directory_path() / ("downrange-juno3-" + std::to_string(getpid()) + ".mcap");
  archive::ImportOptions options;
  options.folder = app::flights_folder("") / "gnss_juno3";
  options.writer.overwrite = true;
  const fs::path root = DOWNRANGE_SOURCE_DIR;
  const auto report = archive::import_csv(root / "tools" / "imports" / "juno3.toml", archive, options);
  ASSERT_EQ(report.files.size(), 1u);
  const auto& file = report.files.front();
  EXPECT_EQ(file.epoch_backwards.count, 6u);  // as its provenance says
  EXPECT_EQ(file.epoch_repeated.count, 3u);
  Fixes fixes;
  Engine engine(config::load((root / "config" / "spaceport.toml").string()).range, {}, fixes);
  archive::EventSource source(archive);
  while (const auto event = source.next()) engine.handle(engine.admit(*event));
  fs::remove(archive);
  EXPECT_GT(fixes.verdicts[Reason::ClockStep], 0);
  EXPECT_GT(fixes.verdicts[Reason::Duplicate], 0);
  EXPECT_GT(fixes.verdicts[Reason::Accepted], 350);
  EXPECT_GT(fixes.commands, 100);
  EXPECT_EQ(fixes.wild, 0);
}

}  // namespace
}  // namespace downrange
