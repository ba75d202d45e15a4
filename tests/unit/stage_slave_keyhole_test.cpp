/// What operators order while an antenna passes the zenith by a plan: no order leaves it looking elsewhere.
#include <gtest/gtest.h>

#include <cmath>

#include "stage/slave/look.hpp"
#include "stage_slave_testing.hpp"

namespace downrange {
namespace {

using test::deg;

/// A satellite that passes at 89.5 deg at 0 s, past one antenna of 15 deg/s and 20 deg/s^2 (or what a test makes of
/// it).
class KeyholeTest : public testing::TestWithParam<double> {
 protected:
  KeyholeTest() {
    range = test::mount_range();
    range.antennas[0].elevation_max_rad = GetParam() * deg;
    range.targets.push_back({.id = "another"});
    method.path = test::orbit_pass(range.antennas[0].site, 89.5 * deg, 0.3);
    other.path = test::orbit_pass(range.antennas[0].site, 60 * deg, 1.2);
  }

  /// Ticks over [from_s, to_s); `order(t)`: what operators want of the antenna, `seen(t, off_rad, command)` of its
  /// mount.
  template <class Order, class Seen>
  void fly(double from_s, double to_s, Order&& order, Seen&& seen) {
    Slave slave(range);
    test::Mount mount;
    std::vector<AntennaWill> will(range.antennas.size());
    for (int i = 0; from_s + i * range.tick.seconds() < to_s; ++i) {
      const double t = from_s + i * range.tick.seconds();
      const Time tick = test::liftoff + seconds(t);
      method.data_epoch = other.data_epoch = tick;
      const std::vector<Followed> followed{{.method = &method, .newest = tick}, {.method = &other, .newest = tick}};
      will[0] = order(t);
      test::Collector out;
      slave.tick(tick, followed, test::liftoff, out, will);
      const AntennaConfig& antenna = range.antennas[0];
      for (const SlavingCommand& c : out.of<SlavingCommand>()) {
        if (c.antenna == antenna.id) mount.take(c);
      }
      const Time at = tick + antenna.link_delay + antenna.lead + range.tick;
      for (int k = 4; k >= 0; --k) mount.step(at - milliseconds(5L * k), 0.005);
      if (!mount.newest) continue;
      const test::Knows& target = will[0].target.value_or(0) == 1 ? other : method;
      const Polar q = polar_from_enu(antenna.site.enu_of(target.path((at - test::liftoff).seconds()).position));
      // A trim is one of the axes: they read that much more than where the antenna points.
      test::Mount points = mount;
      points.azimuth.angle -= will[0].azimuth_trim_rad;
      points.elevation.angle -= will[0].elevation_trim_rad;
      seen(t, points.off(q), *mount.newest);
    }
  }
  [[nodiscard]] double worst(double from_s, double to_s, const std::function<AntennaWill(double)>& order = nothing) {
    double most = 0;
    fly(from_s, to_s, order, [&](double t, double off, const SlavingCommand&) {
      if (t > from_s + 5) most = std::max(most, off);
    });
    return most;
  }
  static AntennaWill nothing(double) { return {}; }

