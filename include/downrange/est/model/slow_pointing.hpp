#pragma once
/// A mount's pointing errs slowly. Methods that have states for it (joint, schmidt) use them; others take it for noise.

#include <downrange/est/model/sensors.hpp>
#include <vector>

namespace downrange {

/// The radars as a method with states of wander sees them: one whose angles are inflated and whose `wander` nobody has
/// configured has one of half its instrument's noise over 100 s. Its noise stays inflated, for what is faster.
[[nodiscard]] std::vector<RadarModel> with_wander_as_states(std::vector<RadarModel> radars);

}  // namespace downrange
