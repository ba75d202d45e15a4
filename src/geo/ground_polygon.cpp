#include <Eigen/Geometry>
#include <GeographicLib/Geodesic.hpp>
#include <GeographicLib/GeodesicLine.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <downrange/geo/earth.hpp>
#include <downrange/geo/ground_polygon.hpp>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace downrange {
namespace {

using GeographicLib::Geodesic;

constexpr double deg = std::numbers::pi / 180;
constexpr double mean_radius_m = 6'371'008.8;
constexpr double longest_piece_m = 25e3;
/// Cosine of the angle between the middle and the farthest vertex.
constexpr double least_cosine = 0.5;
/// Vertices and edges that are nearer to each other than a millimetre touch.
constexpr double touching = 1.5e-10;

Position<Ecef> on_ground(const GroundPoint& p) { return ecef_from_geodetic({p.latitude_rad, p.longitude_rad, 0}); }

Eigen::Vector3d direction_of(const GroundPoint& p) { return on_ground(p).m.normalized(); }

/// Of a geocentric direction: where it leaves the ellipsoid.
GroundPoint ground_of(const Eigen::Vector3d& u) {
  constexpr double e2 = wgs84::flattening * (2 - wgs84::flattening);
  return {std::atan2(u.z(), (1 - e2) * std::hypot(u.x(), u.y())), std::atan2(u.y(), u.x())};
}

double geodesic_m(const GroundPoint& a, const GroundPoint& b) {
  double s = 0;
  Geodesic::WGS84().Inverse(a.latitude_rad / deg, a.longitude_rad / deg, b.latitude_rad / deg, b.longitude_rad / deg,
                            s);
  return s;
}

std::vector<GroundPoint> without_repeated_end(std::vector<GroundPoint> vertices) {
  if (vertices.size() > 1 && vertices.front() == vertices.back()) vertices.pop_back();
  return vertices;
}

/// A point of the line, and the edge that begins there or before it.
struct LinePoint {
  GroundPoint at;
  std::size_t edge;
};

/// The vertices, and points between them.
std::vector<LinePoint> line_of(const std::vector<GroundPoint>& vertices) {
  std::vector<LinePoint> line;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const GroundPoint& a = vertices[i];
    const GroundPoint& b = vertices[(i + 1) % vertices.size()];
    line.push_back({a, i});
    const auto edge = Geodesic::WGS84().InverseLine(a.latitude_rad / deg, a.longitude_rad / deg, b.latitude_rad / deg,
                                                    b.longitude_rad / deg);
    const int parts = std::max(1, static_cast<int>(std::ceil(edge.Distance() / longest_piece_m)));
    for (int k = 1; k < parts; ++k) {
      double latitude_deg = 0;
      double longitude_deg = 0;
      edge.Position(edge.Distance() * k / parts, latitude_deg, longitude_deg);
      line.push_back({{latitude_deg * deg, longitude_deg * deg}, i});
    }
  }
  return line;
}

/// Rows: two axes of the plane that touches the sphere in the middle of the line, and the middle. Zero: it has none.
Eigen::Matrix3d axes_of(const std::vector<LinePoint>& line) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Eigen::Vector3d a = direction_of(line[i].at);
    const Eigen::Vector3d b = direction_of(line[(i + 1) % line.size()].at);
    middle += (b - a).norm() * (a + b);
  }
  Eigen::Matrix3d axes = Eigen::Matrix3d::Zero();
  const double size = middle.norm();
  if (!(size > 0)) return axes;
  middle /= size;
  axes.row(0) = middle.unitOrthogonal();
  axes.row(1) = middle.cross(Eigen::Vector3d(axes.row(0)));
  axes.row(2) = middle;
  return axes;
}

Eigen::Vector2d in_plane(const Eigen::Matrix3d& axes, const Eigen::Vector3d& u) {
  const Eigen::Vector3d local = axes * u;
  return local.head<2>() / local.z();
}

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

double distance_to_segment(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d d = b - a;
  const double t = std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0);
  return (p - a - t * d).norm();
}

