#include <algorithm>
#include <cmath>
#include <downrange/est/model/slow_pointing.hpp>

namespace downrange {
namespace {

/// Chosen on the recorded flights (THEORY.md, section 4a): of the instrument's own noise.
constexpr double share_of_sigma = 0.5;
constexpr double tau_s = 100;

}  // namespace

std::vector<RadarModel> with_wander_as_states(std::vector<RadarModel> radars) {
  for (RadarModel& radar : radars) {
    if (radar.wander.sigma_rad > 0 || radar.angle_inflation <= 1) continue;
    const double inflated = std::max(radar.sigma.azimuth_rad, radar.sigma.elevation_rad);
    radar.wander = {.sigma_rad = share_of_sigma * inflated / std::sqrt(radar.angle_inflation), .tau_s = tau_s};
  }
  return radars;
}

}  // namespace downrange
