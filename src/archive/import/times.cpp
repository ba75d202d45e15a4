#include <algorithm>
#include <archive/import/times.hpp>
#include <array>
#include <cctype>
#include <chrono>
#include <cstdio>
#include <string>

namespace downrange::archive {
namespace {

constexpr std::int64_t second_ns = 1'000'000'000;
constexpr std::int64_t day_s = 86'400;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Takes a text apart from its front; each function leaves the text alone where it does not fit.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {}

  [[nodiscard]] bool empty() const { return text_.empty(); }
  [[nodiscard]] std::string_view rest() const { return text_; }

  bool skip(std::string_view expected) {
    if (!text_.starts_with(expected)) return false;
    text_.remove_prefix(expected.size());
    return true;
  }
  /// A whole number of `least` to `most` digits, which no further digit follows.
  std::optional<int> number(std::size_t least, std::size_t most) {
    std::size_t size = 0;
    while (size < text_.size() && is_digit(text_[size])) ++size;
    if (size < least || size > most) return std::nullopt;
    return digits(size);
  }
  /// The next `size` characters, all digits.
  std::optional<int> digits(std::size_t size) {
    if (text_.size() < size) return std::nullopt;
    int value = 0;
    for (std::size_t i = 0; i < size; ++i) {
      if (!is_digit(text_[i])) return std::nullopt;
      value = value * 10 + (text_[i] - '0');
    }
    text_.remove_prefix(size);
    return value;
  }
  /// ".050" or ",050" in nanoseconds, to the nearest; 0 where there is none.
  std::optional<std::int64_t> fraction_ns() {
    if (!skip(".") && !skip(",")) return 0;
    std::int64_t ns = 0;
    int places = 0;
    bool up = false;
    for (; !text_.empty() && is_digit(text_.front()); text_.remove_prefix(1), ++places) {
      if (places < 9) ns = ns * 10 + (text_.front() - '0');
      if (places == 9) up = text_.front() >= '5';
    }
    if (places == 0) return std::nullopt;
    for (; places < 9; ++places) ns *= 10;
    return ns + (up ? 1 : 0);
  }
  void skip_blanks() { text_.remove_prefix(std::min(text_.find_first_not_of(' '), text_.size())); }

 private:
  std::string_view text_;
};

/// hh:mm:ss with a fraction, or with `colons` false hhmmss. In ns. Hours up to `last_hour`; 24:00:00 and the leap
/// second hh:59:60 are instants too.
std::optional<std::int64_t> clock_of(Scanner& scan, int last_hour, bool colons = true) {
  const auto hour = colons ? scan.number(1, 4) : scan.digits(2);
  if (!hour || (colons && !scan.skip(":"))) return std::nullopt;
  const auto minute = colons ? scan.number(2, 2) : scan.digits(2);
  if (!minute || (colons && !scan.skip(":"))) return std::nullopt;
  const auto second = colons ? scan.number(2, 2) : scan.digits(2);
  const auto fraction = second ? scan.fraction_ns() : std::nullopt;
  if (!fraction || *minute > 59 || *second > (*minute == 59 ? 60 : 59)) return std::nullopt;
  const bool end_of_day = *hour == 24 && *minute == 0 && *second == 0 && *fraction == 0;
  if (*hour > last_hour && !end_of_day) return std::nullopt;
  return (std::int64_t{*hour} * 3600 + std::int64_t{*minute} * 60 + *second) * second_ns + *fraction;
}

std::optional<std::int64_t> days_of(int year, int month, int day) {
  const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day))};
  if (!date.ok()) return std::nullopt;
  return std::chrono::sys_days(date).time_since_epoch().count();
}

std::optional<std::int64_t> days_of(int year, int day_of_year) {
  const auto first = days_of(year, 1, 1);
  const int days = std::chrono::year(year).is_leap() ? 366 : 365;
  if (!first || day_of_year < 1 || day_of_year > days) return std::nullopt;
  return *first + day_of_year - 1;
}

