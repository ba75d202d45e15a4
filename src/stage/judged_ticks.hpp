#pragma once
/// Which ticks are for what is done less often than SLAVE points: judging the sources, telling where a target falls.

#include <downrange/geo/time.hpp>
#include <optional>

namespace downrange {

/// A multiple of `grid` lies in (last, now].
[[nodiscard]] constexpr bool crosses(std::optional<Time> last, Time now, Duration grid) {
  return !last || now.ns / grid.ns > last->ns / grid.ns;
}

/// Ten times a second, or with every tick where these are fewer.
[[nodiscard]] constexpr bool is_judged_tick(std::optional<Time> last, Time now) {
  return crosses(last, now, milliseconds(100));
}

}  // namespace downrange
