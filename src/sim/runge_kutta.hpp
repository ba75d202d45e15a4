#pragma once
/// One step along a trajectory.

#include <Eigen/Core>

#include "score/truth.hpp"

namespace downrange::sim {

/// Runge-Kutta of order 4 from `t_s` to `t_s + h`; h may be negative. `acceleration(t_s, state)` is relative to the
/// rotating Earth, m/s^2, ECEF axes.
template <class Acceleration>
score::TrueState runge_kutta_step(const Acceleration& acceleration, double t_s, double h, const score::TrueState& x) {
  const auto advanced = [&x](const Eigen::Vector3d& dp, const Eigen::Vector3d& dv, double dt) {
    return score::TrueState{{x.position.m + dt * dp}, {x.velocity.m_s + dt * dv}};
  };
  const Eigen::Vector3d& v1 = x.velocity.m_s;
  const Eigen::Vector3d a1 = acceleration(t_s, x);
  const score::TrueState x2 = advanced(v1, a1, h / 2);
  const Eigen::Vector3d a2 = acceleration(t_s + h / 2, x2);
  const score::TrueState x3 = advanced(x2.velocity.m_s, a2, h / 2);
  const Eigen::Vector3d a3 = acceleration(t_s + h / 2, x3);
  const score::TrueState x4 = advanced(x3.velocity.m_s, a3, h);
  const Eigen::Vector3d a4 = acceleration(t_s + h, x4);
  return advanced((v1 + 2 * x2.velocity.m_s + 2 * x3.velocity.m_s + x4.velocity.m_s) / 6,
                  (a1 + 2 * a2 + 2 * a3 + a4) / 6, h);
}

}  // namespace downrange::sim
