/// Scenario files: what the shipped ones say, and an exact complaint for everything that may be wrong with one.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <source_dir.hpp>

#include "sim/scenario.hpp"
#include "sim/simulation.hpp"

namespace downrange::sim {
namespace {

constexpr double deg = std::numbers::pi / 180;

RangeConfig naro() {
  RangeConfig range;
  range.targets = {{"kslv"}};
  RadarConfig goheung;
  goheung.id = "goheung";
  goheung.site = Site({34.4450 * deg, 127.5200 * deg, 120});
  goheung.sigma = {25, 0.01 * deg, 0.01 * deg};
  RadarConfig jeju = goheung;
  jeju.id = "jeju";
  jeju.site = Site({33.2900 * deg, 126.4600 * deg, 350});
  jeju.rate_hz = 20;
  range.radars = {goheung, jeju};
  range.telemetry = {{"goheung-tgs", Site({34.4480 * deg, 127.5165 * deg, 105})},
                     {"jeju-tgs", Site({33.3870 * deg, 126.3660 * deg, 95})},
                     {"ship-tgs", Site({14.0 * deg, 130.0 * deg, 20})}};
  AngleSensorConfig optical;
  optical.id = "optical";
  optical.site = Site({34.4390 * deg, 127.5105 * deg, 160});
  optical.sigma_azimuth_rad = 0.003 * deg;
  optical.sigma_elevation_rad = 0.002 * deg;
  optical.rate_hz = 25;
  optical.elevation_min_rad = 5 * deg;
  range.angle_sensors = {optical};
  AntennaConfig antenna;
  antenna.id = "goheung-tm";
  antenna.site = goheung.site;
  range.antennas = {antenna};
  antenna.id = "ship";
  antenna.site = Site({32.5 * deg, 127.5 * deg, 25});
  antenna.moves = true;
  range.antennas.push_back(antenna);
  return range;
}

std::filesystem::path shipped(const char* name) {
  return std::filesystem::path(DOWNRANGE_SOURCE_DIR) / "tools" / "scenarios" / name;
}

/// A file of its own per test and process: tests run in parallel.
class ScenarioFile : public ::testing::Test {
 protected:
  ScenarioFile()
      : folder_(std::filesystem::temp_directory_path() /
                ("downrange-scenario-" + std::to_string(::getpid()) + "-" +
                 ::testing::UnitTest::GetInstance()->current_test_info()->name())) {
    std::filesystem::create_directories(folder_);
  }
  ~ScenarioFile() override { std::filesystem::remove_all(folder_); }

  Scenario load(const std::string& text) {
    std::ofstream(folder_ / "s.toml") << text;
    return load_scenario(folder_ / "s.toml", naro());
  }

  /// What load() complains about, the folder's name taken off.
  std::string complaint(const std::string& text) {
    try {
      (void)load(text);
    } catch (const ScenarioError& error) {
      return std::string(error.what()).substr(folder_.string().size() + 1);
    }
    return "none";
  }

