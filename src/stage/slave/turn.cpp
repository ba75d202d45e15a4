#include "stage/slave/turn.hpp"

#include <cmath>
#include <numbers>

namespace downrange {
namespace {

constexpr double pi = std::numbers::pi;

double held_for(std::span<const PassPoint> pass, const AntennaConfig& antenna, double offset_rad, bool over) {
  for (const PassPoint& point : pass) {
    const double azimuth = point.azimuth_rad + offset_rad;
    const bool inside = azimuth >= antenna.azimuth_min_rad && azimuth <= antenna.azimuth_max_rad &&
                        (!over || pi - point.elevation_rad <= antenna.elevation_max_rad);
    if (!inside) return point.s - pass.front().s;
  }
  // To the end: longer than any that leaves the travel there.
  return pass.back().s - pass.front().s + PredictedPath::step_s;
}

}  // namespace

std::optional<Turn> choose_turn(std::span<const PassPoint> pass, const AntennaConfig& antenna,
                                std::optional<double> previous_rad) {
  if (pass.empty()) return std::nullopt;
  const double wanted = previous_rad.value_or((antenna.azimuth_min_rad + antenna.azimuth_max_rad) / 2);
  const double begin = pass.front().azimuth_rad;
  std::optional<Turn> best;
  const auto away = [&](const Turn& t) { return std::abs(begin + t.offset_rad - wanted); };
  for (const bool over : {false, true}) {
    if (over && antenna.elevation_max_rad <= pi / 2) continue;
    const double half = over ? pi : 0;
    const double first = std::ceil((antenna.azimuth_min_rad - begin - half) / (2 * pi));
    for (double turn = first; begin + half + 2 * pi * turn <= antenna.azimuth_max_rad; ++turn) {
      Turn candidate{.offset_rad = half + 2 * pi * turn, .over = over};
      candidate.holds_s = held_for(pass, antenna, candidate.offset_rad, over);
      if (candidate.holds_s <= 0) continue;
      const bool longer = best && candidate.holds_s > best->holds_s;
      const bool nearer =
          best && candidate.holds_s == best->holds_s && over == best->over && away(candidate) < away(*best);
      if (!best || longer || nearer) best = candidate;
    }
  }
  return best;
}

}  // namespace downrange
