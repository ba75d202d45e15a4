/// Parallax: reference vectors, exactness in the plane and in space, the covariance against differences and draws.
#include <gtest/gtest.h>

#include <cmath>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/geo/polar.hpp>
#include <numbers>
#include <random>
#include "experiment/parallax.hpp"

#include "../support/vectors.hpp"

namespace downrange {
namespace {

constexpr double pi = std::numbers::pi;

TEST(Parallax, Vectors) {
  DOWNRANGE_VECTOR_CASES(cases, "parallax.json");
  for (const auto& c : cases) {
    const double bias = planar_parallax(c["theta"], c["r"], c["d"]);
    EXPECT_NEAR(bias, c["bias"].get<double>(), 1e-15);
    EXPECT_NEAR(compensate_planar_parallax(c["theta_sensor"], c["theta"], c["r"], c["d"]), c["theta"].get<double>(),
                1e-15);
  }
}

TEST(Parallax, PlanarIsExactForEveryGeometry) {
  std::mt19937_64 rng(6);
  std::uniform_real_distribution<double> angle(-pi, pi);
  std::uniform_real_distribution<double> log_range(1, 5);
  for (int i = 0; i < 10000; ++i) {
    const double theta = angle(rng);
    const double r = std::pow(10, log_range(rng));
    const double d = std::pow(10, log_range(rng)) * (i % 2 == 0 ? 1 : -1);  // also further away than the target
    const double at_sensor = std::atan2(r * std::sin(theta), r * std::cos(theta) - d);
    const double back = compensate_planar_parallax(at_sensor, theta, r, d);
    // Rounding of the sensor's own bearing grows where it is near the target.
    const double nearness = (r + std::abs(d)) / std::hypot(r * std::cos(theta) - d, r * std::sin(theta));
    EXPECT_LT(std::abs(wrap_pi(back - theta)), 2e-15 * (1 + nearness)) << theta << ' ' << r << ' ' << d;
  }
  EXPECT_EQ(planar_parallax(0, 1000, 100), 0);
  EXPECT_NEAR(planar_parallax(pi, 1000, 100), 0, 1e-16);
  // Largest where cos th = d / r, not at 90 deg.
  EXPECT_GT(planar_parallax(std::acos(0.1), 1000, 100), planar_parallax(pi / 2, 1000, 100));
}

const Site goheung{{34.4450 * pi / 180, 127.5200 * pi / 180, 120}};
const Site jeju{{33.2900 * pi / 180, 126.4600 * pi / 180, 350}};

Position<Ecef> somewhere(double azimuth, double elevation, double range) {
  return goheung.ecef_of(enu_from_polar({range, azimuth, elevation}));
}

TEST(Parallax, TransferIsExactThroughTheTruePosition) {
  for (const double azimuth : {0.001, 1.0, 3.0, 6.28}) {
    for (const double elevation : {0.05, 0.7, 1.5}) {
      const Position<Ecef> p = somewhere(azimuth, elevation, 150e3);
      const Polar at_jeju = polar_from_enu(jeju.enu_of(p));
      const Bearing b = transfer_bearing({azimuth, elevation}, goheung, jeju, p, Eigen::Matrix3d::Zero());
      EXPECT_NEAR(wrap_pi(b.azimuth_rad - at_jeju.azimuth_rad), 0, 1e-12);
      EXPECT_NEAR(b.elevation_rad, at_jeju.elevation_rad, 1e-12);
      EXPECT_GE(b.azimuth_rad, 0);
      EXPECT_LT(b.azimuth_rad, 2 * pi);
    }
  }
}

TEST(Parallax, CovarianceIsThatOfDifferencesAndOfDraws) {
  const Position<Ecef> p = somewhere(2.5, 0.6, 60e3);
  const Bearing measured{2.5, 0.6, (Eigen::Matrix2d() << 4e-8, 1e-8, 1e-8, 9e-8).finished()};
  Eigen::Matrix3d root;
  root << 80, 0, 0, 30, 50, 0, -20, 10, 40;
  const Eigen::Matrix3d P = root * root.transpose();
  const Bearing b = transfer_bearing(measured, goheung, jeju, p, P);

  // By central differences.
  Eigen::Matrix<double, 2, 3> J;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d step = Eigen::Vector3d::Unit(i);
    const Bearing up = transfer_bearing(measured, goheung, jeju, {p.m + step}, P);
    const Bearing down = transfer_bearing(measured, goheung, jeju, {p.m - step}, P);
    J.col(i) << wrap_pi(up.azimuth_rad - down.azimuth_rad) / 2, (up.elevation_rad - down.elevation_rad) / 2;
  }
  EXPECT_LT(test::relative_error(b.cov, measured.cov + J * P * J.transpose()), 1e-6);

  // By draws: mean NEES of 4000 within the band of 1e-4 false alarms.
  std::mt19937_64 rng(12);
  std::normal_distribution<double> normal;
  const Eigen::Matrix2d noise_root = measured.cov.llt().matrixL();
  const Polar truth = polar_from_enu(jeju.enu_of(p));
  constexpr int draws = 4000;
  double nees = 0;
  for (int i = 0; i < draws; ++i) {
    const Eigen::Vector2d noise = noise_root * Eigen::Vector2d(normal(rng), normal(rng));
    const Eigen::Vector3d off = root * Eigen::Vector3d(normal(rng), normal(rng), normal(rng));
    const Bearing drawn =
        transfer_bearing({2.5 + noise[0], 0.6 + noise[1], measured.cov}, goheung, jeju, {p.m + off}, P);
    const Vec<2> e(wrap_pi(drawn.azimuth_rad - truth.azimuth_rad), drawn.elevation_rad - truth.elevation_rad);
    nees += normalised_square<2>(e, drawn.cov) / 2 / draws;
  }
  EXPECT_TRUE(average_chi2_band(2, draws, 1e-4).contains(nees)) << nees;
}

}  // namespace
}  // namespace downrange
