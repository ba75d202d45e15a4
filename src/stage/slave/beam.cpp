#include "stage/slave/beam.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace downrange {
namespace {

/// Gauss-Legendre, eight points on [-1, 1] (Abramowitz, Stegun, table 25.4): the positive half.
constexpr std::array node{0.183434642495650, 0.525532409916329, 0.796666477413627, 0.960289856497536};
constexpr std::array weight{0.362683783378362, 0.313706645877887, 0.222381034453374, 0.101228536290376};
constexpr int panels = 8;

double normal_below(double x) { return std::erfc(-x / std::numbers::sqrt2) / 2; }

}  // namespace

double probability_in_disc(const Eigen::Vector2d& mean, const Eigen::Matrix2d& cov, double radius) {
  // Along the axes of the ellipse: the longer one in closed form, the shorter one, which is left, by quadrature.
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes;
  axes.computeDirect(cov);
  const Eigen::Vector2d m = axes.eigenvectors().transpose() * mean;
  const double least = 1e-6 * radius;
  const double s = std::max(std::sqrt(std::max(axes.eigenvalues()[0], 0.0)), least);
  const double l = std::max(std::sqrt(std::max(axes.eigenvalues()[1], 0.0)), least);
  constexpr double widest = 7;  // sigmas: less than 1e-11 is outside
  const double from = std::max(m[0] - widest * s, -radius);
  const double to = std::min(m[0] + widest * s, radius);
  if (!(from < to)) return 0;
  // x = radius sin(angle): smooth up to the edge of the disc.
  const double from_angle = std::asin(from / radius);
  const double half_panel = (std::asin(to / radius) - from_angle) / (2 * panels);
  const auto density = [&](double angle) {
    const double x = radius * std::sin(angle);
    const double half_chord = radius * std::cos(angle);
    const double u = (x - m[0]) / s;
    return std::exp(-u * u / 2) / (s * std::sqrt(2 * std::numbers::pi)) *
           (normal_below((half_chord - m[1]) / l) - normal_below((-half_chord - m[1]) / l)) * half_chord;
  };
  double sum = 0;
  for (int panel = 0; panel < panels; ++panel) {
    const double middle = from_angle + (2 * panel + 1) * half_panel;
    for (std::size_t i = 0; i < node.size(); ++i) {
      const double dx = half_panel * node[i];
      sum += weight[i] * half_panel * (density(middle - dx) + density(middle + dx));
    }
  }
  return std::clamp(sum, 0.0, 1.0);
}

}  // namespace downrange
