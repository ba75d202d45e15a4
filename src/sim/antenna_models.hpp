#pragma once
/// What antennas tell of themselves: where a moving one is, and in which mode each is.

#include <cstdint>
#include <downrange/stage/event.hpp>
#include <vector>

#include "sim/scenario.hpp"

namespace downrange::sim {

/// Where the platform truly is, and its heading, seconds after lift-off.
struct PlatformTruth {
  Geodetic place;
  double course_rad = 0;
  double heading_rad = 0;
};
[[nodiscard]] PlatformTruth platform_at(const PlatformScenario& platform, double t_s);

[[nodiscard]] std::vector<PlatformState> simulate_platform(const PlatformScenario& platform, const Scenario& scenario,
                                                           std::uint64_t seed);
[[nodiscard]] std::vector<AntennaReport> simulate_antenna(const AntennaScenario& antenna, const Scenario& scenario);

}  // namespace downrange::sim
