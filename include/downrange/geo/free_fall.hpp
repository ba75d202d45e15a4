#pragma once
/// A body that falls freely over the rotating Earth, without air: where and when it comes down.

#include <downrange/geo/hermite.hpp>
#include <optional>

namespace downrange {

/// d(free_fall_acceleration)/d(position), 1/s^2: gravity gradient with J2, and centrifugal.
[[nodiscard]] Eigen::Matrix3d free_fall_gradient(const Position<Ecef>& p);

struct Landing {
  PositionVelocity state;  ///< when it comes down
  double time_s = 0;       ///< until then
};

/// Free fall (earth.hpp: central gravitation and J2, centrifugal, Coriolis) from `start` until it comes down through
/// `height_m` above the ellipsoid; a body that starts below that height comes down to where it starts from. Nothing
/// when it does not within `horizon_s`, nor from a place 50 km below the ellipsoid. Runge-Kutta of order 5 (Dormand,
/// Prince, 1980, doi 10.1016/0771-050X(80)90013-3): in steps of 40 s as tested within 0.03 m of a high-order
/// integration in the inertial frame, flights of 45 minutes included; in steps of 80 s within 1 m. `height_m` -500 to
/// 1e5. Allocates nothing.
[[nodiscard]] std::optional<Landing> fall_to(const PositionVelocity& start, double height_m, double horizon_s,
                                             double longest_step_s = 40);

/// d(position, velocity after `time_s` of free fall)/d(position, velocity at `start`), by the variational equations: in
/// steps of 120 s, to 1e-5 of each derivative.
[[nodiscard]] Eigen::Matrix<double, 6, 6> free_fall_transition(const PositionVelocity& start, double time_s);

}  // namespace downrange
