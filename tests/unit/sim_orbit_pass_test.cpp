/// A satellite's pass: horizon to horizon, free fall, the height of its orbit.
#include <gtest/gtest.h>

#include <cmath>
#include <downrange/geo/earth.hpp>
#include <downrange/geo/polar.hpp>
#include <numbers>
#include <stdexcept>

#include "sim/orbit_pass.hpp"

namespace downrange::sim {
namespace {

constexpr Time rise{1'772'352'000'000'000'000};
constexpr double deg = std::numbers::pi / 180;

TEST(OrbitPass, GoesFromHorizonToHorizon) {
  const OrbitPass pass(naro_orbit_pass(), rise);
  const Site site(naro_orbit_pass().over);
  const auto elevation = [&](double t_s) {
    return polar_from_enu(site.enu_of(pass.at(rise + seconds(t_s))->position)).elevation_rad / deg;
  };
  EXPECT_GT(pass.duration_s(), 500);
  EXPECT_LT(pass.duration_s(), 700);
  // 400 km above, one second at each horizon is some 0.1 degrees.
  EXPECT_GE(elevation(0), 0);
  EXPECT_LT(elevation(0), 0.2);
  EXPECT_LT(elevation(pass.duration_s()), 0.2);
  EXPECT_NEAR(elevation(std::round(pass.duration_s() / 2)), 55, 5);
  EXPECT_FALSE(pass.at(rise - seconds(1)));
  EXPECT_FALSE(pass.at(rise + seconds(pass.duration_s() + 1)));
}

TEST(OrbitPass, FallsFreelyInACircle) {
  const OrbitPass pass(naro_orbit_pass(), rise);
  for (double t_s = 1; t_s < pass.duration_s() - 1; t_s += 50) {
    const auto state = *pass.at(rise + seconds(t_s));
    // J2 lifts and lowers the orbit by a few kilometres round the Earth, less within a pass.
    EXPECT_NEAR(state.position.m.norm(), wgs84::semi_major_axis_m + 400e3, 2e3) << t_s;
    const Eigen::Vector3d before = pass.at(rise + seconds(t_s - 1))->velocity.m_s;
    const Eigen::Vector3d after = pass.at(rise + seconds(t_s + 1))->velocity.m_s;
    const Eigen::Vector3d expected = free_fall_acceleration(state.position, state.velocity);
    EXPECT_LT(((after - before) / 2 - expected).norm(), 1e-4) << t_s;
  }
}

TEST(OrbitPass, BelowTheHorizonThereIsNone) {
  OrbitPassProfile profile = naro_orbit_pass();
  profile.off_centre_rad = 30 * deg;
  EXPECT_THROW(OrbitPass(profile, rise), std::invalid_argument);
}

}  // namespace
}  // namespace downrange::sim
