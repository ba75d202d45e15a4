#pragma once
/// Angles as degrees, minutes and seconds, and with a letter for their sign.

#include <archive/import/numbers.hpp>
#include <cstdint>
#include <optional>
#include <string_view>

namespace downrange::archive {

/// Which letters say the sign of an angle.
enum class AngleLetters : std::uint8_t {
  None,
  NorthSouth,  ///< S is negative
  EastWest,    ///< W is negative
};

/// Degrees of "12:34:56.7", "12 34 56.7", "12°34'56.7\"", "12d34m56.7s", "12:34.9", "120.5°", "34.43N", "W 127:30:00",
/// "-12:34:56". Minutes and seconds are below 60 (60 itself is what rounding makes of 59.99) and only the last part has
/// a fraction. Nothing for other text, plain numbers among it, and for a sign beside a letter.
[[nodiscard]] std::optional<double> parse_degrees(std::string_view text, DecimalMark mark, AngleLetters letters);

}  // namespace downrange::archive
