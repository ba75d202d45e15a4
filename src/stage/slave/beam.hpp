#pragma once
/// Is the target in the beam?

#include <Eigen/Core>

namespace downrange {

/// Probability that a normal variable of two dimensions lies in the disc of that radius about the origin. `cov`
/// symmetric positive semidefinite. Error below 1e-4 (tested for axes of 1 : 1 to 1 : 1000, 1e-3 to 1e3 radii long,
/// and off by up to three radii). Allocates nothing.
[[nodiscard]] double probability_in_disc(const Eigen::Vector2d& mean, const Eigen::Matrix2d& cov, double radius);

}  // namespace downrange
