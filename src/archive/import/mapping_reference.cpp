#include <archive/import/mapping.hpp>
#include <sstream>

namespace downrange::archive {
namespace {

constexpr const char* keys = R"(mission        name of the flight; required
liftoff        date and time with offset (2017-06-03T21:07:38Z), or nanoseconds since 1970 UTC; required
target         name of the target of every file that does not name its own
folder         of the files, relative to the mapping; default: the mapping's
leap_seconds   GPS time minus UTC, for files in GPS or TAI time; default: --config's, else 18 (since 2017)

[[file]]  one file of measurements; the same file may stand in several, with a filter each
  path           required
  kind           radar, angles, gps or truth; required. A radar's file, and each of its rows, has range, or azimuth and
                 elevation, or all of them
  format         table (default), or nmea: NMEA 0183 sentences of a receiver (GGA or GNS; GST, RMC and ZDA where they are
                 there), which need no columns
  sensor         name of the radar or tracker (radar, angles); required
  station        name of the telemetry station (gps); required
  receiver       name of the receiver, where the vehicle has several (gps)
  target         name of the target
                 Each name may stand in a column instead: sensor = {column = "RADAR"}, or with other names for what the
                 cells say: {column = "RADAR", names = {"1" = "cape", "2" = "merritt"}}
  latency_s      received = epoch + latency; needed where no column says when a row was received

  How the file is written. Not given: found out, where that is certain.
  delimiter      one character, "tab", or "blanks" for runs of spaces and tabs
  decimal        "." or ","
  header         false: there is no line of names, columns are "1", "2", ...; default true
  skip_lines     lines at the top that are not read
  comment        what starts a comment line: a text or a list; default ["#", "%", "//", ";"]; []: nothing
  missing        cells that stand for no value, beside "", "-", "N/A", "null", "***": a text or a list; "-9999" is -9999.0 too
  where          {column = "TRK", equals = "1"}: read these rows only; or differs = ...; a value or a list of values; a
                 list of such tables: all of them
  other_columns  "ignore": columns that the mapping does not name are left out

  What its times are.
  time_scale     UTC (default), GPS or TAI: of dates, times of day and numbers that are not from lift-off
  date           day of the first time since midnight; default: the day that is nearest to lift-off
  date_order     "dmy" or "mdy": dates such as 04/03/2025 are day or month first; default "ymd": they are no dates
  wrap_s         times start anew this often (86400: each midnight, 604800: each week) and are continued; 0: they do not
  sort           true: sort the rows by their epoch; false: take them as they stand; default: refused where the rows
                 cannot be in order
  accept_implausible   true: import what looks like a wrong unit all the same

  [file.columns]  every column of the file: name = "ignore", or name = {field = ..., unit = ..., ...}. "name#2" is the second
                  column of that name, "#3" the third of all. Small and capital letters, and a unit behind the name in the
                  file ("rng [m]"), make no difference; a unit there must be the one declared here, but for columns by number
    field   see below
    unit    see below
    at      [first, last]: the column's characters in a line, from 1, where nothing stands between columns; then of every
            column. One without a field, for where or a name: {at = [1, 4]}. With header = true the first line is not read
    scale   value = number * scale * unit + offset; default 1
    offset  in SI units, radians, seconds; default 0
    since   of times: "liftoff" (default), "unix" (1970), "midnight" (a time of day), "gps" (1980-01-06), or a date and time
            with offset. Dates (ISO 8601, year-day of year, 4-Mar-2025), T+00:01:02 and times beside a date column need none
    values  of mode and fix: what the cells say, e.g. {"1" = "track", "*" = "coast"}; "*": anything else
)";

}  // namespace

std::string mapping_reference() {
  std::ostringstream out;
  out << keys << "\nFields\n";
  for (const FieldInfo& field : all_fields()) {
    std::string kinds;
    for (const KindInfo& kind : all_kinds()) {
      if ((field.kinds & kind_mask(kind.kind)) != 0) kinds += (kinds.empty() ? "" : ", ") + std::string(kind.name);
    }
    std::string values;
    for (const std::string_view choice : choices_of(field.field))
      values += (values.empty() ? ": " : ", ") + std::string(choice);
    out << "  " << field.name << std::string(18 - field.name.size(), ' ') << '(' << kinds << ") " << field.help
        << values << '\n';
  }
  constexpr std::pair<const char*, Quantity> quantities[] = {
      {"time", Quantity::Time},
      {"length", Quantity::Length},
      {"angle (of deg also 12:34:56.7, 34.43N)", Quantity::Angle},
      {"speed", Quantity::Speed},
      {"acceleration", Quantity::Acceleration},
      {"number (none needed)", Quantity::Number}};
  out << "\nUnits\n";
  for (const auto& [name, quantity] : quantities) {
    const Quantity wanted = quantity;
    out << "  " << name << ": " << names_of(all_units(), [&](const UnitInfo& u) { return u.quantity == wanted; })
        << (quantity == Quantity::Time ? ", text (dates and times of day only), hhmmss (one number)" : "") << '\n';
  }
  return out.str();
}

}  // namespace downrange::archive
