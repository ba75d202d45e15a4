#include <algorithm>
#include <archive/import/row_values.hpp>
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
  left_empty_ = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const CellProblem found = read_cell(mapping_.columns[i], fields[places[i]]);
    if (found != CellProblem::None) return found;
  }
  if (has(Field::Latitude) && std::abs(value(Field::Latitude)) > std::numbers::pi / 2) {
    what_ = "latitude beyond a pole";
    return CellProblem::Malformed;
  }
  last_epoch_ = epoch_;
  last_received_ = received_;
  return CellProblem::None;
}

CellProblem RowValues::read_cell(const ColumnMapping& column, std::string_view text) {
  const FieldInfo& field = info_of(column.field);
  const auto quoted = [&] { return text::in_quotes(text); };
  const bool declared = std::find(mapping_.missing.begin(), mapping_.missing.end(), text) != mapping_.missing.end();
  const bool none = declared || is_no_value(text);
  // What a truth has of velocity cannot be left out of it.
  const bool optional = field.optional && mapping_.kind != FileKind::Truth;
  if (none && optional) {
    ++left_empty_;
    return CellProblem::None;
  }
  if (text.empty()) return problem(CellProblem::NotFinite, column, "empty");
  if (none) return problem(CellProblem::NotFinite, column, quoted() + " is no value");
  if (field.quantity == Quantity::Choice) return read_choice(column, text);
  if (field.quantity == Quantity::Time) return read_time(column, text);

  const auto number = parse_number<double>(text, rules_.mark);
  if (number.kind == NumberKind::NotANumber) {
    const bool stray = text.find('"') != std::string_view::npos;
    return problem(CellProblem::Malformed, column, quoted() + " is not a number" + (stray ? ": a stray quote" : ""));
  }
  const double value = number.value * column.factor + column.offset;
  if (number.kind == NumberKind::NotFinite || !std::isfinite(value)) {
    if (optional) {
      ++left_empty_;
      return CellProblem::None;
    }
    return problem(CellProblem::NotFinite, column, quoted() + " is not finite");
  }
  if (column.field == Field::Satellites && (value < 0 || value > 255 || value != std::floor(value))) {
    return problem(CellProblem::Malformed, column, quoted() + " is no count of satellites");
  }
  values_[static_cast<std::size_t>(column.field)] = value;
  there_.set(static_cast<std::size_t>(column.field));
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

long double RowValues::base_ns(const ColumnMapping& column, Since since) const {
  switch (since) {
    case Since::Liftoff:
      return rules_.liftoff.ns;
    case Since::Unix:
      return 0;
    case Since::Midnight:
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
      if (!column.since) {
        throw ImportError(column.column +
                          ": hours:minutes:seconds, which may be a time of day or a time since lift-off: "
                          "write since = \"midnight\" (with date = ... if the first is not within 12 h of lift-off) or "
                          "since = \"liftoff\"");
      }
      if (*column.since == Since::Unix) return std::nullopt;
      return base_ns(column, *column.since) + clock.ns +
             (*column.since == Since::Liftoff ? rules_.scale_minus_utc.ns : 0);
  }
  return std::nullopt;
}

/// A time of day, or of another period, on the day that continues the row before.
std::int64_t RowValues::continued(const ColumnMapping& column, std::int64_t ns) const {
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
  const auto clock = parse_clock(text);
  std::optional<long double> ns;
  bool absolute = false;  // a date of its own
  if (clock) {
    if (clock_example_.empty()) clock_example_ = text::printable(text, false, 40);
    absolute = clock->shape != ClockShape::Hours;
    ns = clock_ns(column, *clock);
    if (!ns) {
      const bool zone = clock->shape == ClockShape::Instant;
      return problem(CellProblem::Malformed, column,
                     text::in_quotes(text) + (zone ? " has an offset from UTC, and time_scale is another"
                                                   : " is no number of seconds since 1970"));
    }
    *ns += column.offset * 1e9L - rules_.scale_minus_utc.ns;
  } else {
    const auto number = parse_number<long double>(text, rules_.mark);
    if (number.kind == NumberKind::NotFinite) {
      return problem(CellProblem::NotFinite, column, text::in_quotes(text) + " is not finite");
    }
    if (number.kind == NumberKind::NotANumber || column.text) {
      return problem(CellProblem::Malformed, column,
                     text::in_quotes(text) + (text.find(':') != std::string_view::npos
                                                  ? " is no time: dates are year-month-day or year-day of year"
                                              : column.text ? " is no date and no time of day"
                                                            : " is not a number"));
    }
    const Since since = column.since.value_or(Since::Liftoff);
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
