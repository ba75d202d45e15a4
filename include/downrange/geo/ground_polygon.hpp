#pragma once
/// Closed lines on the ellipsoid: how far inside of one a place is, and how far it is to it in a direction.

#include <downrange/geo/site.hpp>
#include <optional>
#include <string>
#include <vector>

namespace downrange {

/// A place on the ellipsoid.
struct GroundPoint {
  double latitude_rad = 0;   ///< geodetic
  double longitude_rad = 0;  ///< any turn
  bool operator==(const GroundPoint&) const = default;
};

/// Along the ground from `from`, whose axes are `R_enu_ecef`, to `to`: east and north in metres, as long as the way is
/// on a sphere of the Earth's mean radius. Both on (or near) the ellipsoid, not antipodes.
[[nodiscard]] Eigen::Vector2d ground_offset(const Position<Ecef>& from, const Rotation<Enu, Ecef>& R_enu_ecef,
                                            const Position<Ecef>& to);

/// A polygon on the ellipsoid. Its edges are geodesics, its inside is the side that does not go around the Earth; the
/// vertices go around either way, over the date line and around a pole as well. A value; allocates at construction.
class GroundPolygon {
 public:
  static constexpr std::size_t max_vertices = 500;

  /// What is wrong with these vertices, as a sentence; empty: nothing. At least three, no two neighbours alike, no
  /// edges that cross or touch, none farther than 60 deg (6 700 km) from their middle. A first vertex that is repeated
  /// at the end is left out.
  [[nodiscard]] static std::string defect_of(const std::vector<GroundPoint>& vertices);

  /// Throws std::invalid_argument with that sentence.
  explicit GroundPolygon(const std::vector<GroundPoint>& vertices);

  [[nodiscard]] bool contains(const GroundPoint& p) const;

  /// Length of the geodesic to the nearest point of the line, m; positive inside. Against a search over densely sampled
  /// geodesics: within 1e-5 of the distance and 3 cm, as tested up to 5 000 km.
  [[nodiscard]] double signed_distance_m(const GroundPoint& p) const;

  /// From `p` straight ahead with this azimuth: how far it is to the line. Nothing where there is none within a quarter
  /// of the Earth.
  [[nodiscard]] std::optional<double> distance_ahead_m(const GroundPoint& p, double azimuth_rad) const;

  /// Points of the line, counterclockwise seen from above, not more than 25 km apart: between two of them it is
  /// straight.
  [[nodiscard]] const std::vector<Position<Ecef>>& outline() const { return outline_; }

 private:
  /// From a point of the line to the next: an arc of a great circle of geocentric directions, which a geodesic of its
  /// length is to 3 cm.
  struct Piece {
    Eigen::Vector3d from;  ///< unit vectors
    Eigen::Vector3d normal;
    Eigen::Vector3d after_from;  ///< (after_from . u) >= 0, (before_to . u) >= 0: u is between the ends
    Eigen::Vector3d before_to;
    Eigen::Vector2d at;  ///< `from` in the plane that touches the sphere at the middle, where arcs are straight
  };

  Eigen::Matrix3d axes_;  ///< rows: two in that plane, and the middle
  std::vector<Piece> pieces_;
  std::vector<Position<Ecef>> outline_;
};

}  // namespace downrange
