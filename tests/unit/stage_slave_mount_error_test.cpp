/// A mount's own pointing error: found from what it reads while it tracks, and taken out of its commands.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "stage/slave/mount_error.hpp"
#include "stage_slave_testing.hpp"

namespace downrange {
namespace {

using test::deg;

constexpr MountNoise noise{.sigma_azimuth_rad = 0.02 * deg,
                           .sigma_elevation_rad = 0.02 * deg,
                           .prior_rad = 0.2 * deg,
                           .drift_azimuth_rad_sqrt_s = 0.02 * deg / std::numbers::sqrt2 / 10,
                           .drift_elevation_rad_sqrt_s = 0.02 * deg / std::numbers::sqrt2 / 10};

/// Readings at 10 Hz of a mount that is off by what `error` says (azimuth, elevation, deg).
class Readings {
 public:
  explicit Readings(std::uint64_t seed) : rng_(seed) {}
  template <class Error>
  void feed(MountError& mount, double from_s, double to_s, Error&& error, double outliers = 0) {
    for (int i = 0; from_s + 0.1 * i < to_s; ++i) {
      const double t = from_s + 0.1 * i;
      const auto [azimuth, elevation] = error(t);
      const double off = uniform_(rng_) < outliers ? 3 : 0;
      mount.note(test::liftoff + seconds(t), (azimuth + off + 0.02 * normal_(rng_)) * deg,
                 (elevation + 0.02 * normal_(rng_)) * deg, 0.8, 0, 0);
    }
  }

 private:
  std::mt19937_64 rng_;
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> uniform_;
};

constexpr Time now = test::liftoff + seconds(60);
constexpr auto half_a_degree = [](double) { return std::pair{0.5, -0.3}; };

TEST(MountError, HalfADegreeIsKnownWithin002DegAndItsSigmaIsHonest) {
  int inside = 0;
  constexpr int seeds = 200;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    MountError mount(noise, 1 * deg);
    EXPECT_EQ(mount.at(now).azimuth_rad, 0);
    EXPECT_EQ(mount.at(now).sigma_azimuth_rad, noise.prior_rad);
    Readings(seed).feed(mount, 0, 60, half_a_degree);
    const MountOffset o = mount.at(now);
    EXPECT_NEAR(o.azimuth_rad, 0.5 * deg, 0.02 * deg) << seed;
    EXPECT_NEAR(o.elevation_rad, -0.3 * deg, 0.02 * deg) << seed;
    if (std::abs(o.azimuth_rad - 0.5 * deg) < 1.96 * o.sigma_azimuth_rad) ++inside;
  }
  // The error does not drift here as it may: the sigma is rather large.
  EXPECT_GE(inside, 0.93 * seeds);
}

TEST(MountError, ItIsFollowedAsItDriftsAndAsTheSigmaSays) {
  int inside = 0;
  constexpr int seeds = 300;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    MountError mount(noise, 1 * deg);
    std::mt19937_64 rng(seed + 1000);
    std::normal_distribution<double> step(0, noise.drift_azimuth_rad_sqrt_s / deg * std::sqrt(0.1));
    double walked = 0.3;
    Readings(seed).feed(mount, 0, 60, [&](double) { return std::pair{walked += step(rng), 0.0}; });
    if (std::abs(mount.at(now).azimuth_rad - walked * deg) < 1.96 * mount.at(now).sigma_azimuth_rad) ++inside;
  }
  EXPECT_GE(inside, 0.92 * seeds);
  EXPECT_LE(inside, 0.98 * seeds);
}

TEST(MountError, ABumpIsTakenOverAfterASecondAndUntilThenWhatWasKnownIsKept) {
  MountError mount(noise, 1 * deg);
  Readings readings(1);
  readings.feed(mount, 0, 20, [](double) { return std::pair{0.1, 0.0}; });
  readings.feed(mount, 20, 21, [](double) { return std::pair{0.6, 0.0}; });
  EXPECT_NEAR(mount.at(now).azimuth_rad, 0.1 * deg, 0.02 * deg);
  readings.feed(mount, 21, 23, [](double) { return std::pair{0.6, 0.0}; });
  EXPECT_NEAR(mount.at(now).azimuth_rad, 0.6 * deg, 0.03 * deg);
}

TEST(MountError, OutliersBeginNothingAnew) {
  MountError mount(noise, 1 * deg);
  Readings readings(2);
  readings.feed(mount, 0, 20, half_a_degree);
  for (int t = 20; t < 120; ++t) {
    readings.feed(mount, t, t + 1, half_a_degree, 0.1);
    ASSERT_NEAR(mount.at(now).azimuth_rad, 0.5 * deg, 0.02 * deg) << t;
  }
}

