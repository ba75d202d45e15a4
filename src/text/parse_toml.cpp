#include "text/parse_toml.hpp"

#include <algorithm>

#include "text/file.hpp"
#include "text/printable.hpp"

namespace downrange::text {
namespace {

/// Walks the text without understanding it: strings and comments are stepped over, dots between two separators are the
/// parts of one key, open brackets are the nesting. Wrong TOML may be counted wrongly, but never too low.
class DepthCheck {
 public:
  explicit DepthCheck(std::string_view text) : text_(text) {}

  void run() {
    while (at_ < text_.size()) step();
  }

 private:
  void step() {
    const char c = text_[at_];
    if (c == '#') return skip_comment();
    if (c == '"' || c == '\'') return skip_string(c);
    ++at_;
    switch (c) {
      case '\n':
        ++line_;
        dots_ = 0;
        return;
      case '=':
      case ',':
        dots_ = 0;
        return;
      case '[':
      case '{':
        dots_ = 0;
        ++nesting_;
        return require(nesting_ <= max_nesting, "more than " + std::to_string(max_nesting) + " brackets in each other");
      case ']':
      case '}':
        dots_ = 0;
        nesting_ = std::max(nesting_ - 1, 0);
        return;
      case '.':
        ++dots_;
        return require(dots_ < max_key_parts, "a key of more than " + std::to_string(max_key_parts) + " parts");
      default:
        return;
    }
  }

  void skip_comment() { at_ = std::min(text_.find('\n', at_), text_.size()); }

  /// A string that is not closed ends, as far as this check goes, with its line, or with the text for one of many
  /// lines.
  void skip_string(char quote) {
    const std::string_view three = quote == '"' ? R"(""")" : "'''";
    const bool many_lines = text_.substr(at_).starts_with(three);
    at_ += many_lines ? 3 : 1;
    while (at_ < text_.size()) {
      if (many_lines ? text_.substr(at_).starts_with(three) : text_[at_] == quote) {
        at_ += many_lines ? 3 : 1;
        // The string's own last characters may be one or two quotes.
        for (int i = 0; many_lines && i < 2 && at_ < text_.size() && text_[at_] == quote; ++i) ++at_;
        return;
      }
      if (text_[at_] == '\n') {
        if (!many_lines) return;
        ++line_;
      }
      const bool escaped = quote == '"' && text_[at_] == '\\' && at_ + 1 < text_.size() && text_[at_ + 1] != '\n';
      at_ += escaped ? 2 : 1;
    }
  }

  void require(bool good, const std::string& what) const {
    if (!good) throw TomlError(line_, what + ": too deep for a file of this kind");
  }

  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1;
  int dots_ = 0;
  int nesting_ = 0;
};

}  // namespace

toml::table parse_toml(std::string_view text) {
  if (text.size() > max_toml_size) throw TomlError(0, "is larger than " + show_size(max_toml_size));
  DepthCheck(text).run();
  try {
    return toml::parse(text);
  } catch (const toml::parse_error& error) {
    throw TomlError(static_cast<int>(error.source().begin.line),
                    "not valid TOML: " + printable(error.description(), false, 300));
  }
}

}  // namespace downrange::text
