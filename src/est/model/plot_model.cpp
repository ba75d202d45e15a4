#include <algorithm>
#include <cmath>
#include <downrange/est/model/plot_model.hpp>
#include <numbers>

namespace downrange {
namespace {

/// Signals are told apart within this of the reference.
constexpr double most_db = 100;

/// Noise at the reference -> factor on its variance.
double fading(const SnrNoise& noise, const Plot& plot) {
  return plot.snr_valid ? std::pow(10, std::clamp(noise.ref_db - plot.snr_db, -most_db, most_db) / 10) : 1;
}

}  // namespace

PredictedPlot predict_plot(const RadarModel& radar, const Vec<9>& motion, const Vec<bias_term_count>& bias) {
  const auto part = [&bias](BiasTerm first) -> Vec<3> { return bias.segment<3>(static_cast<Eigen::Index>(first)); };
  const Vec<3> offset = part(BiasTerm::OffsetRange);
  const Vec<3> scale = part(BiasTerm::ScaleRange);
  const double tau = bias[static_cast<Eigen::Index>(BiasTerm::TimeTag)];

  // The plot stamped t was true at t - tau.
  const Vec<3> a = motion.tail<3>();
  const Vec<3> v = motion.segment<3>(3) - tau * a;
  const Vec<3> p = motion.head<3>() - tau * motion.segment<3>(3) + tau * tau / 2 * a;
  const Mat<3, 3>& R_sez_ecef = radar.site.R_sez_ecef().R;
  const Mat<3, 3> R_enu_sez = sez_from_enu().R.transpose();
  const Vec<3> d_sez = R_sez_ecef * (p - radar.site.ecef().m);
  const Vec<3> sez_scale = Vec<3>::Ones() + part(BiasTerm::ScaleSouth);
  const Displacement<Enu> d{R_enu_sez * (sez_scale.cwiseProduct(d_sez) + part(BiasTerm::OffsetSouth))};
  const Polar polar = polar_from_enu(d);
  Vec<3> scaled(polar.range_m, wrap_pi(polar.azimuth_rad - std::numbers::pi), polar.elevation_rad);

  PredictedPlot plot;
  Mat<3, 3> J_air = Mat<3, 3>::Identity();
  if (radar.refraction) {
    const RefractionTable::Value air = radar.refraction->at_true(polar.range_m, polar.elevation_rad);
    scaled[0] += air.refraction.range_m;
    scaled[2] += air.refraction.elevation_rad;
    J_air(0, 0) += air.d_range.range_m;
    J_air(0, 2) += air.d_elevation.range_m;
    J_air(2, 0) += air.d_range.elevation_rad;
    J_air(2, 2) += air.d_elevation.elevation_rad;
  }
  plot.q = Vec<3>(scaled[0], polar.azimuth_rad, scaled[2]) + offset + scale.cwiseProduct(scaled);
  const Mat<3, 3> J_sez = (Vec<3>::Ones() + scale).asDiagonal() * J_air * d_polar_d_enu(d) * R_enu_sez;
  const Mat<3, 3> J_ecef = J_sez * sez_scale.asDiagonal() * R_sez_ecef;
  plot.d_motion << J_ecef, -tau * J_ecef, tau * tau / 2 * J_ecef;
  const auto columns = [&plot](BiasTerm first) { return plot.d_bias.middleCols<3>(static_cast<Eigen::Index>(first)); };
  columns(BiasTerm::OffsetSouth) = J_sez;
  columns(BiasTerm::ScaleSouth) = J_sez * d_sez.asDiagonal();
  columns(BiasTerm::OffsetRange).setIdentity();
  columns(BiasTerm::ScaleRange) = scaled.asDiagonal();
  plot.d_bias.col(static_cast<Eigen::Index>(BiasTerm::TimeTag)) = -J_ecef * v;
  return plot;
}

PredictedRangeRate predict_range_rate(const RadarModel& radar, const Vec<9>& motion, const Vec<bias_term_count>& bias) {
  const auto part = [&bias](BiasTerm first) -> Vec<3> { return bias.segment<3>(static_cast<Eigen::Index>(first)); };
  const double tau = bias[static_cast<Eigen::Index>(BiasTerm::TimeTag)];
  const Vec<3> a = motion.tail<3>();
  const Vec<3> v = motion.segment<3>(3) - tau * a;
  const Vec<3> p = motion.head<3>() - tau * motion.segment<3>(3) + tau * tau / 2 * a;
  // All in the site's SEZ axes: the displaced target d moves by w.
  const Mat<3, 3>& R_sez_ecef = radar.site.R_sez_ecef().R;
  const Vec<3> scale = Vec<3>::Ones() + part(BiasTerm::ScaleSouth);
  const Vec<3> d_true = R_sez_ecef * (p - radar.site.ecef().m);
  const Vec<3> v_true = R_sez_ecef * v;
  const Vec<3> d = scale.cwiseProduct(d_true) + part(BiasTerm::OffsetSouth);
  const Vec<3> w = scale.cwiseProduct(v_true);
  const double range = d.norm();
  const Vec<3> u = d / range;
  const double rate = u.dot(w);
  const Vec<3> across = (w - rate * u) / range;  // d rate / d d

  PredictedRangeRate predicted;
  predicted.m_s = rate;
  if (radar.refraction) {
    const Mat<3, 3> R_enu_sez = sez_from_enu().R.transpose();
    const Displacement<Enu> d_enu{R_enu_sez * d};
    const Polar polar = polar_from_enu(d_enu);
    const RefractionTable::Value air = radar.refraction->at_true(polar.range_m, polar.elevation_rad);
    const Vec<3> polar_rate = d_polar_d_enu(d_enu) * (R_enu_sez * w);
    predicted.m_s += air.d_range.range_m * polar_rate[0] + air.d_elevation.range_m * polar_rate[2];
  }
  const Mat<1, 3> by_position = scale.cwiseProduct(across).transpose() * R_sez_ecef;
  const Mat<1, 3> by_velocity = scale.cwiseProduct(u).transpose() * R_sez_ecef;
  predicted.d_motion << by_position, by_velocity - tau * by_position, tau * tau / 2 * by_position - tau * by_velocity;
  const auto columns = [&](BiasTerm first) { return predicted.d_bias.middleCols<3>(static_cast<Eigen::Index>(first)); };
  columns(BiasTerm::OffsetSouth) = across.transpose();
  columns(BiasTerm::ScaleSouth) = (across.cwiseProduct(d_true) + u.cwiseProduct(v_true)).transpose();
  predicted.d_bias[static_cast<Eigen::Index>(BiasTerm::TimeTag)] = -by_position.dot(v) - by_velocity.dot(a);
  return predicted;
}

Polar without_refraction(const RadarModel& radar, const Polar& plot) {
  if (!radar.refraction) return plot;
  const Refraction air = radar.refraction->at_measured(plot.range_m, plot.elevation_rad);
  return {plot.range_m - air.range_m, plot.azimuth_rad, plot.elevation_rad - air.elevation_rad};
}

Vec<3> plot_residual(const Polar& plot, const Vec<3>& predicted) {
  return {plot.range_m - predicted[0], wrap_pi(plot.azimuth_rad - predicted[1]), plot.elevation_rad - predicted[2]};
}

double azimuth_of_sky_angle(double elevation_rad) {
  constexpr double least_cos_elevation = 0.01;
  return 1 / std::max(std::cos(elevation_rad), least_cos_elevation);
}

Vec<3> plot_variance(const RadarModel& radar, const Plot& plot) {
  const double of_sky = radar.azimuth_sigma_on_sky ? azimuth_of_sky_angle(plot.measured.elevation_rad) : 1;
  const auto squares = [of_sky](const PolarSigma& sigma) -> Vec<3> {
    return Vec<3>(sigma.range_m, sigma.azimuth_rad * of_sky, sigma.elevation_rad).cwiseAbs2();
  };
  return squares(radar.sigma) + fading(radar.snr, plot) * squares(radar.snr.at_ref);
}

double range_rate_variance(const RadarModel& radar, const Plot& plot) {
  return std::pow(radar.sigma_range_rate_m_s, 2) +
         fading(radar.snr, plot) * std::pow(radar.snr.range_rate_at_ref_m_s, 2);
}

}  // namespace downrange
