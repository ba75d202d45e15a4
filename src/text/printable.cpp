#include "text/printable.hpp"

#include "text/utf8.hpp"

namespace downrange::text {
namespace {

void append_escaped(std::string& out, std::string_view bytes) {
  constexpr std::string_view digits = "0123456789abcdef";
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    out += "\\x";
    out += digits[byte >> 4];
    out += digits[byte & 15];
  }
}

/// C0, DEL and C1 controls; marks that turn the direction of writing around, which hide what a name says.
bool obeyed(char32_t c) {
  return c < 0x20 || (c >= 0x7F && c < 0xA0) || (c >= 0x200E && c <= 0x200F) || (c >= 0x2028 && c <= 0x202E) ||
         (c >= 0x2066 && c <= 0x2069) || c == 0xFEFF;
}

}  // namespace

std::string printable(std::string_view text, bool lines, std::size_t max_size) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    if (out.size() >= max_size) return out + "...";
    const std::size_t size = utf8_size(text.substr(at));
    const std::string_view bytes = text.substr(at, size == 0 ? 1 : size);
    at += bytes.size();
    if (lines && (bytes == "\n" || bytes == "\t")) {
      out += bytes;
    } else if (size == 0 || obeyed(utf8_value(bytes))) {
      append_escaped(out, bytes);
    } else {
      out += bytes;
    }
  }
  return out;
}

std::string in_quotes(std::string_view text) { return '\'' + printable(text, false, 40) + '\''; }

}  // namespace downrange::text
