/// Antennas on ships and aircraft.
#include <gtest/gtest.h>

#include <cmath>

#include "stage_slave_testing.hpp"

namespace downrange {
namespace {

using test::deg;

constexpr double knot = 0.5144;

/// A ship that steams east at 20 knots, and turns by `turn_deg_s`.
class ShipTest : public testing::Test {
 protected:
  ShipTest() {
    range.antennas.resize(1);
    range.antennas[0].moves = true;
    method.path = [](double t) {
      const Eigen::Vector3d v = (test::vehicle_at(t + 0.01).m - test::vehicle_at(t - 0.01).m) / 0.02;
      return PositionVelocity{test::vehicle_at(t), {v}};
    };
  }

  [[nodiscard]] Site ship_at(double t) const {
    const Site harbour({34.0 * deg, 127.4 * deg, 20});
    const Geodetic g = geodetic_from_ecef(harbour.ecef_of({{speed_m_s * t, 0, 0}}));
    return Site(g, (heading_deg + turn_deg_s * t) * deg);
  }
  [[nodiscard]] PlatformState state_at(double t) const {
    PlatformState s;
    s.antenna = range.antennas[0].id;
    s.epoch = test::liftoff + seconds(t);
    s.received = s.epoch + milliseconds(50);
    s.position = ship_at(t).ecef();
    s.velocity.m_s = (ship_at(t + 0.5).ecef().m - ship_at(t - 0.5).ecef().m);
    s.velocity_valid = true;
    s.heading_rad = wrap_two_pi((heading_deg + turn_deg_s * t) * deg);
    s.simulated = true;
    return s;
  }
  /// Reports of the ship each second, until `heard_to_s`.
  std::vector<SlavingCommand> fly(Slave& slave, double from_s, double to_s, double heard_to_s = 1e9) {
    test::Collector out;
    for (int i = 0; from_s + i * range.tick.seconds() < to_s; ++i) {
      const double t = from_s + i * range.tick.seconds();
      const Time tick = test::liftoff + seconds(t);
      if (tick.ns % 1'000'000'000 == 0 && t <= heard_to_s) slave.note(changed(state_at(t - 0.05)));
      method.data_epoch = tick;
      slave.tick(tick, std::vector<Followed>{{.method = &method, .newest = tick}}, test::liftoff, out);
    }
    accounts = out.of<AntennaAccount>();
    return out.of<SlavingCommand>();
  }
  [[nodiscard]] PlatformState changed(PlatformState s) const {
    if (change) change(s);
    return s;
  }

  RangeConfig range = test::small_range();
  test::Knows method;
  double speed_m_s = 20 * knot;
  double heading_deg = 90;
  double turn_deg_s = 0;
  std::function<void(PlatformState&)> change;
  std::vector<AntennaAccount> accounts;
};

TEST_F(ShipTest, CommandsAreFromWhereItIsAndFromItsHeading) {
  turn_deg_s = 1;
  Slave slave(range);
  const auto commands = fly(slave, 30, 60);
  ASSERT_FALSE(commands.empty());
  for (const SlavingCommand& c : commands) {
    const double t = (c.apply_at - test::liftoff).seconds();
    if (t < 33) continue;  // by then it is known how it turns
    const auto seen = [&](double at) { return polar_from_enu(ship_at(at).enu_of(test::vehicle_at(at))); };
    const Polar q = seen(t);
    EXPECT_LT(std::abs(wrap_pi(q.azimuth_rad - c.azimuth_rad)), 0.002 * deg) << t;
    EXPECT_NEAR(q.elevation_rad, c.elevation_rad, 0.001 * deg) << t;
    EXPECT_NEAR(wrap_pi(seen(t + 0.05).azimuth_rad - seen(t - 0.05).azimuth_rad) / 0.1, c.azimuth_rate_rad_s,
                0.01 * deg)
        << t;
    EXPECT_NEAR((seen(t + 0.05).elevation_rad - seen(t - 0.05).elevation_rad) / 0.1, c.elevation_rate_rad_s,
                0.002 * deg)
        << t;
  }
  ASSERT_FALSE(accounts.empty());
  EXPECT_TRUE(accounts.back().pass_valid);
}

TEST_F(ShipTest, NoCommandBeforeItIsHeardNorFiveSecondsAfter) {
  Slave slave(range);
  EXPECT_TRUE(fly(slave, 30, 31, 0).empty());
  const auto commands = fly(slave, 31, 50, 40);
  ASSERT_FALSE(commands.empty());
  EXPECT_LE(commands.back().apply_at, test::liftoff + seconds(45));
  EXPECT_GE(commands.back().apply_at, test::liftoff + seconds(44.9));
  EXPECT_FALSE(fly(slave, 50, 52).empty()) << "it is heard again";
}

TEST_F(ShipTest, ItsSigmasAreInTheCommands) {
  Slave exact(range);
  const SlavingCommand without = fly(exact, 30, 32).back();
  Slave slave(range);
  change = [](PlatformState& s) {
    s.sigma_position_m = 100;
    s.sigma_heading_rad = 0.5 * deg;
  };
  const SlavingCommand with = fly(slave, 30, 32).back();
  const double by_place = 100 / with.range_m;
  EXPECT_NEAR(std::hypot(without.sigma_elevation_rad, by_place), with.sigma_elevation_rad, 1e-6);
  const auto with_heading = [&](double sigma_deg) {
    return std::hypot(without.sigma_azimuth_rad, by_place / std::cos(with.elevation_rad), sigma_deg * deg);
  };
  EXPECT_GE(with.sigma_azimuth_rad, with_heading(0.5));
  EXPECT_LE(with.sigma_azimuth_rad, with_heading(1)) << "how it turns is known less well, for a second";
}

TEST_F(ShipTest, WhatCannotBeIsPassedOver) {
  for (const auto& wrong : std::vector<std::function<void(PlatformState&)>>{
           [](PlatformState& s) { s.simulated = false; }, [](PlatformState& s) { s.antenna = "another"; },
           [](PlatformState& s) { s.heading_rad = NAN; }, [](PlatformState& s) { s.position.m.setZero(); },
           [](PlatformState& s) { s.position.m *= 2; }, [](PlatformState& s) { s.velocity.m_s.setConstant(INFINITY); },
           [](PlatformState& s) { s.sigma_position_m = -1; }, [](PlatformState& s) { s.sigma_heading_rad = NAN; },
           [](PlatformState& s) { s.epoch = s.received + seconds(60); }, [](PlatformState& s) { s.epoch = {}; }}) {
    Slave slave(range);
    change = wrong;
    EXPECT_TRUE(fly(slave, 30, 31).empty());
  }
}

TEST_F(ShipTest, AnOlderReportThatArrivesLateChangesNothing) {
  Slave a(range);
  Slave b(range);
  const SlavingCommand one = fly(a, 30, 31).back();
  static_cast<void>(fly(b, 30, 30.9));
  PlatformState old = state_at(20);
  old.received = test::liftoff + seconds(30.9);
  b.note(old);
  EXPECT_EQ(fly(b, 30.9, 31, 0).back().azimuth_rad, one.azimuth_rad);
}

TEST_F(ShipTest, WithoutVelocityItIsWhereItWasSaidToBe) {
  change = [](PlatformState& s) { s.velocity_valid = false, s.velocity.m_s.setConstant(NAN); };
  Slave slave(range);
  const SlavingCommand c = fly(slave, 30, 31).back();
  const Polar q = polar_from_enu(ship_at(29.95).enu_of(test::vehicle_at((c.apply_at - test::liftoff).seconds())));
  EXPECT_LT(std::abs(wrap_pi(q.azimuth_rad - c.azimuth_rad)), 1e-4 * deg);
}

}  // namespace
}  // namespace downrange
