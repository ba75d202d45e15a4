#include <algorithm>
#include <archive/import/time_hints.hpp>
#include <archive/import/times.hpp>
#include <archive/import/unit_hints.hpp>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

namespace downrange::archive {
namespace {

constexpr double hour_s = 3600;
constexpr double day_s = 86'400;
constexpr double gps_epoch_s = 315'964'800;
/// 1899-12-30, from which spreadsheets count days.
constexpr double spreadsheet_epoch_s = -2'209'161'600;
/// Between rows.
constexpr double shortest_step_s = 0.002;
constexpr double longest_step_s = 60;

/// Numbers of a file's epochs, and the time between two rows.
struct Numbers {
  double least = 0;
  double most = 0;
  double step = 0;  ///< median; 0: not known
};

/// A reference and a unit: seconds after lift-off = number * size_s + base_s.
struct Reading {
  std::string advice;
  double size_s = 1;
  double base_s = 0;
};

enum class Nearness : std::uint8_t { Whole, InPart };

Numbers seconds_of(Time liftoff, const std::vector<PlausibleRow>& rows) {
  const auto since = [&](const PlausibleRow& row) { return (row.epoch - liftoff).seconds(); };
  Numbers found{since(rows.front()), since(rows.front())};
  std::vector<double> steps;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    found.least = std::min(found.least, since(rows[i]));
    found.most = std::max(found.most, since(rows[i]));
    if (i > 0) steps.push_back(std::abs((rows[i].epoch - rows[i - 1].epoch).seconds()));
  }
  if (steps.empty()) return found;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  found.step = *middle;
  return found;
}

bool is_near(const Numbers& n, const Reading& reading, Nearness nearness) {
  const double step_s = n.step * reading.size_s;
  if (n.step > 0 && (step_s < shortest_step_s || step_s > longest_step_s)) return false;
  const double least_s = n.least * reading.size_s + reading.base_s;
  const double most_s = n.most * reading.size_s + reading.base_s;
  if (nearness == Nearness::Whole) return least_s > -hour_s && most_s < hour_s;
  return least_s < hour_s && most_s > -hour_s;
}

class Hints {
 public:
  Hints(const FileMapping& mapping, const ColumnMapping& column, Time liftoff, const std::vector<PlausibleRow>& rows)
      : mapping_(mapping),
        column_(column),
        liftoff_s_(static_cast<double>(liftoff.ns) * 1e-9),
        times_(seconds_of(liftoff, rows)),
        clock_(rows.front().clock) {}

  [[nodiscard]] std::string run() const {
    const std::string keys = of_keys();
    if (!keys.empty()) return "with " + keys;
    const bool of_a_clock = clock_ ? clock_->shape != ClockShape::Hours || !since_liftoff() : !since_liftoff();
    return of_a_clock ? of_zones() : std::string();
  }

 private:
  /// Beside a date the times are of that day.
  [[nodiscard]] bool has_dates() const { return mapping_.has(Field::Date); }
  [[nodiscard]] bool since_liftoff() const {
    return !has_dates() && column_.since.value_or(Since::Liftoff) == Since::Liftoff;
  }
  [[nodiscard]] double of_day_s() const { return std::fmod(liftoff_s_, day_s); }
  [[nodiscard]] double unit_s() const {
    const UnitInfo* unit = unit_of(&column_);
    return unit == nullptr ? 1 : unit->size * 1e-9;
  }

  /// Another reference or unit.
  [[nodiscard]] std::string of_keys() const {
    if (clock_) return clock_->shape == ClockShape::Hours && since_liftoff() ? of_references() : std::string();
    if (has_dates() || unit_of(&column_) == nullptr) return {};
    const std::string whole = of_numbers(Nearness::Whole);
    return whole.empty() ? of_numbers(Nearness::InPart) : whole;
  }

  /// Of the reference that the mapping declares, in seconds after lift-off.
  [[nodiscard]] double declared_base_s() const {
    switch (column_.since.value_or(Since::Liftoff)) {
      case Since::Liftoff:
        return 0;
      case Since::Unix:
        return -liftoff_s_;
      case Since::Midnight:  // of the day on which the rows are
        return std::floor((liftoff_s_ + times_.least) / day_s) * day_s - liftoff_s_;
      case Since::Instant:
        return static_cast<double>(column_.instant.ns) * 1e-9 - liftoff_s_;
    }
    return 0;
  }

  /// In the declared unit, a declared scale applied.
  [[nodiscard]] Numbers numbers() const {
    const double base_s = declared_base_s() + column_.offset;
    return {(times_.least - base_s) / unit_s(), (times_.most - base_s) / unit_s(), times_.step / unit_s()};
  }

  [[nodiscard]] bool is_declared(const Reading& reference) const {
    const double away_s = std::abs(reference.base_s - declared_base_s());
    return (column_.since == Since::Midnight ? std::fmod(away_s, day_s) : away_s) < 1;
  }

  /// With the declared unit.
  [[nodiscard]] std::vector<Reading> references() const {
    std::vector<Reading> all{{"since = \"unix\"", unit_s(), -liftoff_s_},
                             {"since = \"gps\"", unit_s(), gps_epoch_s - liftoff_s_},
                             {"since = \"midnight\"", unit_s(), -of_day_s()},
                             {"since = \"liftoff\"", unit_s(), 0}};
    std::erase_if(all, [&](const Reading& r) { return is_declared(r); });
    return all;
  }

  [[nodiscard]] std::string first_near(const std::vector<Reading>& readings, Nearness nearness) const {
    const Numbers n = numbers();
    const auto found = std::ranges::find_if(readings, [&](const Reading& r) { return is_near(n, r, nearness); });
    return found == readings.end() ? std::string() : found->advice;
  }

