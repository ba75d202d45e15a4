#pragma once
/// Short text held in place, and identifiers of targets, sources and antennas.

#include <algorithm>
#include <array>
#include <compare>
#include <cstddef>
#include <optional>
#include <string_view>

namespace downrange {

/// Text of at most `MaxSize` characters, held in place: copying an event never allocates. Empty means "none".
template <std::size_t MaxSize>
class FixedText {
 public:
  static constexpr std::size_t max_size = MaxSize;

  constexpr FixedText() = default;
  /// Longer text is a bug of the caller: readers of outside data use `parse`.
  constexpr FixedText(std::string_view text) {  // NOLINT(google-explicit-constructor): literals are names
    std::copy_n(text.begin(), std::min(text.size(), max_size), text_.begin());
  }
  constexpr FixedText(const char* text)  // NOLINT(google-explicit-constructor)
      : FixedText(std::string_view(text)) {}

  /// Nothing when `text` is longer than `max_size` or holds a NUL.
  [[nodiscard]] static constexpr std::optional<FixedText> parse(std::string_view text) {
    if (text.size() > max_size || text.find('\0') != std::string_view::npos) return std::nullopt;
    return FixedText(text);
  }

  [[nodiscard]] constexpr std::string_view view() const { return {text_.data()}; }
  [[nodiscard]] constexpr const char* c_str() const { return text_.data(); }
  [[nodiscard]] constexpr bool empty() const { return text_[0] == '\0'; }

  constexpr auto operator<=>(const FixedText&) const = default;

 private:
  std::array<char, max_size + 1> text_{};
};

/// An identifier.
using Name = FixedText<31>;

/// What a person wrote: why an order was given.
using Remark = FixedText<127>;

}  // namespace downrange
