#pragma once
/// UTF-8, one character at a time.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace downrange::text {

/// Value of a character whose bytes utf8_size found well-formed.
[[nodiscard]] constexpr char32_t utf8_value(std::string_view bytes) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
  if (bytes.size() == 1) return byte(0);
  char32_t value = byte(0) & (0xFFU >> (bytes.size() + 1));
  for (std::size_t i = 1; i < bytes.size(); ++i) value = (value << 6) | (byte(i) & 0x3FU);
  return value;
}

/// Bytes of the character that `text` starts with; 0 when it starts with none (no UTF-8, or `text` is empty).
[[nodiscard]] constexpr std::size_t utf8_size(std::string_view text) {
  if (text.empty()) return 0;
  const auto lead = static_cast<unsigned char>(text[0]);
  std::size_t size = 1;
  if (lead >= 0x80) size = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead >= 0xF5 || (lead >= 0x80 && lead < 0xC2) || text.size() < size) return 0;
  for (std::size_t i = 1; i < size; ++i) {
    if ((static_cast<unsigned char>(text[i]) & 0xC0) != 0x80) return 0;
  }
  const char32_t value = utf8_value(text.substr(0, size));
  const bool too_long = (size == 3 && value < 0x800) || (size == 4 && (value < 0x10000 || value > 0x10FFFF));
  const bool surrogate = value >= 0xD800 && value < 0xE000;
  return too_long || surrogate ? 0 : size;
}

inline void append_utf8(std::string& out, char32_t c) {
  const auto put = [&](char32_t byte) { out += static_cast<char>(byte); };
  if (c < 0x80) return put(c);
  if (c < 0x800) {
    put(0xC0 | (c >> 6));
  } else {
    if (c < 0x10000) {
      put(0xE0 | (c >> 12));
    } else {
      put(0xF0 | (c >> 18));
      put(0x80 | ((c >> 12) & 0x3F));
    }
    put(0x80 | ((c >> 6) & 0x3F));
  }
  put(0x80 | (c & 0x3F));
}

}  // namespace downrange::text
