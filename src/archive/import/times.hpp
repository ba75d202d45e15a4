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
  bool zoned = false;   ///< the text says its offset from UTC, which is taken off
  bool halved = false;  ///< the text says AM or PM
};

/// How dates of three numbers are written that do not start with a year of four digits.
enum class DateOrder : std::uint8_t {
  YearFirst,   ///< others are no dates
  DayFirst,    ///< 04/03/2025, 4.3.2025
  MonthFirst,  ///< 03/04/2025
};

/// Dates as year-month-day, year/month/day, year.month.day, year-day of year, 20250304T050010 or with the name of the
/// month (4-Mar-2025, Mar 4, 2025); ISO 8601 with T or a blank before the time of day; Z, UTC, GMT, an offset, AM or PM
/// behind it; fractions behind a point or a comma. Nothing for other text, plain numbers among it, and for dates that
/// do not exist.
[[nodiscard]] std::optional<ClockTime> parse_clock(std::string_view text, DateOrder order = DateOrder::YearFirst);

/// "20250304050010.050", year to second as one number: no flight has so many seconds; nothing for other text.
[[nodiscard]] std::optional<ClockTime> compact_instant(std::string_view text);

/// "050010.05", hhmmss as one number, leading zeros left off or not, as "05:00:10.05"; nothing for other text.
[[nodiscard]] std::optional<std::string> unpacked_clock(std::string_view text);

/// "2025-03-04T05:00:10.050Z".
[[nodiscard]] std::string show_utc(Time time);

}  // namespace downrange::archive