/// A date, and what separates it from the time of day. In days since 1970.
std::optional<std::int64_t> date_of(Scanner& scan) {
  Scanner basic = scan;  // 20250304T
  if (const auto digits = basic.number(8, 8); digits && basic.skip("T")) {
    scan = basic;
    return days_of(*digits / 10'000, *digits / 100 % 100, *digits % 100);
  }
  const auto year = scan.number(4, 4);
  if (!year) return std::nullopt;
  const std::string_view mark = scan.rest().substr(0, 1);
  if (mark != "-" && mark != "/" && mark != ":" && mark != ".") return std::nullopt;
  scan.skip(mark);
  const Scanner after_year = scan;
  if (const auto day = scan.number(3, 3)) {
    if (scan.skip("T") || scan.skip(" ") || scan.skip(":") || scan.skip("/") || scan.skip("-")) {
      return days_of(*year, *day);
    }
  }
  scan = after_year;
  const auto month = scan.number(1, 2);
  if (!month || mark == ":" || !scan.skip(mark)) return std::nullopt;
  const auto day = scan.number(1, 2);
  if (!day || !(scan.skip("T") || scan.skip("t") || scan.skip(" ") || scan.skip("_"))) return std::nullopt;
  return days_of(*year, *month, *day);
}

/// What stands between a date and a time of day.
bool take_date_end(Scanner& scan) {
  return scan.skip("T") || scan.skip("t") || scan.skip(", ") || scan.skip(" ") || scan.skip("_") || scan.skip(":");
}

/// The month of an English name, from three letters on.
std::optional<int> month_of(Scanner& scan) {
  constexpr std::array<std::string_view, 12> names{"january",   "february", "march",    "april",
                                                   "may",       "june",     "july",     "august",
                                                   "september", "october",  "november", "december"};
  const std::string_view rest = scan.rest();
  std::string word;
  for (std::size_t i = 0; i < rest.size() && std::isalpha(static_cast<unsigned char>(rest[i])) != 0; ++i) {
    word += static_cast<char>(std::tolower(static_cast<unsigned char>(rest[i])));
  }
  for (std::size_t i = 0; i < names.size() && word.size() >= 3; ++i) {
    if (!names[i].starts_with(word)) continue;
    scan.skip(rest.substr(0, word.size()));
    return static_cast<int>(i) + 1;
  }
  return std::nullopt;
}

/// "4-Mar-2025", "04MAR2025", "Mar 4, 2025". In days since 1970.
std::optional<std::int64_t> named_date_of(Scanner& scan) {
  const auto skip_marks = [&] { return scan.skip(", ") || scan.skip("-") || scan.skip(" ") || scan.skip("/"); };
  auto month = month_of(scan);
  const bool day_first = !month;
  if (month) skip_marks();
  const auto day = scan.number(1, 2);
  if (day) skip_marks();
  if (day_first) {
    month = month_of(scan);
    if (month) skip_marks();
  }
  const auto year = month ? scan.number(4, 4) : std::nullopt;
  if (!day || !year || !take_date_end(scan)) return std::nullopt;
  return days_of(*year, *month, *day);
}

/// "04/03/2025", "4.3.2025" in the order that the mapping says. In days since 1970.
std::optional<std::int64_t> ordered_date_of(Scanner& scan, DateOrder order) {
  const auto first = scan.number(1, 2);
  const std::string_view mark = scan.rest().substr(0, 1);
  if (!first || (mark != "-" && mark != "/" && mark != ".")) return std::nullopt;
  scan.skip(mark);
  const auto second = scan.number(1, 2);
  const auto year = second && scan.skip(mark) ? scan.number(4, 4) : std::nullopt;
  if (!year || !take_date_end(scan)) return std::nullopt;
  const bool day_first = order == DateOrder::DayFirst;
  return days_of(*year, day_first ? *second : *first, day_first ? *first : *second);
}

/// Of whichever spelling; the scanner stands behind it.
std::optional<std::int64_t> any_date_of(Scanner& scan, DateOrder order) {
  const Scanner start = scan;
  if (const auto days = date_of(scan)) return days;
  scan = start;
  if (const auto days = named_date_of(scan)) return days;
  scan = start;
  return order == DateOrder::YearFirst ? std::nullopt : ordered_date_of(scan, order);
}

/// What AM or PM behind a time of day says.
struct HalfDay {
  bool stated = false;
  std::int64_t offset_ns = 0;
};

/// Twelve hours more or less, for a time of day with AM or PM behind it; nothing where they do not fit together.
std::optional<HalfDay> half_day_of(Scanner& scan, std::int64_t clock_ns) {
  constexpr std::int64_t hour_ns = 3600 * second_ns;
  scan.skip_blanks();
  const bool morning = scan.skip("AM") || scan.skip("am");
  if (!morning && !scan.skip("PM") && !scan.skip("pm")) return HalfDay{};
  const std::int64_t hour = clock_ns / hour_ns;
  if (hour < 1 || hour > 12) return std::nullopt;
  if (hour == 12) return HalfDay{true, morning ? -12 * hour_ns : 0};
  return HalfDay{true, morning ? 0 : 12 * hour_ns};
}

struct Zone {
  bool stated = false;
  std::int64_t offset_ns = 0;
};

/// The rest of the text, which must be a zone or nothing.
std::optional<Zone> zone_of(Scanner& scan) {
  scan.skip_blanks();
  if (scan.empty()) return Zone{};
  for (const std::string_view name : {"Z", "z", "UTC", "GMT"}) {
    if (scan.rest() == name) return Zone{true, 0};
  }
  const bool west = scan.skip("-") || scan.skip("\u2212");
  if (!west && !scan.skip("+")) return std::nullopt;
  const auto hours = scan.digits(2);
  scan.skip(":");
  const auto minutes = scan.empty() ? std::optional<int>(0) : scan.digits(2);
  if (!hours || !minutes || !scan.empty() || *hours > 18 || *minutes > 59) return std::nullopt;
  const std::int64_t offset = (*hours * std::int64_t{60} + *minutes) * 60 * second_ns;
  return Zone{true, west ? -offset : offset};
}

std::optional<ClockTime> instant_of(std::string_view text, DateOrder order) {
  Scanner scan(text);
  const bool basic = text.size() > 8 && text[8] == 'T';
  const auto days = any_date_of(scan, order);
  if (!days) return std::nullopt;
  scan.skip_blanks();
  const auto clock = clock_of(scan, 23, !basic || scan.rest().find(':') != std::string_view::npos);
  const auto half_day = clock ? half_day_of(scan, *clock) : std::nullopt;
  const auto zone = half_day ? zone_of(scan) : std::nullopt;
  if (!zone) return std::nullopt;
  const std::int64_t ns = *days * day_s * second_ns + *clock + half_day->offset_ns - zone->offset_ns;
  return ClockTime{ClockShape::Instant, ns, zone->stated, half_day->stated};
}

std::optional<ClockTime> day_of_year_of(std::string_view text) {
  Scanner scan(text);
  const auto day = scan.number(3, 3);
  if (!day || *day < 1 || *day > 366 || !(scan.skip(":") || scan.skip(" "))) return std::nullopt;
  const auto clock = clock_of(scan, 23);
  const auto zone = clock ? zone_of(scan) : std::nullopt;
  if (!zone || zone->offset_ns != 0) return std::nullopt;
  return ClockTime{ClockShape::DayOfYear, (*day - 1) * day_s * second_ns + *clock, zone->stated, false};
}

std::optional<ClockTime> hours_of(std::string_view text) {
  Scanner scan(text);
  const bool negative = scan.skip("-") || scan.skip("\u2212");
  if (!negative) scan.skip("+");
  const auto clock = clock_of(scan, 9999);
  const auto half_day = clock ? half_day_of(scan, *clock) : std::nullopt;
  if (!half_day) return std::nullopt;
  // A Z says that it is a time of day, which its shape alone does not.
  const bool zoned = !negative && scan.skip("Z");
  if (!scan.empty()) return std::nullopt;
  return ClockTime{ClockShape::Hours, (negative ? -*clock : *clock) + half_day->offset_ns, zoned, half_day->stated};
}

std::optional<ClockTime> countdown_of(std::string_view text) {
  Scanner scan(text);
  if (!scan.skip("T") && !scan.skip("t")) return std::nullopt;
  const bool before = scan.skip("-") || scan.skip("\u2212");
  if (!before && !scan.skip("+")) return std::nullopt;
  Scanner seconds = scan;
  std::optional<std::int64_t> ns;
  if (const auto whole = seconds.number(1, 7)) {
    const auto fraction = seconds.fraction_ns();
    if (fraction && seconds.empty()) ns = *whole * second_ns + *fraction;
  }
  if (!ns) {
    ns = clock_of(scan, 9999);
    if (!ns || !scan.empty()) return std::nullopt;
  }
  return ClockTime{ClockShape::Countdown, before ? -*ns : *ns, false, false};
}

}  // namespace

