#include "sim/hop.hpp"

#include <algorithm>
#include <cmath>

namespace downrange::sim {
namespace {

struct Way {
  double value = 0;
  double rate = 0;
  double acceleration = 0;
};

/// `far` times s(t / duration) and its derivatives in t.
Way smooth_way(double far, double t_s, double duration_s) {
  const double u = std::clamp(t_s / duration_s, 0.0, 1.0);
  const double s = u * u * u * (10 + u * (6 * u - 15));
  const double ds = 30 * u * u * (u - 1) * (u - 1);
  const double dds = 60 * u * (u - 1) * (2 * u - 1);
  return {far * s, far * ds / duration_s, far * dds / (duration_s * duration_s)};
}

}  // namespace

HopMotion hop_motion(const Hop& hop, const Site& pad, double azimuth_rad, double t_s) {
  const Way rise = smooth_way(hop.apogee_m, t_s, hop.up_s);
  const Way fall = smooth_way(hop.apogee_m, t_s - hop.up_s, hop.down_s);
  const Way along = smooth_way(hop.distance_m, t_s, hop.up_s + hop.down_s);
  const Eigen::Vector3d ahead(std::sin(azimuth_rad), std::cos(azimuth_rad), 0);
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  const auto enu = [&](double way, double height) -> Eigen::Vector3d { return way * ahead + height * up; };
  const Rotation<Ecef, Enu> R_ecef_enu = pad.R_enu_ecef().inverse();
  HopMotion motion;
  motion.state.position = pad.ecef_of({enu(along.value, rise.value - fall.value)});
  motion.state.velocity = R_ecef_enu * Velocity<Enu>{enu(along.rate, rise.rate - fall.rate)};
  motion.acceleration = R_ecef_enu.R * enu(along.acceleration, rise.acceleration - fall.acceleration);
  return motion;
}

}  // namespace downrange::sim
