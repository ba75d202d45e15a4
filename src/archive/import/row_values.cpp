#include <algorithm>
#include <archive/import/angles.hpp>
#include <archive/import/row_values.hpp>
#include <archive/import/unit_hints.hpp>
#include <cmath>
#include <numbers>
#include <text/printable.hpp>

namespace downrange::archive {
namespace {

constexpr std::int64_t day_ns = 86'400'000'000'000;

/// The multiple of `period` away from `ns` that is nearest to `reference`.
std::int64_t nearest(std::int64_t ns, std::int64_t reference, std::int64_t period) {
  const auto periods = std::llround(static_cast<double>(reference - ns) / static_cast<double>(period));
  return ns + periods * period;
}

constexpr const char* no_time =
    ": dates are year-month-day or year-day of year, with date_order = \"dmy\" or \"mdy\" day or month first; times of "
    "day "
    "are hours:minutes:seconds";
constexpr const char* no_date =
    " is no date: they are year-month-day, year-day of year, or with date_order = \"dmy\" or \"mdy\" day or month "
    "first";

/// What a text is an example of.
std::string name_of_clock(const ClockTime& clock) {
  switch (clock.shape) {
    case ClockShape::Instant:
      return "dates such as ";
    case ClockShape::DayOfYear:
      return "days of the year such as ";
    case ClockShape::Hours:
      return "hours:minutes:seconds such as ";
    case ClockShape::Countdown:
      return "times from lift-off such as ";
  }
  return {};
}

/// What a radar's plot may lack, as long as it has its range or both angles.
bool is_part_of_plot(FileKind kind, Field field) {
  return kind == FileKind::Radar && (field == Field::Range || field == Field::Azimuth || field == Field::Elevation);
}

std::int64_t midnight_before(Time time) {
  const std::int64_t since = time.ns % day_ns;
  return time.ns - (since < 0 ? since + day_ns : since);
}

}  // namespace

CellProblem RowValues::problem(CellProblem kind, const ColumnMapping& column, const std::string& what) {
  what_ = text::printable(column.column, false, 40) + ": " + what;
  return kind;
}

CellProblem RowValues::read(const std::vector<std::string_view>& fields, const std::vector<std::size_t>& places) {
  there_.reset();
  epoch_clock_.reset();
  left_empty_ = 0;
  date_.reset();
  // The date first: times of day need it.
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (mapping_.columns[i].field != Field::Date) continue;
    const CellProblem found = read_cell(mapping_.columns[i], fields[places[i]]);
    if (found != CellProblem::None) return found;
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (mapping_.columns[i].field == Field::Date) continue;
    const CellProblem found = read_cell(mapping_.columns[i], fields[places[i]]);
    if (found != CellProblem::None) return found;
  }
  if (has(Field::Latitude) && std::abs(value(Field::Latitude)) > std::numbers::pi / 2) {
    const std::string what = latitude_problem(mapping_, value(Field::Latitude), value(Field::Longitude));
    return problem(CellProblem::Malformed, *mapping_.column_of(Field::Latitude), what);
  }
  if (mapping_.kind == FileKind::Radar && !has(Field::Range) && !has_angles()) {
    what_ = "neither a range nor both angles";
    return CellProblem::NotFinite;
  }
  last_epoch_ = epoch_;
  last_received_ = received_;
  return CellProblem::None;
}

bool RowValues::may_be_absent(Field field) const {
  // What a truth has of velocity cannot be left out of it.
  return (info_of(field).optional && mapping_.kind != FileKind::Truth) || is_part_of_plot(mapping_.kind, field);
}

/// By its letters, or as the same number: "-9999.0" is "-9999".
bool RowValues::is_missing(std::string_view text) const {
  if (mapping_.missing.empty()) return false;
  const auto number = parse_number<double>(text, rules_.mark);
  return std::ranges::any_of(mapping_.missing, [&](const std::string& missing) {
    if (missing == text) return true;
    const auto same = parse_number<double>(missing, DecimalMark::Point);
    return number.kind == NumberKind::Finite && same.kind == NumberKind::Finite && number.value == same.value;
  });
}

