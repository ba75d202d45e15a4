#pragma once
/// The declared mapping of an import: which column of which CSV file is which field of which record. As TOML:
///
///     mission = "crs11"
///     target = "falcon9"                 # of every file that does not name its own
///     liftoff = 2017-06-03T21:07:38Z     # with offset, or an integer: nanoseconds since 1970 UTC
///     folder = "../data"                 # of the CSV files, relative to this file; default: this file's
///
///     [[file]]
///     path = "radar.csv"
///     kind = "radar"                     # radar, angles, gps, truth
///     sensor = "cape"                    # radar or angles-only tracker; a gps file has station, and receiver where
///     the vehicle has several latency_s = 0.2                    # where no column says when a row was received
///     delimiter = ","
///     [file.columns]                     # every column of the file
///     time_s = {field = "epoch", unit = "s", since = "liftoff"}   # or since = "unix"
///     az_deg = {field = "azimuth", unit = "deg", scale = 1.0, offset = 0.0}   # SI value = number*scale*unit + offset
///     outlier = "ignore"

#include <cstdint>
#include <downrange/geo/name.hpp>
#include <downrange/geo/time.hpp>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace downrange::archive {

/// A mapping or a CSV file that cannot be imported. The text names file, line, key and what is allowed.
class ImportError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

enum class FileKind : std::uint8_t { Radar, Gps, Truth, Angles };

/// What a column can mean. SI and radians; times from their reference.
enum class Field : std::uint8_t {
  Epoch,
  Received,
  Range,
  Azimuth,
  Elevation,
  RangeRate,
  Snr,  ///< dB
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
  Satellites,
};
inline constexpr std::size_t field_count = 23;

struct ColumnMapping {
  std::string column;
  Field field = Field::Epoch;
  double factor = 1;        ///< scale times unit, to SI; of times to nanoseconds
  double offset = 0;        ///< SI (times: seconds), added after the factor
  bool since_unix = false;  ///< times only: from 1970, not from lift-off
};

struct FileMapping {
  std::filesystem::path path;
  FileKind kind = FileKind::Radar;
  Name source;  ///< radar, angles-only tracker, or telemetry station
  Name receiver;
  Name target;
  std::optional<Duration> latency;  ///< received = epoch + latency, never decreasing; nothing: a column says
  char delimiter = ',';
  std::vector<ColumnMapping> columns;
  std::vector<std::string> ignored;

  [[nodiscard]] bool has(Field field) const;
};

struct ImportMapping {
  Name mission;
  Time liftoff;
  std::vector<FileMapping> files;
  std::string text;  ///< the TOML file itself
};

/// Reads and checks a mapping. `folder`, where given, holds the CSV files instead of the mapping's own. Throws
/// ImportError.
[[nodiscard]] ImportMapping load_mapping(const std::filesystem::path& file,
                                         const std::optional<std::filesystem::path>& folder = std::nullopt);

}  // namespace downrange::archive
