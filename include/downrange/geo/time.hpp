#pragma once
/// One time type for the whole project: signed nanoseconds, so that sums and comparisons are exact.

#include <compare>
#include <cstdint>

namespace downrange {

/// A span of time. Positive: later minus earlier.
struct Duration {
  std::int64_t ns = 0;

  constexpr auto operator<=>(const Duration&) const = default;
  [[nodiscard]] constexpr double seconds() const { return static_cast<double>(ns) * 1e-9; }
};

/// An instant on the UTC (POSIX) scale: nanoseconds since 1970-01-01T00:00:00Z, leap seconds not counted.
struct Time {
  std::int64_t ns = 0;

  constexpr auto operator<=>(const Time&) const = default;
};

/// Nearest nanosecond to `s` seconds. Finite |s| < 9.2e9 s; anything else is the caller's bug.
[[nodiscard]] constexpr Duration seconds(double s) {
  return {static_cast<std::int64_t>(s * 1e9 + (s < 0 ? -0.5 : 0.5))};
}
[[nodiscard]] constexpr Duration milliseconds(std::int64_t ms) { return {ms * 1'000'000}; }

constexpr Duration operator-(Time a, Time b) { return {a.ns - b.ns}; }
constexpr Time operator+(Time a, Duration d) { return {a.ns + d.ns}; }
constexpr Time operator-(Time a, Duration d) { return {a.ns - d.ns}; }
constexpr Duration operator+(Duration a, Duration b) { return {a.ns + b.ns}; }
constexpr Duration operator-(Duration a, Duration b) { return {a.ns - b.ns}; }
constexpr Duration operator-(Duration a) { return {-a.ns}; }

/// 1970 to 2100: what a measurement's time can be; sums and differences of such times do not overflow.
[[nodiscard]] constexpr bool plausible(Time t) { return t.ns >= 0 && t.ns < 4'102'444'800'000'000'000; }

/// First instant of the UTC-aligned grid of spacing `step` that is at or after `t`. `step` > 0.
[[nodiscard]] constexpr Time ceil_to_grid(Time t, Duration step) {
  const std::int64_t remainder = t.ns % step.ns;
  if (remainder == 0) return t;
  return {t.ns - remainder + (remainder > 0 ? step.ns : 0)};
}

/// UTC of a GPS week and time of week: epoch 1980-01-06, less the leap seconds inserted since (18 since 2017).
[[nodiscard]] constexpr Time utc_from_gps(std::int64_t week, double time_of_week_s, int leap_seconds) {
  constexpr std::int64_t gps_epoch_s = 315'964'800;
  return Time{(gps_epoch_s + week * 604'800 - leap_seconds) * 1'000'000'000} + seconds(time_of_week_s);
}

}  // namespace downrange
