#pragma once
/// How far a vehicle is from its nominal trajectory.

#include <Eigen/Core>
#include <array>
#include <downrange/geo/nominal_trajectory.hpp>
#include <optional>

namespace downrange {

/// Along the plan's course (its horizontal velocity; while that is below 10 m/s, the way to the plan's end), across to
/// the right of it, and up; at the planned position.
struct Deviation {
  std::array<double, 3> m{};
  std::array<double, 3> sigma_m{};  ///< of the vehicle's position
};

/// `t_s` after lift-off. None: there is no plan for that time.
[[nodiscard]] std::optional<Deviation> deviation_from(const NominalTrajectory& nominal, double t_s,
                                                      const Eigen::Vector3d& position_m, const Eigen::Matrix3d& cov);

}  // namespace downrange
