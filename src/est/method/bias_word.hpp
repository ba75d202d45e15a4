#pragma once
/// Joint and schmidt hold each radar's bias once per target: whose word on a radar counts.

#include <cstddef>
#include <utility>

namespace downrange {

/// Of the targets that have `started`, one with GPS before one without, then the one that saw the radar last; null:
/// none.
template <class Targets, class Started>
[[nodiscard]] const typename Targets::value_type* best_informed(const Targets& targets, std::size_t radar,
                                                                Started started) {
  const typename Targets::value_type* best = nullptr;
  const auto rank = [radar](const auto& t) { return std::pair(!t.without_gps, t.radars[radar].epoch); };
  for (const auto& t : targets) {
    if (started(t) && (best == nullptr || rank(t) > rank(*best))) best = &t;
  }
  return best;
}

/// Has any radar but this one had plots accepted?
template <class Radars>
[[nodiscard]] bool others_contribute(const Radars& radars, std::size_t radar) {
  for (std::size_t other = 0; other < radars.size(); ++other) {
    if (other != radar && radars[other].samples > 0) return true;
  }
  return false;
}

}  // namespace downrange
