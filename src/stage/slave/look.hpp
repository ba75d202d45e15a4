#pragma once
/// How a target is seen from an antenna's site.

#include <Eigen/Core>
#include <downrange/est/filter/estimates.hpp>
#include <downrange/geo/polar.hpp>
#include <downrange/geo/refraction.hpp>
#include <downrange/geo/site.hpp>
#include <optional>

namespace downrange {

/// Of one axis, or of one angle of a look.
struct AxisMotion {
  double angle_rad = 0;
  double rate_rad_s = 0;
  double acceleration_rad_s2 = 0;

  /// `dt_s` later or, negative, earlier.
  [[nodiscard]] double at(double dt_s) const {
    return angle_rad + dt_s * (rate_rad_s + dt_s / 2 * acceleration_rad_s2);
  }
};

struct Look {
  Displacement<Enu> line;  ///< from the site to the target, without refraction
  double range_m = 0;
  double range_rate_m_s = 0;
  AxisMotion azimuth;    ///< angle in [0, 2 pi)
  AxisMotion elevation;  ///< of the arriving ray: refraction included
  /// How much of the elevation is refraction.
  double refraction_rad = 0;
  bool acceleration_valid = false;  ///< else the accelerations are those of a target that is not accelerated
  double sigma_azimuth_rad = 0;     ///< of the axis
  double sigma_elevation_rad = 0;
  Eigen::Matrix2d sky = Eigen::Matrix2d::Zero();  ///< covariance on the sky, across (clockwise) and up, rad^2
};

/// `air`: null, no refraction. None: the target is at the site itself, there is no direction.
[[nodiscard]] std::optional<Look> look_at(const Site& site, const RefractionTable* air, const TrackEstimate& estimate);

/// On the sky, between two directions given as azimuth and elevation; exact for small angles as well. An elevation
/// beyond the zenith means the back.
[[nodiscard]] double separation_rad(double azimuth_a_rad, double elevation_a_rad, double azimuth_b_rad,
                                    double elevation_b_rad);

}  // namespace downrange
