#pragma once
/// Lines into fields: delimiters, blanks, quotes, comments.

#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace downrange::archive {

/// Without blanks of any kind (no-break ones too) at both ends.
[[nodiscard]] std::string_view trimmed(std::string_view text);

/// A character, or `blanks`: fields stand between runs of spaces and tabs.
using Delimiter = char;
inline constexpr Delimiter blanks = ' ';
/// "','", "tab", "blanks": as a mapping writes it.
[[nodiscard]] std::string show_delimiter(Delimiter delimiter);

/// What starts a comment line where a mapping does not say: # % // and, where it is not the delimiter, a semicolon.
[[nodiscard]] std::vector<std::string> usual_comments(Delimiter delimiter);

/// The line without its comment mark; nothing when it is no comment. A spreadsheet's error (#N/A, #DIV/0!) is none, and
/// a comment may stand in quotes.
[[nodiscard]] std::optional<std::string_view> comment_of(std::string_view line, const std::vector<std::string>& marks);

/// Splits line after line. A field may stand in double quotes, with the delimiter and line breaks in it and its own
/// quotes doubled; a quote anywhere else is a character like others, so that it spoils its own field only.
class RowSplitter {
 public:
  explicit RowSplitter(Delimiter delimiter) : delimiter_(delimiter) {}

  /// Without surrounding blanks and quotes; they live until the next split, and as long as the line.
  [[nodiscard]] const std::vector<std::string_view>& split(std::string_view line);
  /// Whether a quoted field began in the line that was split last and did not end there.
  [[nodiscard]] bool open() const { return open_; }
  /// A line is split into so many fields at most; the last then has the rest.
  static constexpr std::size_t max_fields = 20'000;
  [[nodiscard]] Delimiter delimiter() const { return delimiter_; }

 private:
  /// The quoted field at `at`, which is moved behind its delimiter; nothing where the quote is no proper one.
  std::optional<std::string_view> quoted_field(std::string_view line, std::size_t& at);
  [[nodiscard]] std::size_t delimiter_at(std::string_view line, std::size_t from) const;

  Delimiter delimiter_;
  std::vector<std::string_view> fields_;
  std::deque<std::string> unquoted_;  ///< fields whose doubled quotes were taken out
  bool open_ = false;
};

/// A field by its place: characters `first` to `last` of a line, from 1.
struct FixedPlace {
  std::size_t first = 0;
  std::size_t last = 0;
};

/// The text at each place, without surrounding blanks; empty where the line is shorter. Characters, not bytes.
[[nodiscard]] std::vector<std::string_view> split_fixed(std::string_view line, const std::vector<FixedPlace>& places);

}  // namespace downrange::archive
