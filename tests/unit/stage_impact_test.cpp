/// The impact points that leave the engine: whose, when, how long without data, and that what falls freely stands
/// still.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/geo/earth.hpp>
#include <downrange/geo/free_fall.hpp>
#include <downrange/stage/engine.hpp>
#include <set>

#include "../support/allocations.hpp"
#include "../support/small_range.hpp"
#include "stage/impact.hpp"

namespace downrange {
namespace {

using namespace test;

GroundPoint at(double latitude_deg, double longitude_deg) { return {latitude_deg * deg, longitude_deg * deg}; }

RangeConfig impact_range() {
  RangeConfig range = small_range();
  range.fuse.methods = {"joint"};
  range.antennas.clear();
  range.boundaries = {{"corridor", {at(34.6, 127.2), at(34.6, 127.9), at(20, 131), at(20, 126)}},
                      {"sea", {at(34, 125), at(34, 130), at(30, 130), at(30, 125)}}};
  range.impact.data_loss = {{.t_plus_s = 0, .limit_s = 4}, {.t_plus_s = 100, .limit_s = 14}};
  return range;
}

/// What is flown: position and velocity, seconds after lift-off.
using Flight = std::function<PositionVelocity(double t)>;

/// Under constant acceleration, as small_range has it.
PositionVelocity climb(double t) { return {vehicle_at(t), {(vehicle_at(t + 0.01).m - vehicle_at(t - 0.01).m) / 0.02}}; }

/// Engines off: free fall from a state at t = 0, by the classical Runge-Kutta rule.
Flight free_fall_from(const PositionVelocity& start) {
  return [start](double t) {
    Vec<6> x;
    x << start.position.m, start.velocity.m_s;
    const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(t))));
    const double h = t / steps;
    const auto f = [](const Vec<6>& y) {
      Vec<6> d;
      d << y.tail<3>(), free_fall_acceleration({y.head<3>()}, {y.tail<3>()});
      return d;
    };
    for (int i = 0; i < steps; ++i) {
      const Vec<6> k1 = f(x);
      const Vec<6> k2 = f(x + h / 2 * k1);
      const Vec<6> k3 = f(x + h / 2 * k2);
      const Vec<6> k4 = f(x + h * k3);
      x += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
    return PositionVelocity{{x.head<3>()}, {x.tail<3>()}};
  };
}

PositionVelocity start_of_fall() {
  const Geodetic g{33.8 * deg, 127.6 * deg, 80e3};
  return {ecef_from_geodetic(g), enu_from_ecef_at(g).inverse() * Velocity<Enu>{{100, -900, 800}}};
}

/// Plots and fixes of `flight`, `noise` times as noisy as the range says, without bias.
std::vector<Event> flown(const RangeConfig& range, const Flight& flight, double duration_s, std::uint64_t seed,
                         double noise = 1) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  std::vector<Event> events;
  MissionEvent mark;
  mark.mission = "test";
  mark.kind = MissionEventKind::Liftoff;
  mark.epoch = mark.received = liftoff;
  mark.simulated = true;
  events.emplace_back(mark);
  for (std::size_t r = 0; r < range.radars.size(); ++r) {
    const RadarConfig& radar = range.radars[r];
    std::uint64_t sequence = 0;
    for (double t = 0.5 + 0.013 * static_cast<double>(r); t < duration_s; t += 1 / radar.rate_hz) {
      RadarTspi p = plot_at(radar, t, ++sequence);
      p.measured = polar_from_enu(radar.site.enu_of(flight(t).position));
      p.measured.range_m += noise * radar.sigma.range_m * normal(rng);
      p.measured.azimuth_rad += noise * radar.sigma.azimuth_rad * normal(rng);
      p.measured.elevation_rad += noise * radar.sigma.elevation_rad * normal(rng);
      events.emplace_back(p);
    }
  }
  std::uint64_t sequence = 0;
  for (double t = 0; t < duration_s; t += 1) {
    GpsFix f = fix_at(range.telemetry[0].id, t, ++sequence);
    f.position = flight(t).position;
    f.velocity = flight(t).velocity;
    for (int k = 0; k < 3; ++k) {
      f.position.m[k] += noise * 5 * normal(rng);
      f.velocity.m_s[k] += noise * 0.2 * normal(rng);
    }
    events.emplace_back(f);
  }
  std::stable_sort(events.begin(), events.end(),
                   [](const Event& a, const Event& b) { return received_of(a) < received_of(b); });
  return events;
}

std::vector<ImpactPoint> impacts(const RangeConfig& range, const std::vector<Event>& events, double until_s) {
  Collector out;
  Engine engine(range, {}, out);
  for (const Event& e : events) engine.handle(engine.admit(e));
  engine.advance_to(liftoff + seconds(until_s));
  return out.of<ImpactPoint>();
}

