#include "stage/slave/look.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace downrange {
namespace {

/// d/dt of the Jacobian times the velocity: what a target that is not accelerated gives the angles.
Eigen::Vector3d curvature(const Displacement<Enu>& line, const Eigen::Vector3d& v_enu) {
  constexpr double h_s = 1e-3;
  const Eigen::Matrix3d later = d_polar_d_enu({line.m + h_s * v_enu});
  const Eigen::Matrix3d earlier = d_polar_d_enu({line.m - h_s * v_enu});
  return (later - earlier) * v_enu / (2 * h_s);
}

Eigen::Vector3d direction(double azimuth_rad, double elevation_rad) {
  return enu_from_polar({1, azimuth_rad, elevation_rad}).m;
}

}  // namespace

std::optional<Look> look_at(const Site& site, const RefractionTable* air, const TrackEstimate& estimate) {
  const Eigen::Matrix3d& R_enu_ecef = site.R_enu_ecef().R;
  // Parallax is geometry: the look angle from this site to the predicted position.
  const Displacement<Enu> line = site.enu_of({estimate.mean.head<3>()});
  if (!(line.m.norm() > 1.0)) return std::nullopt;
  const Polar q = polar_from_enu(line);
  const Eigen::Matrix3d J = d_polar_d_enu(line);
  const Eigen::Vector3d v_enu = R_enu_ecef * estimate.mean.segment<3>(3);
  const Eigen::Vector3d rates = J * v_enu;
  Eigen::Vector3d accelerations = curvature(line, v_enu);
  if (estimate.size == 9) accelerations += J * (R_enu_ecef * estimate.mean.tail<3>());
  const Eigen::Matrix3d J_ecef = J * R_enu_ecef;
  const Eigen::Matrix3d cov = J_ecef * estimate.cov.topLeftCorner<3, 3>() * J_ecef.transpose();

  Look look;
  look.line = line;
  look.range_m = q.range_m;
  look.range_rate_m_s = rates[0];
  look.azimuth = {q.azimuth_rad, rates[1], accelerations[1]};
  look.elevation = {q.elevation_rad, rates[2], accelerations[2]};
  look.acceleration_valid = estimate.size == 9;
  look.sigma_azimuth_rad = std::min(std::sqrt(cov(1, 1)), std::numbers::pi);
  look.sigma_elevation_rad = std::min(std::sqrt(cov(2, 2)), std::numbers::pi);
  Eigen::Matrix<double, 2, 3> T;  // rows: clockwise along the horizon, and up
  T << std::cos(q.azimuth_rad), -std::sin(q.azimuth_rad), 0, -std::sin(q.elevation_rad) * std::sin(q.azimuth_rad),
      -std::sin(q.elevation_rad) * std::cos(q.azimuth_rad), std::cos(q.elevation_rad);
  const Eigen::Matrix<double, 2, 3> T_ecef = T * R_enu_ecef / q.range_m;
  look.sky = T_ecef * estimate.cov.topLeftCorner<3, 3>() * T_ecef.transpose();
  if (air != nullptr) {
    const auto bent = air->at_true(q.range_m, q.elevation_rad);
    look.refraction_rad = bent.refraction.elevation_rad;
    look.elevation.angle_rad += look.refraction_rad;
    const double stretch = 1 + bent.d_elevation.elevation_rad;
    look.elevation.rate_rad_s = stretch * look.elevation.rate_rad_s + bent.d_range.elevation_rad * rates[0];
    look.elevation.acceleration_rad_s2 =
        stretch * look.elevation.acceleration_rad_s2 + bent.d_range.elevation_rad * accelerations[0];
  }
  return look;
}

double separation_rad(double azimuth_a_rad, double elevation_a_rad, double azimuth_b_rad, double elevation_b_rad) {
  const Eigen::Vector3d a = direction(azimuth_a_rad, elevation_a_rad);
  const Eigen::Vector3d b = direction(azimuth_b_rad, elevation_b_rad);
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace downrange
