#pragma once
/// WGS-84 constants and the known accelerations of free flight in the Earth-fixed frame.

#include <Eigen/Core>
#include <downrange/geo/frames.hpp>

namespace downrange::wgs84 {

inline constexpr double semi_major_axis_m = 6378137.0;
inline constexpr double flattening = 1.0 / 298.257223563;
inline constexpr double gm_m3_s2 = 3.986004418e14;  ///< atmosphere included
inline constexpr double rotation_rate_rad_s = 7.292115e-5;
inline constexpr double j2 = 1.082629821313e-3;  ///< unnormalised, from C20 = -4.84166774985e-4

}  // namespace downrange::wgs84

namespace downrange {

/// Central + J2 gravitation, m/s^2, ECEF axes. `p` outside the Earth's core (|p| > 1e6 m).
[[nodiscard]] Eigen::Vector3d gravitation(const Position<Ecef>& p);

/// Acceleration of a free body relative to the rotating Earth: gravitation + centrifugal + Coriolis.
[[nodiscard]] Eigen::Vector3d free_fall_acceleration(const Position<Ecef>& p, const Velocity<Ecef>& v);

}  // namespace downrange