bool cross_or_touch(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
                    const Eigen::Vector2d& d) {
  for (int k = 0; k < 2; ++k) {  // most are far from each other
    if (std::min(a[k], b[k]) > std::max(c[k], d[k]) + touching ||
        std::min(c[k], d[k]) > std::max(a[k], b[k]) + touching)
      return false;
  }
  const bool crossing = cross(b - a, c - a) * cross(b - a, d - a) < 0 && cross(d - c, a - c) * cross(d - c, b - c) < 0;
  return crossing || distance_to_segment(a, c, d) < touching || distance_to_segment(b, c, d) < touching ||
         distance_to_segment(c, a, b) < touching || distance_to_segment(d, a, b) < touching;
}

std::string vertex(std::size_t index) { return std::to_string(index + 1); }

std::string edge(std::size_t index, std::size_t count) { return vertex(index) + '-' + vertex((index + 1) % count); }

/// "edges 1-2 and 3-4 cross", or empty. `plane`: of the line's points.
std::string crossing_of(const std::vector<LinePoint>& line, const std::vector<Eigen::Vector2d>& plane,
                        std::size_t vertices) {
  const std::size_t n = line.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d& a = plane[i];
    const Eigen::Vector2d& b = plane[(i + 1) % n];
    const auto names = [&](std::size_t other) {
      return "edges " + edge(line[i].edge, vertices) + " and " + edge(line[other].edge, vertices) + " cross or touch";
    };
    // The next one begins where this one ends: they touch there, and nowhere else unless it goes back.
    const Eigen::Vector2d& next = plane[(i + 2) % n];
    if (distance_to_segment(next, a, b) < touching || distance_to_segment(a, b, next) < touching)
      return names((i + 1) % n);
    for (std::size_t j = i + 2; j < n; ++j) {
      if ((j + 1) % n == i) continue;
      if (cross_or_touch(a, b, plane[j], plane[(j + 1) % n])) return names(j);
    }
  }
  return {};
}

double doubled_area(const std::vector<Eigen::Vector2d>& plane) {
  double area = 0;
  for (std::size_t i = 0; i < plane.size(); ++i) area += cross(plane[i], plane[(i + 1) % plane.size()]);
  return area;
}

}  // namespace

Eigen::Vector2d ground_offset(const Position<Ecef>& from, const Rotation<Enu, Ecef>& R_enu_ecef,
                              const Position<Ecef>& to) {
  const Displacement<Enu> chord = R_enu_ecef * (to - from);
  const double across = chord.m.head<2>().norm();
  if (!(across > 0)) return Eigen::Vector2d::Zero();
  const double along = 2 * mean_radius_m * std::asin(std::min(1.0, chord.m.norm() / (2 * mean_radius_m)));
  return along / across * chord.m.head<2>();
}

std::string GroundPolygon::defect_of(const std::vector<GroundPoint>& given) {
  const std::vector<GroundPoint> vertices = without_repeated_end(given);
  if (vertices.size() < 3)
    return std::to_string(vertices.size()) + " different vertices, where a polygon has at least 3";
  if (vertices.size() > max_vertices)
    return std::to_string(vertices.size()) + " vertices, at most " + std::to_string(max_vertices);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const GroundPoint& p = vertices[i];
    if (!std::isfinite(p.longitude_rad) || !(std::abs(p.latitude_rad) <= std::numbers::pi / 2))
      return "vertex " + vertex(i) + " is no latitude and longitude";
    const std::size_t next = (i + 1) % vertices.size();
    if (geodesic_m(p, vertices[next]) < 1e-3) return "vertices " + vertex(i) + " and " + vertex(next) + " are alike";
  }
  const std::vector<LinePoint> line = line_of(vertices);
  const Eigen::Matrix3d axes = axes_of(line);
  std::vector<Eigen::Vector2d> plane;
  for (const LinePoint& p : line) {
    const Eigen::Vector3d u = direction_of(p.at);
    if (!(axes.row(2).dot(u) >= least_cosine))
      return "it reaches farther than 60 deg (6700 km) from its middle, near vertex " + vertex(p.edge);
    plane.push_back(in_plane(axes, u));
  }
  return crossing_of(line, plane, vertices.size());
}

