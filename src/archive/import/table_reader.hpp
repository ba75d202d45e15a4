#pragma once
/// The rows of a file under its columns: finds header and delimiter, passes over what is no row.

#include <archive/import/mapping.hpp>
#include <archive/import/rows.hpp>
#include <archive/import/source_text.hpp>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace downrange::archive {

/// What was passed over.
struct PassedOver {
  std::uint64_t comments = 0;
  std::uint64_t headers = 0;   ///< the header again, or a line of units
  std::uint64_t filtered = 0;  ///< rows that a filter does not want
  std::uint64_t others = 0;    ///< rows of other sensors or targets
};

class TableReader {
 public:
  /// The header is the first line (comments included) that has every column of the mapping, under the delimiter that
  /// the mapping declares or else the first that does. Throws ImportError, which names the columns that there are, and
  /// where the file says another unit than the mapping.
  TableReader(const FileMapping& mapping, std::string_view text);

  /// The next row that the filters want; false at the end. A row has several lines where a quoted field has. Throws
  /// ImportError where another header stands between the rows that does not have every column.
  [[nodiscard]] bool next();
  /// From the first row again.
  void rewind();

  [[nodiscard]] const std::vector<std::string_view>& fields() const { return *fields_; }
  /// The row as it stands.
  [[nodiscard]] std::string_view text() const { return row_text_; }
  /// Of the row's first line in the file, from 1.
  [[nodiscard]] std::uint64_t line() const { return row_line_; }
  /// Number of the row in the file, filtered ones included, from 1.
  [[nodiscard]] std::uint64_t row() const { return row_; }
  [[nodiscard]] std::size_t offset() const { return lines_.offset(); }

  /// Fields that a row must have.
  [[nodiscard]] std::size_t width() const { return layout_.names.size(); }
  /// In a row, of each mapped column.
  [[nodiscard]] const std::vector<std::size_t>& places() const { return layout_.places; }
  /// In a row, of each column that says a name, in the order of FileMapping::name_columns().
  [[nodiscard]] const std::vector<std::size_t>& name_places() const { return layout_.name_places; }
  [[nodiscard]] const std::vector<std::string>& names() const { return layout_.names; }
  [[nodiscard]] Delimiter delimiter() const { return splitter_.delimiter(); }
  [[nodiscard]] std::uint64_t header_line() const { return layout_.header_line; }
  [[nodiscard]] const PassedOver& passed_over() const { return passed_over_; }
  /// Of rows that a filter did not want: a few values of its column.
  [[nodiscard]] const std::map<std::string, std::uint64_t>& filtered_values() const { return filtered_values_; }

 private:
  /// The columns, and where the mapping's are.
  struct Layout {
    std::vector<std::string> names;
    std::vector<std::size_t> places;
    std::vector<std::size_t> filter_places;
    std::vector<std::size_t> name_places;
    std::uint64_t header_line = 0;
  };

  void skip_top();
  void find_header();
  void find_width();
  void use_fixed_places();
  [[noreturn]] void fail_without_header();
  void use(std::vector<std::string> names, Delimiter delimiter, std::uint64_t line);
  void find_places();
  void declare_all();
  void check_units();
  [[nodiscard]] bool is_empty_column(std::size_t index);
  [[nodiscard]] std::vector<Delimiter> candidates() const;
  [[nodiscard]] std::vector<std::string> comments(Delimiter delimiter) const;
  [[nodiscard]] bool has_all(const std::vector<std::string>& names) const;
  [[nodiscard]] std::size_t place_of(const std::string& column) const;
  [[nodiscard]] std::vector<std::string> wanted_columns() const;
  /// The header in the line, or in the lines that a quote joins; empty when it is none.
  [[nodiscard]] std::vector<std::string> header_in(std::string_view line, Delimiter delimiter);
  /// From `begin` in the file to the end of a line behind it.
  [[nodiscard]] std::string_view joined(std::size_t begin, std::string_view last_line) const;
  [[nodiscard]] bool is_other_header();
  [[nodiscard]] bool is_first_header_or_units();
  void split(std::string_view line);
  [[nodiscard]] bool join_lines(std::string_view line, std::size_t begin);
  [[nodiscard]] bool wanted(const std::vector<std::string_view>& fields);
  [[noreturn]] void fail(std::uint64_t line, const std::string& what) const;

  const FileMapping& mapping_;
  std::string_view text_;
  LineReader lines_;
  RowSplitter splitter_{','};
  std::vector<FixedPlace> fixed_;
  std::vector<std::string_view> fixed_fields_;
  bool lines_in_quotes_ = false;  ///< each as a whole
  std::string line_inside_;
  std::vector<std::string> comments_;
  Layout layout_;
  Layout first_layout_;
  LineReader first_row_;
  const std::vector<std::string_view>* fields_ = nullptr;
  std::string_view row_text_;
  std::uint64_t row_line_ = 0;
  std::uint64_t row_ = 0;
  PassedOver passed_over_;
  std::map<std::string, std::uint64_t> filtered_values_;
};

}  // namespace downrange::archive
