#pragma once
/// Numbers as people and instruments write them.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace downrange::archive {

/// Which character stands before a number's fraction; the other one may group its digits by three.
enum class DecimalMark : char { Point = '.', Comma = ',' };

enum class NumberKind : std::uint8_t {
  Finite,
  NotFinite,  ///< NaN, infinity, their spellings elsewhere, or beyond a double
  NotANumber,
};

template <class T>
struct ParsedNumber {
  NumberKind kind = NumberKind::NotANumber;
  T value = 0;
};

/// "12.5", "+12.5", "-1.2E+03", "1.2D3", "12,000.5", "12 000.5", "12'000.5", and with a decimal comma "12.000,5".
/// Digits are grouped by three or not at all. The nearest T, as of the plain spelling. Instances: double, long double.
template <class T>
[[nodiscard]] ParsedNumber<T> parse_number(std::string_view text, DecimalMark mark);

/// What stands where there is no value: nothing, dashes, stars of a too narrow field, N/A, null, None and the like.
[[nodiscard]] bool is_no_value(std::string_view text);

/// For messages: fixed, with so many decimals, below a million; from there on six digits ("1e+305").
[[nodiscard]] std::string show_fixed(double value, int decimals);
/// For messages: so many digits.
[[nodiscard]] std::string show_digits(double value, int digits = 6);

/// Finds out which mark the numbers of a file have. "10,05" can only be a decimal comma, "1,234.5" only a point;
/// "12,000" can be either.
class DecimalEvidence {
 public:
  void observe(std::string_view text, std::uint64_t line);

  struct Cell {
    std::string text;
    std::uint64_t line = 0;
  };
  [[nodiscard]] const std::optional<Cell>& point() const { return point_; }
  [[nodiscard]] const std::optional<Cell>& comma() const { return comma_; }
  /// A cell with a comma that can be either.
  [[nodiscard]] const std::optional<Cell>& either() const { return either_; }

 private:
  std::optional<Cell> point_;
  std::optional<Cell> comma_;
  std::optional<Cell> either_;
};

}  // namespace downrange::archive
