#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <downrange/geo/earth.hpp>
#include <downrange/geo/refraction.hpp>
#include <numbers>

namespace downrange {
namespace {

constexpr double deg = std::numbers::pi / 180;

// ---- The ray -------------------------------------------------------------------------------------------------------

/// A point of a ray in the vertical plane through site and target: x along the site's horizontal, y up. The parameter
/// tau runs so that d position / d tau = p, |p| = n, d path / d tau = n^2.
struct RayPoint {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  Eigen::Vector2d p = Eigen::Vector2d::Zero();
  double path_m = 0;  ///< radio path from the site, the integral of n ds
};

/// No ground lies deeper than this under a site: further down the law would soon trap a ray that points there.
constexpr double deepest_m = -2500;

/// Above this many scale heights n - 1 is below 1e-14: the ray is straight.
constexpr double empty_space = 24;

class Ray {
 public:
  Ray(const Atmosphere& atmosphere, double elevation_rad) : atmosphere_(atmosphere) {
    point_.p = (1 + excess(0)) * Eigen::Vector2d(std::cos(elevation_rad), std::sin(elevation_rad));
  }

  /// Follows the ray until `missing` (of a point, in m) is zero; it falls by about one metre per metre of the ray.
  template <class Missing>
  const RayPoint& run(Missing missing) {
    constexpr double close_m = 1e-7;
    for (double left = missing(point_); std::abs(left) > close_m; left = missing(point_)) {
      const double step = longest_step();
      if (step < left) {
        advance(step);
      } else {
        advance(left);
      }
    }
    return point_;
  }

 private:
  [[nodiscard]] double excess(double height_m) const {
    return 1e-6 * atmosphere_.refractivity * std::exp(-std::max(height_m, deepest_m) / atmosphere_.scale_height_m);
  }
  [[nodiscard]] Eigen::Vector2d from_centre(const Eigen::Vector2d& position) const {
    return {position.x(), position.y() + atmosphere_.radius_m};
  }

  /// A fifth of a scale height, or 20 km where the ray runs level.
  [[nodiscard]] double longest_step() const {
    const Eigen::Vector2d r = from_centre(point_.position);
    const double radius = r.norm();
    const double climb = point_.p.dot(r) / radius;
    if (climb > 0 && radius - atmosphere_.radius_m > empty_space * atmosphere_.scale_height_m) return 1e8;
    constexpr double level_step_m = 20e3;
    return std::min(level_step_m, atmosphere_.scale_height_m / 5 / std::max(std::abs(climb), 1e-3));
  }

  [[nodiscard]] RayPoint rate(const RayPoint& at) const {
    const Eigen::Vector2d r = from_centre(at.position);
    const double radius = r.norm();
    const double height = radius - atmosphere_.radius_m;
    const double delta = excess(height);
    const double n = 1 + delta;
    const double slope = height > deepest_m ? -delta / atmosphere_.scale_height_m : 0;
    // grad(n^2 / 2) = n n' r / |r|
    return {at.p, r * (n * slope / radius), n * n};
  }

  void advance(double tau) {
    const auto moved = [this](const RayPoint& k, double h) {
      return RayPoint{point_.position + h * k.position, point_.p + h * k.p, point_.path_m + h * k.path_m};
    };
    const RayPoint k1 = rate(point_);
    const RayPoint k2 = rate(moved(k1, tau / 2));
    const RayPoint k3 = rate(moved(k2, tau / 2));
    const RayPoint k4 = rate(moved(k3, tau));
    point_ = {point_.position + tau / 6 * (k1.position + 2 * k2.position + 2 * k3.position + k4.position),
              point_.p + tau / 6 * (k1.p + 2 * k2.p + 2 * k3.p + k4.p),
              point_.path_m + tau / 6 * (k1.path_m + 2 * k2.path_m + 2 * k3.path_m + k4.path_m)};
    // |p| = n holds along the ray; what the integration loses of it would grow with the way through empty space.
    const double height = from_centre(point_.position).norm() - atmosphere_.radius_m;
    point_.p *= (1 + excess(height)) / point_.p.norm();
  }

