/// The track-level rules as methods: two of them against the centralised filter, the honesty of all, radars that fall
/// silent or jump, the number of radars they take.
#include <gtest/gtest.h>

#include <downrange/est/method/method_table.hpp>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/est/method/method.hpp>
#include <downrange/est/track/track_fusion.hpp>
#include <iostream>
#include <map>
#include <random>
#include <string>

#include "../support/drawn_flight.hpp"

namespace downrange {
namespace {

using test::deg;
using test::draw_flight;
using test::Flight;

const std::array<std::string, 5> rules{"information", "federated", "map", "bar-shalom-campo", "convex"};

/// How far two methods' tracks of target 0 are apart: the means in sigma of `b`, the covariances relative to b's.
struct Apart {
  double mean = 0;
  double cov = 0;
};
Apart apart(const Method& a, const Method& b) {
  const TrackEstimate x = a.fused(0).value();
  const TrackEstimate y = b.fused(0).value();
  EXPECT_EQ(x.epoch, y.epoch);
  const Mat<6, 6> P = y.cov.topLeftCorner<6, 6>();
  const Vec<6> sigma = P.diagonal().cwiseSqrt();
  const Mat<6, 6> scale = sigma.cwiseInverse().asDiagonal();
  return {(x.mean - y.mean).head<6>().cwiseQuotient(sigma).cwiseAbs().maxCoeff(),
          (scale * (x.cov.topLeftCorner<6, 6>() - P) * scale).cwiseAbs().maxCoeff()};
}

/// Over a whole flight, after every measurement; both methods must say the same of each.
Apart worst_apart(const Flight& f, const std::string& name, const std::string& reference) {
  const auto a = make_method(name, f.settings);
  const auto b = make_method(reference, f.settings);
  Apart worst;
  for (const Measurement& m : f.measurements) {
    EXPECT_EQ(a->process(m, m.epoch).verdict, b->process(m, m.epoch).verdict);
    if (!b->fused(0)) continue;
    const Apart now = apart(*a, *b);
    worst.mean = std::max(worst.mean, now.mean);
    worst.cov = std::max(worst.cov, now.cov);
  }
  EXPECT_EQ(a->bias(0).value, b->bias(0).value);
  return worst;
}

/// The asynchronous fusion of song2015 equals the sequential Kalman filter of all compensated plots (est_async_fusion),
/// the centralised filter of this data. Its ALIGN is the same code, so both fuse the same positions with the same R. No
/// plot of this flight is outside either's gate: were the verdicts different, so were the tracks.
TEST(Information, IsTheCentralisedFilterAtEveryPlot) {
  // 1 200 plots at 30 instants a second, each radar's track on its own; after each the fused tracks are compared. What
  // is left is rounding: positions of 6e6 m have digits of 1e-9 m, some 1e-10 sigma.
  const Apart worst = worst_apart(draw_flight(11, 40, true), "information", "song2015");
  EXPECT_LT(worst.mean, 1e-7);
  EXPECT_LT(worst.cov, 1e-9);
}

/// Both radars measure at the instants of fusion: then, and only then, the shares add up to the centralised filter.
TEST(Federated, IsTheCentralisedFilterWhereRadarsMeasureAtTheInstantsOfFusion) {
  Flight f = draw_flight(12, 40, true);
  for (Measurement& m : f.measurements) m.epoch = ceil_to_grid(m.epoch, f.settings.cartesian_fusion.batch);
  std::sort(f.measurements.begin(), f.measurements.end(), processed_before);
  const Apart worst = worst_apart(f, "federated", "song2015");
  EXPECT_LT(worst.mean, 1e-7);
  EXPECT_LT(worst.cov, 1e-9);
}

/// Between them it knows less than the centralised filter, and says so: the difference of the covariances is positive
/// semidefinite (to rounding).
TEST(Federated, IsOnTheSafeSideBetweenTheInstantsOfFusion) {
  const Flight f = draw_flight(12, 40, true);
  const auto federated = make_method("federated", f.settings);
  const auto centralised = make_method("song2015", f.settings);
  double wider = 0;
  for (const Measurement& m : f.measurements) {
    (void)federated->process(m, m.epoch);
    (void)centralised->process(m, m.epoch);
    if (m.epoch < Time{} + seconds(20)) continue;
    const Mat<6, 6> P = centralised->fused(0)->cov.topLeftCorner<6, 6>();
    const Mat<6, 6> root = P.llt().matrixL();
    const Mat<6, 6> D = federated->fused(0)->cov.topLeftCorner<6, 6>() - P;
    const Mat<6, 6> relative =
        root.triangularView<Eigen::Lower>().solve(Mat<6, 6>(root.triangularView<Eigen::Lower>().solve(D).transpose()));
    const Eigen::SelfAdjointEigenSolver<Mat<6, 6>> eigen(symmetric<6>(relative));
    EXPECT_GT(eigen.eigenvalues().minCoeff(), -1e-9);
    wider = std::max(wider, eigen.eigenvalues().maxCoeff());
  }
  EXPECT_GT(wider, 0.001);
}

/// Targets that move as the tracks' model says, seen by three radars without bias, out of step, one of them away for
/// seven seconds: longer than a silent track is kept.
struct Drawn {
  MethodSettings settings;
  std::vector<Measurement> measurements;
  Vec<6> truth;  ///< at the last measurement
};
Drawn draw_common_noise(std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  const auto draw3 = [&] { return Vec<3>(normal(rng), normal(rng), normal(rng)); };
  Drawn d;
  const PolarSigma sigma{25, 0.02 * deg, 0.02 * deg};
  d.settings.radars = {{Site({34.4450 * deg, 127.52 * deg, 120}), sigma},
                       {Site({33.9 * deg, 127.0 * deg, 350}), sigma},
                       {Site({34.3 * deg, 128.2 * deg, 50}), sigma}};
  d.settings.cartesian_bias.offset_prior_m = 0;
  d.settings.cartesian_bias.scale_prior = 0;
  d.settings.arbitration.gate_probability = 1;
  d.settings.start.sigma_velocity_m_s = 300;
  const std::array<std::int64_t, 3> period{100, 50, 250};
  const std::array<std::int64_t, 3> phase{13, 31, 77};
  const Site centre({34.2 * deg, 127.6 * deg, 0});
  Vec<3> p = centre.ecef_of({{2000 * normal(rng), 2000 * normal(rng), 30'000}}).m;
  Vec<3> v = d.settings.start.sigma_velocity_m_s * draw3();
  std::int64_t at_ms = 0;
  for (std::int64_t ms = 1; ms <= 14'000; ++ms) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (ms % period[i] != phase[i] || (i == 1 && ms > 4000 && ms < 11'000)) continue;
      // White acceleration over dt: two independent normals give [T^3/3, T^2/2; T^2/2, T] q.
      const double T = 1e-3 * static_cast<double>(ms - at_ms);
      const double root = std::sqrt(d.settings.cartesian_fusion.q_m2_s3 * T);
      const Vec<3> a = draw3();
      const Vec<3> b = draw3();
      p += T * v + root * T * (a / 2 + b / std::sqrt(12.0));
      v += root * a;
      at_ms = ms;
      Measurement m;
      m.epoch = Time{} + milliseconds(ms);
      m.source = static_cast<int>(i);
      m.sequence = static_cast<std::uint64_t>(ms);
      test::polar(m) = polar_from_enu(d.settings.radars[i].site.enu_of({p}));
      test::polar(m).range_m += sigma.range_m * normal(rng);
      test::polar(m).azimuth_rad = wrap_two_pi(test::polar(m).azimuth_rad + sigma.azimuth_rad * normal(rng));
      test::polar(m).elevation_rad += sigma.elevation_rad * normal(rng);
      d.measurements.push_back(m);
    }
  }
  d.truth << p, v;
  return d;
}

TEST(TrackLevel, WhatEachRuleDoesAboutTheCommonNoise) {
  // NEES / 6 at the end of 400 runs; bands with 1e-4 false alarms each. The tracks' common noise is large: a track of
  // one radar is mostly that.
  constexpr int runs = 400;
  std::map<std::string, double> nees;
  std::map<std::string, double> square;
  for (std::uint64_t run = 0; run < runs; ++run) {
    const Drawn d = draw_common_noise(1000 + run);
    for (const std::string& rule : rules) {
      const auto method = make_method(rule, d.settings);
      for (const Measurement& m : d.measurements) (void)method->process(m, m.epoch);
      const TrackEstimate e = method->fused(0).value();
      const Vec<6> error = e.mean.head<6>() - d.truth;
      nees[rule] += normalised_square<6>(error, e.cov.topLeftCorner<6, 6>()) / 6 / runs;
      square[rule] += error.head<3>().squaredNorm() / runs;
    }
  }
  for (const std::string& rule : rules)
    std::cout << rule << ": NEES/6 " << nees[rule] << ", rms " << std::sqrt(square[rule]) << " m\n";
  const Band honest = average_chi2_band(6, runs, 1e-4);
  EXPECT_TRUE(honest.contains(nees["information"])) << nees["information"];
  EXPECT_TRUE(honest.contains(nees["map"])) << nees["map"];
  EXPECT_TRUE(honest.contains(nees["bar-shalom-campo"])) << nees["bar-shalom-campo"];
  EXPECT_LT(nees["federated"], honest.high);  // wide between the instants of fusion
  EXPECT_GT(nees["federated"], 0.7 * honest.low);
  EXPECT_GT(nees["convex"], honest.high);  // over-confident: it takes the common noise for independent
  // Information is the best there is.
  for (const std::string& rule : rules) EXPECT_LE(square["information"], 1.01 * square[rule]) << rule;
}

class EveryRule : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Rules, EveryRule, testing::ValuesIn(rules), [](const auto& rule) {
  std::string label = rule.param;
  std::ranges::replace(label, '-', '_');
  return label;
});

TEST_P(EveryRule, TakesTheBiasOut) {
  const Flight f = draw_flight(1, 60, true);
  const auto method = make_method(GetParam(), f.settings);
  const test::Flown with = test::fly(*method, f, 30);
  const test::Flown without = test::fly(*make_method("uncorrected", f.settings), f, 30);
  EXPECT_LT(with.rms_m, 0.5 * without.rms_m);
  EXPECT_EQ(method->bias(1).terms, 6);
  EXPECT_EQ(method->fused(0)->sources, 0b111u) << "both radars, and the station by whose fixes their biases go";
}

TEST_P(EveryRule, ARadarThatJumpsIsOpenedAgainInsteadOfLockedOut) {
  Flight f = draw_flight(6, 60, true);
  for (Measurement& m : f.measurements)
    if (!is_fix(m) && m.source == 1 && m.epoch > Time{} + seconds(40)) test::polar(m).range_m += 280;
  const auto method = make_method(GetParam(), f.settings);
  for (const Measurement& m : f.measurements) (void)method->process(m, m.epoch);
  EXPECT_GE(method->account(1).gated, static_cast<std::uint64_t>(f.settings.arbitration.reopen_after) - 1);
  EXPECT_EQ(method->account(1).rejected_in_row, 0);
}

TEST_P(EveryRule, StartsWithTheEstimateGiven) {
  const Flight f = draw_flight(3, 2, false, false);
  const auto method = make_method(GetParam(), f.settings);
  const Site pad({34.43 * deg, 127.53 * deg, 100});
  Gaussian<9> prior;
  prior.mean.setZero();
  prior.mean.head<3>() = test::truth_at(pad, 10).m;
  prior.mean.segment<3>(3) = (test::truth_at(pad, 10.01).m - test::truth_at(pad, 9.99).m) / 0.02;
  prior.cov.diagonal().setConstant(1e-4);
  method->start(0, Time{} + seconds(10), prior);
  (void)method->process(f.measurements.front(), f.measurements.front().epoch);
  // A plot of 25 m against a prior of centimetres, 13 ms old: 1 m is left for q = 1000.
  EXPECT_LT((method->fused(0)->mean.head<3>() - test::truth_at(pad, 10.013).m).norm(), 1);
}

TEST_P(EveryRule, TakesSoManyRadarsAndSaysSo) {
  MethodSettings settings = draw_flight(1, 1, false).settings;
  settings.radars.resize(static_cast<std::size_t>(capabilities_of(GetParam()).most_radars), settings.radars.front());
  settings.radars.push_back({.site = Site{}, .sigma = {}});  // a tracker does not count
  EXPECT_NO_THROW((void)make_method(GetParam(), settings));
  settings.radars.insert(settings.radars.begin(), settings.radars.front());
  try {
    (void)make_method(GetParam(), settings);
    ADD_FAILURE() << "17 radars were taken";
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(std::string(e.what()).find("at most 16 radars, found 17"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace downrange
