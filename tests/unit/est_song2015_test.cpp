/// The range paper's method on drawn flights: bias found, track honest, order and doubles irrelevant, alarms ring.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <downrange/est/method/method.hpp>
#include <numbers>
#include <random>

#include "../support/drawn_flight.hpp"

namespace downrange {
namespace {

using test::draw_flight;
using test::Flight;
using test::Flown;
using test::fly;

TEST(Song2015, TakesTheBiasOutAndSaysHowWell) {
  const Flight f = draw_flight(1, 60, true);
  const auto corrected = make_method("song2015", f.settings);
  const auto uncorrected = make_method("uncorrected", f.settings);
  const Flown with = fly(*corrected, f, 30);
  const Flown without = fly(*uncorrected, f, 30);
  EXPECT_LT(with.rms_m, 0.5 * without.rms_m) << "corrected " << with.rms_m << " uncorrected " << without.rms_m;
  EXPECT_GT(with.inside95, 0.85);
  EXPECT_LT(without.inside95, 0.5);  // the covariance of the uncorrected fusion lies: the reason for all this
  for (int radar = 0; radar < 2; ++radar) {
    const BiasEstimate b = corrected->bias(radar);
    ASSERT_EQ(b.terms, 6);
    EXPECT_EQ(b.reference, BiasReference::Gps);
    EXPECT_GT(b.samples, 500u);
    EXPECT_GT((b.cov.topLeftCorner<6, 6>().llt().matrixL().toDenseMatrix().diagonal().minCoeff()), 0);
    EXPECT_EQ(uncorrected->bias(radar).terms, 0);
  }
}

TEST(Song2015, WithoutBiasNothingIsLostOnAverage) {
  double with = 0;
  double without = 0;
  for (std::uint64_t seed = 20; seed < 24; ++seed) {
    const Flight f = draw_flight(seed, 30, false);
    with += fly(*make_method("song2015", f.settings), f, 25).rms_m;
    without += fly(*make_method("uncorrected", f.settings), f, 25).rms_m;
  }
  EXPECT_LT(with, 1.5 * without);
}

TEST(Song2015, SignOfTheBiasIsMeasuredMinusTrue) {
  // A radar 200 m too long in range, seen along its line of sight: the compensated plot is 200 m shorter.
  Flight f = draw_flight(3, 40, false);
  for (Measurement& m : f.measurements)
    if (!is_fix(m) && m.source == 1) test::polar(m).range_m += 200;
  const auto method = make_method("song2015", f.settings);
  Polar last;
  for (const Measurement& m : f.measurements) {
    (void)method->process(m, m.epoch);
    if (!is_fix(m) && m.source == 1) last = test::polar(m);
  }
  const BiasEstimate b = method->bias(1);
  const Polar compensated = compensate(last, {b.term.data(), 6}, {b.value.data(), 6});
  EXPECT_NEAR(last.range_m - compensated.range_m, 200, 25);
}

TEST(Song2015, ShuffledArrivalGivesTheInOrderBits) {
  const Flight f = draw_flight(4, 30, true);
  const auto in_order = make_method("song2015", f.settings);
  for (const Measurement& m : f.measurements) (void)in_order->process(m, m.epoch);

  std::mt19937_64 rng(99);
  std::vector<std::pair<Time, std::size_t>> arrival;
  for (std::size_t i = 0; i < f.measurements.size(); ++i) {
    const bool gps = is_fix(f.measurements[i]);
    const auto delay = milliseconds(static_cast<std::int64_t>(gps ? 500 + rng() % 1500 : rng() % 300));
    arrival.push_back({f.measurements[i].epoch + delay, i});
  }
  std::sort(arrival.begin(), arrival.end());
  const auto shuffled = make_method("song2015", f.settings);
  for (const auto& [received, i] : arrival) (void)shuffled->process(f.measurements[i], received);

  const auto a = in_order->fused(0);
  const auto b = shuffled->fused(0);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->mean, b->mean);
  EXPECT_EQ(a->cov, b->cov);
  for (int radar = 0; radar < 2; ++radar) {
    EXPECT_EQ(in_order->bias(radar).value, shuffled->bias(radar).value);
    EXPECT_EQ(in_order->account(radar).accepted, shuffled->account(radar).accepted);
  }
}

TEST(Song2015, OutliersAreGatedAndTheTrackDoesNotMove) {
  Flight f = draw_flight(5, 40, true);
  int planted = 0;
  for (std::size_t i = 600; i < f.measurements.size(); i += 97) {
    if (is_fix(f.measurements[i])) continue;
    test::polar(f.measurements[i]).range_m += 3000;
    ++planted;
  }
  const auto method = make_method("song2015", f.settings);
  const Flown flown = fly(*method, f, 25);
  EXPECT_EQ(method->account(0).gated + method->account(1).gated, static_cast<std::uint64_t>(planted));
  EXPECT_LT(flown.rms_m, 40);
}

TEST(Song2015, ARadarThatJumpsIsOpenedAgainInsteadOfLockedOut) {
  Flight f = draw_flight(6, 60, true);
  for (Measurement& m : f.measurements)
    if (!is_fix(m) && m.source == 1 && m.epoch > Time{} + seconds(40)) test::polar(m).range_m += 280;
  const auto method = make_method("song2015", f.settings);
  for (const Measurement& m : f.measurements) (void)method->process(m, m.epoch);
  EXPECT_GE(method->account(1).gated, static_cast<std::uint64_t>(f.settings.arbitration.reopen_after) - 1);
  EXPECT_EQ(method->account(1).rejected_in_row, 0);
}

TEST(Song2015, AFrozenReceiverIsRejectedButOneAtRestIsNot) {
  Flight f = draw_flight(7, 20, false);
  const auto method = make_method("song2015", f.settings);
  Measurement last_fix;
  int frozen = 0;
  for (Measurement m : f.measurements) {
    if (is_fix(m) && m.epoch > Time{} + seconds(20)) {
      test::fix(m).position = test::fix(last_fix).position;
      test::fix(m).velocity = test::fix(last_fix).velocity;
      frozen += method->process(m, m.epoch).verdict == Verdict::Frozen ? 1 : 0;
      continue;
    }
    if (is_fix(m)) last_fix = m;
    (void)method->process(m, m.epoch);
  }
  EXPECT_GE(frozen, 8);

  Measurement parked = last_fix;
  test::fix(parked).velocity = {};
  const auto at_rest = make_method("song2015", f.settings);
  for (int i = 0; i < 20; ++i) {
    parked.epoch = Time{} + milliseconds(500 * i);
    EXPECT_EQ(at_rest->process(parked, parked.epoch).verdict, Verdict::Accepted);
  }
}

TEST(Song2015, AReceiverThatFreezesJustAfterLiftoffDoesNotDragTheTrackAway) {
  Flight f = draw_flight(13, 60, true);
  // The vehicle starts at 400 m/s there; slow it down: the receiver freezes at once, at its first fix but one.
  Measurement frozen;
  int fixes = 0;
  for (Measurement& m : f.measurements) {
    if (!is_fix(m)) continue;
    if (++fixes <= 3) {
      frozen = m;
    } else {
      test::fix(m).position = test::fix(frozen).position;
      test::fix(m).velocity = test::fix(frozen).velocity;
    }
  }
  const auto method = make_method("song2015", f.settings);
  const Flown flown = fly(*method, f, 30);
  const Flown without = fly(*make_method("uncorrected", f.settings), f, 30);
  EXPECT_LT(flown.rms_m, 5 * without.rms_m);  // biases found in three seconds are poor, kilometres they are not
  EXPECT_GT(method->account(2).frozen, 50u);
}

TEST(Song2015, OneBadFixAfterAGapIsNoReference) {
  Flight f = draw_flight(14, 60, true);
  std::erase_if(f.measurements, [](const Measurement& m) {
    return is_fix(m) && m.epoch > Time{} + seconds(40) && m.epoch < Time{} + seconds(50);
  });
  bool spoilt = false;
  for (Measurement& m : f.measurements) {
    if (spoilt || !is_fix(m) || m.epoch < Time{} + seconds(50)) continue;
    test::fix(m).position.m += Vec<3>(50'000, 0, 0);
    spoilt = true;
  }
  ASSERT_TRUE(spoilt);
  const auto method = make_method("song2015", f.settings);
  for (const Measurement& m : f.measurements) {
    (void)method->process(m, m.epoch);
    const auto gps = method->gps_track(0, m.epoch);
    if (!gps || m.epoch < Time{} + seconds(45)) continue;
    const Site pad({34.43 * test::deg, 127.53 * test::deg, 100});
    const double error = (gps->mean.head<3>() - test::truth_at(pad, (m.epoch - Time{}).seconds()).m).norm();
    ASSERT_LT(error, 20'000) << "at " << (m.epoch - Time{}).seconds();  // an old track drifts; 50 km is the bad fix
  }
  EXPECT_EQ(method->account(2).rejected_in_row, 0);
}

TEST(Song2015, GpsLostFreezesTheBiasesAndGpsBackWins) {
  Flight f = draw_flight(8, 60, true);
  std::erase_if(f.measurements, [](const Measurement& m) {
    return is_fix(m) && m.epoch > Time{} + seconds(35) && m.epoch < Time{} + seconds(60);
  });
  const auto method = make_method("song2015", f.settings);
  BiasState during{};
  for (const Measurement& m : f.measurements) {
    (void)method->process(m, m.epoch);
    if (m.epoch < Time{} + seconds(59)) during = method->bias(0).state[0];
  }
  EXPECT_EQ(during, BiasState::Frozen);
  EXPECT_NE(method->bias(0).state[0], BiasState::Frozen);
}

TEST(Methods, UnknownNameIsRefused) {
  EXPECT_THROW((void)make_method("song2016", {}), std::invalid_argument);
  EXPECT_EQ(method_names().front(), "joint");
}

}  // namespace
}  // namespace downrange
