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
  std::uint64_t headers = 0;   ///< the header again
  std::uint64_t filtered = 0;  ///< rows that a filter does not want
};

class TableReader {
 public:
  /// The header is the first line (comments included) that has every column of the mapping, under the delimiter that
  /// the mapping declares or else the first that does. Throws ImportError, which names the columns that there are.
  TableReader(const FileMapping& mapping, std::string_view text);

  /// The next row that the filters want; false at the end.
  [[nodiscard]] bool next();
  /// From the first row again.
  void rewind();

  [[nodiscard]] const std::vector<std::string_view>& fields() const { return *fields_; }
  /// Of the row in the file, from 1.
  [[nodiscard]] std::uint64_t line() const { return lines_.line(); }
  /// Number of the row in the file, filtered ones included, from 1.
  [[nodiscard]] std::uint64_t row() const { return row_; }
  [[nodiscard]] std::size_t offset() const { return lines_.offset(); }

  /// Fields that a row must have.
  [[nodiscard]] std::size_t width() const { return names_.size(); }
  /// In a row, of each mapped column.
  [[nodiscard]] const std::vector<std::size_t>& places() const { return places_; }
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  [[nodiscard]] Delimiter delimiter() const { return splitter_.delimiter(); }
  [[nodiscard]] std::uint64_t header_line() const { return header_line_; }
  [[nodiscard]] const PassedOver& passed_over() const { return passed_over_; }
  /// Of rows that a filter did not want: a few values of its column.
  [[nodiscard]] const std::map<std::string, std::uint64_t>& filtered_values() const { return filtered_values_; }

 private:
  void find_header();
  void find_width();
  [[noreturn]] void fail_without_header();
  void use(std::vector<std::string> names, Delimiter delimiter, std::uint64_t line);
  void declare_all();
  [[nodiscard]] std::vector<Delimiter> candidates() const;
  [[nodiscard]] std::vector<std::string> comments(Delimiter delimiter) const;
  [[nodiscard]] bool has_all(const std::vector<std::string>& names) const;
  [[nodiscard]] std::size_t place_of(const std::string& column) const;
  [[nodiscard]] bool wanted(const std::vector<std::string_view>& fields);
  [[noreturn]] void fail(std::uint64_t line, const std::string& what) const;

  const FileMapping& mapping_;
  std::string_view text_;
  LineReader lines_;
  RowSplitter splitter_{','};
  std::vector<std::string> comments_;
  std::vector<std::string> names_;
  std::vector<std::size_t> places_;
  std::vector<std::size_t> filter_places_;
  std::uint64_t header_line_ = 0;
  LineReader first_row_;
  const std::vector<std::string_view>* fields_ = nullptr;
  std::uint64_t row_ = 0;
  PassedOver passed_over_;
  std::map<std::string, std::uint64_t> filtered_values_;
};

/// A column of these names, by a mapping's spelling ("az", "az#2", "#3"); nothing when there is none. `how_many` tells
/// how many columns a plain name fits.
[[nodiscard]] std::optional<std::size_t> find_column(const std::vector<std::string>& names, const std::string& column,
                                                     std::size_t* how_many = nullptr);

}  // namespace downrange::archive
