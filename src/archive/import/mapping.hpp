#pragma once
/// The declared mapping of an import: which column of which file is which field of which record. As TOML:
///
///     mission = "crs11"
///     target = "falcon9"                 # of every file that does not name its own
///     liftoff = 2017-06-03T21:07:38Z
///     folder = "../data"                 # of the files, relative to this one
///
///     [[file]]
///     path = "radar.csv"
///     kind = "radar"
///     sensor = "cape"
///     [file.columns]                     # every column of the file
///     time_s = {field = "epoch", unit = "s", since = "liftoff"}
///     az_deg = {field = "azimuth", unit = "deg", scale = 1.0, offset = 0.0}   # SI value = number*scale*unit + offset
///     outlier = "ignore"
///
/// mapping_reference() lists every key.

#include <archive/import/fields.hpp>
#include <archive/import/import_error.hpp>
#include <archive/import/numbers.hpp>
#include <archive/import/rows.hpp>
#include <archive/import/times.hpp>
#include <downrange/geo/name.hpp>
#include <downrange/geo/time.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace downrange::archive {

/// What the numbers, or the times of day, of a time column are counted from.
enum class Since : std::uint8_t { Liftoff, Unix, Midnight, Instant };

/// A column: by its header's name, as "name#2" the second of that name, as "#3" the third of all.
struct ColumnMapping {
  std::string column;
  Field field = Field::Epoch;
  double factor = 1;    ///< scale times unit, to SI; of times to nanoseconds
  double offset = 0;    ///< SI (times: seconds), added after the factor
  std::string unit;     ///< as declared; empty: none
  bool scaled = false;  ///< the numbers are in the unit only after a scale
  // Times only.
  std::optional<Since> since;  ///< not declared: numbers are from lift-off, times of day are refused
  Time instant;                ///< for Since::Instant
  bool text = false;           ///< the cells are dates or times of day, no numbers
  bool packed = false;         ///< hhmmss.sss as one number
  // Choices only: what the cells say, and which value that is; "*" is anything else.
  std::vector<std::pair<std::string, int>> values;
};

/// A row is read where the cell is one of the texts (or none of them).
struct RowFilter {
  std::string column;
  std::vector<std::string> texts;
  bool equals = true;
  bool exact = false;  ///< by letter: "1" is not "01"
};

/// A name that a column says, row by row.
struct NameColumn {
  std::string column;
  std::vector<std::pair<std::string, Name>>
      names;  ///< what the cells say, and whose name that is; empty: the cells' own
};

/// A column by its place in the line.
struct FixedColumn {
  std::string name;
  FixedPlace place;
};

enum class TimeScale : std::uint8_t { Utc, Gps, Tai };

struct FileMapping {
  std::filesystem::path path;
  FileKind kind = FileKind::Radar;
  Name source;  ///< radar, angles-only tracker, or telemetry station
  Name receiver;
  Name target;
  // Where the rows say it, instead of the name above.
  std::optional<NameColumn> source_column;
  std::optional<NameColumn> receiver_column;
  std::optional<NameColumn> target_column;
  bool first_of_names = true;  ///< of the parts of a file by its names: the one that counts rows too short to have any
  std::optional<Duration> latency;  ///< received = epoch + latency, never decreasing; nothing: a column says

  // How the file is written. Nothing: found out, where that is certain.
  bool nmea = false;                     ///< NMEA 0183 sentences, which need no columns
  std::vector<FixedColumn> fixed;        ///< columns by their places; empty: by a delimiter
  std::vector<std::string> given_names;  ///< of all columns, where no header is read
  std::uint64_t skip_lines = 0;          ///< at the top
  std::optional<Delimiter> delimiter;
  std::optional<DecimalMark> decimal;
  std::optional<std::vector<std::string>> comments;
  bool header = true;                ///< false: columns are "1", "2", ...
  std::vector<std::string> missing;  ///< cells that stand for no value, beside the usual ones
  std::vector<RowFilter> filters;

  // What its times are.
  TimeScale scale = TimeScale::Utc;
  DateOrder date_order = DateOrder::YearFirst;
  std::optional<Time> date;      ///< the day of the first time since midnight; nothing: the nearest to lift-off
  std::optional<Duration> wrap;  ///< times start anew this often; 0: they do not, whatever it looks like
  std::optional<bool> sort;      ///< by epoch; nothing: refused where the rows cannot be in order
  bool accept_implausible = false;

  std::vector<ColumnMapping> columns;
  std::vector<std::string> ignored;
  bool ignore_others = false;

  [[nodiscard]] bool has(Field field) const { return column_of(field) != nullptr; }
  /// Null where no column is the field.
  [[nodiscard]] const ColumnMapping* column_of(Field field) const;
  /// The columns that say names.
  [[nodiscard]] std::vector<const NameColumn*> name_columns() const;
};

struct ImportMapping {
  Name mission;
  Time liftoff;
  std::optional<int> leap_seconds;  ///< GPS minus UTC
  std::vector<FileMapping> files;
  std::string text;  ///< the TOML file itself
};

/// Reads and checks a mapping. `folder`, where given, holds the files instead of the mapping's own. Throws ImportError.
[[nodiscard]] ImportMapping load_mapping(const std::filesystem::path& file,
                                         const std::optional<std::filesystem::path>& folder = std::nullopt);

/// Every key of a mapping with its meaning, fields and units, for people.
[[nodiscard]] std::string mapping_reference();

}  // namespace downrange::archive
