/// Probability that a normal variable lies in a disc, against closed forms and against brute force.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "stage/slave/beam.hpp"

namespace downrange {
namespace {

constexpr double pi = std::numbers::pi;

Eigen::Matrix2d ellipse(double along, double across, double turned_rad) {
  const Eigen::Matrix2d R = Eigen::Rotation2Dd(turned_rad).toRotationMatrix();
  return R * Eigen::Vector2d(along * along, across * across).asDiagonal() * R.transpose();
}

TEST(Beam, RoundAndCentred) {
  for (const double sigma : {1e-6, 0.01, 0.1, 0.3, 1.0, 2.0, 10.0, 1000.0}) {
    const double exact = -std::expm1(-1 / (2 * sigma * sigma));
    EXPECT_NEAR(probability_in_disc({0, 0}, ellipse(sigma, sigma, 0.3), 1), exact, 1e-6) << sigma;
  }
}

TEST(Beam, FlatIsTheNormalIntegralAlongTheChord) {
  // Nearly no width across: the chord at that offset.
  for (const double across : {0.0, 0.5, 0.9}) {
    for (const double sigma : {0.1, 1.0, 5.0}) {
      const double half = std::sqrt(1 - across * across);
      const double exact = std::erf(half / (sigma * std::numbers::sqrt2));
      EXPECT_NEAR(probability_in_disc({0, across}, ellipse(sigma, 1e-5, 0), 1), exact, 1e-4) << across << ' ' << sigma;
    }
  }
  EXPECT_NEAR(probability_in_disc({0, 1.1}, ellipse(3, 1e-5, 0), 1), 0, 1e-6);
}

/// Midpoints of a fine polar grid.
double brute_force(const Eigen::Vector2d& mean, const Eigen::Matrix2d& cov, double radius) {
  const Eigen::Matrix2d inverse = cov.inverse();
  const double scale = 1 / (2 * pi * std::sqrt(cov.determinant()));
  constexpr int rings = 800;
  constexpr int spokes = 800;
  double sum = 0;
  for (int i = 0; i < rings; ++i) {
    const double r = radius * (i + 0.5) / rings;
    for (int k = 0; k < spokes; ++k) {
      const double angle = 2 * pi * (k + 0.5) / spokes;
      const Eigen::Vector2d d = Eigen::Vector2d(r * std::cos(angle), r * std::sin(angle)) - mean;
      sum += std::exp(-d.dot(inverse * d) / 2) * r;
    }
  }
  return sum * scale * (radius / rings) * (2 * pi / spokes);
}

TEST(Beam, AnyEllipseAndOffset) {
  for (const double along : {0.2, 1.0, 4.0}) {
    for (const double ratio : {1.0, 0.3, 0.1}) {
      for (const double off : {0.0, 0.7, 1.0, 2.0, 3.0}) {
        for (const double turned : {0.0, 0.4, 1.2, 2.5}) {
          const Eigen::Matrix2d cov = ellipse(along, along * ratio, turned);
          const Eigen::Vector2d mean(off * std::cos(0.9), off * std::sin(0.9));
          EXPECT_NEAR(probability_in_disc(2 * mean, 4 * cov, 2), brute_force(mean, cov, 1), 1e-4)
              << along << ' ' << ratio << ' ' << off << ' ' << turned;
        }
      }
    }
  }
}

TEST(Beam, NeverMoreThanOneNorLessThanNothing) {
  for (const double s : {0.0, 1e-12, 1e-3, 1.0, 1e6}) {
    for (const double off : {0.0, 0.999999, 1.0, 1.000001, 1e6}) {
      const double p = probability_in_disc({off, 0}, ellipse(s, s, 0), 1);
      EXPECT_GE(p, 0);
      EXPECT_LE(p, 1);
    }
  }
  EXPECT_EQ(probability_in_disc({5, 0}, Eigen::Matrix2d::Zero(), 1), 0);
  EXPECT_NEAR(probability_in_disc({0.5, 0}, Eigen::Matrix2d::Zero(), 1), 1, 1e-9);
}

}  // namespace
}  // namespace downrange
