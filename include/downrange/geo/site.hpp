#pragma once
/// WGS-84 sites and the conversions between geodetic, ECEF and local axes.

#include <downrange/geo/frames.hpp>

namespace downrange {

/// WGS-84 geodetic coordinates.
struct Geodetic {
  double latitude_rad = 0;   ///< [-pi/2, pi/2]
  double longitude_rad = 0;  ///< east positive
  double height_m = 0;       ///< above the ellipsoid
  bool operator==(const Geodetic&) const = default;
};

/// Exact (closed form). Finite input; |latitude| <= pi/2.
[[nodiscard]] Position<Ecef> ecef_from_geodetic(const Geodetic& g);

/// Inverse by GeographicLib::Geocentric (Karney 2011, doi 10.1007/s00190-011-0520-z): error below 1e-8 m from the
/// Earth's centre to 1e9 m. Longitude in [-pi, pi].
[[nodiscard]] Geodetic geodetic_from_ecef(const Position<Ecef>& p);

/// Rotation from ECEF to east-north-up at a geodetic point (rows: east, north, up).
[[nodiscard]] Rotation<Enu, Ecef> enu_from_ecef_at(const Geodetic& g);

/// South-east-zenith from east-north-up: (s, e, z) = (-n, e, u).
[[nodiscard]] Rotation<Sez, Enu> sez_from_enu();

/// A surveyed point: antenna phase centre of a radar, a telemetry station or a slaved antenna.
class Site {
 public:
  Site() : Site(Geodetic{}) {}
  explicit Site(const Geodetic& g) : Site(g, 0) {}
  /// Of a moving antenna: azimuths count from `azimuth_zero_rad`, clockwise from true north, in place of north. "East"
  /// and "north" are then to the right of that direction and along it.
  Site(const Geodetic& g, double azimuth_zero_rad);

  [[nodiscard]] const Geodetic& geodetic() const { return geodetic_; }
  [[nodiscard]] const Position<Ecef>& ecef() const { return ecef_; }
  [[nodiscard]] const Rotation<Enu, Ecef>& R_enu_ecef() const { return R_enu_ecef_; }
  [[nodiscard]] const Rotation<Sez, Ecef>& R_sez_ecef() const { return R_sez_ecef_; }

  [[nodiscard]] Displacement<Enu> enu_of(const Position<Ecef>& p) const { return R_enu_ecef_ * (p - ecef_); }
  [[nodiscard]] Position<Ecef> ecef_of(const Displacement<Enu>& d) const { return ecef_ + R_enu_ecef_.inverse() * d; }

 private:
  Geodetic geodetic_;
  Position<Ecef> ecef_;
  Rotation<Enu, Ecef> R_enu_ecef_;
  Rotation<Sez, Ecef> R_sez_ecef_;
};

}  // namespace downrange
