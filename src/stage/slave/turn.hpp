#pragma once
/// On which turn of the cable an antenna follows a pass, chosen ahead.

#include <downrange/stage/range_config.hpp>
#include <optional>
#include <span>

#include "stage/slave/pass.hpp"

namespace downrange {

/// Azimuth and elevation axis of a direction: azimuth + offset and elevation, or, over the zenith, pi - elevation. The
/// offset is a multiple of a turn, over the zenith of that and half a turn.
struct Turn {
  double offset_rad = 0;
  bool over = false;
  double holds_s = 0;  ///< how long the pass stays inside the travel; 0 where it does not begin inside
};

/// The turn that stays inside the antenna's travel for the longest part of the pass; of several that do so to its end:
/// not over the zenith, then the one nearest to `previous_rad`, without one to the middle of the travel. None: no turn
/// holds the pass's begin, or there is no pass. `pass`: as an antenna at that horizon sees it.
[[nodiscard]] std::optional<Turn> choose_turn(std::span<const PassPoint> pass, const AntennaConfig& antenna,
                                              std::optional<double> previous_rad);

}  // namespace downrange