  [[nodiscard]] std::string of_references() const {
    const std::string whole = first_near(references(), Nearness::Whole);
    return whole.empty() ? first_near(references(), Nearness::InPart) : whole;
  }

  /// The likelier ones first.
  [[nodiscard]] std::string of_numbers(Nearness nearness) const {
    if (std::string found = first_near(references(), nearness); !found.empty()) return found;
    if (std::string found = of_packed(nearness); !found.empty()) return found;
    return first_near(other_readings(), nearness);
  }

  [[nodiscard]] std::vector<Reading> other_readings() const {
    std::vector<Reading> all{week()};
    std::vector<UnitInfo> units;
    std::ranges::copy_if(all_units(), std::back_inserter(units),
                         [&](const UnitInfo& u) { return u.quantity == Quantity::Time && u.name != column_.unit; });
    std::ranges::sort(units, [](const UnitInfo& a, const UnitInfo& b) { return a.size > b.size; });
    const auto named = [](const UnitInfo& unit) { return "unit = \"" + std::string(unit.name) + '"'; };
    for (const UnitInfo& unit : units) all.push_back({named(unit), unit.size * 1e-9, declared_base_s()});
    all.push_back({"unit = \"d\", since = 1899-12-30T00:00:00Z (days as spreadsheets count them)", day_s,
                   spreadsheet_epoch_s - liftoff_s_});
    for (const UnitInfo& unit : units) {
      for (const Reading& reference : references()) {
        all.push_back({named(unit) + ", " + reference.advice, unit.size * 1e-9, reference.base_s});
      }
    }
    return all;
  }

  /// GPS weeks begin where GPS time does, on a Sunday.
  [[nodiscard]] Reading week() const {
    const double week_s = liftoff_s_ - std::fmod(liftoff_s_ - gps_epoch_s, 7 * day_s);
    const std::string day = show_utc(Time{std::llround(week_s) * 1'000'000'000}).substr(0, 10);
    return {"since = " + day + "T00:00:00Z, time_scale = \"GPS\" (counted from the GPS week's begin)", unit_s(),
            week_s - liftoff_s_};
  }

  /// A number read as hhmmss, in seconds after lift-off.
  [[nodiscard]] std::optional<double> unpacked_s(double number) const {
    if (!(number >= 0 && number < 240'000)) return std::nullopt;
    const auto clock = unpacked_clock(show_fixed(number, 3));
    const auto read = clock ? parse_clock(*clock) : std::nullopt;
    return read ? std::optional(static_cast<double>(read->ns) * 1e-9 - of_day_s()) : std::nullopt;
  }

  [[nodiscard]] std::string of_packed(Nearness nearness) const {
    const Numbers n = numbers();
    const auto least_s = unpacked_s(n.least);
    const auto most_s = unpacked_s(n.most);
    if (!least_s || !most_s) return {};
    // A minute's sixty seconds are a step of a hundred at most.
    const Numbers read{*least_s, *most_s, n.step};
    return is_near(read, {}, nearness) ? "unit = \"hhmmss\", since = \"midnight\" (hhmmss as one number)" : "";
  }

  /// Clocks that show another time than UTC.
  [[nodiscard]] std::string of_zones() const {
    if (mapping_.nmea || (clock_ && (clock_->zoned || clock_->shape == ClockShape::Countdown))) return {};
    const double hours = zone_hours();
    if (times_.step > longest_step_s || hours < -12 || hours > 14 || hours == 0) return {};
    if (!is_near(times_, {"", 1, -hours * hour_s}, Nearness::InPart)) return {};
    const std::string key =
        "offset = " + show_digits(column_.offset - hours * hour_s) + " (seconds) in the columns of time";
    if (clock_ && clock_->halved && std::abs(hours) == 12) {
      return "with AM and PM exchanged: write them as hours of 0 to 23, or " + key;
    }
    const bool behind = clock_ && mapping_.scale == TimeScale::Utc && clock_->shape == ClockShape::Instant;
    return "as local time of UTC" + show_zone(hours) + ": write " +
           (behind ? show_zone(hours) + " behind each time, or " : "") + key;
  }

  /// The whole hours that put lift-off between the rows, else the half hours that put their first nearest to it.
  [[nodiscard]] double zone_hours() const {
    const double whole = std::ceil(times_.least / hour_s);
    return whole * hour_s <= times_.most ? whole : std::round(2 * times_.least / hour_s) / 2;
  }

  static std::string show_zone(double hours) {
    std::array<char, 24> text{};
    const double whole = std::floor(std::abs(hours));
    std::snprintf(text.data(), text.size(), "%c%02.0f:%02.0f", hours < 0 ? '-' : '+', whole,
                  (std::abs(hours) - whole) * 60);
    return text.data();
  }

  const FileMapping& mapping_;
  const ColumnMapping& column_;
  double liftoff_s_;
  Numbers times_;  ///< seconds after lift-off, as the mapping says
  std::optional<ClockTime> clock_;
};

}  // namespace

bool times_are_text(const std::vector<PlausibleRow>& rows) { return !rows.empty() && rows.front().clock.has_value(); }

std::string time_hint(const FileMapping& mapping, Time liftoff, const std::vector<PlausibleRow>& rows) {
  const ColumnMapping* column = mapping.column_of(Field::Epoch);
  if (column == nullptr || rows.empty()) return {};
  return Hints(mapping, *column, liftoff, rows).run();
}

}  // namespace downrange::archive
