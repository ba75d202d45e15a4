#include "experiment/parallax.hpp"
#include <cmath>
#include <downrange/geo/polar.hpp>

namespace downrange {

double planar_parallax(double bearing_rad, double range_m, double d_m) {
  return std::atan2(d_m * std::sin(bearing_rad), range_m - d_m * std::cos(bearing_rad));
}

double compensate_planar_parallax(double measured_rad, double track_bearing_rad, double track_range_m, double d_m) {
  return wrap_pi(measured_rad - planar_parallax(track_bearing_rad, track_range_m, d_m));
}

Bearing transfer_bearing(const Bearing& measured, const Site& from, const Site& to, const Position<Ecef>& position,
                         const Eigen::Matrix3d& position_cov) {
  const Displacement<Enu> d_from = from.enu_of(position);
  const Displacement<Enu> d_to = to.enu_of(position);
  const Polar q_from = polar_from_enu(d_from);
  const Polar q_to = polar_from_enu(d_to);
  const Eigen::Matrix<double, 2, 3> J = d_polar_d_enu(d_to).bottomRows<2>() * to.R_enu_ecef().R -
                                        d_polar_d_enu(d_from).bottomRows<2>() * from.R_enu_ecef().R;
  return {.azimuth_rad = wrap_two_pi(measured.azimuth_rad + q_to.azimuth_rad - q_from.azimuth_rad),
          .elevation_rad = measured.elevation_rad + q_to.elevation_rad - q_from.elevation_rad,
          .cov = measured.cov + J * position_cov * J.transpose()};
}

}  // namespace downrange
