#pragma once
/// What an antenna's axes can reach.

#include <cstdint>
#include <downrange/stage/range_config.hpp>
#include <optional>
#include <vector>

#include "stage/slave/look.hpp"

namespace downrange {

/// The azimuth stays at the end of its travel while the target is no farther beyond: a target that hovers there does
/// not send the antenna around and around.
inline constexpr double wrap_hysteresis_rad = 1 * std::numbers::pi / 180;

/// Azimuth `wrapped` (any turn) brought into the antenna's travel.
struct TravelAzimuth {
  double azimuth_rad = 0;
  std::uint8_t limits = 0;  ///< SlavingLimit
};
/// The turn nearest to `previous` (to the middle of the travel when there is none) that lies inside [min, max]; an end,
/// with LimitAzimuth, while the target is up to `wrap_hysteresis_rad` beyond it; farther, another turn, flagged
/// LimitUnwrapped. Where no turn lies inside: the nearer end, and that of `previous` while the other one is not nearer
/// by twice the hysteresis.
[[nodiscard]] TravelAzimuth unwrap_into_travel(double wrapped_rad, std::optional<double> previous_rad, double min_rad,
                                               double max_rad);

/// The lowest elevation that an antenna is pointed at, by azimuth.
class Horizon {
 public:
  Horizon(double elevation_min_rad, std::vector<HorizonPoint> points);
  [[nodiscard]] double at(double azimuth_rad) const;

 private:
  double elevation_min_rad_;
  std::vector<HorizonPoint> points_;  ///< ascending azimuth in [0, 2 pi)
};

/// Both axes of a command.
struct Axes {
  AxisMotion azimuth;    ///< unwrapped
  AxisMotion elevation;  ///< beyond 90 deg: over the zenith
  std::uint8_t limits = 0;
};

/// The same direction with both axes over the zenith.
[[nodiscard]] Axes over_the_zenith(const Axes& axes);

/// Holds the elevation inside its travel and above the horizon; a held axis moves as the horizon does, else stands.
void hold_elevation(Axes& axes, const Horizon& horizon, double elevation_max_rad);

}  // namespace downrange
