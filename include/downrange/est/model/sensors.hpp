#pragma once
/// Radars, trackers and receivers as the filters see them.

#include <downrange/est/model/bias_terms.hpp>
#include <downrange/geo/polar.hpp>
#include <downrange/geo/refraction.hpp>
#include <downrange/geo/site.hpp>
#include <memory>
#include <numbers>

namespace downrange {

/// Slowly varying pointing error of a mount, across and along elevation, on the sky: first-order Gauss-Markov. Azimuth
/// is off by the first over cos(elevation). Two states per radar of joint and schmidt (ts knows none: give the angle
/// offsets a drift there).
struct PointingWander {
  double sigma_rad = 0;  ///< 0: none
  double tau_s = 30;
};

/// How a plot's noise grows as its signal fades: variance = sigma^2 + at_ref^2 * 10^((ref_db - snr) / 10), sigma being
/// what remains of a strong signal.
struct SnrNoise {
  double ref_db = 0;
  PolarSigma at_ref{};  ///< 0: this does not depend on the signal
  double range_rate_at_ref_m_s = 0;
};

/// One radar, or one angles-only tracker, as the filters see it.
struct RadarModel {
  Site site;
  PolarSigma sigma;  ///< as the filter uses it, inflation included; 0: it never measures this
  /// sigma.azimuth_rad is on the sky, as a mount's pointing errors are: the noise of the azimuth itself is that over
  /// cos(elevation). False: it is the axis's own.
  bool azimuth_sigma_on_sky = false;
  double angle_inflation = 1;  ///< what the angle variances of sigma, and of snr, contain beside the instrument's own
  /// Terms of joint, schmidt and ts; song2015 and the track-level rules always use their own Cartesian ones.
  BiasModel bias = bias_model({BiasBlock::Polar, BiasBlock::SezOffset, BiasBlock::Time});
  PointingWander wander{};
  double sigma_range_rate_m_s = 0;  ///< 0: the range rate of its plots is not used
  SnrNoise snr{};
  std::shared_ptr<const RefractionTable> refraction =
      nullptr;  ///< of the air over the site; none: plots are free of it
};

/// Whether a plot with this noise may tell a position: range and both angles are measured.
[[nodiscard]] inline bool measures_position(const PolarSigma& sigma) {
  return sigma.range_m > 0 && sigma.azimuth_rad > 0 && sigma.elevation_rad > 0;
}

/// Slowly varying error of a receiver's position, per axis: first-order Gauss-Markov.
struct GpsErrorModel {
  bool enabled = true;
  double sigma_m = 3;
  double tau_s = 80;
};

/// How joint, schmidt and ts work until a target's first fix: what a radar's bias may then be, and how its pointing
/// wanders.
struct NoGpsRegime {
  bool enabled = true;
  double offset_prior_m = 25;
  double angle_prior_rad = 0.05 * std::numbers::pi / 180;
  PointingWander wander{.sigma_rad = 0.02 * std::numbers::pi / 180, .tau_s = 30};
};

}  // namespace downrange
