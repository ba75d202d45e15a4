#include <algorithm>
#include <archive/import/import_error.hpp>
#include <archive/import/source_text.hpp>
#include <array>
#include <text/file.hpp>
#include <text/utf8.hpp>

namespace downrange::archive {
namespace {

/// Rows are held in memory, each in some five times its text.
constexpr std::uint64_t max_source_size = 1'000'000'000;

/// How much of a text tells how many bytes a character has.
constexpr std::size_t sample_size = 2000;

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

/// Four bytes a character.
std::string from_utf32(std::string_view bytes, bool big_endian) {
  if (bytes.size() % 4 != 0) throw ImportError("is cut off within a character of UTF-32");
  std::string text;
  text.reserve(bytes.size() / 4);
  for (std::size_t at = 0; at < bytes.size(); at += 4) {
    char32_t c = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      c = (c << 8) | static_cast<unsigned char>(bytes[at + (big_endian ? i : 3 - i)]);
    }
    text::append_utf8(text, c > 0x10FFFF || (c >= 0xD800 && c < 0xE000) ? char32_t{0xFFFD} : c);
  }
  return text;
}

/// How many bytes a character has, by where the zero bytes of the text's first part are: all of ASCII has one zero in
/// each pair of bytes, or three in each four. A few other characters do not change which.
struct UnitShape {
  std::size_t size = 1;
  bool big_endian = false;
};

UnitShape shape_of(std::string_view bytes) {
  std::array<std::size_t, 4> zeros{};
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    if (bytes[at] == '\0') ++zeros[at % 4];
  }
  const std::size_t most = bytes.size() / 4 * 9 / 10;
  if (bytes.size() < 4 || most == 0) return {};
  const auto full = [&](std::size_t i) { return zeros[i] >= most; };
  if (zeros[0] == 0 && full(1) && full(2) && full(3)) return {4, false};
  if (full(0) && full(1) && full(2) && zeros[3] == 0) return {4, true};
  if (zeros[0] + zeros[2] == 0 && full(1) && full(3)) return {2, false};
  if (full(0) && full(2) && zeros[1] + zeros[3] == 0) return {2, true};
  return {};
}

/// What else is handed over as a table, by its first bytes.
struct Foreign {
  std::string_view start;
  const char* what;
};
constexpr std::array<Foreign, 15> foreign{
    {{"PK\x03\x04", "is a ZIP file (a spreadsheet's .xlsx or .ods is one): export it as CSV, or unpack it"},
     {"\xD0\xCF\x11\xE0", "is a spreadsheet's .xls: export it as CSV"},
     {"\x1F\x8B", "is compressed by gzip: unpack it first"},
     {"BZh", "is compressed by bzip2: unpack it first"},
     {"\xFD\x37zXZ", "is compressed by xz: unpack it first"},
     {"\x28\xB5\x2F\xFD", "is compressed by zstd: unpack it first"},
     {"7z\xBC\xAF", "is a 7z archive: unpack it first"},
     {"%PDF-", "is a PDF"},
     {"<html", "is HTML: export it as CSV"},
     {"<!DOCTYPE", "is HTML: export it as CSV"},
     {"\x89MCAP", "is an archive already: replay it"},
     {"\x89HDF", "is an HDF5 file: export it as CSV"},
     {"\x84\x31\x95\x33", "is text in GB 18030: save it as UTF-8"},
     {"+/v8", "is text in UTF-7: save it as UTF-8"},
     {"\xDD\x73\x66\x73", "is text in UTF-EBCDIC: save it as UTF-8"}}};

[[noreturn]] void refuse_zeros(std::string_view bytes) {
  const auto end = bytes.begin() + static_cast<std::ptrdiff_t>(bytes.find('\0'));
  const auto line = 1 + std::count(bytes.begin(), end, '\n');
  throw ImportError("holds many zero bytes (the first on line " + std::to_string(line) + "): it is no text");
}

/// Zero bytes at the end are what a file system promised and a logger never wrote; a few elsewhere spoil their rows
/// only; many are no text.
SourceText from_bytes(std::string bytes) {
  const std::size_t end = bytes.find_last_not_of('\0');
  const std::uint64_t end_zeros = bytes.size() - (end == std::string::npos ? 0 : end + 1);
  bytes.resize(bytes.size() - end_zeros);
  const auto zeros = static_cast<std::size_t>(std::count(bytes.begin(), bytes.end(), '\0'));
  if (zeros > bytes.size() / 4) refuse_zeros(bytes);
  if (bytes.starts_with("\xEF\xBB\xBF")) bytes.erase(0, 3);
  if (!is_utf8(bytes)) return {from_latin1(bytes), "Latin-1", end_zeros};
  return {std::move(bytes), "", end_zeros};
}

}  // namespace

SourceText decode_text(std::string bytes) {
  using namespace std::string_literals;
  const auto without = [&](std::size_t mark) { return std::string_view(bytes).substr(mark); };
  for (const Foreign& known : foreign) {
    if (bytes.starts_with(known.start)) throw ImportError(known.what);
  }
  if (bytes.starts_with("\xFF\xFE\0\0"s)) return {from_utf32(without(4), false), "UTF-32 (little-endian)", 0};
  if (bytes.starts_with("\0\0\xFE\xFF"s)) return {from_utf32(without(4), true), "UTF-32 (big-endian)", 0};
  if (bytes.starts_with("\xFF\xFE")) return {from_utf16(without(2), false), "UTF-16 (little-endian)", 0};
  if (bytes.starts_with("\xFE\xFF")) return {from_utf16(without(2), true), "UTF-16 (big-endian)", 0};
  const UnitShape shape = shape_of(std::string_view(bytes).substr(0, sample_size));
  const char* order = shape.big_endian ? "big-endian, without a mark)" : "little-endian, without a mark)";
  if (shape.size == 4) return {from_utf32(bytes, shape.big_endian), std::string("UTF-32 (") + order, 0};
  if (shape.size == 2) return {from_utf16(bytes, shape.big_endian), std::string("UTF-16 (") + order, 0};
  return from_bytes(std::move(bytes));
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
