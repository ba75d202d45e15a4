/// Two-stage estimation: it is the augmented-state filter, at a cost per measurement that does not know how many
/// targets there are.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/est/filter/two_stage.hpp>
#include <limits>
#include <numeric>
#include <vector>

#include "../support/allocations.hpp"
#include "../support/planar.hpp"
#include "experiment/augmented_filter.hpp"

namespace downrange {
namespace {

using experiment::AugmentedFilter;
using test::planar_noise;
using test::planar_transition;
using test::RandomMatrices;

constexpr double no_gate = std::numeric_limits<double>::infinity();
constexpr int terms = 3;
constexpr int biases = 2 * terms;
constexpr double dt = 0.5;
constexpr double q = 2;

/// One measurement of a linear problem.
struct Plot {
  int target = 0;
  int sensor = 0;
  Vec<2> z;
  Mat<2, 4> H;
  Mat<2, terms> C;
  Mat<2, 2> R;
};

struct Problem {
  std::vector<Gaussian<4>> starts;
  Gaussian<biases> prior;
  std::vector<std::vector<Plot>> scans;
};

/// Random measurements of `targets` targets by two sensors in turn.
Problem draw(std::uint64_t seed, int targets, int scans) {
  RandomMatrices random(seed);
  Problem p;
  for (int t = 0; t < targets; ++t) p.starts.push_back({random.matrix<4, 1>(), 4 * random.covariance<4>()});
  p.prior = {random.matrix<biases, 1>(), random.covariance<biases>()};
  for (int k = 0; k < scans; ++k) {
    p.scans.emplace_back();
    for (int t = 0; t < targets; ++t)
      p.scans.back().push_back({t, k % 2, 10 * random.matrix<2, 1>(), random.matrix<2, 4>(), random.matrix<2, terms>(),
                                random.covariance<2>()});
  }
  return p;
}

template <int Biases, int Max>
struct Filter {
  SharedBias<Biases, Max> bias;
  std::vector<BiasFreeTrack<4, Biases>> tracks;

