#include <gtest/gtest.h>

#include <cmath>
#include <downrange/est/model/plot_model.hpp>
#include <map>
#include <string>
#include <vector>

#include "../support/small_range.hpp"
#include "stage/integrity/bias_test.hpp"
#include "stage/integrity/copies.hpp"
#include "stage/integrity/fine_test.hpp"
#include "stage/integrity/identification.hpp"
#include "stage/integrity/judge.hpp"
#include "stage/integrity/own_past.hpp"

namespace downrange::integrity {
namespace {

using test::deg;
using test::liftoff;

// Witnesses of the identification tests: a receiver and two or three radars.
constexpr int gps = 0;
constexpr int first = 1;
constexpr int second = 2;

Edge fails(int a, int b) { return {.first = a, .second = b, .fails = true, .doubt = 0}; }
Edge passes(int a, int b, double doubt = 0.1) { return {.first = a, .second = b, .fails = false, .doubt = doubt}; }

TEST(Identification, TheOneThatAllDisagreeWithIsNamed) {
  const std::vector<Edge> edges{fails(gps, first), fails(gps, second), passes(first, second)};
  const std::vector<Character> characters(3);
  EXPECT_EQ(identify(edges, characters, 0, 0, 0).guilty, only(gps));
  EXPECT_EQ(identify(edges, characters, 0, 0, 0).tied, 0u);
}

TEST(Identification, WhereNothingFailsNobodyIsNamed) {
  const std::vector<Edge> edges{passes(gps, first, 0.9), passes(first, second, 0.9)};
  EXPECT_EQ(identify(edges, std::vector<Character>(3), 0, 0, 0).guilty, 0u);
}

TEST(Identification, TwoThatDisagreeAreTied) {
  const std::vector<Edge> edges{fails(gps, first)};
  const Accusation accusation = identify(edges, std::vector<Character>(2), 0, 0, 0);
  EXPECT_EQ(accusation.guilty, 0u);
  EXPECT_EQ(accusation.tied, only(gps) | only(first));
}

TEST(Identification, AThirdThatDoubtsOneOfTwoDecides) {
  const std::vector<Edge> edges{fails(gps, first), passes(gps, second, 0.1), passes(first, second, 0.8)};
  EXPECT_EQ(identify(edges, std::vector<Character>(3), 0, 0, 0).guilty, only(first));
}

TEST(Identification, WhatAThirdSaysForOneOfTwoDecides) {
  const std::vector<Edge> edges{fails(gps, first), passes(gps, second, 0.1), passes(first, second, 0.1)};
  std::vector<Character> characters(3);
  characters[first].acquittal = 1;
  EXPECT_EQ(identify(edges, characters, 0, 0, 0).guilty, only(gps));
  characters[gps].acquittal = 0.9;  // for both: nothing follows
  EXPECT_EQ(identify(edges, characters, 0, 0, 0).guilty, 0u);
}

TEST(Identification, WhoBrokeWithItsOwnPastDecidesATie) {
  std::vector<Character> characters(2);
  characters[gps].own_break = 5;
  characters[first].own_break = 0.4;
  const std::vector<Edge> edges{fails(gps, first)};
  EXPECT_EQ(identify(edges, characters, 0, 0, 0).guilty, only(gps));
  characters[first].own_break = 4;  // both: nothing follows
  EXPECT_EQ(identify(edges, characters, 0, 0, 0).guilty, 0u);
}

TEST(Identification, TwoThatBrokeAtOnceAreNoMajority) {
  std::vector<Character> characters(3);
  characters[first].own_break = 4000;
  characters[second].own_break = 150;
  // Whether the two agree with each other or not.
  const std::vector<Edge> alike{fails(gps, first), fails(gps, second), passes(first, second)};
  EXPECT_EQ(identify(alike, characters, 0, 0, 0).guilty, only(first) | only(second));
  const std::vector<Edge> apart{fails(gps, first), fails(gps, second), fails(first, second)};
  EXPECT_EQ(identify(apart, characters, 0, 0, 0).guilty, only(first) | only(second));
  // Not where the third broke as well, nor on an operator's word.
  characters[gps].own_break = 200;
  EXPECT_EQ(identify(alike, characters, 0, 0, 0).guilty, only(gps));
  EXPECT_EQ(identify(alike, characters, 0, only(first), 0).guilty, only(gps));
}

TEST(Identification, OfThreeThatAllDisagreeThoseTwoAreNamedWhoBrokeWithTheirPast) {
  std::vector<Character> characters(3);
  const std::vector<Edge> edges{fails(gps, first), fails(gps, second), fails(first, second)};
  EXPECT_EQ(identify(edges, characters, 0, 0, 0).guilty, 0u);
  characters[first].own_break = 90;
  characters[second].own_break = 4;  // far less, and yet more than the receiver's
  EXPECT_EQ(identify(edges, characters, 0, 0, 0).guilty, only(first) | only(second));
  characters[gps].own_break = 3;
  const Accusation accusation = identify(edges, characters, 0, 0, 0);
  EXPECT_EQ(accusation.guilty, only(first));
  EXPECT_EQ(accusation.tied, only(gps) | only(second));
}

TEST(Identification, PhysicsThenNominalThenTrustDecideInThisOrder) {
  const std::vector<Edge> edges{fails(gps, first)};
  std::vector<Character> characters(2);
  characters[first].distrust = 1;
  EXPECT_EQ(identify(edges, characters, 0, 0, 0).guilty, only(first));
  characters[gps].off_nominal = 2;
  EXPECT_EQ(identify(edges, characters, 0, 0, 0).guilty, only(gps));
  characters[first].impossible = true;
  EXPECT_EQ(identify(edges, characters, 0, 0, 0).guilty, only(first));
}

TEST(Identification, WhoIsExcludedIsNoGoodWitnessAgainstAnother) {
  const int third = 3;
  const WitnessSet excluded = only(first);
  const std::vector<Character> characters(4);
  std::vector<Edge> edges{fails(gps, first), fails(gps, second), passes(first, second)};
  EXPECT_EQ(identify(edges, characters, 0, 0, 0).guilty, only(gps)) << "where it is not excluded";
  const Accusation accusation = identify(edges, characters, 0, 0, excluded);
  EXPECT_EQ(accusation.guilty, 0u);
  EXPECT_EQ(accusation.tied, only(gps) | only(first) | only(second));
  // Two more that agree with it: it was excluded wrongly.
  edges.push_back(fails(gps, third));
  edges.push_back(passes(first, third));
  edges.push_back(passes(second, third));
  EXPECT_EQ(identify(edges, characters, 0, 0, excluded).guilty, only(gps));
  // Of two alone, the one that is excluded stays so.
  EXPECT_EQ(identify(std::vector<Edge>{fails(gps, first)}, characters, 0, 0, excluded).guilty, only(first));
}

TEST(Identification, AForcedWitnessIsNeverNamed) {
  const std::vector<Edge> edges{fails(gps, first), fails(gps, second), passes(first, second)};
  EXPECT_EQ(identify(edges, std::vector<Character>(3), 0, only(gps), 0).guilty, only(first) | only(second));
}

TEST(Identification, TwoLiarsAmongFourAreBothNamed) {
  const int third = 3;
  const int fourth = 4;
  const std::vector<Edge> edges{
      fails(gps, first),   fails(gps, second),   fails(gps, third),     fails(gps, fourth),     fails(first, second),
      fails(first, third), fails(first, fourth), passes(second, third), passes(second, fourth), passes(third, fourth)};
  EXPECT_EQ(identify(edges, std::vector<Character>(5), 0, 0, 0).guilty, only(gps) | only(first));
}

Fix fix_at(double east_m) {
  Fix fix;
  fix.position = test::pad().ecef_of({{east_m, 0, 0}});
  fix.sigma_horizontal_m = fix.sigma_vertical_m = 5;
  return fix;
}

constexpr CopyTolerance wire{.position_m = 0.1, .velocity_m_s = 0.01};

TEST(Copies, ThreeNameTheOddOneWhateverCameFirst) {
  for (int odd = 0; odd < 3; ++odd) {
    Copies copies(wire);
    const Copies::Message* message = nullptr;
    for (int station = 0; station < 3; ++station)
      message = &copies.note(station, liftoff, fix_at(station == odd ? 30 : 0.05));
    const Copies::Odd result = copies.odd(*message, {});
    EXPECT_EQ(result.stations, set_of(odd));
    EXPECT_EQ(result.disputed, 0u);
    EXPECT_NEAR(result.apart_m, 30, 0.1);
  }
}

TEST(Copies, TwoThatDifferAreDisputedUntilOneIsWhereTheTargetIs) {
  Copies copies(wire);
  static_cast<void>(copies.note(0, liftoff, fix_at(0)));
  const Copies::Message& message = copies.note(1, liftoff + milliseconds(1), fix_at(5000));
  EXPECT_EQ(copies.odd(message, {}).disputed, set_of(0) | set_of(1));
  EXPECT_EQ(copies.odd(message, test::pad().ecef_of({{40, 0, 0}})).stations, set_of(1));
  EXPECT_EQ(copies.odd(message, test::pad().ecef_of({{2000, 0, 0}})).stations, 0u);
}

TEST(Copies, TheWiresQuantumIsNoDifference) {
  Copies copies(wire);
  static_cast<void>(copies.note(0, liftoff, fix_at(0)));
  EXPECT_EQ(copies.odd(copies.note(1, liftoff, fix_at(0.09)), {}).disputed, 0u);
}

LearntBias learnt(int witness, double time_tag_sigmas, double ignorance = 0.1) {
  LearntBias b;
  b.witness = witness;
  b.ignorance.fill(ignorance);
  const auto term = static_cast<std::size_t>(BiasTerm::TimeTag);
  b.excess[term] = time_tag_sigmas;
  b.plausibility = {.ratio = time_tag_sigmas * time_tag_sigmas / 240,
                    .block = BiasBlock::Time,
                    .value = time_tag_sigmas,
                    .term = BiasTerm::TimeTag};
  b.implausible = b.plausibility.ratio >= 1;
  b.displacement = {100 * time_tag_sigmas, 0, 0};
  return b;
}

TEST(BiasTest, TheSameClockErrorInAllRadarsIsTheReceivers) {
  const std::vector<LearntBias> radars{learnt(0, 45), learnt(1, 47)};
  EXPECT_TRUE(blame(radars).receivers);
  EXPECT_EQ(blame(radars).radars, 0u);
}

TEST(BiasTest, AClockErrorOfOneRadarIsItsOwn) {
  const std::vector<LearntBias> radars{learnt(0, 45), learnt(1, 0.3)};
  EXPECT_FALSE(blame(radars).receivers);
  EXPECT_EQ(blame(radars).radars, only(0));
}

TEST(BiasTest, WhereTheOtherRadarKnowsNothingYetNobodyIsBlamed) {
  const std::vector<LearntBias> radars{learnt(0, 45), learnt(1, 0, 0.95)};
  EXPECT_FALSE(blame(radars).receivers);
  EXPECT_EQ(blame(radars).radars, 0u);
  EXPECT_EQ(blame(radars).disputed, only(0));
}

TEST(BiasTest, ClocksThatAreOffAlikeAreTheReceiversThoughEachIsWithinBelief) {
  const std::vector<LearntBias> alike{learnt(0, 5), learnt(1, 4.6)};
  EXPECT_FALSE(blame(alike).receivers);
  EXPECT_GT(common_clock(alike).ratio, 1);
  EXPECT_DOUBLE_EQ(common_clock(alike).apart_m, 500);
  EXPECT_LT(common_clock(std::vector{learnt(0, 4), learnt(1, 4)}).ratio, 1);
  EXPECT_EQ(common_clock(std::vector{learnt(0, 12), learnt(1, 1)}).ratio, 0) << "one radar's own";
  EXPECT_EQ(common_clock(std::vector{learnt(0, 12), learnt(1, -12)}).ratio, 0);
  EXPECT_EQ(common_clock(std::vector{learnt(0, 12), learnt(1, 12, 0.95)}).ratio, 0) << "the other is not known yet";
  EXPECT_EQ(common_clock(std::vector{learnt(0, 12)}).ratio, 0);
}

TEST(BiasTest, APosteriorFarBeyondItsPriorIsImplausible) {
  const BiasModel prior = bias_model({BiasBlock::Polar, BiasBlock::Time});
  BiasEstimate bias;
  bias.reference = BiasReference::Gps;
  bias.samples = 500;
  bias.terms = 1;
  bias.term[0] = BiasTerm::TimeTag;
  bias.cov(0, 0) = 1e-6;
  bias.value[0] = 0.3;  // fifteen prior sigmas
  EXPECT_LT(BiasTest()(prior, bias).plausibility.ratio, 1);
  bias.value[0] = 0.32;
  EXPECT_GT(BiasTest()(prior, bias).plausibility.ratio, 1);
  bias.reference = BiasReference::CrossRadar;  // it was not a receiver that taught it
  EXPECT_EQ(BiasTest()(prior, bias).plausibility.ratio, 0);
}

/// A radar and a receiver that sampled a vehicle at one instant.
struct Two {
  Two() : all(witnesses_of(test::small_range(), 1)), radar(all[0]), receiver(all[2]) {
    motion.head<3>() = test::vehicle_at(60).m;
    receiver_sample = sample(motion.head<3>());
    const Polar q = polar_from_enu(radar.model.site.enu_of(test::vehicle_at(60)));
    radar_sample = sample({q.range_m, q.azimuth_rad, q.elevation_rad});
  }
  Sample sample(const Vec<3>& z) const {
    Sample s;
    s.epoch = liftoff + seconds(60);
    s.z = z;
    s.motion = motion;
    s.measurements = 5;
    s.sigma_horizontal_m = 5;
    s.sigma_vertical_m = 8;
    return s;
  }
  std::vector<Witness> all;
  Witness& radar;
  Witness& receiver;
  Vec<9> motion = Vec<9>::Zero();
  Sample radar_sample;
  Sample receiver_sample;
  Threshold threshold;
};

TEST(Witness, AMountWandersAsTheMethodsHaveItUntilAReceiverIsHeard) {
  RangeConfig range = test::small_range();
  range.radars[1].wander = {.sigma_rad = 0.05 * deg, .tau_s = 10};  // more than the methods allow without GPS
  const PointingWander without_gps = range.align.gps.no_gps.wander;
  ASSERT_GT(without_gps.sigma_rad, range.radars[0].wander.sigma_rad);
  std::vector<Witness> all = witnesses_of(range, 1);
  EXPECT_EQ(all[0].model.wander.sigma_rad, without_gps.sigma_rad);
  EXPECT_EQ(all[0].slow_tau_s, without_gps.tau_s);
  EXPECT_EQ(all[1].model.wander.sigma_rad, range.radars[1].wander.sigma_rad);
  for (Witness& w : all) w.receiver_is_heard();
  EXPECT_EQ(all[0].model.wander.sigma_rad, range.radars[0].wander.sigma_rad);
  EXPECT_EQ(all[0].slow_tau_s, range.radars[0].wander.tau_s);

  range.align.gps.no_gps.enabled = false;
  EXPECT_EQ(witnesses_of(range, 1)[0].model.wander.sigma_rad, range.radars[0].wander.sigma_rad);
}

/// A target that crosses north in half a second, 40 km from a radar whose place is certain and whose azimuth's scale is
/// not: the step of 2 pi times the scale is no break with its past, ten times as much is.
/// Of a receiver that samples once a second and jumps by these vectors (m east) at these seconds: whether it is said to
/// have leapt, after each second.
std::string leaps(const std::map<int, double>& jumps, int seconds_flown, bool alone = true) {
  Leap leap;
  std::string said;
  for (int t = 0; t < seconds_flown; ++t) {
    OwnPast jump{.ratio = 0.1, .apart_m = 5, .step_m = {1, 0, 0}};
    if (const auto at = jumps.find(t); at != jumps.end())
      jump = {.ratio = 100, .apart_m = std::abs(at->second), .step_m = {at->second, 0, 0}};
    leap.note(liftoff + seconds(t), jump, alone);
    said += leap.since() ? '!' : '.';
  }
  return said;
}

TEST(OwnPast, ALeapLastsUntilItIsTakenBackOrHalfAMinute) {
  EXPECT_EQ(leaps({{10, 500}, {15, -480}}, 20), "...........!!!!.....");
  EXPECT_EQ(leaps({{10, 250}, {11, 250}, {15, -250}, {16, -250}}, 20), "............!!!!....") << "in two samples";
  EXPECT_EQ(leaps({{10, 500}, {11, -500}}, 20), std::string(20, '.')) << "one wild fix";
  EXPECT_EQ(leaps({{4, 500}}, 20), std::string(20, '.')) << "no quiet past";
  EXPECT_EQ(leaps({{10, 500}}, 20, false), std::string(20, '.')) << "others will tell";
  EXPECT_EQ(leaps({{10, 500}}, 50), std::string(11, '.') + std::string(30, '!') + std::string(9, '.'));
}

/// A receiver that jumped at 0 s by 300 m, and what a radar's tests make of it with and without the jump, each second.
TEST(OwnPast, TheFirstRadarTellsOnWhichSideOfItsJumpAReceiverWasRight) {
  const auto judged = [](std::initializer_list<std::pair<double, double>> tests, int first_s = 1) {
    Return back;
    back.jumped(liftoff, {300, 0, 0});
    int t = first_s;
    for (const auto& [ratio, without_jump] : tests) back.judge(liftoff + seconds(t++), ratio, without_jump);
    return back;
  };
  const Return right = judged({{0.01, 0.3}, {0.01, 0.3}, {0.02, 0.3}});
  EXPECT_EQ(right.since(), liftoff);
  EXPECT_FALSE(right.jump()) << "judged";
  EXPECT_FALSE(judged({{0.01, 0.3}, {0.01, 0.3}}).since());
  EXPECT_FALSE(judged({{0.01, 0.3}, {0.01, 0.1}, {0.01, 0.3}, {0.01, 0.3}}).since()) << "not in a row";
  EXPECT_FALSE(judged({{0.3, 0.01}, {0.3, 0.01}, {0.3, 0.01}}).since()) << "the other side is likelier";
  const Return liar = judged({{1.5, 9}});
  EXPECT_FALSE(liar.jump()) << "wrong on both sides: others will tell";
  EXPECT_FALSE(judged({{0.01, 0.3}, {0.01, 0.3}, {0.02, 0.3}}, 31).since()) << "too long ago";

  Return in_two;
  in_two.jumped(liftoff, {150, 0, 0});
  in_two.jumped(liftoff + seconds(1), {150, 0, 0});
  EXPECT_EQ(in_two.step_m(), Vec<3>(300, 0, 0));
}

TEST(OwnPast, CrossingNorthIsNoBreak) {
  RangeConfig range = test::small_range();
  range.radars[0].bias.blocks = {BiasBlock::Polar};
  const Witness radar = witnesses_of(range, 1)[0];
  const double scale = 2 * std::sqrt(radar.prior.cov(static_cast<Eigen::Index>(BiasTerm::ScaleAzimuth),
                                                     static_cast<Eigen::Index>(BiasTerm::ScaleAzimuth)));
  const auto seen = [&](double east_m, double scale_of_azimuth) {
    Sample s;
    s.epoch = liftoff + seconds(60 + east_m / 1000);
    s.measurements = 5;
    s.motion.head<3>() = radar.model.site.ecef_of(Displacement<Enu>{{east_m, 40'000, 20'000}}).m;
    s.motion.segment<3>(3) = radar.model.site.R_enu_ecef().R.transpose() * Vec<3>(1000, 0, 0);
    BiasVector bias = BiasVector::Zero();
    bias[static_cast<Eigen::Index>(BiasTerm::ScaleAzimuth)] = scale_of_azimuth;
    s.z = predict_plot(radar.model, s.motion, bias).q;
    return s;
  };
  const Threshold threshold;
  EXPECT_LT(own_jump(radar, seen(-250, scale), seen(250, scale), threshold).ratio, 0.5);
  EXPECT_GT(own_jump(radar, seen(-250, 10 * scale), seen(250, 10 * scale), threshold).ratio, 1);
  EXPECT_GT(own_jump(radar, seen(1000, 0), seen(1500, scale), threshold).ratio, 1) << "a step without a crossing";
}

TEST(CoarseTest, AgreesWithinThePriorsAndSeesASign) {
  Two two;
  two.radar_sample.z[0] += 100;
  two.radar_sample.z[2] += 0.2 * deg;
  EXPECT_LT(coarse_test(two.receiver, two.receiver_sample, two.radar, two.radar_sample, two.threshold).ratio, 0.2);
  two.radar_sample.z[1] = -two.radar_sample.z[1];
  EXPECT_GT(coarse_test(two.receiver, two.receiver_sample, two.radar, two.radar_sample, two.threshold).ratio, 1);
}

TEST(Difference, OfTwoRadarsIsThatOfTheirPositionsByBothLinearisations) {
  Two two;
  Witness& other = two.all[1];
  const Polar q = polar_from_enu(other.model.site.enu_of(test::vehicle_at(60)));
  const Sample b = two.sample({q.range_m, q.azimuth_rad, q.elevation_rad});
  BiasVector bias = BiasVector::Zero();
  const auto none = difference(two.radar, two.radar_sample, bias, other, b, BiasVector::Zero());
  ASSERT_TRUE(none);
  EXPECT_NEAR(none->d.cwiseProduct(none->to_metres).norm(), 0, 1e-5);
  // A small bias of the first moves the difference as its Jacobian says.
  for (const BiasTerm term : {BiasTerm::OffsetRange, BiasTerm::OffsetAzimuth, BiasTerm::OffsetEast}) {
    const auto k = static_cast<Eigen::Index>(term);
    const double step = term == BiasTerm::OffsetAzimuth ? 1e-6 : 0.1;
    bias.setZero();
    bias[k] = step;
    const auto moved = difference(two.radar, two.radar_sample, bias, other, b, BiasVector::Zero());
    ASSERT_TRUE(moved);
    const Vec<3> expected = none->by_first.col(k) * step;
    EXPECT_LT((moved->d - none->d - expected).cwiseProduct(none->to_metres).norm(),
              1e-3 * expected.cwiseProduct(none->to_metres).norm());
  }
}

}  // namespace
}  // namespace downrange::integrity
