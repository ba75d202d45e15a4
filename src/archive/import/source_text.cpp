#include <algorithm>
#include <archive/import/import_error.hpp>
#include <archive/import/source_text.hpp>
#include <text/file.hpp>
#include <text/utf8.hpp>

namespace downrange::archive {
namespace {

/// Rows are held in memory, each in some five times its text.
constexpr std::uint64_t max_source_size = 1'000'000'000;

/// How much of a text tells whether every other byte is zero.
constexpr std::size_t sample_size = 2000;

bool starts_with(std::string_view bytes, std::string_view mark) { return bytes.substr(0, mark.size()) == mark; }

std::string from_utf16(std::string_view bytes, bool big_endian) {
  if (bytes.size() % 2 != 0) throw ImportError("is cut off within a character of UTF-16");
  const auto unit = [&](std::size_t at) {
    const auto first = static_cast<unsigned char>(bytes[at]);
    const auto second = static_cast<unsigned char>(bytes[at + 1]);
    return static_cast<char32_t>(big_endian ? (first << 8) | second : (second << 8) | first);
  };
  std::string text;
  text.reserve(bytes.size() / 2);
  for (std::size_t at = 0; at < bytes.size(); at += 2) {
    char32_t c = unit(at);
    const bool high = c >= 0xD800 && c < 0xDC00;
    if (high && at + 2 < bytes.size() && unit(at + 2) >= 0xDC00 && unit(at + 2) < 0xE000) {
      c = 0x10000 + ((c - 0xD800) << 10) + (unit(at + 2) - 0xDC00);
      at += 2;
    } else if (c >= 0xD800 && c < 0xE000) {
      c = 0xFFFD;  // half a character: the sign for what cannot be read
    }
    text::append_utf8(text, c);
  }
  return text;
}

std::string from_latin1(std::string_view bytes) {
  std::string text;
  text.reserve(bytes.size());
  for (const char c : bytes) text::append_utf8(text, static_cast<unsigned char>(c));
  return text;
}

bool is_utf8(std::string_view bytes) {
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t size = text::utf8_size(bytes.substr(at, 4));
    if (size == 0) return false;
    at += size;
  }
  return true;
}

enum class Zeros { None, Even, Odd, Mixed };

/// Where the zero bytes of the text's first part are.
Zeros zeros_of(std::string_view bytes) {
  std::size_t even = 0;
  std::size_t odd = 0;
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    if (bytes[at] == '\0') ++(at % 2 == 0 ? even : odd);
  }
  if (even + odd == 0) return Zeros::None;
  // All of ASCII: one zero in each pair of bytes. A few other characters do not change which.
  const std::size_t most = bytes.size() / 2 * 9 / 10;
  if (odd == 0 && even >= most) return Zeros::Even;
  if (even == 0 && odd >= most) return Zeros::Odd;
  return Zeros::Mixed;
}

[[noreturn]] void refuse_zeros(std::string_view bytes) {
  const auto end = bytes.begin() + static_cast<std::ptrdiff_t>(bytes.find('\0'));
  const auto line = 1 + std::count(bytes.begin(), end, '\n');
  throw ImportError("holds zero bytes (the first on line " + std::to_string(line) + "): it is no text");
}

}  // namespace

SourceText decode_text(std::string bytes) {
  using namespace std::string_literals;
  const auto without = [&](std::size_t mark) { return std::string_view(bytes).substr(mark); };
  if (starts_with(bytes, "PK\x03\x04")) {
    throw ImportError("is a ZIP file (a spreadsheet's .xlsx or .ods is one): export it as CSV, or unpack it");
  }
  if (starts_with(bytes, "\x1F\x8B")) throw ImportError("is compressed by gzip: unpack it first");
  if (starts_with(bytes, "\xFF\xFE\0\0"s) || starts_with(bytes, "\0\0\xFE\xFF"s)) {
    throw ImportError("is text in UTF-32: save it as UTF-8");
  }
  if (starts_with(bytes, "\xFF\xFE")) return {from_utf16(without(2), false), "UTF-16 (little-endian)"};
  if (starts_with(bytes, "\xFE\xFF")) return {from_utf16(without(2), true), "UTF-16 (big-endian)"};
  switch (zeros_of(std::string_view(bytes).substr(0, sample_size))) {
    case Zeros::Even:
      return {from_utf16(bytes, true), "UTF-16 (big-endian, without a mark)"};
    case Zeros::Odd:
      return {from_utf16(bytes, false), "UTF-16 (little-endian, without a mark)"};
    case Zeros::None:
    case Zeros::Mixed:
      break;
  }
  if (bytes.find('\0') != std::string::npos) refuse_zeros(bytes);
  if (starts_with(bytes, "\xEF\xBB\xBF")) bytes.erase(0, 3);
  if (!is_utf8(bytes)) return {from_latin1(bytes), "Latin-1"};
  return {std::move(bytes), ""};
}

SourceText read_source(const std::filesystem::path& file) {
  try {
    return decode_text(text::read_file(file, max_source_size));
  } catch (const text::FileError& error) {
    throw ImportError(file.string() + ": cannot open the file: " + error.what());
  } catch (const ImportError& error) {
    throw ImportError(file.string() + ": " + error.what());
  }
}

std::optional<std::string_view> LineReader::next() {
  constexpr char dos_end_of_file = '\x1A';
  if (at_ >= text_.size() || (text_[at_] == dos_end_of_file && at_ + 1 == text_.size())) return std::nullopt;
  ++line_;
  const std::size_t end = std::min(text_.find_first_of("\r\n", at_), text_.size());
  const std::string_view found = text_.substr(at_, end - at_);
  at_ = end + (text_.substr(end).starts_with("\r\n") ? 2 : 1);
  return found;
}

}  // namespace downrange::archive
