/// What operators want of an antenna: stop, trim, another target, a chain of its own.
#include <gtest/gtest.h>

#include <cmath>

#include "stage_slave_testing.hpp"

namespace downrange {
namespace {

using test::deg;
using test::Told;

constexpr double newest_s = 60;

TrackEstimate estimate_at(double t) {
  TrackEstimate e;
  e.epoch = e.data_epoch = test::liftoff + seconds(t);
  e.mean.head<3>() = test::vehicle_at(t).m;
  e.mean.segment<3>(3) = (test::vehicle_at(t + 0.01).m - test::vehicle_at(t - 0.01).m) / 0.02;
  e.cov.topLeftCorner<6, 6>() = Mat<6, 6>::Identity() * 100;
  return e;
}

/// Two targets: the vehicle, and what was a vehicle ten seconds before it.
class AntennaWillTest : public testing::Test {
 protected:
  AntennaWillTest() {
    range.targets.push_back({.id = "stage-1"});
    vehicle.fused_track = estimate_at(newest_s);
    stage.fused_track = estimate_at(newest_s - 10);
    stage.fused_track->data_epoch = vehicle.fused_track->data_epoch;
    will.resize(range.antennas.size());
  }

  /// The commands of tick `i` after the first.
  std::vector<SlavingCommand> tick(Slave& slave, int i) {
    const Time now = test::liftoff + seconds(newest_s) + seconds(i * range.tick.seconds());
    for (Told* told : {&vehicle, &stage}) told->fused_track->data_epoch = now;
    const std::vector<Followed> followed{{.method = &vehicle, .newest = now}, {.method = &stage, .newest = now}};
    test::Collector out;
    slave.tick(now, followed, {}, out, will);
    return out.of<SlavingCommand>();
  }

  RangeConfig range = test::small_range();
  Told vehicle;
  Told stage;
  std::vector<AntennaWill> will;
};

TEST_F(AntennaWillTest, AStoppedAntennaHasNoCommandTheOthersHave) {
  Slave slave(range);
  will[0].stopped = true;
  const auto commands = tick(slave, 0);
  ASSERT_EQ(commands.size(), range.antennas.size() - 1);
  EXPECT_EQ(commands.front().antenna, range.antennas[1].id);
  will[0].stopped = false;
  EXPECT_EQ(tick(slave, 1).size(), range.antennas.size());
}

TEST_F(AntennaWillTest, ATrimIsAddedWithoutAStepAndIsNoError) {
  Slave slave(range);
  Slave untrimmed(range);
  const SlavingCommand before = tick(slave, 0).front();
  will[0].azimuth_trim_rad = 1 * deg;
  will[0].elevation_trim_rad = -0.5 * deg;
  SlavingCommand last = before;
  for (int i = 1; i <= 40; ++i) {
    const SlavingCommand c = tick(slave, i).front();
    const double most = range.slave.blend_rate_rad_s * range.tick.seconds() + 1e-4;
    EXPECT_LT(std::hypot((c.azimuth_rad - last.azimuth_rad) * std::cos(c.elevation_rad),
                         c.elevation_rad - last.elevation_rad),
              most)
        << i;
    last = c;
  }
  will[0] = {};
  const SlavingCommand plain = tick(untrimmed, 40).front();
  EXPECT_NEAR(last.azimuth_rad - plain.azimuth_rad, 1 * deg, 1e-9);
  EXPECT_NEAR(last.elevation_rad - plain.elevation_rad, -0.5 * deg, 1e-9);
  EXPECT_LT(last.off_target_rad, 0.01 * deg) << "the mount that is told so is on its target";
}

TEST_F(AntennaWillTest, AnotherTargetIsReachedWithoutAStepAndLeftAgain) {
  Slave slave(range);
  const SlavingCommand before = tick(slave, 0).front();
  EXPECT_EQ(before.target, Name("kslv"));
  will[0].target = 1;
  const auto at_once = tick(slave, 1);
  EXPECT_EQ(at_once[0].target, Name("stage-1"));
  EXPECT_EQ(at_once[1].target, Name("kslv")) << "another antenna";
  EXPECT_NEAR(at_once[0].elevation_rad, before.elevation_rad, 0.3 * deg);
  for (int i = 2; i <= 400; ++i) (void)tick(slave, i);
  Slave of_stage(range);
  const SlavingCommand there = tick(slave, 401).front();
  EXPECT_NEAR(there.elevation_rad, tick(of_stage, 401).front().elevation_rad, 1e-6);
  will[0].target.reset();
  EXPECT_EQ(tick(slave, 402).front().target, Name("kslv"));
}

TEST_F(AntennaWillTest, APinnedChainIsFollowedWhileItHasATrackAndIsUnbounded) {
  Slave slave(range);
  Told alone;
  alone.fused_track = estimate_at(newest_s + 5);
  const auto pin = [&](int i) {
    const Time now = test::liftoff + seconds(newest_s) + seconds(i * range.tick.seconds());
    alone.fused_track->data_epoch = now;
    will[0].pinned = Followed{.method = &alone, .newest = now, .chain = "only-goheung"};
  };
  pin(0);
  const auto commands = tick(slave, 0);
  EXPECT_EQ(commands[0].chain, Name("only-goheung"));
  EXPECT_FALSE(commands[0].bound_valid);
  EXPECT_TRUE(commands[1].chain.empty()) << "another antenna";
  alone.fused_track.reset();
  will[0].pinned->newest = test::liftoff + seconds(newest_s) + range.tick;
  EXPECT_TRUE(tick(slave, 1).front().chain.empty()) << "nothing to follow there";
}

}  // namespace
}  // namespace downrange