  RangeConfig range;
  test::Knows method;
  test::Knows other;
};

TEST_P(KeyholeTest, StoppedAndReleasedAtAnySecondItIsOnItsTargetAgain) {
  for (double stopped_s = -14; stopped_s <= 14; stopped_s += 2) {
    fly(
        -40, stopped_s + 40, [&](double t) { return AntennaWill{.stopped = t >= stopped_s && t < stopped_s + 4}; },
        [&](double t, double off, const SlavingCommand& c) {
          if (t < stopped_s + 34) return;
          EXPECT_LT(off, 0.05 * deg) << stopped_s << ' ' << t;
          EXPECT_LT(c.off_target_rad, 0.05 * deg) << stopped_s;
          EXPECT_EQ(c.limits, LimitNone) << stopped_s << ' ' << t;
        });
  }
}

TEST_P(KeyholeTest, SentToAnotherTargetAtAnySecondItGetsThereAndBack) {
  const double blended_s = 60 / (range.slave.blend_rate_rad_s / deg);  // the two are up to 60 deg apart
  for (double sent_s = -14; sent_s <= 14; sent_s += 2) {
    const double back_s = sent_s + 5 + blended_s;
    SlavingCommand last;
    fly(
        -40, back_s + blended_s + 20,
        [&](double t) { return AntennaWill{.target = t >= sent_s && t < back_s ? std::optional(1) : std::nullopt}; },
        [&](double t, double off, const SlavingCommand& c) {
          if (t > back_s - 1 && t < back_s - 0.1) {
            EXPECT_LT(off, 0.1 * deg) << sent_s << ' ' << t;
          }
          if (t > back_s + blended_s + 10) {
            EXPECT_LT(off, 0.1 * deg) << sent_s << ' ' << t;
          }
          if (t > sent_s && t < sent_s + 1) {
            const double moved = separation_rad(c.azimuth_rad, c.elevation_rad, last.azimuth_rad, last.elevation_rad);
            EXPECT_LT(moved, 15 * deg * 0.025 + 0.2 * deg) << sent_s << ' ' << t << ": a step on the sky";
          }
          last = c;
        });
  }
}

TEST_P(KeyholeTest, ATrimmedAntennaPassesTheZenithAsWell) {
  const double plain = worst(-60, 60);
  for (const double trim : {3 * deg, -3 * deg}) {
    EXPECT_LT(worst(-60, 60, [&](double) { return AntennaWill{.azimuth_trim_rad = trim}; }), 1.1 * plain) << trim;
  }
}

TEST_P(KeyholeTest, ATrimInElevationKeepsInsideTheTravel) {
  for (const double trim : {0.3 * deg, -0.3 * deg}) {
    fly(
        -60, 60, [&](double) { return AntennaWill{.elevation_trim_rad = trim}; },
        [&](double t, double off, const SlavingCommand& c) {
          EXPECT_LE(c.elevation_rad, range.antennas[0].elevation_max_rad);
          EXPECT_GE(c.elevation_rad, range.antennas[0].elevation_min_rad);
          if (std::abs(t) > 40) {
            EXPECT_LT(off, 0.05 * deg) << trim << ' ' << t;
          }
        });
  }
}

TEST_P(KeyholeTest, WhereAnotherAntennaIsPinnedToIsNoMatterOfThisOne) {
  const double plain = worst(-60, 60);
  // The pinned one comes first in the range.
  range.antennas.insert(range.antennas.begin(), range.antennas[0]);
  range.antennas[0].id = "pinned";
  test::Knows liar;
  liar.path = test::orbit_pass(range.antennas[0].site, 40 * deg, 2);
  Slave slave(range);
  test::Mount mount;
  double most = 0;
  std::vector<AntennaWill> will(2);
  for (double t = -60; t < 60; t += range.tick.seconds()) {
    const Time tick = ceil_to_grid(test::liftoff + seconds(t), range.tick);
    method.data_epoch = other.data_epoch = liar.data_epoch = tick;
    will[0].pinned = Followed{.method = &liar, .newest = tick, .chain = "only-liar"};
    test::Collector out;
    slave.tick(tick, std::vector<Followed>{{.method = &method, .newest = tick}, {.method = &other, .newest = tick}},
               test::liftoff, out, will);
    for (const SlavingCommand& c : out.of<SlavingCommand>()) {
      if (c.antenna == range.antennas[1].id) mount.take(c);
    }
    const Time at = tick + range.antennas[1].link_delay + range.antennas[1].lead + range.tick;
    for (int k = 4; k >= 0; --k) mount.step(at - milliseconds(5L * k), 0.005);
    const Polar q = polar_from_enu(range.antennas[1].site.enu_of(method.path((at - test::liftoff).seconds()).position));
    if (t > -55) most = std::max(most, mount.off(q));
  }
  EXPECT_LT(most, 1.1 * plain);
}

INSTANTIATE_TEST_SUITE_P(Mounts, KeyholeTest, testing::Values(90.0, 180.0),
                         [](const auto& mount) { return "ElevationTo" + std::to_string(int(mount.param)); });

}  // namespace
}  // namespace downrange
