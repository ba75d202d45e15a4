#include "stage/integrity/bound.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace downrange {
namespace {

double largest_sigma(const Eigen::Matrix3d& cov) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(cov, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(eigen.eigenvalues()[2], 0.0));
}

}  // namespace

double bound_m(std::span<const Alternative> alternatives) {
  double most = 0;
  for (const Alternative& a : alternatives)
    most = std::max(most, a.from_selected_m.norm() + bound_sigmas * largest_sigma(a.cov));
  return most;
}

double bound_rad(std::span<const Alternative> alternatives, const Eigen::Vector3d& commanded,
                 const Eigen::Vector3d& selected) {
  double most = 0;
  for (const Alternative& a : alternatives) {
    const Eigen::Vector3d look = selected + a.from_selected_m;
    const double range = look.norm();
    if (!(range > 1)) return std::numbers::pi;  // at the antenna itself
    const Eigen::Vector3d u = look / range;
    const double angle = std::atan2(commanded.cross(u).norm(), commanded.dot(u));
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - u * u.transpose();
    most = std::max(most, angle + std::atan(bound_sigmas * largest_sigma(across * a.cov * across) / range));
  }
  return std::min(most, std::numbers::pi);
}

}  // namespace downrange
