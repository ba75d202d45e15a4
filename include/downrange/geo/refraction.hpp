#pragma once
/// Bending and delay of radio waves between a site and a target: what refraction adds to a radar's range and elevation.

#include <array>
#include <downrange/geo/site.hpp>
#include <vector>

namespace downrange {

/// What refraction does to a measurement: measured = true + refraction. Both are positive for a target above the site.
/// Azimuth is not refracted in an atmosphere of spherical layers.
struct Refraction {
  double range_m = 0;
  double elevation_rad = 0;
};

/// Spherical layers over one site: refractive index n(h) = 1 + 1e-6 N0 exp(-h / H), h above the site (to 2.5 km below
/// it the same law goes on, deeper n is constant). est/THEORY.md section 8.
struct Atmosphere {
  double refractivity = 0;    ///< N0 at the site, N-units, 0 to 500; near 1000 a level ray would circle the Earth
  double radius_m = 6.371e6;  ///< from the centre of curvature to the site
  double scale_height_m = 7000;
};

/// The atmosphere over a site: the sphere has the ellipsoid's Gaussian (mean) radius of curvature there.
[[nodiscard]] Atmosphere atmosphere_over(const Geodetic& site, double refractivity);

/// Exact: the ray is traced through the layers (Born, Wolf, Principles of Optics, section 3.2: d(n dr/ds)/ds = grad n;
/// equal to Snell's law in spherical layers, n r cos(elevation) constant) by Runge-Kutta of order 4 until it meets the
/// target. Measured range is the radio path, the integral of n along the ray; measured elevation the ray's direction at
/// the site. Error of the integration below 1e-8 rad and 1e-4 m. A ray takes 20 us, a search about five rays; filters
/// use RefractionTable. Elevation -1.5 deg to 90 deg (below that the ray is in the ground, and any finite answer),
/// range 0 to 1e7 m.
[[nodiscard]] Refraction refraction_at_true(const Atmosphere& atmosphere, double range_m, double elevation_rad);
/// The same of a target that is seen at a measured range and elevation: true = measured - refraction.
[[nodiscard]] Refraction refraction_at_measured(const Atmosphere& atmosphere, double range_m, double elevation_rad);

/// The refraction of one site for filters: bicubic in functions of range and elevation that make it smooth, once
/// continuously differentiable. Against the exact ray: below 0.05 mdeg and 0.02 m for elevations -1 deg to 90 deg and
/// ranges 0 to 4000 km, as tested with N0 = 320. Below -1.5 deg and beyond 6000 km the value at that edge is kept.
class RefractionTable {
 public:
  /// No atmosphere: everything is zero.
  RefractionTable() = default;
  /// Traces about 6 000 rays: 50 ms.
  explicit RefractionTable(const Atmosphere& atmosphere);

  struct Value {
    Refraction refraction;
    Refraction d_range;      ///< per metre of true range
    Refraction d_elevation;  ///< per radian of true elevation
  };
  /// At a true range and elevation. Allocates nothing.
  [[nodiscard]] Value at_true(double range_m, double elevation_rad) const;
  /// At a measured range and elevation: true = measured - refraction. The inverse of `at_true` to 1e-11 relative.
  [[nodiscard]] Refraction at_measured(double range_m, double elevation_rad) const;

 private:
  /// Value, derivatives along both coordinates and mixed, per cell width: of the range error in m and of the elevation
  /// error over cos(elevation).
  struct Node {
    std::array<double, 4> range;
    std::array<double, 4> elevation;
  };
  std::vector<Node> nodes_;
};

}  // namespace downrange
