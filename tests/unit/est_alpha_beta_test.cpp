/// Alpha-beta: reference vectors, the Riccati steady state, slopes by differences, the tracker's laws and honesty.
#include <gtest/gtest.h>

#include <cmath>
#include <downrange/est/filter/alpha_beta.hpp>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/geo/polar.hpp>
#include <limits>
#include <numbers>
#include <random>

#include "../support/vectors.hpp"

namespace downrange {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double deg = std::numbers::pi / 180;

TEST(AlphaBeta, Vectors) {
  DOWNRANGE_VECTOR_CASES(cases, "alpha_beta.json");
  for (const auto& c : cases) {
    const double lambda = c["lam"];
    const AlphaBetaGains exact = exact_gains(lambda);
    if (c.contains("lam_nominal")) {
      const AlphaBetaGains linear = gains_by(GainRule::Linear, lambda, c["lam_nominal"]);
      EXPECT_NEAR(linear.alpha, c["approx_alpha"].get<double>(), 1e-14);
      EXPECT_NEAR(linear.beta, c["approx_beta"].get<double>(), 1e-14);
      EXPECT_NEAR(exact.alpha, c["exact_alpha"].get<double>(), 1e-14);
      EXPECT_NEAR(exact.beta, c["exact_beta"].get<double>(), 1e-14);
      continue;
    }
    const AlphaBetaGains slopes = gain_slopes(lambda);
    EXPECT_NEAR(exact.alpha, c["alpha"].get<double>(), 1e-14);
    EXPECT_NEAR(exact.beta, c["beta"].get<double>(), 1e-13);  // the printed form loses digits at 10
    EXPECT_NEAR(slopes.alpha, c["dalpha"].get<double>(), 1e-12 * c["dalpha"].get<double>() + 1e-12);
    EXPECT_NEAR(slopes.beta, c["dbeta"].get<double>(), 1e-12);
  }
}

/// Steady-state gains by running the covariance recursion, T = 1, sigma_w = 1, sigma_v = lambda.
struct Riccati {
  AlphaBetaGains gains;
  Mat<2, 2> updated;
};
Riccati riccati(double lambda) {
  Mat<2, 2> F;
  F << 1, 1, 0, 1;
  const Vec<2> g(0.5, 1);
  const Mat<2, 2> Q = lambda * lambda * g * g.transpose();
  Riccati result;
  Mat<2, 2> P = Mat<2, 2>::Identity();
  for (int k = 0; k < 20000; ++k) {
    P = F * P * F.transpose() + Q;
    const Vec<2> K = P.col(0) / (P(0, 0) + 1);
    Mat<2, 2> ImKH = Mat<2, 2>::Identity();
    ImKH.col(0) -= K;
    P = ImKH * P * ImKH.transpose() + K * K.transpose();
    result = {{K[0], K[1]}, P};
  }
  return result;
}

TEST(AlphaBeta, GainsAreTheRiccatiSteadyState) {
  for (double lambda = 0.002; lambda < 200; lambda *= 1.7) {
    const Riccati steady = riccati(lambda);
    const AlphaBetaGains gains = exact_gains(lambda);
    EXPECT_NEAR(gains.alpha, steady.gains.alpha, 1e-12) << lambda;
    EXPECT_NEAR(gains.beta, steady.gains.beta, 1e-12) << lambda;
    // 1 - alpha of a large index has few digits left in the covariance's last entry.
    EXPECT_LT(test::relative_error(steady_covariance(gains, 1, 1), steady.updated), 1e-9) << lambda;
  }
}

TEST(AlphaBeta, NoDigitsAreLostAtTheEnds) {
  // beta = 2 (2 - alpha) - 4 sqrt(1 - alpha) (Kalata), small index: alpha -> sqrt(2 lambda), beta -> lambda.
  EXPECT_NEAR(exact_gains(1e-12).beta, 1e-12, 2e-18);
  EXPECT_NEAR(exact_gains(1e-12).alpha, std::sqrt(2e-12), 2e-12);
  // Large index: 1 - alpha = r^2 -> (2 / lambda)^2.
  EXPECT_NEAR((1 - exact_gains(1e6).alpha) * 1e12, 4, 1e-3);
  EXPECT_EQ(exact_gains(infinity).alpha, 1);
  EXPECT_EQ(exact_gains(infinity).beta, 2);
  EXPECT_EQ(exact_gains(0).alpha, 0);
}

TEST(AlphaBeta, SlopesAreThoseOfTheGains) {
  for (double lambda = 0.01; lambda < 50; lambda *= 2) {
    const double h = 1e-5 * lambda;
    const AlphaBetaGains up = exact_gains(lambda + h);
    const AlphaBetaGains down = exact_gains(lambda - h);
    const AlphaBetaGains slope = gain_slopes(lambda);
    EXPECT_NEAR(slope.alpha, (up.alpha - down.alpha) / (2 * h), 1e-8 * slope.alpha + 1e-9);
    EXPECT_NEAR(slope.beta, (up.beta - down.beta) / (2 * h), 1e-8 * slope.beta + 1e-9);
  }
}

TEST(AlphaBeta, LinearGainErrorOverTheNominalInterval) {
  // est/THEORY.md section 10: sigma_y 100 to 200 m, nominal 150 m, 0.98 m/s^2, 5 s.
  const double nominal = tracking_index(0.98, 150, 5);
  double worst_alpha = 0;
  double worst_beta = 0;
  for (int sigma = 100; sigma <= 200; ++sigma) {
    const double lambda = tracking_index(0.98, sigma, 5);
    const AlphaBetaGains exact = exact_gains(lambda);
    const AlphaBetaGains linear = gains_by(GainRule::Linear, lambda, nominal);
    worst_alpha = std::max(worst_alpha, std::abs(linear.alpha - exact.alpha));
    worst_beta = std::max(worst_beta, std::abs(linear.beta - exact.beta));
  }
  EXPECT_LE(worst_alpha, 0.0127);
  EXPECT_LE(worst_beta, 0.0027);
}

TEST(AlphaBeta, ClampedGainsAreStableForEveryIndex) {
  const double nominal = tracking_index(0.98, 150, 5);
  for (const GainRule rule : {GainRule::Exact, GainRule::Linear, GainRule::Fixed}) {
    for (double lambda = 1e-9; lambda < 1e12; lambda *= 3) {
      const auto [alpha, beta] = gains_by(rule, lambda, nominal);
      ASSERT_GT(alpha, 0);
      ASSERT_LT(alpha, 1);
      // Poles of z^2 - (2 - alpha - beta) z + (1 - alpha).
      const double half = (2 - alpha - beta) / 2;
      const double discriminant = half * half - (1 - alpha);
      const double largest = discriminant < 0 ? std::sqrt(1 - alpha) : std::abs(half) + std::sqrt(discriminant);
      ASSERT_LT(largest, 1) << lambda;
      ASSERT_LT(half < 0 ? largest : 0, 0.9) << lambda;
    }
  }
}

TEST(AlphaBeta, LineOfSightAxesAreThoseOfThePolarCoordinates) {
  for (const Vec<3>& d : {Vec<3>(1000, 2000, 500), Vec<3>(-3, 1, 1), Vec<3>(0, 0, 5), Vec<3>(0, 0, 0)}) {
    const Mat<3, 3> axes = line_of_sight_axes<3>(d);
    EXPECT_LT((axes.transpose() * axes - Mat<3, 3>::Identity()).norm(), 1e-15);
    if (d.head<2>().norm() == 0) continue;
    const Polar q = polar_from_enu({d});
    const Eigen::Matrix3d J = d_enu_d_polar(q);
    EXPECT_LT((axes.col(0) - J.col(0).normalized()).norm(), 1e-14);
    EXPECT_LT((axes.col(1) - J.col(1).normalized()).norm(), 1e-14);
    EXPECT_LT((axes.col(2) - J.col(2).normalized()).norm(), 1e-14);
  }
  EXPECT_LT((line_of_sight_axes<2>(Vec<2>(3, 4)) - (Mat<2, 2>() << .6, -.8, .8, .6).finished()).norm(), 1e-15);
}

TEST(AlphaBetaTracker, IsTheKalmanFilterOnOneLineAndSettles) {
  // Along x, nothing rotates: the start gains are those of the Kalman filter, then the steady ones.
  const AlphaBetaSettings settings{.sigma_acceleration = 2, .initial_sigma_velocity = 100};
  AlphaBetaTracker<2> tracker(settings, Vec<2>(1e6, 0), Vec<2>(10, 10));
  std::mt19937_64 rng(1);
  std::normal_distribution<double> normal;
  Gaussian<2> kalman{Vec<2>(1e6, 0), Vec<2>(100, 1e4).asDiagonal()};
  Mat<2, 2> F;
  F << 1, 1, 0, 1;
  const Vec<2> g(0.5, 1);
  for (int k = 0; k < 60; ++k) {
    const double z = 1e6 + 30 * k + 10 * normal(rng);
    kalman = {F * kalman.mean, F * kalman.cov * F.transpose() + 4 * g * g.transpose()};
    kalman = kalman_update<2, 1>(kalman, Vec<1>(z) - kalman.mean.head<1>(), Mat<1, 2>(1, 0), Mat<1, 1>(100.0), infinity)
                 .posterior;
    (void)tracker.scan(Vec<2>(z, 0), Vec<2>(10, 10), 1);
    // Steady gains are taken when within 2 %: from then on a small part of sigma apart.
    EXPECT_LT(std::abs(tracker.position()[0] - kalman.mean[0]), 0.05 * 10) << k;
  }
  EXPECT_DOUBLE_EQ(tracker.gains(0).alpha, exact_gains(0.2).alpha);
  EXPECT_LT(test::relative_error(tracker.covariance(0), steady_covariance(exact_gains(0.2), 10, 1)), 1e-6);
}

/// A target in space with the tracker's own piecewise constant acceleration, seen by a radar; errors of one run.
struct Flown {
  double nis = 0;
  NormalisedPositionError npe;
  double worst_m = 0;
  int gated = 0;
};
Flown fly(std::uint64_t seed, GainRule rule, const Vec<3>& start, const Vec<3>& velocity, double sigma_a, int scans) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  const PolarSigma noise{25, 0.1 * deg, 0.1 * deg};
  const double T = 2;
  AlphaBetaSettings settings{.sigma_acceleration = sigma_a, .initial_sigma_velocity = 300, .rule = rule};
  settings.nominal_sigma = 100;
  settings.gate = chi2_quantile(0.9999, 3);
  Vec<3> p = start;
  Vec<3> v = velocity + Vec<3>::NullaryExpr([&] { return 300 * normal(rng); });
  const auto measure = [&](Vec<3>& sigma) {
    Polar q = polar_from_enu({p});
    q.range_m += noise.range_m * normal(rng);
    q.azimuth_rad += noise.azimuth_rad * normal(rng);
    q.elevation_rad += noise.elevation_rad * normal(rng);
    sigma = Vec<3>(noise.range_m, q.range_m * std::cos(q.elevation_rad) * noise.azimuth_rad,
                   q.range_m * noise.elevation_rad);
    return Vec<3>(enu_from_polar(q).m);
  };
  Vec<3> sigma;
  const Vec<3> first = measure(sigma);
  AlphaBetaTracker<3> tracker(settings, first, sigma);
  Flown flown;
  int counted = 0;
  for (int k = 0; k < scans; ++k) {
    const Vec<3> a = Vec<3>::NullaryExpr([&] { return sigma_a * normal(rng); });
    p += T * v + T * T / 2 * a;
    v += T * a;
    const Vec<3> z = measure(sigma);
    const auto s = tracker.scan(z, sigma, T);
    flown.gated += s.verdict == Verdict::Accepted ? 0 : 1;
    if (k < 20) continue;
    flown.npe.add((tracker.position() - p).norm(), (z - p).norm());
    flown.worst_m = std::max(flown.worst_m, (tracker.position() - p).norm());
    flown.nis += s.nis;
    ++counted;
  }
  flown.nis /= 3 * counted;
  return flown;
}

