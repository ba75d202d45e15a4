#include <downrange/geo/earth.hpp>

namespace downrange {

Eigen::Vector3d gravitation(const Position<Ecef>& p) {
  const double r2 = p.m.squaredNorm();
  const double r = std::sqrt(r2);
  const double a_over_r = wgs84::semi_major_axis_m / r;
  const double sin2 = p.m.z() * p.m.z() / r2;
  // g = -GM/r^3 [ (1 + k (1 - 5 s^2)) x, ..., (1 + k (3 - 5 s^2)) z ], k = 3/2 J2 (a/r)^2, s = sin(geocentric latitude)
  const double k = 1.5 * wgs84::j2 * a_over_r * a_over_r;
  const double horizontal = 1 + k * (1 - 5 * sin2);
  const double vertical = 1 + k * (3 - 5 * sin2);
  return -wgs84::gm_m3_s2 / (r2 * r) * Eigen::Vector3d(horizontal * p.m.x(), horizontal * p.m.y(), vertical * p.m.z());
}

Eigen::Vector3d free_fall_acceleration(const Position<Ecef>& p, const Velocity<Ecef>& v) {
  constexpr double omega = wgs84::rotation_rate_rad_s;
  const Eigen::Vector3d centrifugal(omega * omega * p.m.x(), omega * omega * p.m.y(), 0);
  const Eigen::Vector3d coriolis(2 * omega * v.m_s.y(), -2 * omega * v.m_s.x(), 0);
  return gravitation(p) + centrifugal + coriolis;
}

}  // namespace downrange
