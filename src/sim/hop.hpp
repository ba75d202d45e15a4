#pragma once
/// A test flight: up, a little aside, down again and landed.

#include <Eigen/Core>
#include <downrange/geo/site.hpp>

#include "score/truth.hpp"

namespace downrange::sim {

/// Height and way over ground follow the quintic s(u) = 10 u^3 - 15 u^4 + 6 u^5, which begins and ends at rest and
/// without acceleration: a controlled flight, up to `apogee_m` above the pad, then down to it.
struct Hop {
  double apogee_m = 30e3;
  double distance_m = 15e3;  ///< of the landing place from the pad, in the pad's horizontal plane
  double up_s = 150;
  double down_s = 150;
};

struct HopMotion {
  score::TrueState state;
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  ///< relative to the Earth, ECEF axes
};

/// `t_s` after lift-off, at rest before it and after the landing; towards `azimuth_rad`, clockwise from north.
[[nodiscard]] HopMotion hop_motion(const Hop& hop, const Site& pad, double azimuth_rad, double t_s);

}  // namespace downrange::sim