TEST(AlphaBetaTracker, IsHonestAndBetterThanItsMeasurementsInSpace) {
  // 20 runs of 180 counted innovations. The filter is not quite Kalman's (decoupled axes that turn): 3 % are allowed on
  // top of the band of 1e-4 false alarms.
  constexpr int runs = 20;
  double nis = 0;
  NormalisedPositionError npe;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    const Flown flown = fly(seed, GainRule::Exact, Vec<3>(250e3, 150e3, 60e3), Vec<3>(-200, -100, 20), 3, 200);
    nis += flown.nis / runs;
    npe.estimate_square += flown.npe.estimate_square;
    npe.measurement_square += flown.npe.measurement_square;
    EXPECT_LE(flown.gated, 3) << "seed " << seed;
  }
  const Band band = average_chi2_band(3, runs * 180, 1e-4);
  EXPECT_GT(nis, 0.97 * band.low) << nis;
  EXPECT_LT(nis, 1.03 * band.high) << nis;
  EXPECT_LT(npe.value(), 0.8);
  EXPECT_FALSE(npe.lost());
}

TEST(AlphaBetaTracker, DoesNotDivergeOverTheRadar) {
  // Overhead at 300 m: the cross-range sigma falls to half a metre and the axes turn round within one scan.
  for (const GainRule rule : {GainRule::Exact, GainRule::Linear}) {
    AlphaBetaSettings settings{.sigma_acceleration = 1, .initial_sigma_velocity = 200, .rule = rule};
    settings.nominal_sigma = 20;
    std::mt19937_64 rng(5);
    std::normal_distribution<double> normal;
    const Vec<2> velocity(100, 0);
    Vec<2> p(-20e3, 300);
    AlphaBetaTracker<2> tracker(settings, p, Vec<2>(10, 20));
    double worst = 0;
    for (int k = 0; k < 400; ++k) {
      p += velocity;
      const double r = p.norm();
      const double th = std::atan2(p[1], p[0]) + 1e-3 * normal(rng);
      const double rho = r + 10 * normal(rng);
      (void)tracker.scan(Vec<2>(rho * std::cos(th), rho * std::sin(th)), Vec<2>(10, rho * 1e-3), 1);
      if (k > 20) worst = std::max(worst, (tracker.position() - p).norm());
    }
    EXPECT_LT(worst, 80) << static_cast<int>(rule);  // 4 sigma of the measurement at the far end
  }
}

TEST(AlphaBetaTracker, AGatedScanChangesNothing) {
  AlphaBetaSettings settings;
  settings.gate = chi2_quantile(0.999, 2);
  AlphaBetaTracker<2> tracker(settings, Vec<2>(1e4, 0), Vec<2>(10, 10));
  for (int k = 0; k < 10; ++k) (void)tracker.scan(Vec<2>(1e4, 0), Vec<2>(10, 10), 1);
  const Vec<2> before = tracker.position();
  EXPECT_EQ(tracker.scan(Vec<2>(1.5e4, 0), Vec<2>(10, 10), 1).verdict, Verdict::Gated);
  EXPECT_EQ(tracker.scan(Vec<2>(std::nan(""), 0), Vec<2>(10, 10), 1).verdict, Verdict::Gated);
  EXPECT_EQ(tracker.position(), before);
  EXPECT_EQ(tracker.scan(Vec<2>(1e4, 0), Vec<2>(10, 10), 3).verdict, Verdict::Accepted);
}

}  // namespace
}  // namespace downrange
