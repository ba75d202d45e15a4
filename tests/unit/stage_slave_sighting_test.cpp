/// When an antenna sees its target: acquisition, loss, the highest elevation between.
#include <gtest/gtest.h>

#include <cmath>
#include <downrange/geo/nominal_trajectory.hpp>

#include "stage/slave/sighting.hpp"
#include "stage_slave_testing.hpp"

namespace downrange {
namespace {

using test::deg;
using test::liftoff;

Site site() { return test::small_range().antennas[0].site; }

/// A satellite's free fall from `from_s` on (0: it is highest).
PredictedPath satellite(double from_s, double highest_rad = 40 * deg) {
  const test::Fall pass = test::orbit_pass(site(), highest_rad, 0.3);
  PredictedPath path;
  path.fall(liftoff + seconds(from_s), pass(from_s));
  return path;
}

double elevation_at(const PredictedPath& path, Time at) {
  return seen_at(path, (at - path.from()).seconds(), site(), nullptr).elevation_rad;
}

TEST(Sighting, APassIsSeenFromTheHorizonToTheHorizon) {
  const PredictedPath path = satellite(-395);
  const Horizon horizon(5 * deg, {});
  const AntennaAccount pass = sighting(path, path.from(), site(), nullptr, horizon, path.from());
  EXPECT_FALSE(pass.in_view);
  ASSERT_TRUE(pass.acquisition_valid && pass.loss_valid && pass.highest_valid);
  EXPECT_NEAR(elevation_at(path, pass.acquisition), 5 * deg, 1e-3 * deg);
  EXPECT_NEAR(elevation_at(path, pass.loss), 5 * deg, 1e-3 * deg);
  EXPECT_LT(elevation_at(path, pass.acquisition - seconds(0.1)), 5 * deg);
  EXPECT_GT(elevation_at(path, pass.acquisition + seconds(0.1)), 5 * deg);
  EXPECT_NEAR((pass.highest - liftoff).seconds(), 0, 5);
  EXPECT_NEAR(pass.highest_elevation_rad, 40 * deg, 0.2 * deg);
  for (double s = -300; s < 300; s += 1) {
    EXPECT_LE(elevation_at(path, liftoff + seconds(s)), pass.highest_elevation_rad + 1e-6) << s;
  }
  EXPECT_NEAR(pass.acquisition_azimuth_rad,
              seen_at(path, (pass.acquisition - path.from()).seconds(), site(), nullptr).azimuth_rad, 1e-9);
}

TEST(Sighting, UnderWayOnlyTheRestCounts) {
  const PredictedPath path = satellite(60);
  const AntennaAccount pass =
      sighting(path, path.from(), site(), nullptr, Horizon(5 * deg, {}), path.from() + seconds(1.5));
  EXPECT_TRUE(pass.in_view);
  EXPECT_FALSE(pass.acquisition_valid);
  ASSERT_TRUE(pass.loss_valid && pass.highest_valid);
  EXPECT_NEAR(elevation_at(path, pass.loss), 5 * deg, 1e-3 * deg);
  EXPECT_NEAR((pass.highest - path.from()).seconds(), 1.5, 0.02) << "it sinks";
}

TEST(Sighting, AHillHidesIt) {
  const PredictedPath path = satellite(-395);
  const Horizon flat(0, {});
  const AntennaAccount open = sighting(path, path.from(), site(), nullptr, flat, path.from());
  const double rises = open.acquisition_azimuth_rad;
  const Horizon hill(0, {{wrap_two_pi(rises - 20 * deg), 0},
                         {wrap_two_pi(rises - 10 * deg), 12 * deg},
                         {wrap_two_pi(rises + 10 * deg), 12 * deg},
                         {wrap_two_pi(rises + 20 * deg), 0}});
  const AntennaAccount hidden = sighting(path, path.from(), site(), nullptr, hill, path.from());
  EXPECT_GT((hidden.acquisition - open.acquisition).seconds(), 20);
  EXPECT_EQ(hidden.loss, open.loss);
}

TEST(Sighting, WhatNeverRisesIsNotSeen) {
  const PredictedPath path = satellite(-395);
  const AntennaAccount pass = sighting(path, path.from(), site(), nullptr, Horizon(60 * deg, {}), path.from());
  EXPECT_FALSE(pass.in_view || pass.acquisition_valid || pass.loss_valid || pass.highest_valid);
}

TEST(Sighting, WhatIsStillSeenWhenThePredictionEndsHasNoLoss) {
  PredictedPath path;
  // Up and away: nine hundred seconds are not enough for it to set.
  path.fall(liftoff,
            {site().ecef_of({{0, 1e5, 3e5}}), {site().R_enu_ecef().R.transpose() * Eigen::Vector3d(0, 0, 9e3)}});
  const AntennaAccount pass = sighting(path, path.from(), site(), nullptr, Horizon(0, {}), path.from());
  EXPECT_TRUE(pass.in_view && pass.highest_valid);
  EXPECT_FALSE(pass.loss_valid);
}

/// A vehicle on its pad with a plan, seen by two antennas once a second.
class PlannedTest : public testing::Test {
 protected:
  PlannedTest() {
    std::vector<NominalSample> samples;
    for (int i = 0; i <= 60; ++i) samples.push_back({.t_s = 5.0 * i, .state = state_at(5.0 * i)});
    range.targets[0].nominal = NominalTrajectory(samples);
    method.known = false;
    method.path = state_at;
  }
  static PositionVelocity state_at(double t) {
    return {test::vehicle_at(t), {(test::vehicle_at(t + 0.01).m - test::vehicle_at(t - 0.01).m) / 0.02}};
  }
  std::vector<AntennaAccount> passes(std::optional<Time> lifted_off, std::optional<Time> planned, int ticks = 41) {
    Slave slave(range);
    test::Collector out;
    for (int i = 0; i < ticks; ++i) {
      const Time tick = liftoff - seconds(100) + seconds(i * range.tick.seconds());
      slave.tick(tick, std::vector<Followed>{{.method = &method, .newest = tick - seconds(1000)}}, lifted_off, out, {},
                 planned);
    }
    std::vector<AntennaAccount> known = out.of<AntennaAccount>();
    std::erase_if(known, [](const AntennaAccount& account) { return !account.pass_valid; });
    return known;
  }
  RangeConfig range = test::small_range();
  test::Knows method;
};

TEST_F(PlannedTest, BeforeLiftoffPassesCountFromThePlannedOne) {
  EXPECT_TRUE(passes({}, {}).empty()) << "nobody knows when";
  const auto found = passes({}, liftoff + seconds(20));
  ASSERT_EQ(found.size(), 4u) << "two antennas, two whole seconds";
  const AntennaAccount& jeju = found[1];
  EXPECT_EQ(jeju.antenna, range.antennas[1].id);
  EXPECT_EQ(jeju.target, range.targets[0].id);
  EXPECT_EQ(jeju.basis, PassBasis::PlannedLiftoff);
  EXPECT_FALSE(jeju.in_view);
  ASSERT_TRUE(jeju.acquisition_valid);
  const double t = (jeju.acquisition - liftoff).seconds() - 20;  // after lift-off
  const auto elevation = [&](double at) {
    return polar_from_enu(range.antennas[1].site.enu_of(test::vehicle_at(at))).elevation_rad;
  };
  EXPECT_LT(elevation(t - 0.2), 0);
  EXPECT_GT(elevation(t + 0.2), 0);
}

TEST_F(PlannedTest, AfterLiftoffByThePlan) {
  const auto found = passes(liftoff - seconds(110), {});
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found[0].basis, PassBasis::Plan);
  EXPECT_TRUE(found[0].in_view);
}

}  // namespace
}  // namespace downrange