std::vector<ImpactPoint> of_chain(const std::vector<ImpactPoint>& all, const Name& chain) {
  std::vector<ImpactPoint> found;
  std::ranges::copy_if(all, std::back_inserter(found), [&](const ImpactPoint& i) { return i.chain == chain; });
  return found;
}

double t_of(const ImpactPoint& i) { return (i.epoch - liftoff).seconds(); }

Eigen::Matrix2d cov_of(const ImpactPoint& i) {
  Eigen::Matrix2d cov;
  cov << i.covariance_m2[0], i.covariance_m2[1], i.covariance_m2[1], i.covariance_m2[2];
  return cov;
}

/// From the record's point to another place of the ground.
Eigen::Vector2d off(const ImpactPoint& i, const Position<Ecef>& other) {
  return ground_offset(ecef_from_geodetic(i.point), enu_from_ecef_at(i.point), other);
}

const ImpactPoint* record_at(const std::vector<ImpactPoint>& all, double t, const Name& chain = {}) {
  const auto found =
      std::ranges::find_if(all, [&](const ImpactPoint& i) { return i.chain == chain && std::abs(t_of(i) - t) < 1e-6; });
  return found == all.end() ? nullptr : &*found;
}

TEST(ImpactPoint, OfTheSelectedChainAndOfEachThatIsIndependentTenTimesASecond) {
  const RangeConfig range = impact_range();
  const auto all = impacts(range, flown(range, climb, 30, 1), 30);
  std::set<Name> chains;
  for (const ImpactPoint& i : all) chains.insert(i.chain);
  // Without trackers all radars are all but GPS.
  const std::set<Name> expected{"", "only-goheung", "only-jeju", "only-GPS", "without-GPS"};
  EXPECT_EQ(chains, expected);
  const std::vector<Name> told = impact_chains(range);
  EXPECT_EQ(std::set<Name>(told.begin(), told.end()), expected);
  for (const Name& chain : expected) {
    const auto records = of_chain(all, chain);
    ASSERT_GT(records.size(), 240u) << chain.view();
    for (std::size_t i = 1; i < records.size(); ++i)
      EXPECT_EQ((records[i].epoch - records[i - 1].epoch).ns, 100'000'000) << chain.view();
  }
  for (const ImpactPoint& i : all) {
    ASSERT_EQ(i.boundaries.size(), 2u);
    EXPECT_EQ(i.boundaries[0].boundary, Name("corridor"));
    EXPECT_EQ(i.received, i.epoch);
  }
}

TEST(ImpactPoint, WithinATenthOfASecondOfWhatMovedIt) {
  const RangeConfig range = impact_range();
  const auto events = flown(range, climb, 20, 2);
  const auto all = impacts(range, events, 20);
  int moved = 0;
  int known = 0;
  for (const Event& e : events) {
    const auto* plot = std::get_if<RadarTspi>(&e);
    if (plot == nullptr || plot->received < liftoff + seconds(5.0) || plot->received > liftoff + seconds(19.0))
      continue;
    const auto next =
        std::ranges::find_if(all, [&](const ImpactPoint& i) { return i.chain.empty() && i.epoch > plot->received; });
    ASSERT_NE(next, all.end());
    EXPECT_LE((next->epoch - plot->received).ns, 100'000'000);
    if (next->data_age_s <= (next->epoch - plot->epoch).seconds() + 1e-9) ++known;
    ++moved;
  }
  EXPECT_GT(moved, 400);
  EXPECT_GT(known, 0.98 * moved) << "the others did not pass the gate";
}

TEST(ImpactPoint, OfWhatFallsFreelyStandsStillToItsSigma) {
  const RangeConfig range = impact_range();
  const Flight flight = free_fall_from(start_of_fall());
  const auto landing = fall_to(start_of_fall(), 0, 3600);
  ASSERT_TRUE(landing);
  for (const std::uint64_t seed : {1, 2, 3}) {
    const auto all = impacts(range, flown(range, flight, 100, seed), 100);
    for (const Name& chain : {Name(), Name("only-GPS")}) {
      const auto records = of_chain(all, chain);
      const ImpactPoint* before = nullptr;
      int inside = 0;
      int count = 0;
      for (const ImpactPoint& i : records) {
        if (t_of(i) < 30) continue;
        ASSERT_TRUE(i.impact_valid);
        const Eigen::Matrix2d cov = cov_of(i);
        const Eigen::Vector2d error = off(i, landing->state.position);
        // No one of 700 points that hang together farther than 4 sigmas (3e-4), and half of them and more inside 95 %.
        EXPECT_LT(normalised_square<2>(error, cov), 16) << t_of(i);
        if (normalised_square<2>(error, cov) < chi2_quantile(0.95, 2)) ++inside;
        ++count;
        EXPECT_NEAR(i.time_to_impact_s, landing->time_s - t_of(i), 1);
        if (before != nullptr) {
          EXPECT_LT(normalised_square<2>(off(i, ecef_from_geodetic(before->point)), cov), 9) << t_of(i);
        }
        before = &i;
        // It goes nowhere, so there is no time to a boundary.
        EXPECT_FALSE(i.boundaries[0].time_valid) << t_of(i);
      }
      EXPECT_GT(inside, 0.7 * count) << chain.view() << " seed " << seed;
      EXPECT_GT(count, 600);
      EXPECT_LT(std::sqrt(cov_of(records.back()).trace()), 80);
    }
  }
}

