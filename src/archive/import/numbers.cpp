#include <algorithm>
#include <archive/import/numbers.hpp>
#include <archive/import/rows.hpp>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>

namespace downrange::archive {
namespace {

constexpr std::string_view minus_sign = "\u2212";  // the typographic one
constexpr std::array<std::string_view, 7> group_marks{" ", "'", "_", "\u2019", "\u00A0", "\u202F", "\u2009"};

bool is_digit(char c) { return c >= '0' && c <= '9'; }

bool equal_letters(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [&](char x, char y) { return lower(x) == lower(y); });
}

/// Spellings of infinity and NaN that std::from_chars does not know.
bool is_not_finite(std::string_view text) {
  if (text.starts_with('-') || text.starts_with('+')) text.remove_prefix(1);
  constexpr std::array<std::string_view, 3> words{"nan", "inf", "infinity"};
  if (std::any_of(words.begin(), words.end(), [&](std::string_view w) { return equal_letters(text, w); })) return true;
  return text.starts_with("1.#") || text.starts_with("#N") || text.starts_with("#DIV") || text.starts_with("#VALUE");
}

/// Size of the group mark at the start of `text`; 0 when there is none.
std::size_t group_mark(std::string_view text, DecimalMark mark) {
  const char other = mark == DecimalMark::Point ? ',' : '.';
  if (text.front() == other) return 1;
  for (const std::string_view m : group_marks) {
    if (text.starts_with(m)) return m.size();
  }
  return 0;
}

/// Appends the digits before the fraction, their groups joined. False where they are not grouped by three.
bool append_whole_part(std::string_view& text, DecimalMark mark, std::string& out) {
  std::size_t in_group = 0;
  bool grouped = false;
  while (!text.empty()) {
    if (is_digit(text.front())) {
      out += text.front();
      ++in_group;
      text.remove_prefix(1);
      continue;
    }
    const std::size_t size = group_mark(text, mark);
    if (size == 0) break;
    if (grouped ? in_group != 3 : in_group == 0 || in_group > 3) return false;
    grouped = true;
    in_group = 0;
    text.remove_prefix(size);
  }
  return !grouped || in_group == 3;
}

void append_digits(std::string_view& text, std::string& out) {
  while (!text.empty() && is_digit(text.front())) {
    out += text.front();
    text.remove_prefix(1);
  }
}

/// The plain spelling of a number; nothing when it is none.
std::optional<std::string> plain(std::string_view text, DecimalMark mark) {
  std::string out;
  if (text.starts_with('+')) {
    text.remove_prefix(1);
  } else if (text.starts_with('-') || text.starts_with(minus_sign)) {
    out += '-';
    text.remove_prefix(text.front() == '-' ? 1 : minus_sign.size());
  }
  const std::size_t sign = out.size();
  if (!append_whole_part(text, mark, out)) return std::nullopt;
  if (!text.empty() && text.front() == static_cast<char>(mark)) {
    text.remove_prefix(1);
    out += '.';
    append_digits(text, out);
  }
  if (out.size() == sign || out.substr(sign) == ".") return std::nullopt;
  if (!text.empty() && std::string_view("eEdD").find(text.front()) != std::string_view::npos) {
    text.remove_prefix(1);
    out += 'e';
    if (!text.empty() && (text.front() == '-' || text.front() == '+')) {
      if (text.front() == '-') out += '-';
      text.remove_prefix(1);
    }
    if (text.empty()) return std::nullopt;
    append_digits(text, out);
  }
  if (!text.empty()) return std::nullopt;
  return out;
}

template <class T>
ParsedNumber<T> from_plain(std::string_view text) {
  T value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size() || error == std::errc::invalid_argument) return {};
  // Too small for a double is zero to any instrument; too large is not finite.
  if (error == std::errc::result_out_of_range) {
    const std::size_t exponent = text.find_first_of("eE");
    const bool small = exponent != std::string_view::npos && text.substr(exponent + 1).starts_with('-');
    return small ? ParsedNumber<T>{NumberKind::Finite, 0} : ParsedNumber<T>{NumberKind::NotFinite, 0};
  }
  return std::isfinite(value) ? ParsedNumber<T>{NumberKind::Finite, value} : ParsedNumber<T>{NumberKind::NotFinite, 0};
}

}  // namespace

template <class T>
ParsedNumber<T> parse_number(std::string_view text, DecimalMark mark) {
  if (mark == DecimalMark::Point) {
    // As most numbers are written, without a copy.
    if (const auto found = from_plain<T>(text); found.kind != NumberKind::NotANumber) return found;
  }
  if (is_not_finite(text)) return {NumberKind::NotFinite, 0};
  const auto spelling = plain(text, mark);
  return spelling ? from_plain<T>(*spelling) : ParsedNumber<T>{};
}

template ParsedNumber<double> parse_number(std::string_view text, DecimalMark mark);
template ParsedNumber<long double> parse_number(std::string_view text, DecimalMark mark);

bool is_no_value(std::string_view text) {
  if (text.find_first_not_of('-') == std::string_view::npos || text.find_first_not_of('*') == std::string_view::npos) {
    return true;
  }
  constexpr std::array<std::string_view, 10> words{"n/a", "na",   "#n/a", "null", "none",
                                                   "nil", "n.a.", "?",    ".",    "missing"};
  return std::any_of(words.begin(), words.end(), [&](std::string_view w) { return equal_letters(text, w); });
}

void DecimalEvidence::observe(std::string_view text, std::uint64_t line) {
  if (text.find(',') == std::string_view::npos && (point_ || text.find('.') == std::string_view::npos)) return;
  const bool as_point = parse_number<double>(text, DecimalMark::Point).kind == NumberKind::Finite;
  const bool as_comma = parse_number<double>(text, DecimalMark::Comma).kind == NumberKind::Finite;
  if (!as_point && !as_comma) return;
  const auto note = [&](std::optional<Cell>& cell) {
    if (!cell) cell = Cell{std::string(text), line};
  };
  if (as_point && as_comma) {
    // "0,123" groups nothing: no number starts with a group of zeros.
    const std::size_t first = text.find_first_of("0123456789");
    const bool zero = text[first] == '0' && first + 1 < text.size() && !is_digit(text[first + 1]);
    const bool comma = text.find(',') != std::string_view::npos;
    if (comma) return note(zero ? comma_ : either_);
    if (zero) note(point_);
    return;
  }
  note(as_point ? point_ : comma_);
}

std::string show_fixed(double value, int decimals) {
  constexpr double least_shortened = 1e6;
  if (!(std::abs(value) < least_shortened)) return show_digits(value);
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
  return text.data();
}

std::string show_digits(double value, int digits) {
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "%.*g", digits, value);
  return text.data();
}

}  // namespace downrange::archive
