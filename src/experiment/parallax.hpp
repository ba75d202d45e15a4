#pragma once
/// Parallax: what a bearing taken at one place is at another (spatial paper, section 3, and in three dimensions).

#include <Eigen/Core>
#include <downrange/geo/site.hpp>

namespace downrange {

/// Bearing from a sensor displaced by `d` along the reference axis minus the bearing from the reference sensor, whose
/// target is at `range` and `bearing` from that axis: atan2(d sin th, r - d cos th), (15) with atan2. d > 0: the sensor
/// is ahead. In (-pi, pi]; exact for every range, also inside d; 0 on the axis beyond the sensors.
[[nodiscard]] double planar_parallax(double bearing_rad, double range_m, double d_m);

/// A displaced sensor's bearing as the reference sensor would have taken it, with range and bearing of the target
/// track (16). Exact with the exact range and bearing; into (-pi, pi].
[[nodiscard]] double compensate_planar_parallax(double measured_rad, double track_bearing_rad, double track_range_m,
                                                double d_m);

/// Azimuth and elevation at a site with covariance (rad^2, azimuth first).
struct Bearing {
  double azimuth_rad = 0;
  double elevation_rad = 0;
  Eigen::Matrix2d cov = Eigen::Matrix2d::Zero();
};

/// (16) in three dimensions: the bearing `measured` at `from` as `to` would have taken it, through a position of the
/// target with covariance `position_cov` (ECEF, m^2): measured + bearing(to) - bearing(from), each exact at its site,
/// azimuth into [0, 2 pi). To first order its covariance is that of the measurement plus (J_to - J_from) P (J_to -
/// J_from)'; the position is taken as independent of the measurement. A far target adds almost nothing, a near one
/// what its position is worth. Near a zenith the azimuth's covariance grows without bound, as it should.
[[nodiscard]] Bearing transfer_bearing(const Bearing& measured, const Site& from, const Site& to,
                                       const Position<Ecef>& position, const Eigen::Matrix3d& position_cov);

}  // namespace downrange
