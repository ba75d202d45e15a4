/// Input estimation: reference vectors, the identity that defines it, its statistics, and manoeuvres found and ended.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <downrange/est/filter/input_estimation.hpp>
#include <limits>
#include <random>

#include "../support/vectors.hpp"

namespace downrange {
namespace {

using test::matrix_of;
using test::relative_error;
using test::vector_of;

constexpr double infinity = std::numeric_limits<double>::infinity();

/// A linear filter in the plane that a test steps, with hypotheses beside it.
template <int U>
struct Beside {
  Gaussian<4> x;
  Mat<4, 4> F;
  Mat<4, U> B;
  Mat<4, 4> Q;
  Mat<2, 4> H = Mat<2, 4>::Identity();
  Mat<2, 2> R;
  InputHypotheses<4, U> hypotheses;

  Update<4, 2> step(const Vec<2>& z, double dt = 1) {
    hypotheses.predict(dt, F, B);
    const Gaussian<4> prior{F * x.mean, F * x.cov * F.transpose() + Q};
    const Vec<2> nu = z - H * prior.mean;
    const auto u = kalman_update<4, 2>(prior, nu, H, R, infinity);
    const Mat<4, 2> K = prior.cov * H.transpose() * u.S.inverse();
    hypotheses.template update<2>(H, K, u.S, nu);
    x = u.posterior;
    return u;
  }
};

TEST(InputEstimation, Vectors) {
  DOWNRANGE_VECTOR_CASES(cases, "input_estimation.json");
  for (const auto& c : cases) {
    Beside<2> planar{{vector_of(c["x0"]), matrix_of(c["P0"])},
                     matrix_of(c["F"]),
                     matrix_of(c["B"]),
                     matrix_of(c["Q"]),
                     Mat<2, 4>::Identity(),
                     matrix_of(c["R"]),
                     InputHypotheses<4, 2>()};
    // With B = I the transfer of W = T B is the T of the paper itself.
    Beside<4> whole{planar.x, planar.F, Mat<4, 4>::Identity(), planar.Q, planar.H, planar.R, InputHypotheses<4, 4>()};
    planar.hypotheses.open();
    whole.hypotheses.open();
    Mat<2, 2> D;
    Vec<2> A;
    for (const auto& s : c["steps"]) {
      const Vec<2> z = vector_of(s["z"]);
      const auto u = planar.step(z);
      (void)whole.step(z);
      EXPECT_LT(relative_error(u.innovation, vector_of(s["nu"])), 1e-12);
      EXPECT_LT(relative_error(u.S, matrix_of(s["S"])), 1e-12);
      EXPECT_LT(relative_error(planar.x.cov, matrix_of(s["P"])), 1e-12);
      D = matrix_of(s["D_sum"]);
      A = vector_of(s["A_sum"]);
      const auto e = planar.hypotheses.estimate(0);
      ASSERT_TRUE(e);
      const Mat<4, 4> T = matrix_of(s["T"]);
      EXPECT_LT(relative_error(planar.hypotheses.transfer(0), T * planar.B), 1e-12);
      EXPECT_LT(relative_error(e->R_u.inverse(), D), 1e-12);
      EXPECT_LT((e->R_u.inverse() * e->u - A).norm(), 1e-12 * A.norm());
      EXPECT_LT(relative_error(whole.hypotheses.transfer(0), T), 1e-12);
    }
    const auto e = planar.hypotheses.best();
    ASSERT_TRUE(e);
    EXPECT_LT(relative_error(e->u, vector_of(c["u_hat"])), 1e-10);
    EXPECT_LT(relative_error(e->R_u, matrix_of(c["R_u"])), 1e-10);
    const Gaussian<4> state = corrected<4, 2>(planar.x, *e, planar.hypotheses.transfer(0));
    EXPECT_LT(relative_error(state.mean, vector_of(c["x_corrected"])), 1e-10);
    EXPECT_LT(relative_error(state.cov, matrix_of(c["P_corrected"])), 1e-10);
    const Gaussian<6> all = extended<4, 2>(planar.x, *e, planar.hypotheses.transfer(0));
    EXPECT_LT(relative_error(all.cov.topRightCorner<4, 2>(), matrix_of(c["P_x_u"])), 1e-10);
    EXPECT_EQ(all.mean.tail<2>(), e->u);
  }
}

Mat<4, 4> transition(double T) {
  Mat<4, 4> F = Mat<4, 4>::Identity();
  F.topRightCorner<2, 2>().diagonal().setConstant(T);
  return F;
}
Mat<4, 2> input_effect(double T) {
  Mat<4, 2> B;
  B << T * T / 2 * Mat<2, 2>::Identity(), T * Mat<2, 2>::Identity();
  return B;
}

TEST(InputEstimation, IrregularStepsWithoutNoiseReturnTheInput) {
  // The filter that is told u and the one that is not differ by W u, exactly; without noise u comes out.
  std::mt19937_64 rng(8);
  std::uniform_real_distribution<double> uniform(0.05, 2);
  const Vec<2> u(15, -4);
  Vec<4> truth(100, -50, 20, 5);
  Beside<2> filter{{truth, Mat<4, 4>::Identity() * 100},
                   {},
                   {},
                   {},
                   Mat<2, 4>::Identity(),
                   Mat<2, 2>::Identity() * 9,
                   InputHypotheses<4, 2>()};
  filter.hypotheses.open();
  Gaussian<4> told = filter.x;
  for (int k = 0; k < 12; ++k) {
    const double T = uniform(rng);
    filter.F = transition(T);
    filter.B = input_effect(T);
    filter.Q = 0.25 * filter.B * filter.B.transpose() + Mat<4, 4>::Identity() * 1e-6;
    truth = filter.F * truth + filter.B * u;
    const Gaussian<4> prior{filter.F * told.mean + filter.B * u, filter.F * told.cov * filter.F.transpose() + filter.Q};
    const Vec<2> z = truth.head<2>();
    told = kalman_update<4, 2>(prior, z - prior.mean.head<2>(), filter.H, filter.R, infinity).posterior;
    (void)filter.step(z, T);
    const auto e = filter.hypotheses.best();
    ASSERT_TRUE(e);
    EXPECT_LT((e->u - u).norm(), 1e-9) << "step " << k;
    EXPECT_LT((filter.x.mean + filter.hypotheses.transfer(0) * u - told.mean).norm(), 1e-9) << "step " << k;
  }
}

TEST(InputEstimation, SeveralMeasurementsAtOnceAreOneStackedOne) {
  const double T = 0.7;
  const Mat<4, 4> F = transition(T);
  const Mat<4, 4> Q = Mat<4, 4>::Identity() * 0.1;
  const Gaussian<4> prior{Vec<4>::Zero(), F * Mat<4, 4>::Identity() * 50 * F.transpose() + Q};
  const Vec<2> z1(3, 4);
  const Vec<2> z2(-1, 5);
  const Mat<2, 4> H = Mat<2, 4>::Identity();
  const Mat<2, 2> R1 = Mat<2, 2>::Identity() * 4;
  const Mat<2, 2> R2 = Mat<2, 2>::Identity() * 9;

  InputHypotheses<4, 2> sequential;
  sequential.open();
  sequential.predict(T, F, input_effect(T));
  InputHypotheses<4, 2> stacked = sequential;
  Gaussian<4> x = prior;
  for (const auto& [z, R] : {std::pair{z1, R1}, std::pair{z2, R2}}) {
    const auto u = kalman_update<4, 2>(x, z - H * x.mean, H, R, infinity);
    sequential.update<2>(H, x.cov * H.transpose() * u.S.inverse(), u.S, u.innovation);
    x = u.posterior;
  }
  Mat<4, 4> HH;
  HH << H, H;
  Mat<4, 4> RR = Mat<4, 4>::Zero();
  RR.topLeftCorner<2, 2>() = R1;
  RR.bottomRightCorner<2, 2>() = R2;
  Vec<4> nu;
  nu << z1, z2;
  const Mat<4, 4> S = HH * prior.cov * HH.transpose() + RR;
  stacked.update<4>(HH, prior.cov * HH.transpose() * S.inverse(), S, nu);
  const auto a = sequential.best();
  const auto b = stacked.best();
  EXPECT_LT((a->u - b->u).norm(), 1e-11);
  EXPECT_LT(relative_error(a->R_u, b->R_u), 1e-12);
  EXPECT_LT(relative_error(sequential.transfer(0), stacked.transfer(0)), 1e-12);
  EXPECT_NEAR(a->significance, b->significance, 1e-12);
}

TEST(InputEstimation, DynamicSizeGivesTheSame) {
  const Mat<4, 4> F = transition(1);
  const Mat<4, 2> B = input_effect(1);
  const Mat<2, 4> H = Mat<2, 4>::Identity();
  const Mat<4, 2> K = H.transpose() * 0.3;
  const Mat<2, 2> S = Mat<2, 2>::Identity() * 7;
  InputHypotheses<4, 2> fixed;
  InputHypotheses<Eigen::Dynamic, 2> dynamic(4);
  for (int k = 0; k < 8; ++k) {  // more than the window: the oldest leave
    fixed.open();
    dynamic.open();
    fixed.predict(1, F, B);
    dynamic.predict_with(1, [&](auto& W) { W = (F * W + B).eval(); });
    fixed.update<2>(H, K, S, Vec<2>(k, -1));
    dynamic.update_with<2>([&](const auto& W) -> Mat<2, 2> { return W.topRows(2); }, K, S, Vec<2>(k, -1));
  }
  EXPECT_EQ(fixed.count(), 6);
  EXPECT_EQ(fixed.estimate(0)->age_s, 6);
  EXPECT_EQ(fixed.best()->u, dynamic.best()->u);
  EXPECT_EQ(fixed.transfer(2), dynamic.transfer(2));
}

TEST(InputEstimation, WhatIsNotSeenIsNotEstimated) {
  InputHypotheses<4, 2> hypotheses;
  hypotheses.open();
  EXPECT_FALSE(hypotheses.best());
  hypotheses.predict(1, transition(1), input_effect(1));
  hypotheses.update<1>(Mat<1, 4>(1, 0, 0, 0), Mat<4, 1>(0.5, 0, 0.1, 0), Mat<1, 1>(2.0), Vec<1>(1));
  EXPECT_FALSE(hypotheses.best());  // x alone says nothing of an input in y
}

VariableDimension<4, 2>::Step step_of(double T) {
  return {.dt = T,
          .F = transition(T),
          .B = input_effect(T),
          .Q = input_effect(T) * input_effect(T).transpose() * 0.25,
          .Q_input = Mat<2, 2>::Identity() * 0.01 * T};
}

TEST(InputEstimation, SignificanceIsChiSquareWhenThereIsNoInput) {
  // 500 runs of one hypothesis, two degrees: band of the mean with 1e-4 false alarms; share above the 3 sigma point.
  std::mt19937_64 rng(31);
  std::normal_distribution<double> normal;
  constexpr int runs = 500;
  double sum = 0;
  InsideShare inside;
  const auto step = step_of(1);
  for (int run = 0; run < runs; ++run) {
    Vec<4> truth = Vec<4>::Zero();
    const Mat<4, 4> P0 = Vec<4>(100, 100, 25, 25).asDiagonal();
    Beside<2> filter{
        {truth + P0.diagonal().cwiseSqrt().cwiseProduct(Vec<4>::NullaryExpr([&] { return normal(rng); })), P0},
        step.F,
        step.B,
        step.Q,
        Mat<2, 4>::Identity(),
        Mat<2, 2>::Identity() * 36,
        InputHypotheses<4, 2>()};
    filter.hypotheses.open();
    for (int k = 0; k < 6; ++k) {
      truth = step.F * truth + step.B * Vec<2>::NullaryExpr([&] { return 0.5 * normal(rng); });
      (void)filter.step(truth.head<2>() + Vec<2>::NullaryExpr([&] { return 6 * normal(rng); }));
    }
    const double significance = filter.hypotheses.best()->significance;
    sum += significance / 2;
    inside.add(significance, 2);
  }
  EXPECT_TRUE(average_chi2_band(2, runs, 1e-4).contains(sum / runs)) << sum / runs;
  EXPECT_TRUE(share_band(0.95, runs, 1e-4).contains(inside.share())) << inside.share();
}

TEST(VariableDimension, FindsAManoeuvreEstimatesItAndReturns) {
  std::mt19937_64 rng(2);
  std::normal_distribution<double> normal;
  const auto step = step_of(1);
  Vec<4> truth(0, 0, 30, 10);
  VariableDimension<4, 2> filter({truth, Vec<4>(100, 100, 25, 25).asDiagonal()}, VdieSettings{});
  const Mat<2, 4> H = Mat<2, 4>::Identity();
  const Vec<2> a(9, -6);
  int opened_at = 0;
  int false_before = 0;
  for (int k = 1; k <= 90; ++k) {
    const bool accelerates = k > 30 && k <= 60;
    truth = step.F * truth + (accelerates ? Vec<4>(step.B * a) : Vec<4>::Zero().eval());
    filter.predict(step);
    const Vec<2> z = truth.head<2>() + Vec<2>::NullaryExpr([&] { return 10 * normal(rng); });
    (void)filter.update<2>(z - filter.state().mean.head<2>(), H, Mat<2, 2>::Identity() * 100, infinity);
    filter.decide();
    if (k <= 30 && filter.manoeuvring()) ++false_before;
    if (k > 30 && opened_at == 0 && filter.manoeuvring()) opened_at = k;
    if (k > 40 && k <= 60) {
      EXPECT_TRUE(filter.manoeuvring()) << k;
      EXPECT_LT((filter.input().mean - a).norm(), 3) << k;
      EXPECT_LT((filter.state().mean - truth).head<2>().norm(), 40) << k;
    }
  }
  EXPECT_EQ(false_before, 0);
  EXPECT_LE(opened_at, 36);
  EXPECT_FALSE(filter.manoeuvring());
  EXPECT_LT((filter.state().mean - truth).head<2>().norm(), 30);
  EXPECT_EQ(filter.input().mean, Vec<2>::Zero());
}

}  // namespace
}  // namespace downrange
