#include "stage/slave/mount_error.hpp"

#include <algorithm>
#include <cmath>
#include <downrange/geo/polar.hpp>

#include "stage/indices.hpp"

namespace downrange {
namespace {

/// chi-square of two angles, 1e-4.
constexpr double gate = 18.4;

/// Without a configured wander: half the sigma over 100 s, as the methods have it.
double drift_of(const PointingWander& wander, double sigma_rad) {
  const double size = wander.sigma_rad > 0 ? wander.sigma_rad : sigma_rad / 2;
  const double tau_s = wander.sigma_rad > 0 ? wander.tau_s : 100;
  return std::sqrt(2 / tau_s) * size;
}

MountNoise noise_of(double sigma_azimuth_rad, double sigma_elevation_rad, bool on_sky, const PointingWander& wander,
                    double prior_rad) {
  return {.sigma_azimuth_rad = sigma_azimuth_rad,
          .sigma_elevation_rad = sigma_elevation_rad,
          .azimuth_sigma_on_sky = on_sky,
          .prior_rad = prior_rad,
          .drift_azimuth_rad_sqrt_s = drift_of(wander, sigma_azimuth_rad),
          .drift_elevation_rad_sqrt_s = drift_of(wander, sigma_elevation_rad)};
}

}  // namespace

std::optional<MountNoise> mount_noise(const RangeConfig& range, const AntennaConfig& antenna) {
  if (antenna.sensor.empty()) return std::nullopt;
  if (const int i = index_of(range.angle_sensors, antenna.sensor); i >= 0) {
    const AngleSensorConfig& s = range.angle_sensors[static_cast<std::size_t>(i)];
    return noise_of(s.sigma_azimuth_rad, s.sigma_elevation_rad, s.azimuth_sigma_on_sky, s.wander, s.bias_prior_rad);
  }
  const int i = index_of(range.radars, antenna.sensor);
  if (i < 0) return std::nullopt;
  const RadarConfig& r = range.radars[static_cast<std::size_t>(i)];
  return noise_of(r.sigma.azimuth_rad, r.sigma.elevation_rad, r.azimuth_sigma_on_sky, r.wander, r.bias.prior.angle_rad);
}

void MountError::Axis::predict(double drift_rad_sqrt_s, double track_sigma_rad, double dt_s) {
  const double phi = std::exp(-dt_s / track_tau_s);
  P_mount += drift_rad_sqrt_s * drift_rad_sqrt_s * dt_s;
  track *= phi;
  P_both *= phi;
  P_track = phi * phi * P_track + (1 - phi * phi) * track_sigma_rad * track_sigma_rad;
}

void MountError::Axis::update(double innovation, double variance) {
  const double S = this->variance() + variance;
  const double of_mount = P_mount + P_both;
  const double of_track = P_track + P_both;
  mount += of_mount / S * innovation;
  track += of_track / S * innovation;
  P_mount -= of_mount * of_mount / S;
  P_track -= of_track * of_track / S;
  P_both -= of_mount * of_track / S;
}

MountError::MountError(const MountNoise& noise, double most_rad) : noise_(noise), most_rad_(most_rad) { begin_anew(); }

void MountError::begin_anew() {
  for (Axis* axis : {&azimuth_, &elevation_}) {
    axis->P_mount = most_rad_ * most_rad_;
    axis->P_both = 0;
  }
  taken_ = refused_ = 0;
}

void MountError::note(Time epoch, double azimuth_rad, double elevation_rad, double cos_elevation,
                      double track_azimuth_rad, double track_elevation_rad) {
  if (newest_ && epoch <= *newest_) return;
  const double dt = newest_ ? (epoch - *newest_).seconds() : 1e3;  // what the track is off begins as large as it says
  azimuth_.predict(newest_ ? noise_.drift_azimuth_rad_sqrt_s : 0, track_azimuth_rad, dt);
  elevation_.predict(newest_ ? noise_.drift_elevation_rad_sqrt_s : 0, track_elevation_rad, dt);
  newest_ = epoch;
  const double sigma = noise_.sigma_azimuth_rad / (noise_.azimuth_sigma_on_sky ? std::max(cos_elevation, 1e-3) : 1);
  const double R_azimuth = sigma * sigma;
  const double R_elevation = noise_.sigma_elevation_rad * noise_.sigma_elevation_rad;
  const double nu_azimuth = wrap_pi(azimuth_rad - azimuth_.mount - azimuth_.track);
  const double nu_elevation = elevation_rad - elevation_.mount - elevation_.track;
  const bool fits = nu_azimuth * nu_azimuth / (azimuth_.variance() + R_azimuth) +
                        nu_elevation * nu_elevation / (elevation_.variance() + R_elevation) <=
                    gate;
  if (!fits) {
    if (refused_++ == 0) refused_since_ = epoch;
    if (refused_ < settles_with || epoch - refused_since_ < settles_in) return;
    begin_anew();
  }
  refused_ = 0;
  if (taken_++ == 0) begun_ = epoch;
  azimuth_.update(nu_azimuth, R_azimuth);
  elevation_.update(nu_elevation, R_elevation);
  tell(epoch);
}

void MountError::tell(Time epoch) {
  if (taken_ < settles_with || epoch - begun_ < settles_in) return;  // what was found before is kept for so long
  told_ = epoch;
  told_azimuth_ = azimuth_;
  told_elevation_ = elevation_;
  if (std::abs(azimuth_.mount) <= most_rad_ && std::abs(elevation_.mount) <= most_rad_) return;
  told_azimuth_ = told_elevation_ = {.P_mount = most_rad_ * most_rad_};
}

MountOffset MountError::at(Time t) const {
  if (!told_) return {.sigma_azimuth_rad = noise_.prior_rad, .sigma_elevation_rad = noise_.prior_rad};
  const double dt = std::max((t - *told_).seconds(), 0.0);
  const double phi = std::exp(-dt / track_tau_s);
  return {
      .azimuth_rad = told_azimuth_.mount + phi * told_azimuth_.track,
      .elevation_rad = told_elevation_.mount + phi * told_elevation_.track,
      .sigma_azimuth_rad = std::sqrt(told_azimuth_.P_mount + std::pow(noise_.drift_azimuth_rad_sqrt_s, 2) * dt),
      .sigma_elevation_rad = std::sqrt(told_elevation_.P_mount + std::pow(noise_.drift_elevation_rad_sqrt_s, 2) * dt)};
}

}  // namespace downrange
