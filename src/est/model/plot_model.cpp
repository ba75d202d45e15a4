#include <algorithm>
#include <cmath>
#include <downrange/est/model/plot_model.hpp>
#include <numbers>

namespace downrange {
namespace {

/// Above 89.4 degrees of elevation the azimuth says nothing: its noise grows no further.
constexpr double least_cos_elevation = 0.01;

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

Polar without_refraction(const RadarModel& radar, const Polar& plot) {
  if (!radar.refraction) return plot;
  const Refraction air = radar.refraction->at_measured(plot.range_m, plot.elevation_rad);
  return {plot.range_m - air.range_m, plot.azimuth_rad, plot.elevation_rad - air.elevation_rad};
}

Vec<3> plot_residual(const Polar& plot, const Vec<3>& predicted) {
  return {plot.range_m - predicted[0], wrap_pi(plot.azimuth_rad - predicted[1]), plot.elevation_rad - predicted[2]};
}

Vec<3> plot_variance(const RadarModel& radar, double elevation_rad) {
  const double on_sky = radar.azimuth_sigma_on_sky ? std::max(std::cos(elevation_rad), least_cos_elevation) : 1;
  return Vec<3>(radar.sigma.range_m, radar.sigma.azimuth_rad / on_sky, radar.sigma.elevation_rad).cwiseAbs2();
}

}  // namespace downrange