TEST(ImpactPoint, DistancesAndTheTimeToABoundaryAreTrue) {
  const RangeConfig range = impact_range();
  const auto all = of_chain(impacts(range, flown(range, climb, 60, 4, 0.05), 60), {});
  const GroundPolygon sea(range.boundaries[1].vertices);
  // The impact point goes south into "sea", and later through it; the vehicle itself stays behind.
  std::optional<double> entered_s;
  for (const ImpactPoint& i : all) {
    if (t_of(i) < 10) continue;
    ASSERT_TRUE(i.impact_valid);
    const BoundaryDistance& b = i.boundaries[1];
    EXPECT_NEAR(b.distance_m, sea.signed_distance_m({i.point.latitude_rad, i.point.longitude_rad}), 1e-6);
    const Geodetic below = geodetic_from_ecef(vehicle_at(t_of(i)));
    EXPECT_NEAR(b.present_distance_m, sea.signed_distance_m({below.latitude_rad, below.longitude_rad}), 30);
    if (!entered_s && b.distance_m > 0) entered_s = t_of(i);
    EXPECT_EQ(b.probability_outside > 0.5, b.distance_m < 0) << t_of(i);
  }
  ASSERT_TRUE(entered_s);
  for (const double ahead_s : {1.0, 2.0, 4.0}) {
    const ImpactPoint* i = record_at(all, std::round(10 * (*entered_s - ahead_s)) / 10);
    ASSERT_NE(i, nullptr);
    ASSERT_TRUE(i->boundaries[1].time_valid);
    // It gets faster on the way there, so that it takes a little less than told.
    EXPECT_NEAR(i->boundaries[1].time_s, ahead_s, 0.1 + 0.2 * ahead_s) << ahead_s;
  }
}

TEST(ImpactPoint, TheDataLossTimerGoesOnWhereTheTrackEnds) {
  const RangeConfig range = impact_range();
  auto events = flown(range, climb, 40, 5);
  std::erase_if(events, [](const Event& e) {  // jeju is silent from 30 s on
    const auto* plot = std::get_if<RadarTspi>(&e);
    return plot != nullptr && plot->sensor == Name("jeju") && plot->epoch >= liftoff + seconds(30.0);
  });
  const auto all = impacts(range, events, 700);
  const auto last_epoch = [&](const Name& radar) {
    Time last;
    for (const Event& e : events) {
      const auto* plot = std::get_if<RadarTspi>(&e);
      if (plot != nullptr && (radar.empty() || plot->sensor == radar)) last = std::max(last, plot->epoch);
    }
    return (last - liftoff).seconds();
  };
  const ImpactPoint* with_data = record_at(all, 35);
  const ImpactPoint* jeju = record_at(all, 38, "only-jeju");
  const ImpactPoint* lost = record_at(all, 50);
  ASSERT_TRUE(with_data != nullptr && jeju != nullptr && lost != nullptr);
  EXPECT_LT(with_data->data_loss_timer_s, 0.2);
  EXPECT_EQ(with_data->data_age_s, with_data->data_loss_timer_s);
  EXPECT_NEAR(jeju->data_loss_timer_s, 38 - last_epoch("jeju"), 1e-6);
  EXPECT_FALSE(jeju->impact_valid);
  EXPECT_FALSE(lost->impact_valid);
  EXPECT_TRUE(lost->boundaries.empty());
  EXPECT_EQ(lost->data_age_s, 0);
  EXPECT_NEAR(lost->data_loss_timer_s, 50 - last_epoch({}), 1e-6);
  EXPECT_TRUE(lost->data_loss_limit_valid);
  EXPECT_NEAR(lost->data_loss_limit_s, 9, 1e-9) << "between 4 s at lift-off and 14 s at T+100";
  EXPECT_NE(record_at(all, 630), nullptr);
  EXPECT_EQ(record_at(all, 645), nullptr) << "nothing is told of what is long gone";
}

TEST(ImpactPoint, BeforeLiftoffThereIsNoLimit) {
  const RangeConfig range = impact_range();
  auto events = flown(range, climb, 5, 6);
  events.erase(events.begin());  // the mark of the lift-off
  const auto all = impacts(range, events, 3);
  ASSERT_FALSE(all.empty());
  EXPECT_FALSE(all.front().data_loss_limit_valid);
}

