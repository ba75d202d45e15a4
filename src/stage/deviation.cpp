#include "deviation.hpp"

#include <cmath>
#include <downrange/geo/site.hpp>

namespace downrange {

std::optional<Deviation> deviation_from(const NominalTrajectory& nominal, double t_s, const Eigen::Vector3d& position_m,
                                        const Eigen::Matrix3d& cov) {
  const auto planned = nominal.at(t_s);
  if (!planned) return std::nullopt;
  constexpr double no_course_m_s = 10;
  const Rotation<Enu, Ecef> to_enu = enu_from_ecef_at(geodetic_from_ecef(planned->position));
  Eigen::Vector3d course = (to_enu * planned->velocity).m_s;
  if (std::hypot(course.x(), course.y()) < no_course_m_s)
    course = (to_enu * (nominal.samples().back().state.position - planned->position)).m;
  const double horizontal = std::hypot(course.x(), course.y());
  const double east = horizontal > 0 ? course.x() / horizontal : 0;
  const double north = horizontal > 0 ? course.y() / horizontal : 1;
  Eigen::Matrix3d R;  // along, across, vertical from east, north, up
  R << east, north, 0, north, -east, 0, 0, 0, 1;
  const Eigen::Matrix3d R_ecef = R * to_enu.R;
  const Eigen::Vector3d off = R_ecef * (position_m - planned->position.m);
  const Eigen::Matrix3d P = R_ecef * cov * R_ecef.transpose();
  Deviation d;
  for (int i = 0; i < 3; ++i) {
    d.m[static_cast<std::size_t>(i)] = off[i];
    d.sigma_m[static_cast<std::size_t>(i)] = std::sqrt(P(i, i));
  }
  return d;
}

}  // namespace downrange
