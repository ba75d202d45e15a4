#pragma once
/// Numbers in sentences.

#include <array>
#include <cmath>
#include <cstdint>
#include <downrange/geo/name.hpp>

namespace downrange {

/// "0.250"; with `sign` "+0.250". Up to 1e9, else "?". Allocates nothing.
[[nodiscard]] inline Name decimal(double value, int decimals, bool sign = false) {
  if (!(std::abs(value) < 1e9) || decimals < 0 || decimals > 6) return "?";
  auto digits = std::llround(std::abs(value) * std::pow(10.0, decimals));
  std::array<char, Name::max_size> text{};
  std::size_t at = text.size();
  const auto put = [&](char c) { text[--at] = c; };
  for (int i = 0; digits > 0 || i <= decimals; ++i, digits /= 10) {
    if (i == decimals && decimals > 0) put('.');
    put(static_cast<char>('0' + digits % 10));
  }
  if (value < 0) {
    put('-');
  } else if (sign) {
    put('+');
  }
  return {std::string_view(text.data() + at, text.size() - at)};
}

}  // namespace downrange
