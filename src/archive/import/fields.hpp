#pragma once
/// What a column can mean, and in which units.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace downrange::archive {

enum class FileKind : std::uint8_t { Radar, Gps, Truth, Angles };

/// SI and radians; times from their reference.
enum class Field : std::uint8_t {
  Epoch,
  Received,
  Range,
  Azimuth,
  Elevation,
  RangeRate,
  Snr,  ///< dB
  Mode,
  X,
  Y,
  Z,
  Vx,
  Vy,
  Vz,
  Ax,
  Ay,
  Az,
  Latitude,
  Longitude,
  Height,  ///< above the ellipsoid
  SigmaHorizontal,
  SigmaVertical,
  SigmaVelocity,
  FixType,
  Satellites,
  Date,  ///< of a time of day in another column
};
inline constexpr std::size_t field_count = 26;

enum class Quantity : std::uint8_t { Time, Length, Angle, Speed, Acceleration, Number, Choice, Date };

struct FieldInfo {
  std::string_view name;
  Field field;
  Quantity quantity;
  unsigned kinds;  ///< of files that can have it, as kind_mask
  bool optional;   ///< a row without a value for it is a record all the same
  std::string_view help;
};
[[nodiscard]] constexpr unsigned kind_mask(FileKind kind) { return 1U << static_cast<unsigned>(kind); }
[[nodiscard]] std::span<const FieldInfo> all_fields();
[[nodiscard]] const FieldInfo& info_of(Field field);

/// How a unit's numbers become SI; of times nanoseconds, so that the factor is exact.
struct UnitInfo {
  std::string_view name;
  Quantity quantity;
  double size;
};
[[nodiscard]] std::span<const UnitInfo> all_units();

/// The unit of a quantity that a text says, by its name or as people write it ("metres", "degrees", "sec"); null where
/// it says none.
[[nodiscard]] const UnitInfo* find_unit(Quantity quantity, std::string_view text);

/// Names of the values of a field that is a choice, in the order of its enumeration.
[[nodiscard]] std::span<const std::string_view> choices_of(Field field);

struct KindInfo {
  std::string_view name;
  FileKind kind;
};
[[nodiscard]] std::span<const KindInfo> all_kinds();

/// "a, b, c" of the names that a condition lets through.
template <class Table, class Condition>
std::string names_of(const Table& table, Condition condition) {
  std::string out;
  for (const auto& entry : table) {
    if (condition(entry)) out += (out.empty() ? "" : ", ") + std::string(entry.name);
  }
  return out;
}

}  // namespace downrange::archive