TEST(MountError, WhatIsTooLargeIsNoErrorOfAMount) {
  MountError mount(noise, 1 * deg);
  Readings readings(3);
  readings.feed(mount, 0, 20, half_a_degree);
  readings.feed(mount, 20, 40, [](double) { return std::pair{1.6, 0.0}; });  // a side lobe
  EXPECT_EQ(mount.at(now).azimuth_rad, 0);
  EXPECT_EQ(mount.at(now).elevation_rad, 0);
  EXPECT_NEAR(mount.at(now).sigma_azimuth_rad, 1 * deg, 0.01 * deg);
  readings.feed(mount, 40, 60, half_a_degree);
  EXPECT_NEAR(mount.at(now).azimuth_rad, 0.5 * deg, 0.02 * deg);
}

TEST(MountError, WhatTheTrackIsOffIsMetWhileItTracksAndFadesAfterwards) {
  MountError mount(noise, 1 * deg);
  const auto read = [&](double t, double off_deg, double track_sigma_deg) {
    mount.note(test::liftoff + seconds(t), off_deg * deg, 0, 0.8, track_sigma_deg * deg, track_sigma_deg * deg);
  };
  for (int i = 0; i < 600; ++i) read(0.1 * i, 0.5, 0.01);
  // A poor track now: it is off by 0.2 deg, the mount is not.
  for (int i = 600; i < 650; ++i) read(0.1 * i, 0.7, 0.3);
  const auto at = [&](double t) { return mount.at(test::liftoff + seconds(t)).azimuth_rad / deg; };
  EXPECT_NEAR(at(65), 0.7, 0.02);
  EXPECT_NEAR(at(70), 0.5 + 0.2 * std::exp(-1), 0.03);
  EXPECT_NEAR(at(125), 0.5, 0.03);
}

TEST(MountError, LateReadingsAndReadingsTwiceChangeNothing) {
  MountError a(noise, 1 * deg);
  MountError b(noise, 1 * deg);
  Readings(4).feed(a, 0, 10, half_a_degree);
  Readings(4).feed(b, 0, 10, half_a_degree);
  b.note(test::liftoff + seconds(5), 0, 0, 0.8, 0, 0);
  EXPECT_EQ(a.at(now).azimuth_rad, b.at(now).azimuth_rad);
}

/// A climb followed by a method that knows it, and a tracker on the mount of the first antenna.
class MountOfAntennaTest : public testing::Test {
 protected:
  MountOfAntennaTest() {
    AngleSensorConfig tracker = test::small_tracker();
    tracker.site = range.antennas[0].site;
    tracker.sigma_azimuth_rad = tracker.sigma_elevation_rad = 0.02 * deg;
    range.angle_sensors.push_back(tracker);
    range.antennas[0].sensor = tracker.id;
    range.antennas[0].beamwidth_rad = 1 * deg;
    method.path = [](double t) {
      const Eigen::Vector3d v = (test::vehicle_at(t + 0.01).m - test::vehicle_at(t - 0.01).m) / 0.02;
      return PositionVelocity{test::vehicle_at(t), {v}};
    };
  }

  /// Ticks from `from_s` on; between them the mount reads the target `off` too much while it tracks.
  std::vector<SlavingCommand> fly(Slave& slave, double from_s, double to_s, bool tracks, double off_azimuth_rad = 0,
                                  double off_elevation_rad = 0) {
    test::Collector out;
    for (Time tick = test::liftoff + seconds(from_s); tick < test::liftoff + seconds(to_s); tick = tick + range.tick) {
      if (tracks && tick.ns % 100'000'000 == 0) {
        Observation o;
        o.sensor = range.angle_sensors[0].id;
        o.target = "kslv";
        o.epoch = tick - milliseconds(60);
        const Polar q =
            polar_from_enu(range.antennas[0].site.enu_of(test::vehicle_at((o.epoch - test::liftoff).seconds())));
        o.measured = Angles{.azimuth_rad = q.azimuth_rad + off_azimuth_rad + 0.02 * deg * normal(rng),
                            .elevation_rad = q.elevation_rad + off_elevation_rad + 0.02 * deg * normal(rng)};
        slave.note(o);
      }
      method.data_epoch = data_epoch.value_or(tick);
      slave.tick(tick, std::vector<Followed>{{.method = &method, .newest = tick}}, test::liftoff, out);
    }
    std::vector<SlavingCommand> first;
    for (const SlavingCommand& c : out.of<SlavingCommand>())
      if (c.antenna == range.antennas[0].id) first.push_back(c);
    return first;
  }
  /// Where the mount must read to point at the target, less where it is told to read.
  [[nodiscard]] std::pair<double, double> left(const SlavingCommand& c, double off_azimuth_rad,
                                               double off_elevation_rad) const {
    const Polar q =
        polar_from_enu(range.antennas[0].site.enu_of(test::vehicle_at((c.apply_at - test::liftoff).seconds())));
    return {wrap_pi(q.azimuth_rad + off_azimuth_rad - c.azimuth_rad),
            q.elevation_rad + off_elevation_rad - c.elevation_rad};
  }

  RangeConfig range = test::small_range();
  test::Knows method;
  std::optional<Time> data_epoch;
  std::mt19937_64 rng{7};
  std::normal_distribution<double> normal;
};

