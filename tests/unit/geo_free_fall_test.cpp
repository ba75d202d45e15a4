/// Free fall against an independent integration (geo_free_fall_table.hpp), and its laws.
#include <gtest/gtest.h>

#include <cmath>
#include <downrange/geo/earth.hpp>
#include <downrange/geo/free_fall.hpp>
#include <downrange/geo/site.hpp>
#include <numbers>

#include "geo_free_fall_table.hpp"

namespace downrange {
namespace {

constexpr double deg = std::numbers::pi / 180;
constexpr double hour = 3600;

PositionVelocity start(double latitude_deg, double longitude_deg, double height_m, const Eigen::Vector3d& enu_m_s) {
  const Geodetic g{latitude_deg * deg, longitude_deg * deg, height_m};
  return {ecef_from_geodetic(g), enu_from_ecef_at(g).inverse() * Velocity<Enu>{enu_m_s}};
}

PositionVelocity start(const test::TabulatedFall& row) {
  return start(row.latitude_deg, row.longitude_deg, row.height_m, {row.east_m_s, row.north_m_s, row.up_m_s});
}

using Motion = Eigen::Matrix<double, 6, 1>;

Motion motion_of(const PositionVelocity& s) {
  Motion x;
  x << s.position.m, s.velocity.m_s;
  return x;
}

/// By many steps of the classical Runge-Kutta rule: another integrator than the one tested. Either sign.
Motion flown(Motion x, double time_s, int steps) {
  const double h = time_s / steps;
  const auto f = [](const Motion& y) {
    Motion d;
    d << y.tail<3>(), free_fall_acceleration({y.head<3>()}, {y.tail<3>()});
    return d;
  };
  for (int i = 0; i < steps; ++i) {
    const Motion k1 = f(x);
    const Motion k2 = f(x + h / 2 * k1);
    const Motion k3 = f(x + h / 2 * k2);
    const Motion k4 = f(x + h * k3);
    x += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  return x;
}

/// Circular over the pole: nothing that the Earth's rotation adds or takes.
PositionVelocity orbit(double height_m) {
  const double r = wgs84::semi_major_axis_m + height_m;
  const double v = std::sqrt(wgs84::gm_m3_s2 / r);
  return {{{r, 0, 0}}, {{0, -wgs84::rotation_rate_rad_s * r, v}}};
}

TEST(FreeFall, ComesDownWhereAnIndependentIntegrationSays) {
  for (const test::TabulatedFall& row : test::tabulated_falls) {
    const auto landing = fall_to(start(row), row.ground_m, hour);
    ASSERT_TRUE(landing) << row.name;
    const Eigen::Vector3d off = landing->state.position.m - Eigen::Vector3d(row.x_m, row.y_m, row.z_m);
    // A tenth of what is asked for (1 m over 1000 km), however far; header: within 0.03 m.
    EXPECT_LT(off.norm(), 0.03) << row.name;
    EXPECT_NEAR(landing->time_s, row.time_s, 1e-5) << row.name;
    const auto coarse = fall_to(start(row), row.ground_m, hour, 80);
    ASSERT_TRUE(coarse) << row.name;
    EXPECT_LT((coarse->state.position - landing->state.position).m.norm(), 1) << row.name;
    EXPECT_NEAR(geodetic_from_ecef(landing->state.position).height_m, row.ground_m, 1e-3) << row.name;
  }
}

TEST(FreeFall, TheRestOfAFallEndsAtTheSamePlace) {
  const PositionVelocity first = start(33, 127.8, 140e3, {250, -2000, 1500});
  const auto whole = fall_to(first, 0, hour);
  ASSERT_TRUE(whole);
  for (const double later_s : {1.0, 37.0, 200.0, 400.0, 428.0}) {
    const Motion x = flown(motion_of(first), later_s, 1000);
    const auto rest = fall_to({{x.head<3>()}, {x.tail<3>()}}, 0, hour);
    ASSERT_TRUE(rest);
    EXPECT_LT((rest->state.position - whole->state.position).m.norm(), 0.01) << later_s;
    EXPECT_NEAR(rest->time_s, whole->time_s - later_s, 1e-5);
  }
}

TEST(FreeFall, AnOrbitDoesNotComeDown) {
  EXPECT_FALSE(fall_to(orbit(400e3), 0, 4 * hour));
  EXPECT_FALSE(fall_to(orbit(200e3), 0, 4 * hour));
  // Nor what leaves the Earth, nor what takes longer than it is looked at.
  EXPECT_FALSE(fall_to(start(10, 20, 300e3, {2000, 0, 11'000}), 0, 4 * hour));
  const PositionVelocity lofted = start(34.4, 127.5, 300e3, {100, -900, 6500});
  EXPECT_FALSE(fall_to(lofted, 0, 2700));
  EXPECT_TRUE(fall_to(lofted, 0, 2730));
}

TEST(FreeFall, APerigeeBelowTheGroundBetweenTwoStepsIsALanding) {
  // Faster than a circular orbit: below the ground for less than a step of 40 s, whenever the steps begin.
  const auto before_perigee = [](double perigee_m, double by_s) {
    const Motion x = flown(motion_of(start(0, 0, perigee_m, {9500, 0, 0})), -by_s, 1000);
    return PositionVelocity{{x.head<3>()}, {x.tail<3>()}};
  };
  for (const double by_s : {15.0, 21.0, 55.0, 60.0, 70.0}) {
    EXPECT_TRUE(fall_to(before_perigee(-400, by_s), 0, hour)) << by_s;
    EXPECT_FALSE(fall_to(before_perigee(400, by_s), 0, hour)) << by_s;
  }
}

TEST(FreeFall, OnTheGroundItIsWhereItIs) {
  const PositionVelocity standing = start(34.4319, 127.5351, 0, {0, 0, 0});
  const auto landing = fall_to(standing, 0, hour);
  ASSERT_TRUE(landing);
  EXPECT_EQ(landing->time_s, 0);
  EXPECT_EQ(landing->state, standing);
  // Below the ground that is configured, as a pad in a valley: to its own height.
  const auto thrown = fall_to(start(34.4319, 127.5351, -20, {0, 0, 49}), 0, hour);
  ASSERT_TRUE(thrown);
  EXPECT_NEAR(thrown->time_s, 10, 0.05);
  EXPECT_NEAR(geodetic_from_ecef(thrown->state.position).height_m, -20, 1e-3);
}

TEST(FreeFall, WhatIsNoStateDoesNotComeDown) {
  PositionVelocity s = start(0, 0, 1000, {0, 0, 0});
  s.velocity.m_s.x() = std::nan("");
  EXPECT_FALSE(fall_to(s, 0, hour));
  s.velocity.m_s.x() = 1e300;
  EXPECT_FALSE(fall_to(s, 0, hour));
  EXPECT_FALSE(fall_to(start(0, 0, -60e3, {0, 0, 0}), 0, hour));
  EXPECT_FALSE(fall_to({}, 0, hour));
}

TEST(FreeFall, GradientAgainstCentralDifferences) {
  for (const test::TabulatedFall& row : test::tabulated_falls) {
    const PositionVelocity s = start(row);
    const Eigen::Matrix3d G = free_fall_gradient(s.position);
    for (int i = 0; i < 3; ++i) {
      constexpr double h = 100;
      const Eigen::Vector3d d = h * Eigen::Vector3d::Unit(i);
      const Eigen::Vector3d slope = (free_fall_acceleration({s.position.m + d}, s.velocity) -
                                     free_fall_acceleration({s.position.m - d}, s.velocity)) /
                                    (2 * h);
      // The third derivative of gravity leaves 1e-9 of it at this step.
      EXPECT_LT((G.col(i) - slope).norm(), 1e-8 * G.norm()) << row.name;
    }
  }
}

TEST(FreeFall, TransitionAgainstCentralDifferences) {
  for (const test::TabulatedFall& row : test::tabulated_falls) {
    const PositionVelocity s = start(row);
    const Eigen::Matrix<double, 6, 6> Phi = free_fall_transition(s, row.time_s);
    for (int i = 0; i < 6; ++i) {
      const Motion d = (i < 3 ? 50 : 0.5) * Motion::Unit(i);
      const Motion slope =
          (flown(motion_of(s) + d, row.time_s, 1000) - flown(motion_of(s) - d, row.time_s, 1000)) / (2 * d.norm());
      EXPECT_LT((Phi.col(i) - slope).head<3>().norm(), 1e-5 * slope.head<3>().norm()) << row.name << ' ' << i;
      EXPECT_LT((Phi.col(i) - slope).tail<3>().norm(), 1e-5 * slope.tail<3>().norm()) << row.name << ' ' << i;
    }
    EXPECT_TRUE(free_fall_transition(s, 0).isIdentity());
  }
}

}  // namespace
}  // namespace downrange