TEST(ImpactPoint, DataLossLimits) {
  const std::vector<DataLossLimit> table{{0, 4}, {60, 8}, {230, 30}};
  EXPECT_EQ(data_loss_limit_s({}, 10), std::nullopt);
  EXPECT_EQ(data_loss_limit_s(table, -5), 4);
  EXPECT_EQ(data_loss_limit_s(table, 0), 4);
  EXPECT_EQ(data_loss_limit_s(table, 30), 6);
  EXPECT_EQ(data_loss_limit_s(table, 60), 8);
  EXPECT_EQ(data_loss_limit_s(table, 145), 19);
  EXPECT_EQ(data_loss_limit_s(table, 230), 30);
  EXPECT_EQ(data_loss_limit_s(table, 1e6), 30);
}

TEST(ImpactPoint, AnOrbitHasNone) {
  RangeConfig range = impact_range();
  const Geodetic g{34.0 * deg, 127.0 * deg, 400e3};
  const Flight flight =
      free_fall_from({ecef_from_geodetic(g), enu_from_ecef_at(g).inverse() * Velocity<Enu>{{7300, 0, 0}}});
  const auto all = impacts(range, flown(range, flight, 30, 7), 30);
  int after_start = 0;
  for (const ImpactPoint& i : all) {
    if (t_of(i) < 15) continue;
    ++after_start;
    EXPECT_FALSE(i.impact_valid) << t_of(i);
    EXPECT_EQ(i.point, Geodetic());
    ASSERT_EQ(i.boundaries.size(), 2u);
    EXPECT_NE(i.boundaries[0].present_distance_m, 0);
    EXPECT_EQ(i.boundaries[0].distance_m, 0);
    EXPECT_FALSE(i.boundaries[0].time_valid);
  }
  EXPECT_GT(after_start, 500);
}

/// Arrives in another order, the same within the history: the same in the end. And the same events: the same bits.
TEST(ImpactPoint, TheOrderOfArrivalIsNothing) {
  const RangeConfig range = impact_range();
  const auto events = flown(range, climb, 30, 8);
  auto shuffled = events;
  std::mt19937_64 rng(3);
  std::uniform_real_distribution<double> delay(0.02, 1.5);
  for (Event& e : shuffled) {
    const Time epoch = std::visit([](const auto& message) { return message.epoch; }, e);
    set_received(e, epoch + seconds(delay(rng)));
  }
  std::stable_sort(shuffled.begin(), shuffled.end(),
                   [](const Event& a, const Event& b) { return received_of(a) < received_of(b); });
  const auto a = impacts(range, events, 32);
  EXPECT_EQ(a, impacts(range, events, 32));
  const auto b = impacts(range, shuffled, 32);
  for (const Name& chain : impact_chains(range)) {
    const ImpactPoint* x = record_at(a, 32, chain);
    const ImpactPoint* y = record_at(b, 32, chain);
    ASSERT_TRUE(x != nullptr && y != nullptr) << chain.view();
    EXPECT_EQ(*x, *y) << chain.view();
  }
}

TEST(ImpactPoint, SwitchedOffThereIsNone) {
  RangeConfig range = impact_range();
  range.impact.enabled = false;
  EXPECT_TRUE(impacts(range, flown(range, climb, 5, 1), 5).empty());
  EXPECT_TRUE(impact_chains(range).empty());
}

TEST(ImpactPoint, WithoutIntegrityOfTheOneChain) {
  RangeConfig range = impact_range();
  range.integrity.enabled = false;
  const auto all = impacts(range, flown(range, climb, 10, 1), 10);
  EXPECT_GT(all.size(), 80u);
  EXPECT_EQ(of_chain(all, {}).size(), all.size());
  EXPECT_EQ(impact_chains(range), std::vector<Name>{Name()});
  EXPECT_TRUE(all.back().impact_valid);
}

struct Nobody final : ResultSink {
  void emit(const Result&) override {}
};

TEST(ImpactPoint, AllocatesNothingInTheSteadyState) {
#ifndef DOWNRANGE_COUNTS_ALLOCATIONS
  GTEST_SKIP() << "a sanitizer has a malloc of its own";
#endif
  RangeConfig range = impact_range();
  Nobody sink;
  Engine engine(range, {}, sink);
  std::size_t allocated = 0;
  for (const Event& e : flown(range, climb, 150, 2)) {
    const bool steady = received_of(e) > liftoff + seconds(140.0);
    const std::size_t now = allocations_of([&] { engine.advance_to(received_of(e)); });
    engine.handle(engine.admit(e));
    if (steady) allocated += now;
  }
  EXPECT_EQ(allocated, 0u);
}

}  // namespace
}  // namespace downrange
