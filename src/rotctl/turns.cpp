#include "rotctl/turns.hpp"

#include <algorithm>
#include <cmath>

namespace downrange::rotctl {
namespace {

constexpr double full_turn = 2 * std::numbers::pi;
/// Of rounding degrees to text and back.
constexpr double rounding = 1e-9;

}  // namespace

double Turns::beyond(double azimuth_rad) const {
  return std::max({travel_.azimuth_min_rad - azimuth_rad, azimuth_rad - travel_.azimuth_max_rad, 0.0});
}

double Turns::turn_of(double azimuth_rad, std::optional<double> measured_azimuth_rad) const {
  if (turn_ && beyond(azimuth_rad + *turn_) <= hysteresis_rad) return *turn_;
  if (beyond(azimuth_rad) <= rounding) return 0;
  const double reference = last_azimuth_rad_.value_or(measured_azimuth_rad.value_or(0));
  // The least beyond the travel (0 where it has the direction), of these the nearest. A kept turn is left only for one
  // that is clearly less beyond.
  const double lowest = std::floor((travel_.azimuth_min_rad - azimuth_rad) / full_turn);
  const double highest = std::ceil((travel_.azimuth_max_rad - azimuth_rad) / full_turn);
  double best = turn_.value_or(lowest * full_turn);
  const auto cost = [&](double turn) {
    const double out = beyond(azimuth_rad + turn);
    const double kept = turn_ && out > 0 && turn == *turn_ ? 2 * hysteresis_rad : 0;
    return std::pair(out <= rounding ? 0.0 : 1 + out - kept, std::abs(azimuth_rad + turn - reference));
  };
  for (double k = lowest; k <= highest; ++k)
    if (cost(k * full_turn) < cost(best)) best = k * full_turn;
  return best;
}

Placed Turns::place(double azimuth_rad, double elevation_rad, std::optional<double> measured_azimuth_rad) {
  turn_ = turn_of(azimuth_rad, measured_azimuth_rad);
  const double wanted = azimuth_rad + *turn_;
  Placed placed;
  placed.turn_rad = *turn_;
  placed.azimuth_rad = std::clamp(wanted, travel_.azimuth_min_rad, travel_.azimuth_max_rad);
  placed.elevation_rad = std::clamp(elevation_rad, travel_.elevation_min_rad, travel_.elevation_max_rad);
  placed.held =
      std::abs(placed.azimuth_rad - wanted) > rounding || std::abs(placed.elevation_rad - elevation_rad) > rounding;
  last_azimuth_rad_ = placed.azimuth_rad;
  return placed;
}

}  // namespace downrange::rotctl
