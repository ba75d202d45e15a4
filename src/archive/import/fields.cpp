#include <algorithm>
#include <archive/import/fields.hpp>
#include <array>
#include <numbers>

namespace downrange::archive {
namespace {

constexpr unsigned radar = kind_mask(FileKind::Radar);
constexpr unsigned gps = kind_mask(FileKind::Gps);
constexpr unsigned truth = kind_mask(FileKind::Truth);
constexpr unsigned angles = kind_mask(FileKind::Angles);
constexpr bool optional = true;
constexpr bool needed = false;

constexpr std::array fields{
    FieldInfo{"epoch", Field::Epoch, Quantity::Time, radar | gps | truth | angles, needed,
              "when the measurement was true"},
    FieldInfo{"received", Field::Received, Quantity::Time, radar | gps | angles, needed, "when it arrived"},
    FieldInfo{"range", Field::Range, Quantity::Length, radar, needed, "slant range"},
    FieldInfo{"azimuth", Field::Azimuth, Quantity::Angle, radar | angles, needed, "clockwise from true north"},
    FieldInfo{"elevation", Field::Elevation, Quantity::Angle, radar | angles, needed, "above the horizontal"},
    FieldInfo{"range_rate", Field::RangeRate, Quantity::Speed, radar, optional, "positive: going away"},
    FieldInfo{"snr", Field::Snr, Quantity::Number, radar, optional, "signal to noise"},
    FieldInfo{"mode", Field::Mode, Quantity::Choice, radar | angles, needed, "of tracking"},
    FieldInfo{"x", Field::X, Quantity::Length, gps | truth, needed, "WGS-84 Earth-fixed"},
    FieldInfo{"y", Field::Y, Quantity::Length, gps | truth, needed, ""},
    FieldInfo{"z", Field::Z, Quantity::Length, gps | truth, needed, ""},
    FieldInfo{"vx", Field::Vx, Quantity::Speed, gps | truth, optional, "relative to the Earth, its axes"},
    FieldInfo{"vy", Field::Vy, Quantity::Speed, gps | truth, optional, ""},
    FieldInfo{"vz", Field::Vz, Quantity::Speed, gps | truth, optional, ""},
    FieldInfo{"ax", Field::Ax, Quantity::Acceleration, truth, optional, "likewise"},
    FieldInfo{"ay", Field::Ay, Quantity::Acceleration, truth, optional, ""},
    FieldInfo{"az", Field::Az, Quantity::Acceleration, truth, optional, ""},
    FieldInfo{"latitude", Field::Latitude, Quantity::Angle, gps | truth, needed, "WGS-84, geodetic, north positive"},
    FieldInfo{"longitude", Field::Longitude, Quantity::Angle, gps | truth, needed, "east positive"},
    FieldInfo{"height", Field::Height, Quantity::Length, gps | truth, needed, "above the ellipsoid, not the sea"},
    FieldInfo{"sigma_horizontal", Field::SigmaHorizontal, Quantity::Length, gps, optional, "1-sigma of the receiver"},
    FieldInfo{"sigma_vertical", Field::SigmaVertical, Quantity::Length, gps, optional, "likewise"},
    FieldInfo{"sigma_velocity", Field::SigmaVelocity, Quantity::Speed, gps, optional, "likewise, per axis"},
    FieldInfo{"fix", Field::FixType, Quantity::Choice, gps, needed, "type of the fix"},
    FieldInfo{"satellites", Field::Satellites, Quantity::Number, gps, optional, "used for the fix, 0 to 255"},
    FieldInfo{"date", Field::Date, Quantity::Date, radar | gps | truth | angles, needed,
              "of the row's times of day, where it has a column of its own"},
};
static_assert(fields.size() == field_count);

constexpr std::array units{
    UnitInfo{"s", Quantity::Time, 1e9},
    UnitInfo{"ms", Quantity::Time, 1e6},
    UnitInfo{"us", Quantity::Time, 1e3},
    UnitInfo{"ns", Quantity::Time, 1},
    UnitInfo{"min", Quantity::Time, 60e9},
    UnitInfo{"h", Quantity::Time, 3600e9},
    UnitInfo{"d", Quantity::Time, 86400e9},
    UnitInfo{"m", Quantity::Length, 1},
    UnitInfo{"km", Quantity::Length, 1000},
    UnitInfo{"cm", Quantity::Length, 0.01},
    UnitInfo{"mm", Quantity::Length, 0.001},
    UnitInfo{"ft", Quantity::Length, 0.3048},
    UnitInfo{"kft", Quantity::Length, 304.8},
    UnitInfo{"yd", Quantity::Length, 0.9144},
    UnitInfo{"mi", Quantity::Length, 1609.344},
    UnitInfo{"nmi", Quantity::Length, 1852},
    UnitInfo{"deg", Quantity::Angle, std::numbers::pi / 180},
    UnitInfo{"mdeg", Quantity::Angle, std::numbers::pi / 180e3},
    UnitInfo{"arcmin", Quantity::Angle, std::numbers::pi / 10'800},
    UnitInfo{"arcsec", Quantity::Angle, std::numbers::pi / 648'000},
    UnitInfo{"rad", Quantity::Angle, 1},
    UnitInfo{"mrad", Quantity::Angle, 1e-3},
    UnitInfo{"mil", Quantity::Angle, std::numbers::pi / 3200},
    UnitInfo{"gon", Quantity::Angle, std::numbers::pi / 200},
    UnitInfo{"turn", Quantity::Angle, 2 * std::numbers::pi},
    UnitInfo{"m/s", Quantity::Speed, 1},
    UnitInfo{"km/s", Quantity::Speed, 1000},
    UnitInfo{"ft/s", Quantity::Speed, 0.3048},
    UnitInfo{"km/h", Quantity::Speed, 1 / 3.6},
    UnitInfo{"kn", Quantity::Speed, 1852.0 / 3600},
    UnitInfo{"m/s2", Quantity::Acceleration, 1},
    UnitInfo{"g", Quantity::Acceleration, 9.80665},
    UnitInfo{"1", Quantity::Number, 1},
    UnitInfo{"dB", Quantity::Number, 1},
};

/// How people write units, in small letters.
struct UnitSpelling {
  std::string_view text;
  std::string_view name;
};
constexpr std::array spellings{UnitSpelling{"sec", "s"},
                               UnitSpelling{"secs", "s"},
                               UnitSpelling{"second", "s"},
                               UnitSpelling{"seconds", "s"},
                               UnitSpelling{"msec", "ms"},
                               UnitSpelling{"milliseconds", "ms"},
                               UnitSpelling{"usec", "us"},
                               UnitSpelling{"\u00B5s", "us"},
                               UnitSpelling{"microseconds", "us"},
                               UnitSpelling{"nanoseconds", "ns"},
                               UnitSpelling{"minutes", "min"},
                               UnitSpelling{"hours", "h"},
                               UnitSpelling{"days", "d"},
                               UnitSpelling{"metre", "m"},
                               UnitSpelling{"metres", "m"},
                               UnitSpelling{"meter", "m"},
                               UnitSpelling{"meters", "m"},
                               UnitSpelling{"kilometres", "km"},
                               UnitSpelling{"kilometers", "km"},
                               UnitSpelling{"feet", "ft"},
                               UnitSpelling{"foot", "ft"},
                               UnitSpelling{"yards", "yd"},
                               UnitSpelling{"nm", "nmi"},
                               UnitSpelling{"nautical miles", "nmi"},
                               UnitSpelling{"degree", "deg"},
                               UnitSpelling{"degrees", "deg"},
                               UnitSpelling{"\u00B0", "deg"},
                               UnitSpelling{"\u00BA", "deg"},
                               UnitSpelling{"radian", "rad"},
                               UnitSpelling{"radians", "rad"},
                               UnitSpelling{"millirad", "mrad"},
                               UnitSpelling{"milliradians", "mrad"},
                               UnitSpelling{"mils", "mil"},
                               UnitSpelling{"mps", "m/s"},
                               UnitSpelling{"m s-1", "m/s"},
                               UnitSpelling{"meters/second", "m/s"},
                               UnitSpelling{"metres/second", "m/s"},
                               UnitSpelling{"fps", "ft/s"},
                               UnitSpelling{"kts", "kn"},
                               UnitSpelling{"kt", "kn"},
                               UnitSpelling{"knots", "kn"},
                               UnitSpelling{"kph", "km/h"},
                               UnitSpelling{"m/s^2", "m/s2"},
                               UnitSpelling{"m/s/s", "m/s2"},
                               UnitSpelling{"m/s\u00B2", "m/s2"},
                               UnitSpelling{"db", "dB"}};

constexpr std::array kinds{KindInfo{"radar", FileKind::Radar}, KindInfo{"angles", FileKind::Angles},
                           KindInfo{"gps", FileKind::Gps}, KindInfo{"truth", FileKind::Truth}};

// Of TrackMode and FixType (stage/event.hpp).
constexpr std::array<std::string_view, 4> modes{"search", "acquire", "track", "coast"};
constexpr std::array<std::string_view, 4> fixes{"none", "2d", "3d", "differential"};

}  // namespace

std::span<const FieldInfo> all_fields() { return fields; }

const FieldInfo& info_of(Field field) { return fields.at(static_cast<std::size_t>(field)); }

std::span<const UnitInfo> all_units() { return units; }

const UnitInfo* find_unit(Quantity quantity, std::string_view text) {
  const auto named = [&](std::string_view name) -> const UnitInfo* {
    const auto* found = std::find_if(units.begin(), units.end(),
                                     [&](const UnitInfo& u) { return u.quantity == quantity && u.name == name; });
    return found == units.end() ? nullptr : found;
  };
  if (const UnitInfo* found = named(text)) return found;
  std::string small(text);
  for (char& c : small) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  for (const UnitSpelling& spelling : spellings) {
    if (spelling.text != small) continue;
    if (const UnitInfo* found = named(spelling.name)) return found;
  }
  return named(small);
}

std::span<const std::string_view> choices_of(Field field) {
  if (field == Field::Mode) return modes;
  if (field == Field::FixType) return fixes;
  return {};
}

std::span<const KindInfo> all_kinds() { return kinds; }

}  // namespace downrange::archive
