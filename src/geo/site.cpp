#include <Eigen/Geometry>
#include <GeographicLib/Geocentric.hpp>
#include <cmath>
#include <downrange/geo/site.hpp>
#include <numbers>

namespace downrange {
namespace {

constexpr double rad_per_deg = std::numbers::pi / 180;

}  // namespace

Position<Ecef> ecef_from_geodetic(const Geodetic& g) {
  Position<Ecef> p;
  GeographicLib::Geocentric::WGS84().Forward(g.latitude_rad / rad_per_deg, g.longitude_rad / rad_per_deg, g.height_m,
                                             p.m.x(), p.m.y(), p.m.z());
  return p;
}

Geodetic geodetic_from_ecef(const Position<Ecef>& p) {
  double latitude_deg = 0;
  double longitude_deg = 0;
  Geodetic g;
  GeographicLib::Geocentric::WGS84().Reverse(p.m.x(), p.m.y(), p.m.z(), latitude_deg, longitude_deg, g.height_m);
  g.latitude_rad = latitude_deg * rad_per_deg;
  g.longitude_rad = longitude_deg * rad_per_deg;
  return g;
}

Rotation<Enu, Ecef> enu_from_ecef_at(const Geodetic& g) {
  const double sin_lat = std::sin(g.latitude_rad);
  const double cos_lat = std::cos(g.latitude_rad);
  const double sin_lon = std::sin(g.longitude_rad);
  const double cos_lon = std::cos(g.longitude_rad);
  Rotation<Enu, Ecef> r;
  r.R << -sin_lon, cos_lon, 0,                          //
      -sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat,  //
      cos_lat * cos_lon, cos_lat * sin_lon, sin_lat;
  return r;
}

Rotation<Sez, Enu> sez_from_enu() {
  Rotation<Sez, Enu> r;
  r.R << 0, -1, 0,  //
      1, 0, 0,      //
      0, 0, 1;
  return r;
}

Site::Site(const Geodetic& g, double azimuth_zero_rad)
    : geodetic_(g),
      ecef_(ecef_from_geodetic(g)),
      R_enu_ecef_{Eigen::AngleAxisd(azimuth_zero_rad, Eigen::Vector3d::UnitZ()) * enu_from_ecef_at(g).R},
      R_sez_ecef_(sez_from_enu() * R_enu_ecef_) {}

}  // namespace downrange