GroundPolygon::GroundPolygon(const std::vector<GroundPoint>& given) {
  if (const std::string defect = defect_of(given); !defect.empty()) throw std::invalid_argument(defect);
  std::vector<LinePoint> line = line_of(without_repeated_end(given));
  axes_ = axes_of(line);
  std::vector<Eigen::Vector2d> plane;
  plane.reserve(line.size());
  for (const LinePoint& p : line) plane.push_back(in_plane(axes_, direction_of(p.at)));
  if (doubled_area(plane) < 0) {
    std::ranges::reverse(line);
    std::ranges::reverse(plane);
  }
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Eigen::Vector3d from = direction_of(line[i].at);
    const Eigen::Vector3d to = direction_of(line[(i + 1) % line.size()].at);
    const Eigen::Vector3d normal = from.cross(to).normalized();
    pieces_.push_back({.from = from,
                       .normal = normal,
                       .after_from = normal.cross(from),
                       .before_to = to.cross(normal),
                       .at = plane[i]});
    outline_.push_back(on_ground(line[i].at));
  }
}

bool GroundPolygon::contains(const GroundPoint& p) const {
  const Eigen::Vector3d u = direction_of(p);
  if (!(axes_.row(2).dot(u) > 0)) return false;  // the other half of the Earth
  const Eigen::Vector2d q = in_plane(axes_, u);
  bool inside = false;
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const Eigen::Vector2d& a = pieces_[i].at;
    const Eigen::Vector2d& b = pieces_[i + 1 == pieces_.size() ? 0 : i + 1].at;
    if ((a.y() > q.y()) != (b.y() > q.y()) && q.x() < a.x() + (q.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()))
      inside = !inside;
  }
  return inside;
}

double GroundPolygon::signed_distance_m(const GroundPoint& p) const {
  const Eigen::Vector3d u = direction_of(p);
  double least = std::numeric_limits<double>::infinity();  // square of the chord
  Eigen::Vector3d nearest = u;
  const auto consider = [&](const Eigen::Vector3d& v) {
    const double chord2 = (v - u).squaredNorm();
    if (chord2 < least) {
      least = chord2;
      nearest = v;
    }
  };
  for (const Piece& piece : pieces_) {
    const double off = piece.normal.dot(u);
    if (off * off >= least) continue;
    const Eigen::Vector3d foot = u - off * piece.normal;
    if (piece.after_from.dot(foot) > 0 && piece.before_to.dot(foot) > 0) {
      consider(foot.normalized());
    } else {
      consider(piece.from);  // its end is the next one's begin
    }
  }
  const double distance = geodesic_m(p, ground_of(nearest));
  return contains(p) ? distance : -distance;
}

std::optional<double> GroundPolygon::distance_ahead_m(const GroundPoint& p, double azimuth_rad) const {
  const Position<Ecef> here = on_ground(p);
  const Rotation<Enu, Ecef> R_enu_ecef = enu_from_ecef_at({p.latitude_rad, p.longitude_rad, 0});
  const Eigen::Vector3d ahead =
      R_enu_ecef.R.transpose() * Eigen::Vector3d(std::sin(azimuth_rad), std::cos(azimuth_rad), 0);
  const Eigen::Vector3d u = here.m.normalized();
  double least = std::numeric_limits<double>::infinity();
  for (const Piece& piece : pieces_) {
    const double way = -piece.normal.dot(u) / piece.normal.dot(ahead);
    if (!(way >= 0 && way < least)) continue;
    const Eigen::Vector3d met = u + way * ahead;
    if (piece.after_from.dot(met) >= 0 && piece.before_to.dot(met) >= 0) least = way;
  }
  if (!std::isfinite(least)) return std::nullopt;
  return geodesic_m(p, ground_of(u + least * ahead));
}

}  // namespace downrange
