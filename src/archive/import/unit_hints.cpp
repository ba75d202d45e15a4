#include <algorithm>
#include <archive/import/sentinels.hpp>
#include <archive/import/unit_hints.hpp>
#include <array>
#include <cmath>
#include <numbers>
#include <text/printable.hpp>

namespace downrange::archive {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double deg = pi / 180;

struct UnitWord {
  std::string_view unit;
  std::string_view word;
};
constexpr std::array words{UnitWord{"m", "metres"},        UnitWord{"km", "kilometres"},
                           UnitWord{"ft", "feet"},         UnitWord{"kft", "kilofeet"},
                           UnitWord{"s", "seconds"},       UnitWord{"ms", "milliseconds"},
                           UnitWord{"us", "microseconds"}, UnitWord{"ns", "nanoseconds"},
                           UnitWord{"deg", "degrees"},     UnitWord{"rad", "radians"}};

std::string word_of(std::string_view unit) {
  const auto* found = std::find_if(words.begin(), words.end(), [&](const UnitWord& w) { return w.unit == unit; });
  return std::string(found == words.end() ? unit : found->word);
}

/// Units that are taken for each other, the smaller first.
constexpr std::array<std::pair<std::string_view, std::string_view>, 8> neighbours{
    {{"m", "km"}, {"ft", "kft"}, {"m", "nmi"}, {"cm", "m"}, {"mm", "m"}, {"ms", "s"}, {"us", "s"}, {"ns", "s"}}};

/// A latitude and a longitude that a mapping makes of two numbers.
struct Place {
  const ColumnMapping* latitude_column;
  const ColumnMapping* longitude_column;
  double latitude_rad;
  double longitude_rad;

  [[nodiscard]] bool would_fit(double ratio) const {
    return std::abs(latitude_rad * ratio) <= pi / 2 && std::abs(longitude_rad * ratio) <= 2 * pi;
  }
  /// As the file has it, where neither scale nor offset is declared.
  [[nodiscard]] static double number(const ColumnMapping& column, double si) {
    return (si - column.offset) / column.factor;
  }
};

/// 3425.8: degrees times a hundred plus minutes.
bool is_degrees_and_minutes(double number, double most_degrees) {
  const double degrees = std::trunc(number / 100);
  return std::abs(degrees) <= most_degrees && std::abs(number - 100 * degrees) < 60;
}

std::string as_degrees_and_minutes(const Place& place) {
  const auto& column = *place.latitude_column;
  const double latitude = Place::number(column, place.latitude_rad);
  const double longitude = Place::number(*place.longitude_column, place.longitude_rad);
  if (column.unit != "deg" || column.scaled) return {};
  if (!is_degrees_and_minutes(latitude, 90) || !is_degrees_and_minutes(longitude, 180)) return {};
  const double degrees = std::trunc(latitude / 100);
  return "degrees and minutes as one number (ddmm.mmmm)? With a colon between them, " + show_digits(degrees) + ':' +
         show_digits(std::abs(latitude - 100 * degrees)) +
         ", unit = \"deg\" reads them; the receiver's own sentences need format = \"nmea\" and no columns";
}

std::string as_scaled(const Place& place) {
  constexpr int most_digits = 9;
  const auto& column = *place.latitude_column;
  const double number = Place::number(column, place.latitude_rad);
  for (int digits = 3; digits <= most_digits && !column.scaled && number == std::round(number); ++digits) {
    const double scale = std::pow(10.0, -digits);
    if (!place.would_fit(scale)) continue;
    return "integers? scale = 1e-" + std::to_string(digits) + " in both columns would make it " +
           show_digits(number * scale) + ' ' + column.unit;
  }
  return {};
}

std::string latitude_hint(const Place& place) {
  const auto& column = *place.latitude_column;
  if (const double number = Place::number(column, place.latitude_rad); is_all_nines(number)) {
    return "does it stand for no value? missing = \"" + show_digits(number, 9) + "\" leaves it out";
  }
  const auto units = units_that_fit(&column, [&](double ratio) { return place.would_fit(ratio); });
  if (std::find(units.begin(), units.end(), "deg") != units.end()) return mistaken_unit(&column, column.unit, "deg");
  if (std::abs(place.longitude_rad) <= pi / 2 && std::abs(place.latitude_rad) <= 2 * pi) {
    return "latitude and longitude exchanged? Then '" + text::printable(place.longitude_column->column, false, 40) +
           "' is field = \"latitude\" and '" + text::printable(column.column, false, 40) + "' field = \"longitude\"";
  }
  if (std::string minutes = as_degrees_and_minutes(place); !minutes.empty()) return minutes;
  if (!units.empty()) return show_units(units);
  return as_scaled(place);
}

}  // namespace

