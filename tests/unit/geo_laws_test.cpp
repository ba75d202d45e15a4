/// Laws of geometry: round trips, orthonormal rotations, Jacobians against differences, edges of the angles.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <downrange/geo/name.hpp>
#include <downrange/geo/polar.hpp>
#include <downrange/geo/site.hpp>
#include <downrange/geo/time.hpp>
#include <limits>
#include <numbers>
#include <random>

namespace downrange {
namespace {

constexpr double pi = std::numbers::pi;

TEST(Time, GridAndGps) {
  EXPECT_EQ(ceil_to_grid(Time{50}, Duration{25}).ns, 50);
  EXPECT_EQ(ceil_to_grid(Time{51}, Duration{25}).ns, 75);
  EXPECT_EQ(ceil_to_grid(Time{-51}, Duration{25}).ns, -50);
  EXPECT_EQ(ceil_to_grid(Time{-50}, Duration{25}).ns, -50);
  // GPS week 2086, 0 s is 2019-12-29T00:00:00 GPS, 23:59:42 UTC of the day before (IS-GPS-200; 18 leap seconds).
  EXPECT_EQ(utc_from_gps(2086, 0, 18).ns, 1'577'577'582'000'000'000);
  EXPECT_EQ(seconds(-1.5e-9).ns, -2);
  EXPECT_EQ(seconds(0.1).ns, 100'000'000);
}

TEST(Angles, Wrap) {
  EXPECT_EQ(wrap_pi(pi), pi);
  EXPECT_EQ(wrap_pi(-pi), pi);
  EXPECT_NEAR(wrap_pi(3 * pi / 2), -pi / 2, 1e-15);
  EXPECT_EQ(wrap_two_pi(2 * pi), 0);
  EXPECT_FALSE(std::signbit(wrap_two_pi(-0.0)));
  EXPECT_LT(wrap_two_pi(-1e-300), 2 * pi);
  EXPECT_TRUE(std::isnan(wrap_pi(std::numeric_limits<double>::quiet_NaN())));
}

TEST(Names, ParseRefusesWhatDoesNotFit) {
  EXPECT_EQ(Name::parse(std::string(31, 'a'))->view().size(), 31u);
  EXPECT_FALSE(Name::parse(std::string(32, 'a')));
  EXPECT_FALSE(Name::parse(std::string_view("a\0b", 3)));
  EXPECT_TRUE(Name().empty());
}

TEST(Polar, RoundTripEverywhere) {
  std::mt19937_64 rng(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 10000; ++i) {
    const Displacement<Enu> d{Eigen::Vector3d(unit(rng), unit(rng), unit(rng)) * 3e6};
    const Polar q = polar_from_enu(d);
    EXPECT_GE(q.azimuth_rad, 0);
    EXPECT_LT(q.azimuth_rad, 2 * pi);
    EXPECT_LT((enu_from_polar(q).m - d.m).norm(), 1e-15 * 3e6 * 4);
  }
  EXPECT_EQ(polar_from_enu({{0, 0, 5}}).azimuth_rad, 0);
  EXPECT_EQ(polar_from_enu({{0, 0, 5}}).elevation_rad, pi / 2);
  EXPECT_EQ(polar_from_enu({{-0.0, 5, 0}}).azimuth_rad, 0);
  EXPECT_NEAR(polar_from_enu({{-1e-12, 5, 0}}).azimuth_rad, 2 * pi, 1e-12);
}

TEST(Polar, JacobiansAgreeWithDifferencesAndInvert) {
  std::mt19937_64 rng(2);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 500; ++i) {
    const Displacement<Enu> d{Eigen::Vector3d(unit(rng), unit(rng), unit(rng)) * 1e5};
    const Polar q = polar_from_enu(d);
    if (std::cos(q.elevation_rad) < 0.05) continue;
    const Eigen::Matrix3d J = d_polar_d_enu(d);
    for (int axis = 0; axis < 3; ++axis) {
      const double h = 1.0;
      Displacement<Enu> plus = d;
      Displacement<Enu> minus = d;
      plus.m[axis] += h;
      minus.m[axis] -= h;
      const Polar a = polar_from_enu(plus);
      const Polar b = polar_from_enu(minus);
      const Eigen::Vector3d column(a.range_m - b.range_m, wrap_pi(a.azimuth_rad - b.azimuth_rad),
                                   a.elevation_rad - b.elevation_rad);
      // Central differences of step 1 m: third derivative ~ J / d^2, so 1e-3 relative covers distances above 100 m.
      for (int row = 0; row < 3; ++row)
        EXPECT_NEAR(column[row] / (2 * h), J(row, axis),
                    1e-6 * J.row(row).norm() +
                        1e-3 * h * h * J.row(row).norm() / std::pow(std::cos(q.elevation_rad) * d.m.norm() / 1e3, 2));
    }
    EXPECT_LT((J * d_enu_d_polar(q) - Eigen::Matrix3d::Identity()).norm(), 1e-8 * 1e5);
    const Eigen::Vector3d scale(1, 1e5, 1e5);
    EXPECT_LT(
        (scale.asDiagonal() * J * d_enu_d_polar(q) * scale.cwiseInverse().asDiagonal() - Eigen::Matrix3d::Identity())
            .norm(),
        1e-10);
  }
  EXPECT_TRUE(d_polar_d_enu({{0, 0, 1e5}}).allFinite());
}

TEST(Site, RotationsAreOrthonormalAndPointsReturn) {
  for (const double lat : {-pi / 2, -0.3, 0.0, 0.6, pi / 2}) {
    for (const double lon : {-pi, -1.0, 0.0, 2.2, pi}) {
      const Site site({lat, lon, 120});
      const Eigen::Matrix3d R = site.R_enu_ecef().R;
      EXPECT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-15 * 4);
      EXPECT_NEAR(R.determinant(), 1, 1e-15 * 4);
      const Displacement<Enu> d{{1e6, -2e6, 5e5}};
      EXPECT_LT((site.enu_of(site.ecef_of(d)).m - d.m).norm(), 1e-8);
      const Geodetic back = geodetic_from_ecef(site.ecef());
      EXPECT_NEAR(back.latitude_rad, lat, 1e-14);
      EXPECT_NEAR(back.height_m, 120, 1e-8);
    }
  }
}

