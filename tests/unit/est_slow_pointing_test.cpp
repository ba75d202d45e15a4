/// What methods with states of wander make of radars whose angles are inflated.
#include <gtest/gtest.h>

#include <downrange/est/model/slow_pointing.hpp>

namespace downrange {
namespace {

RadarModel inflated(double inflation) {
  RadarModel radar;
  radar.sigma = {.range_m = 25, .azimuth_rad = 2e-4, .elevation_rad = 1e-4};
  radar.angle_inflation = inflation;
  return radar;
}

TEST(SlowPointing, InflatedAnglesGetAWanderOfHalfTheInstrumentsNoise) {
  const RadarModel radar = with_wander_as_states({inflated(4)}).front();
  EXPECT_DOUBLE_EQ(radar.wander.sigma_rad, 0.5 * 1e-4) << "of the larger axis: 2e-4 with the inflation, 1e-4 without";
  EXPECT_EQ(radar.wander.tau_s, 100);
  EXPECT_EQ(radar.sigma.azimuth_rad, 2e-4) << "what is faster stays noise";
  EXPECT_EQ(radar.angle_inflation, 4);
}

TEST(SlowPointing, WhatIsConfiguredStays) {
  RadarModel known = inflated(4);
  known.wander = {.sigma_rad = 3e-4, .tau_s = 10};
  const auto radars = with_wander_as_states({known, inflated(1)});
  EXPECT_EQ(radars[0].wander.sigma_rad, 3e-4);
  EXPECT_EQ(radars[0].wander.tau_s, 10);
  EXPECT_EQ(radars[1].wander.sigma_rad, 0) << "its noise is white, and it stands still";
}

}  // namespace
}  // namespace downrange
