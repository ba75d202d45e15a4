/// What the simulated GPS receiver and its telemetry stations report.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "sim_sensors.hpp"

namespace downrange::sim {
namespace {

TEST(Gps, AFaultDisplacesTheReceiver) {
  Scenario scenario = make_scenario();
  const Simulation well(scenario, seed);
  scenario.gps.faults = {{.when = {100, 200}, .offset_enu_m = {0, 0, 50}, .drift_enu_m_s = {0, 0, 10}}};
  const Simulation faulty(scenario, seed);
  const auto before = all_of<GpsFix>(well);
  const auto after = all_of<GpsFix>(faulty);
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    const double t = (before[i].epoch - scenario.liftoff).seconds();
    const double off_m = t >= 100 && t < 200 ? 50 + 10 * (t - 100) : 0;
    EXPECT_NEAR((after[i].position.m - before[i].position.m).norm(), off_m, 1e-6) << t;
  }
}

TEST(Gps, EveryStationRelaysTheSameFix) {
  Scenario scenario = make_scenario();
  scenario.gps.sigma_velocity_m_s = 0.2;
  scenario.gps.latency_s = 0.25;
  scenario.stations = {make_station("near", 0.1, 0.05), make_station("far", 0.4, 0.3), make_station("lossy", 0.1, 0)};
  scenario.stations[2].loss_probability = 0.3;
  const Simulation simulation(scenario, seed);
  std::map<std::int64_t, std::vector<GpsFix>> by_epoch;
  std::map<Name, std::vector<GpsFix>> by_station;
  for (const GpsFix& fix : all_of<GpsFix>(simulation)) {
    by_epoch[fix.epoch.ns].push_back(fix);
    by_station[fix.station].push_back(fix);
  }
  EXPECT_EQ(by_epoch.size(), 490u);  // T-10 to T+479
  EXPECT_EQ(by_station["near"].size(), 490u);
  EXPECT_NEAR(static_cast<double>(by_station["lossy"].size()), 343, 4.5 * std::sqrt(490 * 0.21)) << "seed " << seed;
  for (const auto& [epoch, fixes] : by_epoch) {
    ASSERT_GE(fixes.size(), 2u);
    for (const GpsFix& fix : fixes) {
      EXPECT_EQ(fix.position.m, fixes[0].position.m);
      EXPECT_EQ(fix.velocity.m_s, fixes[0].velocity.m_s);
      EXPECT_TRUE(fix.velocity_valid);
    }
  }
  for (const auto& [station, fixes] : by_station)
    for (std::size_t i = 0; i < fixes.size(); ++i) {
      EXPECT_EQ(fixes[i].sequence, i + 1);
      EXPECT_GE(fixes[i].received, fixes[i > 0 ? i - 1 : 0].received);
    }
  for (const GpsFix& fix : by_station["near"]) {
    EXPECT_GE((fix.received - fix.epoch).seconds(), 0.30 - 1e-9);
    EXPECT_LE((fix.received - fix.epoch).seconds(), 0.40 + 1e-9);
  }
}

TEST(Gps, HasItsNoiseInLocalAxes) {
  Scenario scenario = make_scenario();
  scenario.gps.rate_hz = 10;
  scenario.gps.sigma_enu_m = {3, 5, 8};
  scenario.gps.sigma_velocity_m_s = 0.2;
  const Simulation simulation(scenario, seed);
  std::vector<double> east, north, up, velocity;
  for (const GpsFix& fix : all_of<GpsFix>(simulation)) {
    const score::TrueState truth = *simulation.truth(fix.epoch);
    const Eigen::Vector3d e =
        enu_from_ecef_at(geodetic_from_ecef(truth.position)).R * (fix.position.m - truth.position.m);
    east.push_back(e.x());
    north.push_back(e.y());
    up.push_back(e.z());
    for (int i = 0; i < 3; ++i) velocity.push_back(fix.velocity.m_s[i] - truth.velocity.m_s[i]);
  }
  expect_moments(east, 0, 3);
  expect_moments(north, 0, 5);
  expect_moments(up, 0, 8);
  expect_moments(velocity, 0, 0.2);
}

TEST(Gps, StationsSeeAboveTheirMaskOnly) {
  Scenario scenario = make_scenario();
  StationScenario far = make_station("far", 0.1, 0);
  far.site = Site({14 * deg, 130 * deg, 20});
  far.elevation_min_rad = 1 * deg;
  scenario.stations = {far};
  const Simulation simulation(scenario, seed);
  const auto fixes = all_of<GpsFix>(simulation);
  ASSERT_FALSE(fixes.empty());
  EXPECT_LT(fixes.size(), 490u);
  for (const GpsFix& fix : fixes) EXPECT_GE(true_polar(simulation, far.site, fix.epoch).elevation_rad, 1 * deg);
}

TEST(Gps, StatesAccuracyWhenAsked) {
  Scenario scenario = make_scenario();
  EXPECT_EQ(all_of<GpsFix>(Simulation(scenario, seed)).at(0).sigma_vertical_m, 0);
  EXPECT_FALSE(all_of<GpsFix>(Simulation(scenario, seed)).at(0).velocity_valid);
  scenario.gps.states_accuracy = true;
  scenario.gps.coloured_sigma_enu_m = {0, 0, 6};
  const GpsFix fix = all_of<GpsFix>(Simulation(scenario, seed)).at(0);
  EXPECT_NEAR(fix.sigma_horizontal_m, 5, 1e-12);
  EXPECT_NEAR(fix.sigma_vertical_m, 10, 1e-12);
}

}  // namespace
}  // namespace downrange::sim
