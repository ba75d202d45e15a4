#pragma once
/// Between two states of a trajectory.

#include <downrange/geo/frames.hpp>

namespace downrange {

/// Where something is and how it moves, Earth-fixed.
struct PositionVelocity {
  Position<Ecef> position;
  Velocity<Ecef> velocity;
  bool operator==(const PositionVelocity&) const = default;
};

/// Cubic Hermite interpolation: position and velocity of `a` at u = 0 and of `b`, `h_s` later, at u = 1 are met. Error
/// of position below |d4p/dt4| h^4 / 384.
[[nodiscard]] inline PositionVelocity hermite(const PositionVelocity& a, const PositionVelocity& b, double h_s,
                                              double u) {
  const Eigen::Vector3d& p0 = a.position.m;
  const Eigen::Vector3d dp = b.position.m - p0;
  const Eigen::Vector3d m0 = h_s * a.velocity.m_s;
  const Eigen::Vector3d m1 = h_s * b.velocity.m_s;
  // p(u) = p0 + m0 u + c2 u^2 + c3 u^3 with p(1), p'(1) met
  const Eigen::Vector3d c2 = 3 * dp - 2 * m0 - m1;
  const Eigen::Vector3d c3 = m0 + m1 - 2 * dp;
  return {{p0 + u * (m0 + u * (c2 + u * c3))}, {(m0 + u * (2 * c2 + u * 3 * c3)) / h_s}};
}

}  // namespace downrange
