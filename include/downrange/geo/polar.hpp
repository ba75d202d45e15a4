#pragma once
/// Radar measurement geometry: range, azimuth, elevation at a site, and its converted measurement.

#include <Eigen/Core>
#include <downrange/geo/frames.hpp>

namespace downrange {

/// What a radar measures at its site. Azimuth clockwise from true north, elevation up from the local horizontal.
struct Polar {
  double range_m = 0;
  double azimuth_rad = 0;
  double elevation_rad = 0;
  bool operator==(const Polar&) const = default;
};

/// 1-sigma of a radar's noise, per coordinate.
struct PolarSigma {
  double range_m = 0;
  double azimuth_rad = 0;
  double elevation_rad = 0;
};

/// Into (-pi, pi].
[[nodiscard]] double wrap_pi(double angle_rad);
/// Into [0, 2 pi).
[[nodiscard]] double wrap_two_pi(double angle_rad);

/// Azimuth in [0, 2 pi); at the zenith and at the site itself, where it is undefined, azimuth is 0. Range >= 0.
[[nodiscard]] Polar polar_from_enu(const Displacement<Enu>& d);
[[nodiscard]] Displacement<Enu> enu_from_polar(const Polar& q);

/// d(range, azimuth, elevation)/d(east, north, up). The azimuth row grows as 1/(range cos elevation); horizontal
/// distance is floored at 1e-6 of the range so that the zenith gives large numbers, never infinities.
[[nodiscard]] Eigen::Matrix3d d_polar_d_enu(const Displacement<Enu>& d);
/// d(east, north, up)/d(range, azimuth, elevation).
[[nodiscard]] Eigen::Matrix3d d_enu_d_polar(const Polar& q);

/// A polar measurement brought to Cartesian axes: z with E[z | truth] = truth, R its covariance.
struct ConvertedMeasurement {
  Displacement<Enu> z;
  Eigen::Matrix3d R;  ///< m^2, (east, north, up)
};

/// Unbiased converted measurement: multiplicative debiasing (Longbin, Xiaoquan, Yizhu, Kang, Bar-Shalom 1998,
/// doi 10.1109/7.705921) with the consistent covariance of Duan, Han, Li 2004 (E[R | truth] is the covariance of z).
/// Any elevation, the zenith included: R stays positive definite there (its smallest eigenvalue is kept above the
/// fourth-order term range^2 sigma_el^2 (sigma_az^2 + sigma_el^2)); sigma angles below 0.5 rad.
[[nodiscard]] ConvertedMeasurement convert_unbiased(const Polar& q, const PolarSigma& sigma);

/// Additive debiasing with averaged covariance: Lerro, Bar-Shalom 1993; Suchomski 1999 (song2015 eq. 8-10 as
/// corrected in est/ERRATA.md). The conversion the range paper prints.
[[nodiscard]] ConvertedMeasurement convert_additive(const Polar& q, const PolarSigma& sigma);

/// Mean and covariance of the *raw* conversion of measurements of a target truly at `truth`.
[[nodiscard]] ConvertedMeasurement raw_conversion_statistics(const Polar& truth, const PolarSigma& sigma);

}  // namespace downrange
