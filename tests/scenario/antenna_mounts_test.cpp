/// A launch followed by an antenna whose mount reads wrongly, and by one on a ship; in a part of the flight the first
/// is slaved, and what its tracker then reads is our own pointing.

#include <gtest/gtest.h>

#include <cmath>
#include <downrange/stage/engine.hpp>
#include <functional>

#include "../support/small_range.hpp"
#include "../unit/sim_sensors.hpp"
#include "sim/antenna_models.hpp"

namespace downrange {
namespace {

constexpr double mount_azimuth_deg = 0.5;
constexpr double mount_elevation_deg = -0.3;
constexpr double slaved_from_s = 90;
constexpr double slaved_to_s = 110;
constexpr double end_s = 180;

class AntennaMounts : public testing::Test {
 protected:
  AntennaMounts() {
    range.fuse.methods = {"joint"};
    AngleSensorConfig tracker = test::small_tracker();
    tracker.site = range.antennas[0].site;
    tracker.sigma_azimuth_rad = tracker.sigma_elevation_rad = 0.02 * sim::deg;
    range.angle_sensors = {tracker};
    range.antennas[0].sensor = tracker.id;
    range.antennas[1].id = "ship";
    range.antennas[1].moves = true;
    range.antennas[1].site = Site({32.5 * sim::deg, 127.5 * sim::deg, 25});

    scenario = sim::make_scenario();
    scenario.end_s = end_s;
    scenario.gps.active = {-10, end_s};
    scenario.radars.clear();
    for (const RadarConfig& r : range.radars) {
      sim::RadarScenario radar = sim::make_radar(r.id.c_str());
      radar.site = r.site;
      radar.track = {20, end_s};
      radar.elevation_min_rad = 0;
      radar.latency_s = 0.05;
      radar.bias.offset = {30, 0.03 * sim::deg, -0.02 * sim::deg};
      scenario.radars.push_back(radar);
    }
    sim::RadarScenario angles = scenario.radars[0];
    angles.id = tracker.id;
    angles.site = tracker.site;
    angles.sigma = {0, 0.02 * sim::deg, 0.02 * sim::deg};
    angles.bias.offset = {0, mount_azimuth_deg * sim::deg, mount_elevation_deg * sim::deg};
    angles.measures.range = false;
    scenario.angle_sensors = {angles};
    scenario.stations[0].id = range.telemetry[0].id;
    scenario.antennas = {{.id = range.antennas[0].id, .slaved = {{slaved_from_s, slaved_to_s}}, .latency_s = 0.02}};
    ship = {.id = "ship",
            .start = range.antennas[1].site.geodetic(),
            .course_rad = 60 * sim::deg,
            .speed_m_s = 12,
            .heading_rad = 75 * sim::deg,
            .turn_rate_rad_s = 0.2 * sim::deg,
            .rate_hz = 5,
            .sigma_position_m = 5,
            .sigma_heading_rad = 0.02 * sim::deg,
            .latency_s = 0.1};
    scenario.platforms = {ship};
  }

  void fly() {
    const sim::Simulation flight(scenario, sim::seed);
    Engine engine(range, {}, out);
    for (const Event& event : flight.events()) engine.handle(engine.admit(event));
    for (const SlavingCommand& c : out.of<SlavingCommand>()) {
      const auto truth = flight.truth(c.apply_at);
      ASSERT_TRUE(truth);
      const double t = (c.apply_at - scenario.liftoff).seconds();
      check(c, t, truth->position);
    }
  }
  std::function<void(const SlavingCommand&, double, const Position<Ecef>&)> check;

  RangeConfig range = test::small_range();
  sim::Scenario scenario;
  sim::PlatformScenario ship;
  test::Collector out;
};

TEST_F(AntennaMounts, AreFoundOutAndPointedRightly) {
  double worst_mount_rad = 0;  // of what is left of the mount's error
  double worst_sigmas = 0;
  double worst_ship_sigmas = 0;
  double ship_square_sum = 0;
  int ship_commands = 0;
  check = [&](const SlavingCommand& c, double t, const Position<Ecef>& target) {
    if (t < 80) return;  // a minute after it began to track
    if (c.antenna == range.antennas[0].id) {
      const Polar q = polar_from_enu(range.antennas[0].site.enu_of(target));
      const double azimuth = wrap_pi(q.azimuth_rad + mount_azimuth_deg * sim::deg - c.azimuth_rad);
      const double elevation = q.elevation_rad + mount_elevation_deg * sim::deg - c.elevation_rad;
      worst_sigmas = std::max(
          {worst_sigmas, std::abs(azimuth) / c.sigma_azimuth_rad, std::abs(elevation) / c.sigma_elevation_rad});
      // Nearer, and while it is slaved, what the track is off is as large.
      if (t > slaved_to_s + 2) worst_mount_rad = std::max({worst_mount_rad, std::abs(azimuth), std::abs(elevation)});
    } else if (c.antenna == Name("ship")) {
      const sim::PlatformTruth place = sim::platform_at(ship, t);
      const Polar q = polar_from_enu(Site(place.place, place.heading_rad).enu_of(target));
      const double azimuth = wrap_pi(q.azimuth_rad - c.azimuth_rad) / c.sigma_azimuth_rad;
      const double elevation = (q.elevation_rad - c.elevation_rad) / c.sigma_elevation_rad;
      worst_ship_sigmas = std::max({worst_ship_sigmas, std::abs(azimuth), std::abs(elevation)});
      ship_square_sum += azimuth * azimuth;
      ++ship_commands;
    }
  };
  fly();
  EXPECT_LT(worst_mount_rad, 0.02 * sim::deg);
  EXPECT_GT(worst_mount_rad, 0);
  EXPECT_LT(worst_sigmas, 3);
  ASSERT_GT(ship_commands, 3000);
  EXPECT_LT(worst_ship_sigmas, 5);
  EXPECT_NEAR(std::sqrt(ship_square_sum / ship_commands), 1, 0.25) << "its sigma is what its heading's noise makes it";
}

TEST_F(AntennaMounts, WhatIsReadWhileSlavedIsNoMeasurement) {
  check = [](const SlavingCommand&, double, const Position<Ecef>&) {};
  fly();
  for (const Observation& o : out.of<Observation>()) {
    if (o.sensor != range.angle_sensors[0].id) continue;
    const double t = (o.received - scenario.liftoff).seconds();
    const bool slaved = t > slaved_from_s + 0.3 && t < slaved_to_s - 0.3;
    const bool tracks = t < slaved_from_s - 0.3 || t > slaved_to_s + 0.3;
    if (slaved || tracks) {
      EXPECT_EQ(o.verdict, slaved ? Reason::Slaved : Reason::Accepted) << t;
    }
  }
}

TEST_F(AntennaMounts, APassIsForetoldWhileItLasts) {
  check = [](const SlavingCommand&, double, const Position<Ecef>&) {};
  fly();
  int of_ship = 0;
  for (const AntennaAccount& pass : out.of<AntennaAccount>()) {
    of_ship += pass.antenna == Name("ship") ? 1 : 0;
    if ((pass.tick - scenario.liftoff).seconds() > 60) {
      EXPECT_TRUE(pass.in_view) << pass.antenna.view();
    }
  }
  EXPECT_GT(of_ship, 100);
}

}  // namespace
}  // namespace downrange
