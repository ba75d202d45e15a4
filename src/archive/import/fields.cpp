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
    UnitInfo{"ft", Quantity::Length, 0.3048},
    UnitInfo{"yd", Quantity::Length, 0.9144},
    UnitInfo{"nmi", Quantity::Length, 1852},
    UnitInfo{"deg", Quantity::Angle, std::numbers::pi / 180},
    UnitInfo{"rad", Quantity::Angle, 1},
    UnitInfo{"mrad", Quantity::Angle, 1e-3},
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

constexpr std::array kinds{KindInfo{"radar", FileKind::Radar}, KindInfo{"angles", FileKind::Angles},
                           KindInfo{"gps", FileKind::Gps}, KindInfo{"truth", FileKind::Truth}};

// Of TrackMode and FixType (stage/event.hpp).
constexpr std::array<std::string_view, 4> modes{"search", "acquire", "track", "coast"};
constexpr std::array<std::string_view, 4> fixes{"none", "2d", "3d", "differential"};

}  // namespace

std::span<const FieldInfo> all_fields() { return fields; }

const FieldInfo& info_of(Field field) { return fields.at(static_cast<std::size_t>(field)); }

std::span<const UnitInfo> all_units() { return units; }

std::span<const std::string_view> choices_of(Field field) {
  if (field == Field::Mode) return modes;
  if (field == Field::FixType) return fixes;
  return {};
}

std::span<const KindInfo> all_kinds() { return kinds; }

}  // namespace downrange::archive
