#pragma once
/// Which unit a mapping should declare instead of the one that cannot be. What is declared already is never advised.

#include <archive/import/mapping.hpp>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace downrange::archive {

/// The unit that a column declares; null where it declares none (choices, plain numbers, no such column).
[[nodiscard]] const UnitInfo* unit_of(const ColumnMapping* column);

/// The units under which a column's values would be `ratio` times what they are, for every ratio that fits. Not the
/// declared one; none where the column declares none.
[[nodiscard]] std::vector<std::string_view> units_that_fit(const ColumnMapping* column,
                                                           const std::function<bool(double ratio)>& fits);

/// "kilometres taken as metres (unit = \"km\")?" where the column declares `declared`; else empty.
[[nodiscard]] std::string mistaken_unit(const ColumnMapping* column, std::string_view declared,
                                        std::string_view true_unit);

/// The same for the unit that is about a thousand times the declared one (smaller: a thousandth); empty where there is
/// none that people use.
[[nodiscard]] std::string larger_unit(const ColumnMapping* column);
/// The first under which `ratio` times the values would fit.
[[nodiscard]] std::string smaller_unit(const ColumnMapping* column, const std::function<bool(double ratio)>& fits);

/// "unit = \"a\" or \"b\" would fit", the first few; empty for none.
[[nodiscard]] std::string show_units(const std::vector<std::string_view>& units);

/// Of a latitude that is none: the number found, what is allowed, and which key would help. Radians.
[[nodiscard]] std::string latitude_problem(const FileMapping& mapping, double latitude_rad, double longitude_rad);

}  // namespace downrange::archive