/// The unbiased conversion, drawn: mean of z is the truth, mean of R is the covariance of z.
TEST(Conversion, UnbiasedAndConsistentByDrawing) {
  std::mt19937_64 rng(3);
  std::normal_distribution<double> normal;
  const PolarSigma sigma{30, 0.05, 0.04};
  for (const double elevation : {0.0, 0.7, 1.4}) {
    const Polar truth{2000, 2.0, elevation};
    const Eigen::Vector3d p = enu_from_polar(truth).m;
    constexpr int n = 200000;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d mean_R = Eigen::Matrix3d::Zero();
    for (int i = 0; i < n; ++i) {
      const ConvertedMeasurement c = convert_unbiased(
          {truth.range_m + sigma.range_m * normal(rng), truth.azimuth_rad + sigma.azimuth_rad * normal(rng),
           truth.elevation_rad + sigma.elevation_rad * normal(rng)},
          sigma);
      mean += (c.z.m - p) / n;
      second += (c.z.m - p) * (c.z.m - p).transpose() / n;
      mean_R += c.R / n;
    }
    // Five standard errors of the mean, five relative standard errors sqrt(2/n) of a variance.
    EXPECT_LT(mean.norm(), 5 * std::sqrt(second.trace() / n));
    EXPECT_LT((second - mean_R).norm(), 5 * std::sqrt(2.0 / n) * second.norm());
  }
}

TEST(Conversion, PositiveDefiniteAtThreeThousandKilometresAndAtTheZenith) {
  const PolarSigma sigma{4, 1.4e-4, 1.4e-4};
  for (const double range : {1e3, 3e5, 3e6}) {
    for (const double elevation : {0.0, 0.5, pi / 2 - 1e-6, pi / 2}) {
      const Eigen::Matrix3d R = convert_unbiased({range, 1.0, elevation}, sigma).R;
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(R);
      EXPECT_GT(eigen.eigenvalues().minCoeff(), 0) << range << " m at " << elevation;
      // The range axis: sigma_range^2 must survive beside (range sigma_angle)^2 that is 1e4 times larger.
      const Eigen::Vector3d los = enu_from_polar({1, 1.0, elevation}).m;
      EXPECT_NEAR(los.dot(R * los), 16, 0.02 * 16 + 2 * std::pow(range * 1.4e-4 * 1.4e-4, 2));
    }
  }
}

}  // namespace
}  // namespace downrange
