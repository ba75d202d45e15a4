#pragma once
/// Where a vehicle comes down if its engines stop now, in vacuum, how well that is known, and how it moves
/// (est/THEORY.md section 15).

#include <downrange/est/model/matrix.hpp>
#include <downrange/geo/ground_polygon.hpp>
#include <optional>

namespace downrange {

/// The ground that it comes down to, and for how long a fall is looked at.
struct FallSettings {
  double height_m = 0;      ///< above the ellipsoid
  double horizon_s = 3600;  ///< what does not come down by then does not
};

struct Impact {
  Geodetic point;
  double time_s = 0;                              ///< until then
  Eigen::Matrix2d cov = Eigen::Matrix2d::Zero();  ///< m^2, east and north at `point`
  Mat<2, 6> by_state = Mat<2, 6>::Zero();         ///< d(east, north)/d(position, velocity)
  bool curved = false;  ///< the covariance is by sigma points, for the fall is no straight function of the state

  [[nodiscard]] GroundPoint ground() const { return {point.latitude_rad, point.longitude_rad}; }
};

/// Of a state (position, velocity, ECEF): the free fall of its mean (geo/free_fall.hpp), and the covariance by the
/// linearised flow, the instant of the landing included. Where the fall of the states two sigmas off along the
/// direction that moves the point most bends by more than a tenth of their distance, the second moment about the point
/// of the fall of twelve sigma points (cubature: sqrt(6) sigma along each axis) stands in its place. Nothing where the
/// mean, or one of those states, does not come down; nor where the covariance is not positive definite. 20 us with
/// flights of ten minutes, 60 us by sigma points; allocates nothing.
[[nodiscard]] std::optional<Impact> impact_of(const Gaussian<6>& state, const FallSettings& settings);

/// How the impact point moves over the ground.
struct GroundVelocity {
  Eigen::Vector2d m_s = Eigen::Vector2d::Zero();  ///< east, north
  Eigen::Matrix2d cov = Eigen::Matrix2d::Identity();
};

/// In free fall it stands still: what moves it is the specific force, the acceleration without free fall.
/// `motion`: position, velocity, acceleration relative to the Earth, ECEF.
[[nodiscard]] GroundVelocity velocity_of(const Impact& impact, const Gaussian<9>& motion);

/// Probability that a point drawn from a Gaussian about `mean` (cov: east and north, m^2) lies outside: the exact
/// integral over the polygon in the plane of ground_offset, by Owen's T function (1956, doi 10.1214/aoms/1177728074);
/// a covariance is taken to be at least 1 mm^2 per axis.
[[nodiscard]] double probability_outside(const GroundPolygon& polygon, const GroundPoint& mean,
                                         const Eigen::Matrix2d& cov);

}  // namespace downrange