CellProblem RowValues::read_cell(const ColumnMapping& column, std::string_view text) {
  const FieldInfo& field = info_of(column.field);
  const auto quoted = [&] { return text::in_quotes(text); };
  const bool declared = is_missing(text);
  // "none" may be a value of its own.
  const bool choice =
      std::any_of(column.values.begin(), column.values.end(), [&](const auto& v) { return v.first == text; });
  const bool none = declared || (is_no_value(text) && !choice);
  if (none && may_be_absent(column.field)) {
    ++left_empty_;
    return CellProblem::None;
  }
  if (text.empty()) return problem(CellProblem::NotFinite, column, "empty");
  if (none) return problem(CellProblem::NotFinite, column, quoted() + " is no value");
  if (field.quantity == Quantity::Choice) return read_choice(column, text);
  if (field.quantity == Quantity::Time) return read_time(column, text);

  if (field.quantity == Quantity::Date) return read_date(column, text);
  return read_number(column, text);
}

/// The number of "12 km" where the column is in km; else the text as it is.
std::string_view RowValues::without_unit(const ColumnMapping& column, std::string_view text) {
  const std::size_t end = text.find_last_of("0123456789.,");
  if (column.unit.empty() || end == std::string_view::npos || end + 1 == text.size()) return text;
  const UnitInfo* unit = find_unit(info_of(column.field).quantity, trimmed(text.substr(end + 1)));
  return unit == nullptr || unit->name != column.unit ? text : trimmed(text.substr(0, end + 1));
}

ParsedNumber<double> RowValues::number_of(const ColumnMapping& column, std::string_view text) const {
  const Quantity quantity = info_of(column.field).quantity;
  const bool degrees = quantity == Quantity::Angle && column.unit == "deg";
  if (degrees) {
    const auto letters = column.field == Field::Latitude    ? AngleLetters::NorthSouth
                         : column.field == Field::Longitude ? AngleLetters::EastWest
                                                            : AngleLetters::None;
    if (const auto found = parse_degrees(text, rules_.mark, letters)) return {NumberKind::Finite, *found};
    // "12 345" as degrees is no thousands.
    if (trimmed(text).find(' ') != std::string_view::npos) return {};
  }
  const auto number = parse_number<double>(text, rules_.mark);
  if (number.kind != NumberKind::NotANumber || column.unit.empty()) return number;
  return parse_number<double>(without_unit(column, text), rules_.mark);
}

std::string RowValues::why_no_number(const ColumnMapping& column, std::string_view text) const {
  if (text.find('\0') != std::string_view::npos) return " holds zero bytes";
  if (text.find('"') != std::string_view::npos) return " is not a number: a stray quote";
  const Quantity quantity = info_of(column.field).quantity;
  if (quantity == Quantity::Angle && column.unit != "deg" &&
      parse_degrees(text, rules_.mark, AngleLetters::None).has_value()) {
    return " is degrees: write unit = \"deg\"";
  }
  const std::size_t end = text.find_last_of("0123456789.,");
  const UnitInfo* unit = end == std::string_view::npos ? nullptr : find_unit(quantity, trimmed(text.substr(end + 1)));
  if (unit != nullptr && unit->name != column.unit) {
    return " says " + std::string(unit->name) + ", the mapping unit = \"" + column.unit + '"';
  }
  return " is not a number";
}

CellProblem RowValues::read_number(const ColumnMapping& column, std::string_view text) {
  const auto number = number_of(column, text);
  if (number.kind == NumberKind::NotANumber) {
    return problem(CellProblem::Malformed, column, text::in_quotes(text) + why_no_number(column, text));
  }
  const double value = number.value * column.factor + column.offset;
  if (number.kind == NumberKind::NotFinite || !std::isfinite(value)) {
    if (may_be_absent(column.field)) {
      ++left_empty_;
      return CellProblem::None;
    }
    return problem(CellProblem::NotFinite, column, text::in_quotes(text) + " is not finite");
  }
  if (column.field == Field::Satellites && (value < 0 || value > 255 || value != std::floor(value))) {
    return problem(CellProblem::Malformed, column, text::in_quotes(text) + " is no count of satellites");
  }
  values_[static_cast<std::size_t>(column.field)] = value;
  there_.set(static_cast<std::size_t>(column.field));
  return CellProblem::None;
}

CellProblem RowValues::read_date(const ColumnMapping& column, std::string_view text) {
  auto found = parse_clock(std::string(text) + " 00:00:00", mapping_.date_order);
  if (!found || found->shape != ClockShape::Instant) found = parse_clock(std::string(text) + "T000000");
  if (!found || found->shape != ClockShape::Instant) {
    return problem(CellProblem::Malformed, column, text::in_quotes(text) + no_date);
  }
  date_ = Time{found->ns};
  return CellProblem::None;
}

