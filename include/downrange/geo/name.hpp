#pragma once
/// Identifiers of targets, sources and antennas.

#include <algorithm>
#include <array>
#include <compare>
#include <cstddef>
#include <optional>
#include <string_view>

namespace downrange {

/// An identifier of 1 to 31 characters, held in place: copying an event never allocates. Empty means "none".
class Name {
 public:
  static constexpr std::size_t max_size = 31;

  constexpr Name() = default;
  /// Longer text is a bug of the caller: readers of outside data use `parse`.
  constexpr Name(std::string_view text) {  // NOLINT(google-explicit-constructor): literals are names
    std::copy_n(text.begin(), std::min(text.size(), max_size), text_.begin());
  }
  constexpr Name(const char* text) : Name(std::string_view(text)) {}  // NOLINT(google-explicit-constructor)

  /// Nothing when `text` is longer than `max_size` or holds a NUL.
  [[nodiscard]] static constexpr std::optional<Name> parse(std::string_view text) {
    if (text.size() > max_size || text.find('\0') != std::string_view::npos) return std::nullopt;
    return Name(text);
  }

  [[nodiscard]] constexpr std::string_view view() const { return {text_.data()}; }
  [[nodiscard]] constexpr const char* c_str() const { return text_.data(); }
  [[nodiscard]] constexpr bool empty() const { return text_[0] == '\0'; }

  constexpr auto operator<=>(const Name&) const = default;

 private:
  std::array<char, max_size + 1> text_{};
};

}  // namespace downrange