const UnitInfo* unit_of(const ColumnMapping* column) {
  if (column == nullptr || column->unit.empty()) return nullptr;
  const auto units = all_units();
  const auto found = std::find_if(units.begin(), units.end(), [&](const UnitInfo& u) {
    return u.name == column->unit && u.quantity == info_of(column->field).quantity;
  });
  return found == units.end() ? nullptr : &*found;
}

std::vector<std::string_view> units_that_fit(const ColumnMapping* column,
                                             const std::function<bool(double ratio)>& fits) {
  const UnitInfo* declared = unit_of(column);
  std::vector<std::string_view> found;
  for (const UnitInfo& unit : all_units()) {
    if (declared == nullptr || unit.quantity != declared->quantity || unit.name == declared->name) continue;
    if (fits(unit.size / declared->size)) found.push_back(unit.name);
  }
  return found;
}

std::string mistaken_unit(const ColumnMapping* column, std::string_view declared, std::string_view true_unit) {
  if (unit_of(column) == nullptr || column->unit != declared || declared == true_unit) return {};
  return word_of(true_unit) + " taken as " + word_of(declared) + " (unit = \"" + std::string(true_unit) + "\")?";
}

std::string larger_unit(const ColumnMapping* column) {
  for (const auto& [small, large] : neighbours) {
    if (std::string found = mistaken_unit(column, small, large); !found.empty()) return found;
  }
  return {};
}

std::string smaller_unit(const ColumnMapping* column, const std::function<bool(double ratio)>& fits) {
  const auto units = units_that_fit(column, fits);
  for (const auto& [small, large] : neighbours) {
    // Nobody takes centimetres for metres.
    if (large == "m" || std::ranges::find(units, small) == units.end()) continue;
    if (std::string found = mistaken_unit(column, large, small); !found.empty()) return found;
  }
  return {};
}

std::string show_units(const std::vector<std::string_view>& units) {
  constexpr std::size_t shown = 6;
  std::string out;
  for (std::size_t i = 0; i < std::min(units.size(), shown); ++i) {
    out += (i == 0 ? "unit = \"" : "\" or \"") + std::string(units[i]);
  }
  return out.empty() ? out : out + "\" would fit";
}

std::string latitude_problem(const FileMapping& mapping, double latitude_rad, double longitude_rad) {
  const Place place{mapping.column_of(Field::Latitude), mapping.column_of(Field::Longitude), latitude_rad,
                    longitude_rad};
  const UnitInfo* unit = unit_of(place.latitude_column);
  const double size = unit == nullptr ? deg : unit->size;
  const std::string name = unit == nullptr ? "deg" : std::string(unit->name);
  const std::string pole = show_digits(pi / 2 / size);
  std::string out = "found " + show_digits(latitude_rad / size) + ' ' + name + ", allowed -" + pole + " to " + pole +
                    ' ' + name + " (from pole to pole)";
  const std::string hint = mapping.nmea ? std::string() : latitude_hint(place);
  return hint.empty() ? out : out + ": " + hint;
}

}  // namespace downrange::archive
