#pragma once
/// Which column of a file a mapping means.

#include <archive/import/mapping.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace downrange::archive {

/// A column's name as a file has it: "range [km]" is "range" in "km". Brackets, round or square, at the end.
struct HeaderName {
  std::string_view name;
  std::string_view unit;  ///< empty: none is said
};
[[nodiscard]] HeaderName split_header_name(std::string_view text);

/// A column of these names, by a mapping's spelling ("az", "az#2", "#3"): as it stands, else where small and capital
/// letters and blanks make no difference, else without the unit behind the file's name; nothing when there is none, or
/// more than one. `how_many` tells how many columns a plain name fits.
[[nodiscard]] std::optional<std::size_t> find_column(const std::vector<std::string>& names, const std::string& column,
                                                     std::size_t* how_many = nullptr);

/// Every column that a name fits, several of one name among them.
[[nodiscard]] std::vector<std::size_t> find_columns(const std::vector<std::string>& names, const std::string& column);

/// What is wrong with a mapped column when the file says this of its unit; empty: nothing, or no unit that is known.
[[nodiscard]] std::string unit_problem(const ColumnMapping& column, std::string_view said);

/// Whether a row says the units of the columns, as some files have it beneath the header: at least one known or in
/// brackets, and no number. `places` says where each mapped column is.
[[nodiscard]] bool is_unit_row(const std::vector<std::string_view>& fields, const std::vector<std::size_t>& places);
/// "km" of "[km]", "(km)" and "km".
[[nodiscard]] std::string_view without_brackets(std::string_view text);

}  // namespace downrange::archive
