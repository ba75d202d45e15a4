#pragma once
/// What a radar measures of a moving target, bias and refraction included, and how that changes with target and bias.

#include <downrange/est/model/bias_terms.hpp>
#include <downrange/est/model/matrix.hpp>
#include <downrange/est/model/measured.hpp>
#include <downrange/est/model/sensors.hpp>

namespace downrange {

/// A predicted plot and its Jacobians. Rows: range (m), azimuth, elevation (rad).
struct PredictedPlot {
  Vec<3> q = Vec<3>::Zero();
  Mat<3, 9> d_motion = Mat<3, 9>::Zero();                            ///< by position, velocity, acceleration (ECEF)
  Mat<3, bias_term_count> d_bias = Mat<3, bias_term_count>::Zero();  ///< by every term, indexed by BiasTerm
};

/// The plot stamped with the instant of `motion` (position, velocity, acceleration; ECEF):
/// the time tag moves the target to t - tau, the SEZ scales and offsets displace it in the site's axes, the air bends
/// the ray, then the polar scales and offsets act (est/THEORY.md section 3; the azimuth scale about south). `bias` is
/// indexed by BiasTerm; entries that are zero have no effect.
[[nodiscard]] PredictedPlot predict_plot(const RadarModel& radar, const Vec<9>& motion,
                                         const Vec<bias_term_count>& bias);

/// A predicted range rate and its Jacobians.
struct PredictedRangeRate {
  double m_s = 0;
  Mat<1, 9> d_motion = Mat<1, 9>::Zero();
  Mat<1, bias_term_count> d_bias = Mat<1, bias_term_count>::Zero();
};

/// How fast the range of `predict_plot` grows at that instant, of the same displaced target through the same air; polar
/// offsets and scales do not touch it. That the air's part changes with motion and bias is left out of the Jacobians:
/// it is some cm/s above 10 degrees of elevation, some m/s at the horizon.
[[nodiscard]] PredictedRangeRate predict_range_rate(const RadarModel& radar, const Vec<9>& motion,
                                                    const Vec<bias_term_count>& bias);

/// The method uses the plot's range rate.
[[nodiscard]] inline bool uses_range_rate(const RadarModel& radar, const Plot& plot) {
  return plot.range_rate_valid && radar.sigma_range_rate_m_s > 0;
}

/// The plot as it would be without air; unchanged for a radar whose refraction is not modelled.
[[nodiscard]] Polar without_refraction(const RadarModel& radar, const Polar& plot);

/// Calls `use.operator()<First, M>()`: of (range, azimuth, elevation) the plot has the M components from First on, all
/// three, the angles alone or the range alone. It has one part at least.
template <class Use>
auto with_components(const Plot& plot, const Use& use) {
  if (!plot.range_valid) return use.template operator()<1, 2>();
  if (!plot.angles_valid) return use.template operator()<0, 1>();
  return use.template operator()<0, 3>();
}

/// Plot minus prediction, angles wrapped.
[[nodiscard]] Vec<3> plot_residual(const Polar& plot, const Vec<3>& predicted);

/// How far azimuth turns for a small angle on the sky: 1 / cos(elevation). Above 89.4 degrees of elevation, where
/// azimuth says nothing, it grows no further.
[[nodiscard]] double azimuth_of_sky_angle(double elevation_rad);

/// Diagonal of the noise covariance of a plot, by its elevation and signal-to-noise ratio (a plot that does not tell it
/// has that of the reference).
[[nodiscard]] Vec<3> plot_variance(const RadarModel& radar, const Plot& plot);
/// Likewise of its range rate, (m/s)^2.
[[nodiscard]] double range_rate_variance(const RadarModel& radar, const Plot& plot);

}  // namespace downrange
