#include "stage/slave/travel.hpp"

#include <algorithm>
#include <cmath>
#include <downrange/stage/result.hpp>
#include <numbers>
#include <utility>

namespace downrange {
namespace {

constexpr double turn = 2 * std::numbers::pi;

}  // namespace

TravelAzimuth unwrap_into_travel(double wrapped_rad, std::optional<double> previous_rad, double min_rad,
                                 double max_rad) {
  const double reference = previous_rad.value_or((min_rad + max_rad) / 2);
  const double nearest = wrapped_rad + turn * std::round((reference - wrapped_rad) / turn);
  if (nearest >= min_rad && nearest <= max_rad) return {nearest, LimitNone};
  const double end = std::clamp(nearest, min_rad, max_rad);
  if (previous_rad && std::abs(nearest - end) <= wrap_hysteresis_rad) return {end, LimitAzimuth};
  const double other = nearest < min_rad ? nearest + turn : nearest - turn;
  if (other >= min_rad && other <= max_rad) return {other, previous_rad ? LimitUnwrapped : LimitNone};
  // No turn lies inside: hold the end that is nearer to the target around the circle.
  const double to_min = std::abs(wrap_pi(wrapped_rad - min_rad));
  const double to_max = std::abs(wrap_pi(wrapped_rad - max_rad));
  double for_max = 0;
  if (previous_rad)
    for_max = *previous_rad > (min_rad + max_rad) / 2 ? 2 * wrap_hysteresis_rad : -2 * wrap_hysteresis_rad;
  return {to_min <= to_max - for_max ? min_rad : max_rad, LimitAzimuth};
}

Horizon::Horizon(double elevation_min_rad, std::vector<HorizonPoint> points)
    : elevation_min_rad_(elevation_min_rad), points_(std::move(points)) {}

double Horizon::at(double azimuth_rad) const {
  if (points_.empty()) return elevation_min_rad_;
  const double azimuth = wrap_two_pi(azimuth_rad);
  const auto next = std::ranges::find_if(points_, [&](const HorizonPoint& p) { return p.azimuth_rad > azimuth; });
  const HorizonPoint& b = next == points_.end() ? points_.front() : *next;
  const HorizonPoint& a = next == points_.begin() ? points_.back() : *(next - 1);
  const double width = wrap_two_pi(b.azimuth_rad - a.azimuth_rad);
  const double share = width > 0 ? wrap_two_pi(azimuth - a.azimuth_rad) / width : 0;
  return std::max(elevation_min_rad_, a.elevation_rad + share * (b.elevation_rad - a.elevation_rad));
}

Axes over_the_zenith(const Axes& axes) {
  Axes over = axes;
  over.azimuth.angle_rad += std::numbers::pi;
  over.elevation = {std::numbers::pi - axes.elevation.angle_rad, -axes.elevation.rate_rad_s,
                    -axes.elevation.acceleration_rad_s2};
  return over;
}

void hold_elevation(Axes& axes, const Horizon& horizon, double elevation_max_rad) {
  const double angle = axes.elevation.angle_rad;
  const bool over = angle > std::numbers::pi / 2;
  const auto lowest = [&](double azimuth) {
    const double least = horizon.at(over ? azimuth + std::numbers::pi : azimuth);
    return over ? std::numbers::pi - least : least;
  };
  const double limit = lowest(axes.azimuth.angle_rad);
  const bool below = over ? angle > std::min(limit, elevation_max_rad) : angle < limit;
  if (!below && angle <= elevation_max_rad) return;
  axes.limits |= LimitElevation;
  if (angle > elevation_max_rad && (!over || elevation_max_rad <= limit)) {
    axes.elevation = {.angle_rad = elevation_max_rad};
    return;
  }
  constexpr double h_s = 0.01;
  const double later = lowest(axes.azimuth.at(h_s));
  const double earlier = lowest(axes.azimuth.at(-h_s));
  axes.elevation = {.angle_rad = limit, .rate_rad_s = (later - earlier) / (2 * h_s)};
}

}  // namespace downrange
