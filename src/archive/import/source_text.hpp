#pragma once
/// A text file as lines of UTF-8, whatever its encoding and its line ends.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace downrange::archive {

struct SourceText {
  std::string text;             ///< UTF-8, without byte order mark
  std::string encoding;         ///< where it was not UTF-8: what it was
  std::uint64_t end_zeros = 0;  ///< bytes of zero left off at its end
};

/// UTF-8 with or without a byte order mark; UTF-16 and UTF-32 with one, or without where the zero bytes show it; else
/// Latin-1. A few zero bytes stay in the text. Throws ImportError (reason only) for what is no text: compressed files,
/// spreadsheets, many zero bytes.
[[nodiscard]] SourceText decode_text(std::string bytes);

/// Reads and decodes. Throws ImportError with the file's name.
[[nodiscard]] SourceText read_source(const std::filesystem::path& file);

/// Lines that end with LF, CR LF or CR, in any mixture. The text outlives it.
class LineReader {
 public:
  explicit LineReader(std::string_view text) : text_(text) {}

  /// The next line without its end; nothing after the last. A line end at the end of the text starts no line.
  [[nodiscard]] std::optional<std::string_view> next();
  /// Of the line that next() gave, from 1.
  [[nodiscard]] std::uint64_t line() const { return line_; }
  /// Behind the line that next() gave.
  [[nodiscard]] std::size_t offset() const { return at_; }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
  std::uint64_t line_ = 0;
};

}  // namespace downrange::archive