  explicit Filter(const Problem& p) : bias(p.prior.mean, p.prior.cov) {
    for (const Gaussian<4>& start : p.starts) tracks.push_back({start, Eigen::MatrixXd::Zero(4, biases)});
  }
  void predict_all() {
    for (auto& track : tracks)
      predict(
          track, [](auto& X) { X.template topRows<2>() += dt * X.template bottomRows<2>(); }, planar_noise(dt, q));
  }
  TwoStageUpdate<2> process(const Plot& m, double gate = no_gate) {
    auto& track = tracks[static_cast<std::size_t>(m.target)];
    const Vec<2> nu = m.z - m.H * compensated_mean(track, bias) -
                      m.C * bias.mean().template segment<terms>(Eigen::Index{terms} * m.sensor);
    return update(bias, track, nu, m.H, m.C, terms * m.sensor, m.R, gate);
  }
  [[nodiscard]] Eigen::MatrixXd bias_covariance() const { return bias.covariance(); }
};

void process(AugmentedFilter<4>& filter, const Plot& m) {
  const Vec<2> nu =
      m.z - m.H * filter.target(m.target) - m.C * filter.bias().segment<terms>(Eigen::Index{terms} * m.sensor);
  filter.update<2, terms>(m.target, nu, m.H, m.C, terms * m.sensor, m.R);
}

/// Largest difference in sigma of the second estimate, of means and of standard deviations.
double difference(const Eigen::VectorXd& x, const Eigen::MatrixXd& P, const Eigen::VectorXd& y,
                  const Eigen::MatrixXd& Q) {
  const Eigen::ArrayXd sigma = Q.diagonal().cwiseSqrt();
  return std::max(((x - y).array() / sigma).abs().maxCoeff(),
                  ((P.diagonal().array().sqrt() - sigma) / sigma).abs().maxCoeff());
}

template <int Biases, int Max>
double difference(const Filter<Biases, Max>& filter, const AugmentedFilter<4>& augmented) {
  double worst =
      difference(filter.bias.mean(), filter.bias_covariance(), augmented.bias(), augmented.bias_covariance());
  for (std::size_t t = 0; t < filter.tracks.size(); ++t) {
    const Gaussian<4> x = compensated(filter.tracks[t], filter.bias);
    worst = std::max(worst, difference(x.mean, x.cov, augmented.target(static_cast<int>(t)),
                                       augmented.covariance(static_cast<int>(t))));
  }
  return worst;
}

template <class F>
void expect_augmented() {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Problem p = draw(seed, 4, 150);
    F filter(p);
    AugmentedFilter<4> augmented(p.starts, p.prior.mean, p.prior.cov);
    for (const auto& scan : p.scans) {
      filter.predict_all();
      augmented.predict(planar_transition(dt), planar_noise(dt, q));
      for (const Plot& m : scan) {
        filter.process(m);
        process(augmented, m);
      }
      ASSERT_LT(difference(filter, augmented), 1e-8);
    }
  }
}

TEST(TwoStage, IsTheAugmentedStateFilter) {
  expect_augmented<Filter<biases, biases>>();
  expect_augmented<Filter<Eigen::Dynamic, 16>>();
}

TEST(TwoStage, OrderOfTargetsInAScanIsIrrelevant) {
  const Problem p = draw(11, 5, 60);
  Filter<biases, biases> forwards(p);
  Filter<biases, biases> backwards(p);
  for (const auto& scan : p.scans) {
    forwards.predict_all();
    backwards.predict_all();
    for (const Plot& m : scan) forwards.process(m);
    for (auto m = scan.rbegin(); m != scan.rend(); ++m) backwards.process(*m);
  }
  EXPECT_LT(
      difference(forwards.bias.mean(), forwards.bias_covariance(), backwards.bias.mean(), backwards.bias_covariance()),
      1e-9);
}

TEST(TwoStage, ARejectedMeasurementChangesNothing) {
  const Problem p = draw(12, 2, 10);
  Filter<biases, biases> filter(p);
  for (const Plot& m : p.scans[0]) filter.process(m);
  const auto before = filter;
  Plot wild = p.scans[1][0];
  wild.z[0] = 1e6;
  const TwoStageUpdate<2> gated = filter.process(wild, 20);
  EXPECT_EQ(gated.verdict, Verdict::Gated);
  EXPECT_GT(gated.nis, 20);
  wild.z[0] = std::nan("");
  EXPECT_EQ(filter.process(wild).verdict, Verdict::Gated);
  wild.R = -1e6 * Mat<2, 2>::Identity();
  EXPECT_EQ(filter.process(wild).verdict, Verdict::Singular);
  EXPECT_EQ(filter.bias.mean(), before.bias.mean());
  EXPECT_EQ(filter.bias_covariance(), before.bias_covariance());
  EXPECT_EQ(filter.tracks[0].estimate.mean, before.tracks[0].estimate.mean);
  EXPECT_EQ(filter.tracks[0].V, before.tracks[0].V);
}

TEST(TwoStage, InnovationCovarianceCountsWhatIsNotKnownOfTheBiases) {
  const Problem p = draw(13, 1, 2);
  Filter<biases, biases> filter(p);
  const Plot& m = p.scans[0][0];
  const TwoStageUpdate<2> e = filter.process(m);
  const Mat<2, 2> S =
      m.H * p.starts[0].cov * m.H.transpose() + m.C * p.prior.cov.topLeftCorner<terms, terms>() * m.C.transpose() + m.R;
  EXPECT_LT((e.S - S).norm(), 1e-12 * S.norm());
  EXPECT_NEAR(e.nis, e.innovation.dot(S.llt().solve(e.innovation)), 1e-9 * e.nis);
}

TEST(TwoStage, DriftOfOneTargetIsTheAugmentedFiltersProcessNoise) {
  const Problem p = draw(14, 1, 200);
  Filter<biases, biases> filter(p);
  AugmentedFilter<4> augmented(p.starts, p.prior.mean, p.prior.cov);
  SharedBias<biases>::Step step(biases);
  for (const auto& scan : p.scans) {
    filter.predict_all();
    augmented.predict(planar_transition(dt), planar_noise(dt, q));
    for (int b = 0; b < biases; ++b) step.variance[b] = b == 2 ? 0 : 0.01 * (1 + b);
    filter.bias.loosen(step);
    loosen(filter.tracks[0], filter.bias, step);
    augmented.P.diagonal().tail<biases>() += step.variance;
    filter.process(scan[0]);
    process(augmented, scan[0]);
    ASSERT_LT(difference(filter, augmented), 1e-8);
  }
}

TEST(TwoStage, ALargeStepForgetsABiasAndNothingElse) {
  const Problem p = draw(15, 3, 100);
  Filter<biases, biases> filter(p);
  for (const auto& scan : p.scans) {
    filter.predict_all();
    for (const Plot& m : scan) filter.process(m);
  }
  const Eigen::MatrixXd before = filter.bias_covariance();
  SharedBias<biases>::Step step(biases);
  step.variance[1] = 1e7 * before(1, 1);
  for (auto& [estimate, V] : filter.tracks) ASSERT_GT(V.norm(), 0);
  filter.bias.loosen(step);
  for (auto& track : filter.tracks) loosen(track, filter.bias, step);
  Eigen::MatrixXd expected = before;
  expected(1, 1) += step.variance[1];
  const Eigen::ArrayXd sigma = expected.diagonal().cwiseSqrt();
  const Eigen::ArrayXXd relative =
      (filter.bias_covariance() - expected).array() / (sigma.matrix() * sigma.matrix().transpose()).array();
  EXPECT_LT(relative.abs().maxCoeff(), 1e-7);
}

/// A million measurements.
TEST(TwoStage, StaysPositiveDefiniteOverAMillionUpdates) {
  const Problem p = draw(16, 1, 64);
  Filter<biases, biases> filter(p);
  for (int k = 0; k < 1'000'000; ++k) {
    const Plot& m = p.scans[static_cast<std::size_t>(k % 64)][0];
    filter.predict_all();
    ASSERT_EQ(filter.process(m).verdict, Verdict::Accepted);
  }
  const Mat<biases, biases> Sigma = filter.bias_covariance();
  EXPECT_GT((Eigen::SelfAdjointEigenSolver<Mat<biases, biases>>(Sigma).eigenvalues().minCoeff()), 0);
  const Gaussian<4> x = compensated(filter.tracks[0], filter.bias);
  EXPECT_EQ(x.cov, x.cov.transpose().eval());
  EXPECT_GT((Eigen::SelfAdjointEigenSolver<Mat<4, 4>>(x.cov).eigenvalues().minCoeff()), 0);
}

TEST(TwoStage, AllocatesNothing) {
#ifdef DOWNRANGE_COUNTS_ALLOCATIONS
  ASSERT_GT(test::allocations_of([] { std::vector<double>(100).front() = 1; }), 0u);
#endif
  const Problem p = draw(18, 3, 50);
  Filter<Eigen::Dynamic, 832> filter(p);  // 64 radars with 13 terms
  SharedBias<Eigen::Dynamic, 832>::Step step(biases);
  double sum = 0;
  const std::size_t allocated = test::allocations_of([&] {
    for (const auto& scan : p.scans) {
      filter.predict_all();
      for (const Plot& m : scan) {
        filter.process(m);
        sum += compensated(filter.tracks[0], filter.bias).cov.trace();
        step.variance[2] = 1e-3;
        filter.bias.loosen(step);
        for (auto& track : filter.tracks) loosen(track, filter.bias, step);
      }
    }
  });
  EXPECT_EQ(allocated, 0u);
  EXPECT_GT(sum, 0);
}

/// Biases and states drawn from their priors, noise from R and Q: NEES summed over runs is chi-square.
TEST(TwoStage, IsHonestOverRuns) {
  constexpr int runs = 200;
  double nees_bias = 0;
  double nees_target = 0;
  RandomMatrices random(17);
  const Mat<4, 4> root_Q = planar_noise(dt, q).llt().matrixL();
  for (int run = 0; run < runs; ++run) {
    Problem p = draw(100 + static_cast<std::uint64_t>(run), 3, 20);
    const Mat<biases, biases> root_bias = p.prior.cov.llt().matrixL();
    const Vec<biases> b = p.prior.mean + root_bias * random.matrix<biases, 1>();
    std::vector<Vec<4>> truth;
    for (const Gaussian<4>& start : p.starts) {
      const Mat<4, 4> root = start.cov.llt().matrixL();
      truth.push_back(start.mean + root * random.matrix<4, 1>());
    }
    Filter<biases, biases> filter(p);
    for (auto& scan : p.scans) {
      filter.predict_all();
      for (Plot& m : scan) {
        Vec<4>& x = truth[static_cast<std::size_t>(m.target)];
        x = planar_transition(dt) * x + root_Q * random.matrix<4, 1>();
        const Mat<2, 2> root_R = m.R.llt().matrixL();
        m.z = m.H * x + m.C * b.segment<terms>(Eigen::Index{terms} * m.sensor) + root_R * random.matrix<2, 1>();
        filter.process(m);
      }
    }
    const Vec<biases> e_b = filter.bias.mean() - b;
    nees_bias += e_b.dot(Mat<biases, biases>(filter.bias_covariance()).llt().solve(e_b));
    const Gaussian<4> x = compensated(filter.tracks[1], filter.bias);
    nees_target += (x.mean - truth[1]).dot(x.cov.llt().solve(x.mean - truth[1]));
  }
  // Bands that an honest filter leaves once in 10 000 such tests.
  EXPECT_GT(nees_bias, chi2_quantile(0.00005, runs * biases));
  EXPECT_LT(nees_bias, chi2_quantile(0.99995, runs * biases));
  EXPECT_GT(nees_target, chi2_quantile(0.00005, runs * 4));
  EXPECT_LT(nees_target, chi2_quantile(0.99995, runs * 4));
}

}  // namespace
}  // namespace downrange