  Atmosphere atmosphere_;
  RayPoint point_;
};

double elevation_of(const RayPoint& point) { return std::atan2(point.position.y(), point.position.x()); }

/// The point at a true range on the ray that leaves the site at an apparent elevation.
RayPoint at_true_range(const Atmosphere& atmosphere, double apparent_rad, double range_m) {
  return Ray(atmosphere, apparent_rad).run([range_m](const RayPoint& at) { return range_m - at.position.norm(); });
}

/// The ray that meets the target: the secant method on its apparent elevation, from a guess of the bending.
Refraction search_ray(const Atmosphere& atmosphere, double range_m, double elevation_rad, double bending_rad) {
  if (atmosphere.refractivity == 0 || range_m <= 0) return {};
  double apparent = elevation_rad + bending_rad;
  RayPoint end = at_true_range(atmosphere, apparent, range_m);
  double miss = elevation_of(end) - elevation_rad;
  double slope = 1;  // of the true elevation over the apparent one
  constexpr double met_rad = 1e-14;
  constexpr int most = 60;
  for (int i = 0; i < most && std::abs(miss) > met_rad; ++i) {
    const double next = apparent - miss / slope;
    if (next == apparent) break;
    end = at_true_range(atmosphere, next, range_m);
    const double next_miss = elevation_of(end) - elevation_rad;
    const double secant = (next_miss - miss) / (next - apparent);
    // Near the end rounding makes the secant meaningless; the last good one still converges.
    if (secant > 0.05 && secant < 5) slope = secant;
    apparent = next;
    miss = next_miss;
  }
  return {end.path_m - range_m, apparent - elevation_rad};
}

// ---- The table -----------------------------------------------------------------------------------------------------

// The error in elevation over cos(elevation) and the error in range are smooth functions of u = ln(sin(elevation) + s)
// (the zenith is a point like any other; fine near the horizon) and v = ln(1 + range / d) (linear near the site,
// logarithmic afar).
constexpr double elevation_floor_rad = -1.5 * deg;
constexpr double sine_shift = 0.05;
constexpr double range_shift_m = 10e3;
constexpr double range_ceiling_m = 6e6;
constexpr int rows = 48;     // of elevation
constexpr int columns = 40;  // of range

double row_coordinate(double sine) { return std::log(sine + sine_shift); }
double column_coordinate(double range_m) { return std::log(1 + range_m / range_shift_m); }

struct Axis {
  double first;
  double step;
};
Axis row_axis() {
  static const double low = row_coordinate(std::sin(elevation_floor_rad));
  static const Axis axis{low, (row_coordinate(1) - low) / (rows - 1)};
  return axis;
}
Axis column_axis() {
  static const Axis axis{0, column_coordinate(range_ceiling_m) / (columns - 1)};
  return axis;
}

/// Derivative per node distance at node i of n equidistant values, five points, error of order 4.
template <class ValueAt>
double five_point_derivative(int i, int n, ValueAt value) {
  static constexpr std::array<std::array<double, 5>, 5> weight{
      {{-25, 48, -36, 16, -3}, {-3, -10, 18, -6, 1}, {1, -8, 0, 8, -1}, {-1, 6, -18, 10, 3}, {3, -16, 36, -48, 25}}};
  const int first = std::clamp(i - 2, 0, n - 5);
  double sum = 0;
  for (int k = 0; k < 5; ++k)
    sum += weight[static_cast<std::size_t>(i - first)][static_cast<std::size_t>(k)] * value(first + k);
  return sum / 12;
}

/// Cubic Hermite weights of a cell and their derivatives, at a fraction of it: of the value at both ends, then of the
/// derivative at both ends.
struct Hermite {
  std::array<double, 4> weight;
  std::array<double, 4> slope;
};
Hermite hermite(double t) {
  const double t2 = t * t;
  const double t3 = t2 * t;
  return {{1 - 3 * t2 + 2 * t3, 3 * t2 - 2 * t3, t - 2 * t2 + t3, t3 - t2},
          {6 * (t2 - t), 6 * (t - t2), 1 - 4 * t + 3 * t2, 3 * t2 - 2 * t}};
}

/// Cell and fraction of a coordinate.
struct Place {
  int cell;
  double fraction;
};
Place place(double coordinate, const Axis& axis, int n) {
  const double position = std::clamp((coordinate - axis.first) / axis.step, 0.0, n - 1.0);
  const int cell = std::min(static_cast<int>(position), n - 2);
  return {cell, position - cell};
}

}  // namespace

Atmosphere atmosphere_over(const Geodetic& site, double refractivity) {
  constexpr double e2 = wgs84::flattening * (2 - wgs84::flattening);
  const double sine = std::sin(site.latitude_rad);
  // sqrt(M N), M = a (1 - e^2) / W^3, N = a / W, W^2 = 1 - e^2 sin^2(latitude)
  const double gaussian = wgs84::semi_major_axis_m * std::sqrt(1 - e2) / (1 - e2 * sine * sine);
  return {.refractivity = refractivity, .radius_m = gaussian + site.height_m};
}

Refraction refraction_at_true(const Atmosphere& atmosphere, double range_m, double elevation_rad) {
  return search_ray(atmosphere, range_m, elevation_rad, 0);
}

Refraction refraction_at_measured(const Atmosphere& atmosphere, double range_m, double elevation_rad) {
  if (atmosphere.refractivity == 0 || range_m <= 0) return {};
  const RayPoint end =
      Ray(atmosphere, elevation_rad).run([range_m](const RayPoint& at) { return range_m - at.path_m; });
  return {range_m - end.position.norm(), elevation_rad - elevation_of(end)};
}

RefractionTable::RefractionTable(const Atmosphere& atmosphere) {
  if (atmosphere.refractivity == 0) return;
  nodes_.resize(static_cast<std::size_t>(rows * columns));
  const auto node = [this](int row, int column) -> Node& {
    return nodes_[static_cast<std::size_t>(row * columns + column)];
  };
  const Axis u = row_axis();
  const Axis v = column_axis();
  for (int row = 0; row < rows; ++row) {
    const double sine = std::min(std::exp(u.first + row * u.step) - sine_shift, 1.0);
    const double cosine = std::sqrt(1 - sine * sine);
    // At the zenith the error in elevation over cos(elevation) is taken where the cosine is small, not zero.
    const double elevation = std::min(std::asin(sine), 90 * deg - 1e-4);
    double bending = 0;
    for (int column = 0; column < columns; ++column) {
      const double range = range_shift_m * std::expm1(v.first + column * v.step);
      const Refraction r = search_ray(atmosphere, range, elevation, bending);
      bending = r.elevation_rad;
      node(row, column).range[0] = r.range_m;
      node(row, column).elevation[0] = r.elevation_rad / std::max(cosine, std::cos(elevation));
    }
  }
  for (auto member : {&Node::range, &Node::elevation}) {
    const auto entry = [&](int row, int column, std::size_t k) -> double& { return (node(row, column).*member)[k]; };
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; ++column) {
        entry(row, column, 1) = five_point_derivative(row, rows, [&](int i) { return entry(i, column, 0); });
        entry(row, column, 2) = five_point_derivative(column, columns, [&](int i) { return entry(row, i, 0); });
      }
    }
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; ++column)
        entry(row, column, 3) = five_point_derivative(row, rows, [&](int i) { return entry(i, column, 2); });
    }
  }
}