std::optional<ClockTime> parse_clock(std::string_view text, DateOrder order) {
  // Every such text has a sign of its own; plain numbers, the most of all cells, have none.
  if (text.find_first_of(":Tt") == std::string_view::npos) return std::nullopt;
  if (auto found = instant_of(text, order)) return found;
  if (auto found = day_of_year_of(text)) return found;
  if (auto found = hours_of(text)) return found;
  return countdown_of(text);
}

std::optional<ClockTime> compact_instant(std::string_view text) {
  constexpr std::size_t digits = 14;
  if (std::min(text.find_first_of(".,"), text.size()) != digits || text.front() > '2') return std::nullopt;
  return parse_clock(std::string(text.substr(0, 8)) + 'T' + std::string(text.substr(8)));
}

std::optional<std::string> unpacked_clock(std::string_view text) {
  const std::size_t point = std::min(text.find_first_of(".,"), text.size());
  if (point == 0 || point > 6 ||
      !std::all_of(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(point), is_digit)) {
    return std::nullopt;
  }
  const std::string whole = std::string(6 - point, '0') + std::string(text.substr(0, point));
  return whole.substr(0, 2) + ':' + whole.substr(2, 2) + ':' + whole.substr(4) + std::string(text.substr(point));
}

std::string show_utc(Time time) {
  const auto days = std::chrono::floor<std::chrono::days>(
      std::chrono::sys_time<std::chrono::nanoseconds>(std::chrono::nanoseconds(time.ns)));
  const std::chrono::year_month_day date(days);
  const std::int64_t ms = (time.ns - std::chrono::nanoseconds(days.time_since_epoch()).count()) / 1'000'000;
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "%04d-%02u-%02uT%02d:%02d:%02d.%03dZ", static_cast<int>(date.year()),
                static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                static_cast<int>(ms / 3'600'000), static_cast<int>(ms / 60'000 % 60), static_cast<int>(ms / 1000 % 60),
                static_cast<int>(ms % 1000));
  return text.data();
}

}  // namespace downrange::archive
