/// Interacting models: closed forms, probabilities far beyond the range of doubles, a manoeuvre found.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <downrange/est/filter/imm.hpp>
#include <limits>
#include <random>

namespace downrange {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(ImmSwitching, TwoModelsHaveAClosedForm) {
  // exp(G t) of G = [[-a, a], [b, -b]]: p00 = (b + a e^-(a+b)t) / (a + b).
  const double a = 0.3;
  const double b = 0.05;
  const Mat<2, 2> rates = (Mat<2, 2>() << -a, a, b, -b).finished();
  for (const double t : {0.0, 1e-6, 0.2, 1.0, 7.0, 60.0, 1e5}) {
    const Mat<2, 2> P = imm::switching_over<2>(rates, t);
    const double fade = std::exp(-(a + b) * t);
    EXPECT_NEAR(P(0, 0), (b + a * fade) / (a + b), 1e-14) << t;
    EXPECT_NEAR(P(1, 0), b * (1 - fade) / (a + b), 1e-14) << t;
    EXPECT_NEAR(P.row(0).sum(), 1, 1e-15);
  }
}

TEST(ImmSwitching, StepsAddUpAndNothingIsNegative) {
  const Mat<3, 3> rates = (Mat<3, 3>() << -.004, .002, .002, .002, -.004, .002, .25, .25, -.5).finished();
  const Mat<3, 3> once = imm::switching_over<3>(rates, 1.0);
  Mat<3, 3> five = Mat<3, 3>::Identity();
  for (int i = 0; i < 5; ++i) five = (five * imm::switching_over<3>(rates, 0.2)).eval();
  EXPECT_LT((once - five).cwiseAbs().maxCoeff(), 1e-15);
  EXPECT_GE(imm::switching_over<3>(rates, 1e-12).minCoeff(), 0);
}

TEST(ImmMixing, HandComputed) {
  // mu = (0.8, 0.2), switching [[.9 .1], [.4 .6]]: c = (.8, .2), weights into model 0 (.9, .1), into model 1 (.4, .6).
  const Vec<2> mu(0.8, 0.2);
  const Mat<2, 2> switching = (Mat<2, 2>() << 0.9, 0.1, 0.4, 0.6).finished();
  const auto mixing = imm::mixing_weights<2>(mu, switching);
  EXPECT_NEAR(mixing.predicted[0], 0.8, 1e-15);
  EXPECT_NEAR(mixing.weights(0, 0), 0.9, 1e-15);
  EXPECT_NEAR(mixing.weights(1, 0), 0.1, 1e-15);
  EXPECT_NEAR(mixing.weights(0, 1), 0.4, 1e-15);
  // Means 0 and 10, variances 1 and 4: into model 0 mean 1, variance .9 (1 + 1) + .1 (4 + 81) = 10.3.
  const imm::Bank<1, 2> models{Gaussian<1>{Vec<1>(0.0), Mat<1, 1>(1.0)}, Gaussian<1>{Vec<1>(10.0), Mat<1, 1>(4.0)}};
  const auto mixed = imm::mix<1, 2>(models, mixing);
  EXPECT_NEAR(mixed[0].mean[0], 1, 1e-14);
  EXPECT_NEAR(mixed[0].cov(0, 0), 10.3, 1e-13);
  EXPECT_NEAR(mixed[1].mean[0], 6, 1e-14);
  EXPECT_NEAR(mixed[1].cov(0, 0), 0.4 * 37 + 0.6 * 20, 1e-13);
}

TEST(ImmMixing, LeavesTheOverallMomentsAsTheyWere) {
  std::mt19937_64 rng(3);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0.01, 1);
  for (int run = 0; run < 50; ++run) {
    imm::Bank<4, 3> models;
    for (auto& m : models) {
      const Mat<4, 4> A = Mat<4, 4>::NullaryExpr([&] { return normal(rng); });
      m = {Vec<4>::NullaryExpr([&] { return 5 * normal(rng); }), A * A.transpose() + Mat<4, 4>::Identity()};
    }
    Vec<3> mu = Vec<3>::NullaryExpr([&] { return uniform(rng); });
    mu /= mu.sum();
    Mat<3, 3> switching = Mat<3, 3>::NullaryExpr([&] { return uniform(rng); });
    for (int i = 0; i < 3; ++i) switching.row(i) /= switching.row(i).sum();
    const auto mixing = imm::mixing_weights<3>(mu, switching);
    const Gaussian<4> before = imm::combine<4, 3>(models, mu);
    const Gaussian<4> after = imm::combine<4, 3>(imm::mix<4, 3>(models, mixing), mixing.predicted);
    EXPECT_LT((before.mean - after.mean).norm(), 1e-13 * (1 + before.mean.norm()));
    EXPECT_LT((before.cov - after.cov).norm(), 1e-13 * before.cov.norm());
    EXPECT_EQ(after.cov, after.cov.transpose().eval());
    EXPECT_GT((Eigen::SelfAdjointEigenSolver<Mat<4, 4>>(after.cov).eigenvalues().minCoeff()), 0);
  }
}