CellProblem RowValues::read_choice(const ColumnMapping& column, std::string_view text) {
  const auto number = parse_number<double>(text, DecimalMark::Point);
  const auto fits = [&](const std::pair<std::string, int>& value) {
    if (value.first == text) return true;
    const auto named = parse_number<double>(value.first, DecimalMark::Point);
    return number.kind == NumberKind::Finite && named.kind == NumberKind::Finite && named.value == number.value;
  };
  auto found = std::find_if(column.values.begin(), column.values.end(), fits);
  if (found == column.values.end()) {
    found = std::find_if(column.values.begin(), column.values.end(), [](const auto& v) { return v.first == "*"; });
  }
  if (found == column.values.end()) {
    return problem(CellProblem::Malformed, column,
                   text::in_quotes(text) + " is no value of it; write values = {\"" + text::printable(text, false, 40) +
                       "\" = ...}");
  }
  values_[static_cast<std::size_t>(column.field)] = found->second;
  there_.set(static_cast<std::size_t>(column.field));
  return CellProblem::None;
}

/// A time of day beside a date needs no other word.
std::optional<Since> RowValues::since_of(const ColumnMapping& column) const {
  return !column.since && date_ ? std::optional(Since::Midnight) : column.since;
}

long double RowValues::base_ns(const ColumnMapping& column, Since since) const {
  switch (since) {
    case Since::Liftoff:
      return rules_.liftoff.ns;
    case Since::Unix:
      return 0;
    case Since::Midnight:
      if (date_) return date_->ns;
      return mapping_.date ? mapping_.date->ns : midnight_before(rules_.liftoff);
    case Since::Instant:
      return column.instant.ns;
  }
  return 0;
}

/// Nanoseconds since 1970 on the file's scale; nothing where the text does not fit the declaration.
std::optional<long double> RowValues::clock_ns(const ColumnMapping& column, const ClockTime& clock) {
  switch (clock.shape) {
    case ClockShape::Instant:
      if (clock.zoned && mapping_.scale != TimeScale::Utc) return std::nullopt;
      return clock.ns;
    case ClockShape::Countdown:
      return rules_.liftoff.ns + clock.ns + rules_.scale_minus_utc.ns;
    case ClockShape::DayOfYear: {
      // Of the year that puts it nearest to lift-off; each year has its own first of January.
      const std::int64_t year_ns = 365 * day_ns;
      std::optional<std::int64_t> best;
      for (const std::int64_t around : {-year_ns, std::int64_t{0}, year_ns}) {
        const auto first = parse_clock(show_utc(rules_.liftoff + Duration{around}).substr(0, 4) + "-01-01T00:00:00Z");
        const std::int64_t ns = first->ns + clock.ns;
        const auto away = [&](std::int64_t t) { return std::abs(t - rules_.liftoff.ns); };
        if (!best || away(ns) < away(*best)) best = ns;
      }
      return *best;
    }
    case ClockShape::Hours:
      if (!since_of(column)) {
        throw ImportError(column.column +
                          ": hours:minutes:seconds, which may be a time of day or a time since lift-off: "
                          "write since = \"midnight\" (with date = ... if the first is not within 12 h of lift-off) or "
                          "since = \"liftoff\"");
      }
      if (*since_of(column) == Since::Unix) return std::nullopt;
      return base_ns(column, *since_of(column)) + clock.ns +
             (*since_of(column) == Since::Liftoff ? rules_.scale_minus_utc.ns : 0);
  }
  return std::nullopt;
}

/// A time of day, or of another period, on the day that continues the row before.
std::int64_t RowValues::continued(const ColumnMapping& column, std::int64_t ns) const {
  if (date_) return ns;
  const bool of_day = column.since == Since::Midnight;
  const std::int64_t period = mapping_.wrap ? mapping_.wrap->ns : of_day ? day_ns : 0;
  if (period == 0) return ns;
  const auto& last = column.field == Field::Epoch ? last_epoch_ : last_received_;
  if (last) return nearest(ns, last->ns, period);
  // The first: on the day that the mapping says, or the nearest to lift-off; other counters start as they stand.
  return of_day && !mapping_.date ? nearest(ns, rules_.liftoff.ns, period) : ns;
}