RefractionTable::Value RefractionTable::at_true(double range_m, double elevation_rad) const {
  if (nodes_.empty()) return {};
  const double floored = std::max(elevation_rad, elevation_floor_rad);
  const double sine = std::sin(floored);
  const double cosine = std::cos(floored);
  const double range = std::clamp(range_m, 0.0, range_ceiling_m);
  const Axis u = row_axis();
  const Axis v = column_axis();
  const Place row = place(row_coordinate(sine), u, rows);
  const Place column = place(column_coordinate(range), v, columns);
  const Hermite a = hermite(row.fraction);
  const Hermite b = hermite(column.fraction);

  struct Sum {
    double value = 0;
    double d_row = 0;
    double d_column = 0;
  };
  Sum range_error;
  Sum elevation_error;
  const auto add = [&](Sum& sum, const std::array<double, 4>& f, std::size_t i, std::size_t j) {
    const double across = f[0] * b.weight[j] + f[2] * b.weight[2 + j];
    const double across_rise = f[1] * b.weight[j] + f[3] * b.weight[2 + j];
    sum.value += a.weight[i] * across + a.weight[2 + i] * across_rise;
    sum.d_row += a.slope[i] * across + a.slope[2 + i] * across_rise;
    sum.d_column += a.weight[i] * (f[0] * b.slope[j] + f[2] * b.slope[2 + j]) +
                    a.weight[2 + i] * (f[1] * b.slope[j] + f[3] * b.slope[2 + j]);
  };
  for (std::size_t i = 0; i < 2; ++i) {
    for (std::size_t j = 0; j < 2; ++j) {
      const Node& n =
          nodes_[(static_cast<std::size_t>(row.cell) + i) * columns + static_cast<std::size_t>(column.cell) + j];
      add(range_error, n.range, i, j);
      add(elevation_error, n.elevation, i, j);
    }
  }

  const double du = elevation_rad < elevation_floor_rad ? 0 : cosine / (sine + sine_shift) / u.step;
  const double dv = range_m < 0 || range_m > range_ceiling_m ? 0 : 1 / (range + range_shift_m) / v.step;
  const double turn = elevation_rad < elevation_floor_rad ? 0 : -elevation_error.value * sine;
  return {.refraction = {range_error.value, elevation_error.value * cosine},
          .d_range = {range_error.d_column * dv, elevation_error.d_column * dv * cosine},
          .d_elevation = {range_error.d_row * du, elevation_error.d_row * du * cosine + turn}};
}

Refraction RefractionTable::at_measured(double range_m, double elevation_rad) const {
  if (nodes_.empty()) return {};
  // Newton's method on true + refraction(true) = measured.
  double range = range_m;
  double elevation = elevation_rad;
  constexpr int most = 8;
  for (int i = 0; i < most; ++i) {
    const Value at = at_true(range, elevation);
    const double range_left = range_m - range - at.refraction.range_m;
    const double elevation_left = elevation_rad - elevation - at.refraction.elevation_rad;
    if (std::abs(range_left) < 1e-6 && std::abs(elevation_left) < 1e-13) break;
    const double a = 1 + at.d_range.range_m;
    const double b = at.d_elevation.range_m;
    const double c = at.d_range.elevation_rad;
    const double d = 1 + at.d_elevation.elevation_rad;
    const double determinant = a * d - b * c;
    range += (d * range_left - b * elevation_left) / determinant;
    elevation += (a * elevation_left - c * range_left) / determinant;
  }
  return {range_m - range, elevation_rad - elevation};
}

}  // namespace downrange