TEST_F(MountOfAntennaTest, AnErrorOfHalfADegreeIsOutOfTheCommandsWithoutAStep) {
  Slave slave(range);
  constexpr double off = 0.5 * deg;
  auto commands = fly(slave, 30, 90, true, off, -off);
  for (std::size_t i = 1; i < commands.size(); ++i) {
    const SlavingCommand& a = commands[i - 1];
    const SlavingCommand& b = commands[i];
    const double most = range.slave.blend_rate_rad_s * range.tick.seconds() + 0.01 * deg;
    const double dt = range.tick.seconds();
    EXPECT_LT(std::abs(b.elevation_rad - a.elevation_rad - dt * (a.elevation_rate_rad_s + b.elevation_rate_rad_s) / 2),
              most)
        << i;
  }
  const auto [azimuth, elevation] = left(commands.back(), off, -off);
  EXPECT_LT(std::abs(azimuth), 0.02 * deg);
  EXPECT_LT(std::abs(elevation), 0.02 * deg);
  EXPECT_NEAR(commands.back().mount_azimuth_rad, off, 0.02 * deg);
  EXPECT_NEAR(commands.back().mount_elevation_rad, -off, 0.02 * deg);
  EXPECT_LT(commands.back().off_target_rad, 0.01 * deg) << "a mount that is told to read wrongly is not off its target";

  // Slaved it goes on with what it knows: nothing is read.
  commands = fly(slave, 90, 100, false);
  EXPECT_LT(std::abs(left(commands.back(), off, -off).first), 0.02 * deg);

  // Bumped in flight.
  commands = fly(slave, 100, 160, true, off - 0.5 * deg, 0.2 * deg);
  EXPECT_LT(std::abs(left(commands.back(), 0, 0.2 * deg).first), 0.02 * deg);
  EXPECT_LT(std::abs(left(commands.back(), 0, 0.2 * deg).second), 0.02 * deg);
}

TEST_F(MountOfAntennaTest, WhatWasReadWhileItWasStoppedIsNotHeldAgainstALaterTrack) {
  Slave slave(range);
  (void)fly(slave, 30, 60, true, 0.3 * deg);
  // Stopped: it reads on, and nobody asks; a manoeuvre that the later track does not know leads it 0.4 deg away.
  for (int i = 0; i < 600; ++i) {
    Observation o;
    o.sensor = range.angle_sensors[0].id;
    o.target = "kslv";
    o.epoch = test::liftoff + seconds(60 + 0.1 * i);
    const Polar q = polar_from_enu(range.antennas[0].site.enu_of(test::vehicle_at(60 + 0.1 * i)));
    o.measured = Angles{.azimuth_rad = q.azimuth_rad + 0.7 * deg, .elevation_rad = q.elevation_rad};
    slave.note(o);
  }
  for (const SlavingCommand& c : fly(slave, 120, 125, false)) {
    EXPECT_NEAR(c.mount_azimuth_rad, 0.3 * deg, 0.02 * deg);
    EXPECT_NEAR(c.mount_elevation_rad, 0, 0.02 * deg);
  }
}

TEST_F(MountOfAntennaTest, UntilItIsKnownTheCommandsSigmaHasThePrior) {
  Slave slave(range);
  const SlavingCommand before = fly(slave, 30, 31, false).back();
  EXPECT_GT(before.sigma_elevation_rad, 0.2 * deg);
  EXPECT_LT(before.probability_in_beam, 0.99);
  const SlavingCommand after = fly(slave, 31, 60, true).back();
  EXPECT_LT(after.sigma_elevation_rad, 0.02 * deg);
  EXPECT_GT(after.probability_in_beam, 0.999);
}

TEST_F(MountOfAntennaTest, NothingIsLearntOfAPredictionOrOfAnotherTargetOrSensor) {
  Slave slave(range);
  data_epoch = test::liftoff + seconds(29);  // coasting
  EXPECT_EQ(fly(slave, 30, 33, true, 0.5 * deg).back().mount_azimuth_rad, 0);
  data_epoch.reset();
  Observation o;
  o.sensor = range.radars[0].id;
  o.target = "kslv";
  for (int i = 0; i < 100; ++i) {
    o.epoch = test::liftoff + seconds(33 + 0.02 * i);
    o.measured = Plot{.measured = {1e4, 1, 1}};
    slave.note(o);
  }
  EXPECT_EQ(fly(slave, 35, 36, false).back().mount_azimuth_rad, 0);
}

TEST_F(MountOfAntennaTest, ARadarOnTheMountTellsItToo) {
  range.antennas[0].sensor = range.radars[0].id;
  range.angle_sensors[0].id = range.radars[0].id;  // as `fly` names what reads
  Slave slave(range);
  EXPECT_NEAR(fly(slave, 30, 60, true, 0.4 * deg).back().mount_azimuth_rad, 0.4 * deg, 0.02 * deg);
}

}  // namespace
}  // namespace downrange
