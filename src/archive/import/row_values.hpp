#pragma once
/// The cells of one row as numbers, times and choices.

#include <archive/import/mapping.hpp>
#include <archive/import/times.hpp>
#include <array>
#include <bitset>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace downrange::archive {

/// What the cells of all rows of a file have in common.
struct CellRules {
  Time liftoff;
  Duration scale_minus_utc;  ///< of the file's time scale
  DecimalMark mark = DecimalMark::Point;
};

enum class CellProblem : std::uint8_t {
  None,
  Malformed,  ///< no number, no time, no such place
  NotFinite,  ///< empty, NaN, infinite
};

/// Reads row after row: a time of day is continued from the row before.
class RowValues {
 public:
  RowValues(const FileMapping& mapping, const CellRules& rules) : mapping_(mapping), rules_(rules) {}

  /// Takes the cells of a row; `places` says where each mapped column is. Else what is wrong, told by `what()`. Throws
  /// ImportError (reason only) for times whose meaning the mapping must say.
  [[nodiscard]] CellProblem read(const std::vector<std::string_view>& fields, const std::vector<std::size_t>& places);
  [[nodiscard]] const std::string& what() const { return what_; }

  [[nodiscard]] double value(Field field) const { return values_[static_cast<std::size_t>(field)]; }
  /// Whether the row has a value for the field.
  [[nodiscard]] bool has(Field field) const { return there_[static_cast<std::size_t>(field)]; }
  [[nodiscard]] bool has_angles() const { return has(Field::Azimuth) && has(Field::Elevation); }
  [[nodiscard]] Time epoch() const { return epoch_; }
  [[nodiscard]] Time received() const { return received_; }
  /// Optional fields of the row that have no value.
  [[nodiscard]] std::size_t left_empty() const { return left_empty_; }
  /// The epoch's cell, where it is no number.
  [[nodiscard]] const std::optional<ClockTime>& epoch_clock() const { return epoch_clock_; }
  /// The first cell of text that a time column has, and what it is; empty while there was none.
  [[nodiscard]] const std::string& clock_example() const { return clock_example_; }

 private:
  /// A row is one without it.
  [[nodiscard]] bool may_be_absent(Field field) const;
  [[nodiscard]] bool is_missing(std::string_view text) const;
  CellProblem read_cell(const ColumnMapping& column, std::string_view text);
  CellProblem read_time(const ColumnMapping& column, std::string_view text);
  CellProblem read_number(const ColumnMapping& column, std::string_view text);
  CellProblem read_date(const ColumnMapping& column, std::string_view text);
  CellProblem read_choice(const ColumnMapping& column, std::string_view text);
  CellProblem problem(CellProblem kind, const ColumnMapping& column, const std::string& what);
  [[nodiscard]] std::optional<long double> clock_ns(const ColumnMapping& column, const ClockTime& clock);
  [[nodiscard]] static std::string_view without_unit(const ColumnMapping& column, std::string_view text);
  [[nodiscard]] ParsedNumber<double> number_of(const ColumnMapping& column, std::string_view text) const;
  /// What a cell that is no number may be.
  [[nodiscard]] std::string why_no_number(const ColumnMapping& column, std::string_view text) const;
  [[nodiscard]] std::optional<Since> since_of(const ColumnMapping& column) const;
  [[nodiscard]] long double base_ns(const ColumnMapping& column, Since since) const;
  [[nodiscard]] std::int64_t continued(const ColumnMapping& column, std::int64_t ns) const;
  [[nodiscard]] std::string other_meaning(long double number) const;
  [[nodiscard]] std::string other_scale() const;
  void refuse_scale(const ColumnMapping& column, std::string_view text) const;

  const FileMapping& mapping_;
  CellRules rules_;
  std::array<double, field_count> values_{};
  std::bitset<field_count> there_;
  Time epoch_;
  std::optional<ClockTime> epoch_clock_;
  Time received_;
  std::optional<Time> date_;  ///< of the row, from its own column
  std::optional<Time> last_epoch_;
  std::optional<Time> last_received_;
  std::size_t left_empty_ = 0;
  std::string what_;
  std::string clock_example_;
};

}  // namespace downrange::archive
