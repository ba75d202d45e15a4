/// Slaving: cable travel, exact parallax, rates, sigma, the ladder of sources, no command rather than a wrong one.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "stage/slave/travel.hpp"
#include "stage_slave_testing.hpp"

namespace downrange {
namespace {

using test::deg;
using test::Told;

TEST(Travel, NearestTurnInsideTheTravel) {
  const double min = -270 * deg;
  const double max = 270 * deg;
  EXPECT_NEAR(unwrap_into_travel(350 * deg, std::nullopt, min, max).azimuth_rad, -10 * deg, 1e-12);
  // Crossing north going east: stays continuous.
  EXPECT_NEAR(unwrap_into_travel(2 * deg, 359 * deg - 360 * deg, min, max).azimuth_rad, 2 * deg, 1e-12);
  EXPECT_NEAR(unwrap_into_travel(359 * deg, 1 * deg, min, max).azimuth_rad, -1 * deg, 1e-12);
  // Running on past 180 up to the end of the cable ...
  EXPECT_NEAR(unwrap_into_travel(200 * deg, 199 * deg, min, max).azimuth_rad, 200 * deg, 1e-12);
  // ... and a little beyond it, where a target may hover ...
  const TravelAzimuth hovers = unwrap_into_travel(270.9 * deg, 269.9 * deg, min, max);
  EXPECT_EQ(hovers.azimuth_rad, max);
  EXPECT_EQ(hovers.limits, LimitAzimuth);
  // ... and farther: once around, and said so.
  const TravelAzimuth around = unwrap_into_travel(271.1 * deg, 269.9 * deg, min, max);
  EXPECT_NEAR(around.azimuth_rad, -88.9 * deg, 1e-12);
  EXPECT_EQ(around.limits, LimitUnwrapped);
  // Less than a full turn of travel: the end that is nearer.
  const TravelAzimuth held = unwrap_into_travel(100 * deg, std::nullopt, -80 * deg, 80 * deg);
  EXPECT_NEAR(held.azimuth_rad, 80 * deg, 1e-12);
  EXPECT_EQ(held.limits, LimitAzimuth);
  // Opposite to the middle of the travel the end that is held stays.
  EXPECT_EQ(unwrap_into_travel(179.5 * deg, -80 * deg, -80 * deg, 80 * deg).azimuth_rad, -80 * deg);
  EXPECT_EQ(unwrap_into_travel(-179.5 * deg, 80 * deg, -80 * deg, 80 * deg).azimuth_rad, 80 * deg);
  EXPECT_EQ(unwrap_into_travel(178.5 * deg, -80 * deg, -80 * deg, 80 * deg).azimuth_rad, 80 * deg);
}

/// Measurements that come in all the time.
const Time newest = test::liftoff + seconds(60.0);

std::vector<Followed> only(const Method& method) { return {{.method = &method, .newest = newest}}; }

TrackEstimate estimate_at(double t) {
  TrackEstimate e;
  e.epoch = e.data_epoch = test::liftoff + seconds(t);
  e.mean.head<3>() = test::vehicle_at(t).m;
  e.mean.segment<3>(3) = (test::vehicle_at(t + 0.01).m - test::vehicle_at(t - 0.01).m) / 0.02;
  e.cov.topLeftCorner<6, 6>() = Mat<6, 6>::Identity() * 100;
  return e;
}

TEST(Slave, PointsAtTheTargetFromItsOwnSiteAtTheInstantOfApplication) {
  const RangeConfig range = test::small_range();
  Told method;
  method.fused_track = estimate_at(60);
  Slave slave(range);
  test::Collector out;
  const Time tick = test::liftoff + seconds(60.0);
  slave.tick(tick, only(method), {}, out);
  const auto commands = out.of<SlavingCommand>();
  ASSERT_EQ(commands.size(), range.antennas.size());
  for (std::size_t i = 0; i < commands.size(); ++i) {
    const SlavingCommand& c = commands[i];
    const Site& site = range.antennas[i].site;
    EXPECT_EQ(c.apply_at, tick + milliseconds(50));
    EXPECT_EQ(c.valid_until, c.apply_at + range.slave.validity);
    EXPECT_NEAR(c.age_s, 0.05, 1e-9);
    EXPECT_EQ(c.source, SlavingSource::Fused);
    // Truth half a tick later: the climb's acceleration over 50 ms is centimetres.
    const Polar exact = polar_from_enu(site.enu_of(test::vehicle_at(60.05)));
    EXPECT_NEAR(wrap_pi(c.azimuth_rad - exact.azimuth_rad), 0, 1e-6);
    EXPECT_NEAR(c.elevation_rad, exact.elevation_rad, 1e-6);
    EXPECT_NEAR(c.range_m, exact.range_m, 0.1);
    // Rates against central differences of the exact look angle.
    const Polar before = polar_from_enu(site.enu_of(test::vehicle_at(59.95)));
    const Polar after = polar_from_enu(site.enu_of(test::vehicle_at(60.15)));
    EXPECT_NEAR(c.azimuth_rate_rad_s, wrap_pi(after.azimuth_rad - before.azimuth_rad) / 0.2, 2e-5);
    EXPECT_NEAR(c.elevation_rate_rad_s, (after.elevation_rad - before.elevation_rad) / 0.2, 2e-5);
    EXPECT_NEAR(c.range_rate_m_s, (after.range_m - before.range_m) / 0.2, 1.0);
    // An isotropic 10 m is 10 m over the range in elevation, over the horizontal range in azimuth.
    EXPECT_NEAR(c.sigma_elevation_rad, 10 / c.range_m, 1e-6 * 10);
    EXPECT_NEAR(c.sigma_azimuth_rad, 10 / (c.range_m * std::cos(c.elevation_rad)), 1e-5);
  }
  // Parallax: two antennas, two directions.
  EXPECT_GT(std::abs(wrap_pi(commands[0].azimuth_rad - commands[1].azimuth_rad)), 1 * deg);
}

TEST(Slave, LadderOfSources) {
  const RangeConfig range = test::small_range();
  const auto source_after = [&](Duration fused_age, std::optional<Duration> gps_age) -> std::optional<SlavingSource> {
    Told method;
    const Time tick = test::liftoff + seconds(60.0);
    method.fused_track = estimate_at(60);
    method.fused_track->data_epoch = tick - fused_age;
    if (gps_age) {
      method.gps = estimate_at(60);
      method.gps->data_epoch = tick - *gps_age;
    }
    test::Collector out;
    Slave(range).tick(tick, only(method), {}, out);
    const auto commands = out.of<SlavingCommand>();
    if (commands.empty()) return std::nullopt;
    return commands[0].source;
  };
  EXPECT_EQ(source_after(milliseconds(500), {}), SlavingSource::Fused);
  EXPECT_EQ(source_after(milliseconds(501), {}), SlavingSource::Coasting);
  EXPECT_EQ(source_after(milliseconds(5000), milliseconds(100)), SlavingSource::Coasting);
  EXPECT_EQ(source_after(milliseconds(5001), milliseconds(100)), SlavingSource::Gps);
  EXPECT_EQ(source_after(milliseconds(5001), milliseconds(5001)), std::nullopt);
  EXPECT_EQ(source_after(milliseconds(5001), {}), std::nullopt);
}

TEST(Slave, AsksNothingOfATargetTooLongSilent) {
  const RangeConfig range = test::small_range();
  const auto asked_at = [&](Duration silence) {
    Told method;
    method.fused_track = estimate_at(60);
    test::Collector out;
    Slave(range).tick(newest + silence, only(method), {}, out);
    return method.asked;
  };
  EXPECT_EQ(asked_at(range.slave.coast), 2);  // one for each antenna
  EXPECT_EQ(asked_at(range.slave.coast + Duration{1}), 0);
}

TEST(Slave, NoCommandFromAnEstimateThatIsNotOne) {
  const RangeConfig range = test::small_range();
  const Time tick = test::liftoff + seconds(60.0);
  const auto commands_with = [&](auto change) {
    Told method;
    method.fused_track = estimate_at(60);
    change(*method.fused_track);
    test::Collector out;
    Slave(range).tick(tick, only(method), {}, out);
    return out.of<SlavingCommand>().size();
  };
  EXPECT_EQ(commands_with([](TrackEstimate&) {}), 2u);
  EXPECT_EQ(commands_with([](TrackEstimate& e) { e.mean[1] = std::nan(""); }), 0u);
  EXPECT_EQ(commands_with([](TrackEstimate& e) { e.cov(0, 0) = std::nan(""); }), 0u);
  EXPECT_EQ(commands_with([](TrackEstimate& e) { e.cov *= 1e9; }), 0u);
  EXPECT_EQ(commands_with([&](TrackEstimate& e) {
              e.mean.setZero();
              e.mean.head<3>() = range.antennas[0].site.ecef().m;
            }),
            1u);  // no direction from the antenna at the target itself
}

TEST(Slave, HoldsTheEndOfTravelAndSaysSo) {
  RangeConfig range = test::small_range();
  range.antennas[0].elevation_max_rad = 10 * deg;
  Told method;
  method.fused_track = estimate_at(20);
  test::Collector out;
  Slave(range).tick(test::liftoff + seconds(20.0), only(method), {}, out);
  const SlavingCommand c = out.of<SlavingCommand>().at(0);
  EXPECT_EQ(c.elevation_rad, 10 * deg);
  EXPECT_EQ(c.limits, LimitElevation);
  EXPECT_EQ(c.elevation_rate_rad_s, 0);  // the target's own rate would drive the antenna into its stop
  EXPECT_EQ(out.of<SlavingCommand>().at(1).limits, LimitNone);
}

double apart_rad(const SlavingCommand& a, const SlavingCommand& b) {
  const auto direction = [](const SlavingCommand& c) { return enu_from_polar({1, c.azimuth_rad, c.elevation_rad}).m; };
  return std::acos(std::min(1.0, direction(a).dot(direction(b))));
}

/// Commands of the first antenna at ticks 25 ms apart from 60 s on, with what is followed at each.
template <class Follow>
std::vector<SlavingCommand> commands(const RangeConfig& range, int ticks, const Follow& follow) {
  Slave slave(range);
  test::Collector out;
  for (int i = 0; i < ticks; ++i) {
    const Followed followed = follow(i);
    slave.tick(test::liftoff + seconds(60 + 0.025 * i), std::span(&followed, 1), {}, out);
  }
  std::vector<SlavingCommand> of_first;
  for (const SlavingCommand& c : out.of<SlavingCommand>()) {
    if (c.antenna == range.antennas[0].id) of_first.push_back(c);
  }
  return of_first;
}

TEST(Slave, GoesOverToAnotherChainNoFasterThanTheBlendAllows) {
  const RangeConfig range = test::small_range();
  Told from;
  from.fused_track = estimate_at(60);
  from.fused_track->mean.head<3>() += Vec<3>(2000, -1000, 3000);  // some degrees off
  Told to;
  to.fused_track = estimate_at(60);
  const auto told = [&](int i, bool other) {
    return Followed{.method = i < 2 || other ? &from : &to,
                    .newest = newest + seconds(0.025 * i),
                    .chain = i < 2 ? Name{} : Name("without-jeju"),
                    .revision = i < 2 ? 0U : 1U};
  };
  const auto blended = commands(range, 80, [&](int i) { return told(i, false); });
  const auto exact =
      commands(range, 80, [&](int i) { return Followed{.method = &to, .newest = told(i, false).newest}; });
  ASSERT_EQ(blended.size(), 80u);
  const double step = range.slave.blend_rate_rad_s * 0.025;
  EXPECT_GT(apart_rad(blended[1], exact[1]), 2 * deg);
  for (std::size_t i = 1; i < blended.size(); ++i) {
    // Against the target: how much nearer the command has come.
    const double before = apart_rad(blended[i - 1], exact[i - 1]);
    const double now = apart_rad(blended[i], exact[i]);
    EXPECT_LE(std::abs(now - before), 1.02 * step) << i;
    if (i >= 2 && before > 2 * step) {
      EXPECT_LT(now, before) << i;
    }
    EXPECT_EQ(blended[i].chain, i < 2 ? Name{} : Name("without-jeju"));
    // The rates say how the command moves.
    const double moved = (blended[i].azimuth_rad - blended[i - 1].azimuth_rad) / 0.025;
    if (i > 2) {
      EXPECT_NEAR(blended[i].azimuth_rate_rad_s, moved, 2e-3) << i;
    }
  }
  EXPECT_EQ(blended.back().azimuth_rad, exact.back().azimuth_rad);  // and arrives
  EXPECT_EQ(blended.back().elevation_rad, exact.back().elevation_rad);
}

TEST(Slave, WithoutAChangeThereIsNoBlend) {
  const RangeConfig range = test::small_range();
  Told method;
  method.fused_track = estimate_at(60);
  const auto moved = commands(range, 20, [&](int i) {
    if (i == 10) method.fused_track->mean.head<3>() += Vec<3>(500, 500, 500);  // a measurement that says so
    return Followed{.method = &method, .newest = newest};
  });
  Told only_later;
  only_later.fused_track = method.fused_track;
  const auto exact = commands(range, 20, [&](int) { return Followed{.method = &only_later, .newest = newest}; });
  EXPECT_EQ(moved[10].azimuth_rad, exact[10].azimuth_rad);
}

TEST(Slave, TheBoundIsTheAngleToWhereTheTargetMayBeInstead) {
  const RangeConfig range = test::small_range();
  Told method;
  method.fused_track = estimate_at(60);
  const Site& site = range.antennas[0].site;
  const Eigen::Vector3d look = method.fused_track->mean.head<3>() - site.ecef().m;
  // Across the line of sight by a hundredth of the range, known to 100 m.
  const Eigen::Vector3d across = look.cross(Eigen::Vector3d::UnitZ()).normalized() * look.norm() / 100;
  const std::vector<Alternative> alternatives{
      {.from_selected_m = across, .cov = 1e4 * Eigen::Matrix3d::Identity()},
      {.from_selected_m = look * 0.5, .cov = 1e4 * Eigen::Matrix3d::Identity()}};  // along it: seen in one direction
  const auto told = commands(range, 1, [&](int) {
    return Followed{.method = &method, .newest = newest, .alternatives = alternatives, .bounded = true};
  });
  ASSERT_TRUE(told[0].bound_valid);
  EXPECT_NEAR(told[0].bound_rad, 0.01 + 4.1 * 100 / look.norm(), 5e-5);
  const auto unbounded = commands(range, 1, [&](int) { return Followed{.method = &method, .newest = newest}; });
  EXPECT_FALSE(unbounded[0].bound_valid);
}

}  // namespace
}  // namespace downrange