  const std::filesystem::path folder_;
};

const std::string minimal = R"(name = "m"
target = "kslv"
liftoff_utc = 2026-03-01T08:00:00Z
end_s = 100
[trajectory]
kind = "launch"
[gps]
sigma_east_m = 5
sigma_north_m = 5
sigma_up_m = 8
)";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

TEST(ShippedScenario, Launch) {
  const Scenario scenario = load_scenario(shipped("launch.toml"), naro());
  EXPECT_EQ(scenario.liftoff.ns, 1'772'352'000'000'000'000);
  ASSERT_EQ(scenario.radars.size(), 2u);
  EXPECT_EQ(scenario.radars[0].bias.offset.range_m, 35);
  EXPECT_NEAR(scenario.radars[1].bias.offset.azimuth_rad, -0.03 * deg, 1e-15);
  EXPECT_EQ(scenario.radars[1].rate_hz, 20);  // the range's
  ASSERT_EQ(scenario.stations.size(), 3u);
  ASSERT_EQ(scenario.phases.size(), 3u);
  EXPECT_EQ(scenario.phases[1].name, "coast");

  const Simulation simulation(scenario, scenario.seed);
  std::map<Name, int> plots, relayed;
  double latest = 0, earliest = 10;
  for (const Event& event : simulation.events()) {
    if (const auto* plot = std::get_if<RadarTspi>(&event)) ++plots[plot->sensor];
    if (const auto* fix = std::get_if<GpsFix>(&event)) {
      ++relayed[fix->station];
      latest = std::max(latest, (fix->received - fix->epoch).seconds());
      earliest = std::min(earliest, (fix->received - fix->epoch).seconds());
    }
  }
  EXPECT_GT(plots["goheung"], 4000);
  EXPECT_GT(plots["jeju"], 8000);
  EXPECT_GT(relayed["goheung-tgs"], 300);
  EXPECT_GT(relayed["jeju-tgs"], 300);
  EXPECT_GT(relayed["ship-tgs"], 50);
  EXPECT_GT(earliest, 0.29);
  EXPECT_LT(latest, 0.81);
}

TEST(ShippedScenario, PaperIsTheScenarioOfTheFigures) {
  const Scenario scenario = load_scenario(shipped("paper.toml"), naro());
  const Simulation simulation(scenario, 1);
  std::map<Name, Time> first_plot;
  Time first_fix{};
  std::size_t fixes = 0;
  for (const Event& event : simulation.events()) {
    if (const auto* plot = std::get_if<RadarTspi>(&event)) {
      first_plot.try_emplace(plot->sensor, plot->epoch);
      EXPECT_EQ(plot->received, plot->epoch);
    }
    if (const auto* fix = std::get_if<GpsFix>(&event)) {
      if (fixes++ == 0) first_fix = fix->epoch;
      EXPECT_EQ(fix->received, fix->epoch);
      EXPECT_FALSE(fix->velocity_valid);
    }
  }
  EXPECT_EQ((first_plot["goheung"] - scenario.liftoff).ns, 100'013'000'000);
  EXPECT_EQ((first_plot["jeju"] - scenario.liftoff).ns, 100'031'000'000);
  EXPECT_EQ((first_fix - scenario.liftoff).ns, 80'400'000'000);
  EXPECT_EQ(fixes, 400u);
  EXPECT_EQ(scenario.radars[0].bias_sigma.scale, Eigen::Vector3d(3e-5, 2e-4, 2e-4));
}

TEST_F(ScenarioFile, DefaultsHold) {
  const Scenario scenario = load(minimal + "[[radar]]\nid = \"jeju\"\n");
  EXPECT_EQ(scenario.start_s, -10);
  EXPECT_TRUE(scenario.simulated);
  EXPECT_EQ(scenario.seed, 1u);
  EXPECT_EQ(scenario.radars[0].sigma.range_m, 25);
  EXPECT_EQ(scenario.radars[0].refractivity, 0);
  EXPECT_EQ(scenario.radars[0].track, Window(-10, 100));
  EXPECT_EQ(scenario.gps.active, Window(-10, 100));
  EXPECT_EQ(scenario.profile.azimuth_rad, 170 * deg);
}

TEST_F(ScenarioFile, RefractivityIsARadarsKey) {
  EXPECT_EQ(load(minimal + "[[radar]]\nid = \"jeju\"\nrefractivity_n = 320\n").radars[0].refractivity, 320);
}

TEST_F(ScenarioFile, AnAngleSensorHasNoKeysOfRange) {
  const std::string text = minimal + "[[angle_sensor]]\nid = \"optical\"\n";
  const Scenario scenario = load(text + "refractivity_n = 300\n[angle_sensor.bias]\nazimuth_deg = 0.1\n");
  ASSERT_EQ(scenario.angle_sensors.size(), 1u);
  EXPECT_TRUE(scenario.radars.empty());
  const RadarScenario& optical = scenario.angle_sensors[0];
  EXPECT_EQ(optical.sigma.azimuth_rad, 0.003 * deg);
  EXPECT_EQ(optical.sigma.elevation_rad, 0.002 * deg);
  EXPECT_EQ(optical.rate_hz, 25);
  EXPECT_EQ(optical.elevation_min_rad, 5 * deg);
  EXPECT_EQ(optical.refractivity, 300);
  EXPECT_EQ(optical.bias.offset.azimuth_rad, 0.1 * deg);
  for (const char* key : {"sigma_range_m = 1", "range_max_m = 1", "outlier_range_m = 1"})
    EXPECT_NE(complaint(text + key + "\n").find("is not a key of this table"), std::string::npos) << key;
  EXPECT_NE(complaint(text + "[angle_sensor.bias]\nrange_m = 1\n").find("angle_sensor.bias.range_m: is not a key"),
            std::string::npos);
  EXPECT_EQ(complaint(minimal + "[[angle_sensor]]\nid = \"jeju\"\n"),
            "s.toml:12: angle_sensor.id: \"jeju\" is no angle sensor of this range; allowed: optical");
  EXPECT_EQ(complaint(text + "[[angle_sensor]]\nid = \"optical\"\n"),
            "s.toml:11: angle_sensor: \"optical\" is there twice; one table for each");
}

TEST_F(ScenarioFile, LiftoffTakesAnOffset) {
  const Scenario utc = load(minimal);
  const Scenario korea = load(replaced(minimal, "2026-03-01T08:00:00Z", "2026-03-01T17:00:00.25+09:00"));
  EXPECT_EQ((korea.liftoff - utc.liftoff).ns, 250'000'000);
}

TEST_F(ScenarioFile, ComplaintsNameFileLineKeyAndWhatIsAllowed) {
  EXPECT_EQ(complaint(minimal), "none");
  EXPECT_EQ(complaint(replaced(minimal, "\"kslv\"", "\"nuri\"")),
            "s.toml:2: target: \"nuri\" is no target of this range; allowed: kslv");
  EXPECT_EQ(complaint(minimal + "[[radar]]\nid = \"goheng\"\n"),
            "s.toml:12: radar.id: \"goheng\" is no radar of this range; allowed: goheung, jeju");
  EXPECT_EQ(
      complaint(minimal + "[[station]]\nid = \"x\"\n"),
      "s.toml:12: station.id: \"x\" is no telemetry station of this range; allowed: goheung-tgs, jeju-tgs, ship-tgs");
  EXPECT_EQ(complaint(replaced(minimal, "end_s = 100", "end_s = 0")), "s.toml:4: end_s: 0 is not allowed: 1 to 900");
  EXPECT_EQ(complaint(replaced(minimal, "end_s = 100", "end_s = nan")),
            "s.toml:4: end_s: nan is not allowed: 1 to 900");
  EXPECT_EQ(complaint(replaced(minimal, "end_s = 100", "end_s = \"100\"")),
            "s.toml:4: end_s: must be a number, 1 to 900");
  EXPECT_EQ(complaint(replaced(minimal, "end_s = 100\n", "")), "s.toml:1: end_s: is missing");
  EXPECT_EQ(complaint(replaced(minimal, "sigma_up_m = 8\n", "")), "s.toml:7: gps.sigma_up_m: is missing");
  EXPECT_EQ(complaint(replaced(minimal, "08:00:00Z", "08:00:00")),
            "s.toml:3: liftoff_utc: must be a date and time with offset, such as 2026-03-01T08:00:00Z");
  EXPECT_EQ(complaint(replaced(minimal, "\"launch\"", "\"orbit\"")),
            "s.toml:6: trajectory.kind: is not a known trajectory; allowed: launch");
  EXPECT_EQ(complaint(minimal + "sattelites = 3\n"),
            "s.toml:11: gps.sattelites: is not a key of this table; allowed: coloured_sigma_m, coloured_tau_s, fault, "
            "from_s, "
            "latency_ms, outages_s, phase_ms, rate_hz, satellites, sigma_east_m, sigma_north_m, sigma_up_m, "
            "sigma_velocity_m_s, states_accuracy, to_s");
  EXPECT_EQ(complaint(minimal + "outages_s = [[3, 2]]\n"),
            "s.toml:11: gps.outages_s: must be a list of [from, to] with from < to, such as [[80.0, 103.0]]");
  EXPECT_EQ(complaint(minimal + "from_s = 50\nto_s = 40\n"), "s.toml:12: gps.to_s: must be after from_s");
  EXPECT_EQ(complaint(minimal + "[[radar]]\nid = \"jeju\"\nlatency_ms = 10\nlatency_jitter_ms = 20\n"),
            "s.toml:14: radar.latency_jitter_ms: 20 is not allowed: 0 to 10");
  EXPECT_EQ(complaint(minimal + "[[radar]]\nid = \"jeju\"\nrefractivity_n = 501\n"),
            "s.toml:13: radar.refractivity_n: 501 is not allowed: 0 to 500");
  EXPECT_EQ(complaint(minimal + "[[radar]]\nid = \"jeju\"\n[radar.bias]\nrange = 1\n").substr(0, 41),
            "s.toml:14: radar.bias.range: is not a key");
  EXPECT_EQ(complaint(minimal + "[[radar]]\nid = \"jeju\"\n[radar.bias_sigma]\nrange_m = -1\n"),
            "s.toml:14: radar.bias_sigma.range_m: -1 is not allowed: 0 or more");
  EXPECT_EQ(complaint(minimal + "[[radar]]\nid = \"jeju\"\n[[radar]]\nid = \"jeju\"\n"),
            "s.toml:11: radar: \"jeju\" is there twice; one table for each");
  EXPECT_EQ(complaint(minimal + "[radar]\nid = \"jeju\"\n"),
            "s.toml:11: radar: must be a list of tables, each headed [[radar]]");
  EXPECT_EQ(complaint(minimal + "[gps]\n").substr(0, 10), "s.toml:11:");  // not TOML: a table twice
}

TEST_F(ScenarioFile, ANumberThatNoDoubleHoldsIsAnErrorOrANumber) {
  EXPECT_EQ(complaint(minimal + "[[radar]]\nid = \"jeju\"\nrefractivity_n = 9223372036854775807\n"),
            "s.toml:13: radar.refractivity_n: 9.22337e+18 is not allowed: 0 to 500");
  EXPECT_EQ(complaint(minimal + "outages_s = [[0, 9223372036854775807]]\n"), "none");
  EXPECT_NE(complaint(minimal + "outages_s = [[0, inf]]\n").find("must be a list"), std::string::npos);
  EXPECT_NE(complaint(minimal + "outages_s = [[0, \"x\"]]\n").find("must be a list"), std::string::npos);
  EXPECT_EQ(complaint(minimal + "[[radar]]\nid = \"jeju\"\n[radar.bias]\nrange_m = 1e308\n"),
            "s.toml:14: radar.bias.range_m: 1e+308 is not allowed: -1e+09 to 1e+09");
}

TEST_F(ScenarioFile, WhatIsNoFileIsAnError) {
  EXPECT_THROW((void)load_scenario(folder_ / "none.toml", naro()), ScenarioError);
  EXPECT_THROW((void)load_scenario(folder_, naro()), ScenarioError);
  EXPECT_THROW((void)load_scenario("/dev/zero", naro()), ScenarioError);
}

TEST_F(ScenarioFile, ADeepKeyIsAnErrorNotACrash) {
  std::string deep;
  for (int i = 0; i < 50'000; ++i) deep += "a.";
  EXPECT_EQ(complaint(minimal + deep + "a = 1\n").substr(0, 27), "s.toml:11: a key of more th");
}

TEST_F(ScenarioFile, AShipAndAnAntennaThatIsSlavedForAWhile) {
  const std::string text = minimal + R"([[platform]]
id = "ship"
course_deg = 90
speed_m_s = 10
turn_rate_deg_s = 1
rate_hz = 2
latency_ms = 100
[[antenna]]
id = "goheung-tm"
slaved_s = [[10, 20]]
rate_hz = 1
)";
  const Scenario scenario = load(text);
  const Simulation simulation(scenario, 1);
  std::vector<PlatformState> states;
  std::vector<AntennaReport> reports;
  for (const Event& event : simulation.events()) {
    if (const auto* state = std::get_if<PlatformState>(&event)) states.push_back(*state);
    if (const auto* report = std::get_if<AntennaReport>(&event)) reports.push_back(*report);
  }
  ASSERT_EQ(states.size(), 220u);  // 110 s
  const PlatformState& last = states.back();
  EXPECT_EQ(last.antenna, Name("ship"));
  EXPECT_EQ(last.sequence, 220u);
  EXPECT_NEAR((last.received - last.epoch).seconds(), 0.1, 1e-9);
  EXPECT_TRUE(last.simulated);
  const double t = (last.epoch - scenario.liftoff).seconds();
  const Site harbour({32.5 * deg, 127.5 * deg, 25});
  const Displacement<Enu> way = harbour.enu_of(last.position);
  EXPECT_NEAR(way.m.x(), 10 * t, 0.5);
  EXPECT_NEAR(way.m.y(), 0, 0.5);
  EXPECT_NEAR(geodetic_from_ecef(last.position).height_m, 25, 1e-3);
  EXPECT_NEAR((harbour.R_enu_ecef().R * last.velocity.m_s).x(), 10, 0.01);
  EXPECT_NEAR(last.heading_rad, std::remainder((90 + t) * deg, 2 * std::numbers::pi) + 2 * std::numbers::pi, 1e-9);
  ASSERT_EQ(reports.size(), 110u);
  for (const AntennaReport& report : reports) {
    const double at = (report.epoch - scenario.liftoff).seconds();
    EXPECT_EQ(report.mode, at >= 10 && at < 20 ? AntennaMode::Slaved : AntennaMode::Autotrack) << at;
  }

  EXPECT_EQ(complaint(minimal + "[[platform]]\nid = \"goheung-tm\"\n"),
            "s.toml:12: platform.id: this antenna stands; allowed: one with moves = true in the range");
  EXPECT_NE(complaint(minimal + "[[antenna]]\nid = \"jeju-tm\"\n").find("allowed: goheung-tm, ship"),
            std::string::npos);
  EXPECT_NE(complaint(text + "[[antenna]]\nid = \"goheung-tm\"\n").find("is there twice"), std::string::npos);
  EXPECT_NE(complaint(text + "speed = 3\n").find("is not a key of this table"), std::string::npos);
}

}  // namespace
}  // namespace downrange::sim
