#pragma once
/// Times as text: dates, times of day, countdowns.

#include <cstdint>
#include <downrange/geo/time.hpp>
#include <optional>
#include <string_view>

namespace downrange::archive {

/// What a text says by its shape alone.
enum class ClockShape : std::uint8_t {
  Instant,    ///< a date and a time of day
  DayOfYear,  ///< day, hours, minutes, seconds without the year: 063:05:00:10
  Hours,      ///< hours:minutes:seconds: a time of day, or a span
  Countdown,  ///< T+00:01:02.5, T-10: from lift-off
};

struct ClockTime {
  ClockShape shape = ClockShape::Instant;
  std::int64_t ns = 0;  ///< since 1970, 1 January, midnight or lift-off, on the scale of the text
  bool zoned = false;   ///< Instant: the text says its offset from UTC, which is taken off
};

/// Dates as year-month-day, year/month/day, year-day of year or 20250304T050010, ISO 8601 with T or a blank before the
/// time of day; Z, UTC, GMT or an offset behind it; fractions behind a point or a comma. Nothing for other text, plain
/// numbers among it, and for dates that do not exist.
[[nodiscard]] std::optional<ClockTime> parse_clock(std::string_view text);

/// "2025-03-04T05:00:10.050Z".
[[nodiscard]] std::string show_utc(Time time);

}  // namespace downrange::archive