/// With 64 bits of mantissa: a double of seconds since 1970 is good to a quarter of a microsecond only.
CellProblem RowValues::read_time(const ColumnMapping& column, std::string_view text) {
  const auto unpacked = column.packed ? unpacked_clock(text) : std::nullopt;
  auto clock = unpacked ? parse_clock(*unpacked) : parse_clock(text, mapping_.date_order);
  if (!clock) clock = compact_instant(text);
  std::optional<long double> ns;
  bool absolute = false;  // a date of its own
  if (clock) {
    if (clock_example_.empty()) clock_example_ = name_of_clock(*clock) + text::printable(text, false, 40);
    if (column.field == Field::Epoch) epoch_clock_ = clock;
    absolute = clock->shape != ClockShape::Hours;
    ns = clock_ns(column, *clock);
    if (!ns) {
      const bool zone = clock->shape == ClockShape::Instant;
      return problem(CellProblem::Malformed, column,
                     "found " + text::in_quotes(text) + (zone ? other_scale() : " is no number of seconds since 1970"));
    }
    *ns += column.offset * 1e9L - rules_.scale_minus_utc.ns;
  } else {
    auto number = parse_number<long double>(text, rules_.mark);
    if (number.kind == NumberKind::NotANumber)
      number = parse_number<long double>(without_unit(column, text), rules_.mark);
    if (number.kind == NumberKind::NotFinite) {
      return problem(CellProblem::NotFinite, column, text::in_quotes(text) + " is not finite");
    }
    if (number.kind == NumberKind::NotANumber || column.text || column.packed) {
      const bool date = text.find(':') != std::string_view::npos;
      return problem(CellProblem::Malformed, column,
                     text::in_quotes(text) + (date            ? std::string(" is no time") + no_time
                                              : column.packed ? " is no time as hhmmss"
                                              : column.text   ? " is no date and no time of day"
                                                              : " is not a number"));
    }
    const Since since = since_of(column).value_or(Since::Liftoff);
    if (since == Since::Liftoff) refuse_scale(column, text);
    const long double span = number.value * column.factor + column.offset * 1e9L;
    ns = base_ns(column, since) + span - (since == Since::Liftoff ? 0 : rules_.scale_minus_utc.ns);
    if (!(*ns >= 0 && *ns < 4.1024448e18L)) {
      return problem(CellProblem::Malformed, column,
                     text::in_quotes(text) + " is no time of a flight" + other_meaning(number.value));
    }
  }
  if (!(*ns >= 0 && *ns < 4.1024448e18L)) {
    return problem(CellProblem::Malformed, column, text::in_quotes(text) + " is not in the years 1970 to 2100");
  }
  std::int64_t whole = std::llround(*ns);
  if (!absolute) whole = continued(column, whole);
  (column.field == Field::Epoch ? epoch_ : received_) = Time{whole};
  there_.set(static_cast<std::size_t>(column.field));
  return CellProblem::None;
}

std::string RowValues::other_scale() const {
  const std::string scale = mapping_.scale == TimeScale::Gps ? "GPS" : "TAI";
  return ", which says its offset from UTC (a Z is one), expected none with time_scale = \"" + scale +
         "\": leave time_scale out where the offset is right, else take the offset out of the file";
}

/// Numbers from lift-off are the same on every scale: the mapping means others.
void RowValues::refuse_scale(const ColumnMapping& column, std::string_view text) const {
  if (mapping_.scale == TimeScale::Utc) return;
  throw ImportError(column.column + ": found " + text::in_quotes(text) +
                    ", which without since is a number from lift-off, where time_scale has no meaning; allowed: dates, "
                    "numbers with since = \"gps\", \"unix\" or \"midnight\", or no time_scale");
}

/// The units and references under which a number is a time within a day of lift-off; the likelier references first.
std::string RowValues::other_meaning(long double number) const {
  const std::array<std::pair<const char*, long double>, 4> references{{{"unix", 0},
                                                                       {"gps", 315'964'800e9L},
                                                                       {"midnight", midnight_before(rules_.liftoff)},
                                                                       {"liftoff", rules_.liftoff.ns}}};
  for (const auto& [since, base] : references) {
    std::string found;
    for (const UnitInfo& unit : all_units()) {
      if (unit.quantity != Quantity::Time || std::abs(number * unit.size + base - rules_.liftoff.ns) > day_ns) continue;
      found += (found.empty() ? "; it would be one with unit = \"" : "\" or \"") + std::string(unit.name);
    }
    if (!found.empty()) return found + "\", since = \"" + since + '"';
  }
  return {};
}

}  // namespace downrange::archive
