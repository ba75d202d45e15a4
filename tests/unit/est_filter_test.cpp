/// The shared update against a form derived separately, its verdicts, chi-square, bias terms, rewinding.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/est/filter/gaussian.hpp>
#include <downrange/est/method/rewind.hpp>
#include <downrange/est/model/bias_terms.hpp>
#include <downrange/est/model/motion.hpp>
#include <limits>
#include <numbers>
#include <random>

namespace downrange {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(KalmanUpdate, EqualsInformationForm) {
  // A wrong gain stays consistent in Joseph form; the information form knows nothing of gains.
  std::mt19937_64 rng(11);
  std::normal_distribution<double> normal;
  for (int run = 0; run < 100; ++run) {
    const auto random = [&](auto m) { return decltype(m)::NullaryExpr([&] { return normal(rng); }).eval(); };
    const Mat<6, 6> A = random(Mat<6, 6>());
    const Mat<3, 3> B = random(Mat<3, 3>());
    const Gaussian<6> prior{random(Vec<6>()), A * A.transpose() + Mat<6, 6>::Identity()};
    const Mat<3, 6> H = random(Mat<3, 6>());
    const Mat<3, 3> R = B * B.transpose() + Mat<3, 3>::Identity();
    const Vec<3> z = random(Vec<3>());
    const auto u = kalman_update<6, 3>(prior, z - H * prior.mean, H, R, infinity);
    const Mat<6, 6> Y = prior.cov.inverse() + H.transpose() * R.inverse() * H;
    const Vec<6> y = prior.cov.inverse() * prior.mean + H.transpose() * R.inverse() * z;
    EXPECT_LT((u.posterior.cov - Y.inverse()).norm(), 1e-9 * Y.inverse().norm());
    EXPECT_LT((u.posterior.mean - Y.inverse() * y).norm(), 1e-9 * (1 + y.norm()));
    EXPECT_NEAR(u.nis, u.innovation.dot(u.S.inverse() * u.innovation), 1e-9 * (1 + u.nis));
  }
}

TEST(KalmanUpdate, GatesAndLeavesThePriorUntouched) {
  const Gaussian<1> prior{Vec<1>(2.0), Mat<1, 1>(4.0)};
  const Mat<1, 1> one = Mat<1, 1>::Identity();
  const auto gated = kalman_update<1, 1>(prior, Vec<1>(10.0), one, one, 15.0);
  EXPECT_EQ(gated.verdict, Verdict::Gated);
  EXPECT_EQ(gated.posterior.mean, prior.mean);
  EXPECT_EQ(gated.posterior.cov, prior.cov);
  EXPECT_DOUBLE_EQ(gated.nis, 100.0 / 5);
  const auto nan = kalman_update<1, 1>(prior, Vec<1>(std::nan("")), one, one, infinity);
  EXPECT_EQ(nan.verdict, Verdict::Gated);
  const auto indefinite = kalman_update<1, 1>({Vec<1>(0), Mat<1, 1>(-2.0)}, Vec<1>(0), one, one, infinity);
  EXPECT_EQ(indefinite.verdict, Verdict::Singular);
}

TEST(KalmanUpdate, StaysPositiveDefiniteOverAMillionUpdates) {
  Gaussian<6> x{Vec<6>::Zero(), Mat<6, 6>::Identity() * 1e7};
  const Mat<3, 6> H = (Mat<3, 6>() << Mat<3, 3>::Identity(), Mat<3, 3>::Zero()).finished();
  const Mat<3, 3> R = Vec<3>(16, 3e4, 3e4).asDiagonal();
  for (int i = 0; i < 1'000'000; ++i)
    x = kalman_update<6, 3>(cv::predict(x, 0.05, 1000), Vec<3>::Zero(), H, R, infinity).posterior;
  EXPECT_EQ(x.cov, x.cov.transpose().eval());
  EXPECT_GT((Eigen::SelfAdjointEigenSolver<Mat<6, 6>>(x.cov).eigenvalues().minCoeff()), 0);
}

TEST(ChiSquare, PublishedQuantiles) {
  // NIST/SEMATECH e-Handbook of Statistical Methods, section 1.3.6.7.4.
  EXPECT_NEAR(chi2_quantile(0.95, 3), 7.815, 5e-4);
  EXPECT_NEAR(chi2_quantile(0.999, 3), 16.266, 5e-4);
  EXPECT_NEAR(chi2_quantile(0.95, 6), 12.592, 5e-4);
}

TEST(BiasTerms, CompensationUndoesTheBiasToSecondOrder) {
  const Polar truth{2e5, 1.0, 0.4};
  const double west = 0.5 * std::numbers::pi / 180;
  // Polar terms: measured = true + b + eps true (azimuth about south).
  const std::array<BiasTerm, 6> polar{BiasTerm::OffsetRange, BiasTerm::OffsetAzimuth, BiasTerm::OffsetElevation,
                                      BiasTerm::ScaleRange,  BiasTerm::ScaleAzimuth,  BiasTerm::ScaleElevation};
  const std::array<double, 6> value{30, west, -west, 1e-4, 2e-4, -2e-4};
  const Polar measured{truth.range_m * (1 + 1e-4) + 30,
                       truth.azimuth_rad + west + 2e-4 * wrap_pi(truth.azimuth_rad - std::numbers::pi),
                       truth.elevation_rad * (1 - 2e-4) - west};
  const Polar back = compensate(measured, polar, value);
  EXPECT_NEAR(back.range_m, truth.range_m, 1e-4 * 60);  // second order: scale times its own effect
  EXPECT_NEAR(back.azimuth_rad, truth.azimuth_rad, 2e-4 * 0.02);
  EXPECT_NEAR(back.elevation_rad, truth.elevation_rad, 2e-4 * 0.02);

  // SEZ offset of 100 m south moves the measured point south: taking it out moves it north again.
  const std::array<BiasTerm, 1> south{BiasTerm::OffsetSouth};
  const std::array<double, 1> hundred{100};
  const Eigen::Vector3d moved = enu_from_polar(compensate(truth, south, hundred)).m - enu_from_polar(truth).m;
  EXPECT_LT((moved - Eigen::Vector3d(0, 100, 0)).norm(), 1e-6);
}

/// A core whose state is the order it saw: nothing hides a wrong rewind.
struct Journal {
  struct State {
    std::vector<std::uint64_t> seen;
  };
  Outcome apply(State& state, const Measurement& m) const {
    state.seen.push_back(m.sequence);
    return {.verdict = Verdict::Accepted, .nis = static_cast<double>(m.sequence), .dof = 1};
  }
};

TEST(Rewinder, AnyArrivalOrderInsideTheHistoryIsProcessedInOrder) {
  std::mt19937_64 rng(5);
  constexpr int n = 1000;
  std::vector<Measurement> arrivals(n);
  std::vector<Time> now(n);
  std::vector<std::uint64_t> expected(n);
  for (int i = 0; i < n; ++i) {
    arrivals[i].epoch = Time{} + milliseconds(50 * i);
    arrivals[i].sequence = expected[i] = static_cast<std::uint64_t>(i);
  }
  // Delays of up to 2 s in a history of 5 s.
  std::vector<std::pair<Time, int>> order(n);
  for (int i = 0; i < n; ++i) order[i] = {arrivals[i].epoch + milliseconds(static_cast<std::int64_t>(rng() % 2000)), i};
  std::sort(order.begin(), order.end());
  Rewinder<Journal> rewinder(Journal{}, {}, milliseconds(5000));
  for (const auto& [received, i] : order) {
    const Outcome o = rewinder.process(arrivals[static_cast<std::size_t>(i)], received);
    EXPECT_EQ(o.nis, i);  // the outcome is that of the late measurement, not of the last one re-run
  }
  EXPECT_EQ(rewinder.state().seen, expected);
}

}  // namespace
}  // namespace downrange