TEST(ImmMixing, AModelThatNothingLeadsToKeepsItsState) {
  const auto mixing = imm::mixing_weights<2>(Vec<2>(1, 0), Mat<2, 2>::Identity());
  EXPECT_EQ(mixing.predicted, Vec<2>(1, 0));
  EXPECT_EQ(mixing.weights, (Mat<2, 2>::Identity()));
}

TEST(ImmProbabilities, NothingUnderflows) {
  // exp(-1e6) is no double; the difference of two such logarithms is.
  const Vec<2> mu = imm::update_probabilities<2>(Vec<2>(0.5, 0.5), Vec<2>(-1e6, -1e6 - std::log(3)));
  EXPECT_NEAR(mu[0], 0.75, 1e-9);
  EXPECT_NEAR(mu.sum(), 1, 1e-15);
  const Vec<2> far = imm::update_probabilities<2>(Vec<2>(0.5, 0.5), Vec<2>(0, -1e300));
  EXPECT_EQ(far, Vec<2>(1, 0));
  const Vec<2> never = imm::update_probabilities<2>(Vec<2>(0, 1), Vec<2>(50, -1e9));
  EXPECT_EQ(never, Vec<2>(0, 1));
}

TEST(ImmProbabilities, AMeasurementThatTellsNothingChangesNothing) {
  const Vec<2> mu(0.3, 0.7);
  EXPECT_EQ(imm::update_probabilities<2>(mu, Vec<2>(std::nan(""), std::nan(""))), mu);
  EXPECT_EQ(imm::update_probabilities<2>(mu, Vec<2>(-infinity, -infinity)), mu);
  EXPECT_EQ(imm::update_probabilities<2>(mu, Vec<2>(std::nan(""), -5)), Vec<2>(0, 1));
}

TEST(ImmLikelihood, IsTheGaussianDensity) {
  const Mat<2, 2> S = (Mat<2, 2>() << 4, 1, 1, 3).finished();  // det 11, inverse [3 -1; -1 4] / 11
  const Vec<2> nu(1, -2);
  const double nis = (3 * 1 + 2 * 2 + 4 * 4) / 11.0;
  EXPECT_NEAR(imm::log_likelihood<2>(nu, S), -0.5 * (nis + std::log(11) + 2 * std::log(2 * std::numbers::pi)), 1e-14);
  EXPECT_EQ(imm::log_likelihood<1>(Vec<1>(0), Mat<1, 1>(-1.0)), -infinity);
}

TEST(ImmAugmented, TheLackingStateComesWithItsPrior) {
  const Gaussian<2> model{Vec<2>(1, 2), Mat<2, 2>::Identity() * 3};
  const Gaussian<3> all = imm::augmented<3, 2>(model, {Vec<1>(7), Mat<1, 1>(100.0)});
  EXPECT_EQ(all.mean, Vec<3>(1, 2, 7));
  EXPECT_EQ(all.cov.diagonal(), Vec<3>(3, 3, 100));
  EXPECT_EQ(all.cov(0, 2), 0);
}

}  // namespace
}  // namespace downrange
