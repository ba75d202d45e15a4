#include <algorithm>
#include <archive/import/sentinels.hpp>
#include <archive/import/unit_hints.hpp>
#include <array>
#include <cmath>
#include <downrange/geo/site.hpp>
#include <map>
#include <numbers>
#include <optional>
#include <text/printable.hpp>

namespace downrange::archive {
namespace {

constexpr double deg = std::numbers::pi / 180;
/// Fewer are outliers.
constexpr std::size_t least_rows = 3;

/// What a field can be at a site, and its value in a row.
struct Measured {
  Field field;
  double least;
  double most;
  std::optional<double> (*value)(const PlausibleRow&);
};

constexpr double far_m = 1e9;

template <int axis>
std::optional<double> coordinate(const PlausibleRow& row) {
  return row.position.m[axis];
}

const std::array<Measured, 7> fields{
    {{Field::Range, 1e-3, far_m,
      [](const PlausibleRow& r) { return r.range_valid ? std::optional(r.polar.range_m) : std::nullopt; }},
     {Field::Azimuth, -720.001 * deg, 720.001 * deg,
      [](const PlausibleRow& r) { return r.angles_valid ? std::optional(r.polar.azimuth_rad) : std::nullopt; }},
     {Field::Elevation, -90.001 * deg, 90.001 * deg,
      [](const PlausibleRow& r) { return r.angles_valid ? std::optional(r.polar.elevation_rad) : std::nullopt; }},
     {Field::Height, -15e3, far_m,
      [](const PlausibleRow& r) {
        // Through the Earth's axes and back: to the tenth of a millimetre.
        return std::optional(std::round(geodetic_from_ecef(r.position).height_m * 1e4) / 1e4);
      }},
     {Field::X, -far_m, far_m, coordinate<0>},
     {Field::Y, -far_m, far_m, coordinate<1>},
     {Field::Z, -far_m, far_m, coordinate<2>}}};

class Search {
 public:
  Search(const ColumnMapping& column, const Measured& measured, const std::vector<PlausibleRow>& rows)
      : column_(column), measured_(measured), rows_(rows) {
    for (const PlausibleRow& row : rows) {
      const auto value = measured.value(row);
      if (!value) continue;
      const bool suspect = is_beyond_limits(*value) || is_all_nines(number_of(*value));
      suspect ? ++suspects_[*value] : ++others_;
    }
  }

  [[nodiscard]] Sentinel run() const {
    for (const auto& [value, count] : suspects_) {
      const bool alone = others_ == 0 && suspects_.size() == 1;
      if (count < least_rows || alone) continue;
      if (is_beyond_limits(value) || stands_apart(value)) return found(value, count);
    }
    return {};
  }

 private:
  [[nodiscard]] bool is_beyond_limits(double value) const { return value < measured_.least || value > measured_.most; }

  [[nodiscard]] double number_of(double value) const { return (value - column_.offset) / column_.factor; }

  /// No other value is near it: nothing passes through it.
  [[nodiscard]] bool stands_apart(double value) const {
    constexpr double near = 0.01;
    return std::ranges::none_of(rows_, [&](const PlausibleRow& row) {
      const double other = measured_.value(row).value_or(value);
      return other != value && std::abs(other - value) <= near * std::abs(value);
    });
  }

  [[nodiscard]] Sentinel found(double value, std::size_t count) const {
    Sentinel sentinel;
    std::uint64_t line = 0;
    for (const PlausibleRow& row : rows_) {
      if (measured_.value(row) != value) {
        sentinel.rows.push_back(row);
      } else if (line == 0) {
        line = row.line;
      }
    }
    const std::string number = show_digits(number_of(value), 9);
    const std::string name = text::printable(column_.column, false, 40);
    sentinel.what = name + ": found " + number + " in " + std::to_string(count) + " of " +
                    std::to_string(rows_.size()) + " rows, the first on line " + std::to_string(line) +
                    ", which is no " + std::string(info_of(column_.field).name) +
                    " of a site: does it stand for no value? Write missing = \"" + number +
                    "\", or to leave the rows out where = {column = \"" + name + "\", differs = \"" + number + "\"}";
    return sentinel;
  }

  const ColumnMapping& column_;
  const Measured& measured_;
  const std::vector<PlausibleRow>& rows_;
  std::map<double, std::size_t> suspects_;  ///< values, and how many rows have them
  std::size_t others_ = 0;
};

}  // namespace

bool is_all_nines(double number) {
  // Most numbers are told apart without their digits.
  const double size = std::abs(number);
  if (!(size >= 999) || size < 0.998 * std::pow(10.0, std::ceil(std::log10(size)))) return false;
  const std::string text = show_digits(std::abs(number), 9);
  return std::ranges::count(text, '9') >= 3 && text.find_first_not_of("9.") == std::string::npos;
}

Sentinel find_sentinel(const FileMapping& mapping, const std::vector<PlausibleRow>& rows) {
  for (const Measured& measured : fields) {
    const ColumnMapping* column = mapping.column_of(measured.field);
    if (column == nullptr) continue;
    if (Sentinel found = Search(*column, measured, rows).run(); !found.what.empty()) return found;
  }
  return {};
}

}  // namespace downrange::archive
