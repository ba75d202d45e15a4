#pragma once
/// TOML within bounds.

#include <toml++/toml.h>

#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>

namespace downrange::text {

/// No file of ours comes near them: a configuration has a few kilobytes, four parts in a key, four tables in each
/// other.
inline constexpr std::size_t max_toml_size = 4'000'000;
inline constexpr int max_key_parts = 16;
inline constexpr int max_nesting = 16;

/// Text that is not TOML, or too large or too deep.
class TomlError : public std::runtime_error {
 public:
  TomlError(int line, const std::string& what) : std::runtime_error(what), line_(line) {}
  [[nodiscard]] int line() const { return line_; }  ///< 0: of the text as a whole

 private:
  int line_;
};

/// Parses. Size, parts of a key and nesting are tested before, so that no text can exhaust the stack: toml++ reads a
/// dotted key, and frees its tables, by recursion without a bound. Throws TomlError.
[[nodiscard]] toml::table parse_toml(std::string_view text);

}  // namespace downrange::text
