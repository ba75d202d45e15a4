#pragma once
/// What operators want of an antenna.

#include <optional>

#include "stage/followed.hpp"

namespace downrange {

struct AntennaWill {
  bool stopped = false;         ///< no commands
  std::optional<int> target{};  ///< in place of the configured one, by its place in the configuration
  /// What the antenna is pinned to, while that has something to follow; of the target that it follows.
  std::optional<Followed> pinned{};
  double azimuth_trim_rad = 0;  ///< added to its commands
  double elevation_trim_rad = 0;
  Remark orders{};  ///< in words, for its account
};

}  // namespace downrange
