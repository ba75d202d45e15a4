#include <archive/import/angles.hpp>
#include <archive/import/rows.hpp>
#include <array>
#include <span>

namespace downrange::archive {
namespace {

constexpr std::array<std::string_view, 7> degree_marks{":", "\u00B0", "\u00BA", "deg", "d", "D", " "};
constexpr std::array<std::string_view, 7> minute_marks{":", "'", "\u2032", "\u2019", "m", "M", " "};
constexpr std::array<std::string_view, 6> second_marks{"\"", "''", "\u2033", "\u201D", "s", " "};
constexpr std::array<std::span<const std::string_view>, 3> marks{degree_marks, minute_marks, second_marks};

/// Takes the first of the marks that the text starts with, and the blanks around it. False where it starts with none.
bool take_mark(std::string_view& text, std::span<const std::string_view> allowed) {
  const std::string_view rest = trimmed(text);
  for (const std::string_view mark : allowed) {
    const std::string_view from = mark == " " ? text : rest;
    if (!from.starts_with(mark)) continue;
    text = trimmed(from.substr(mark.size()));
    return true;
  }
  return false;
}

/// A hemisphere's letter at either end: -1 or 1; 0 when there is none.
int take_letter(std::string_view& text, AngleLetters letters) {
  if (letters == AngleLetters::None || text.empty()) return 0;
  const std::string_view known = letters == AngleLetters::NorthSouth ? "NS" : "EW";
  for (const bool front : {true, false}) {
    const std::size_t which = known.find(front ? text.front() : text.back());
    if (which == std::string_view::npos) continue;
    text = trimmed(front ? text.substr(1) : text.substr(0, text.size() - 1));
    return which == 0 ? 1 : -1;
  }
  return 0;
}

/// The digits at the start, with a fraction.
std::optional<double> take_number(std::string_view& text, DecimalMark mark, bool& fraction) {
  std::size_t size = 0;
  fraction = false;
  for (; size < text.size(); ++size) {
    const bool digit = text[size] >= '0' && text[size] <= '9';
    const bool point = text[size] == static_cast<char>(mark) && !fraction;
    if (!digit && !point) break;
    fraction |= point;
  }
  const auto number = parse_number<double>(text.substr(0, size), mark);
  if (size == 0 || number.kind != NumberKind::Finite) return std::nullopt;
  text.remove_prefix(size);
  return number.value;
}

}  // namespace

std::optional<double> parse_degrees(std::string_view text, DecimalMark mark, AngleLetters letters) {
  const int letter = take_letter(text, letters);
  int sign = 0;
  for (const auto& [spelling, value] : {std::pair<std::string_view, int>{"-", -1}, {"\u2212", -1}, {"+", 1}}) {
    if (sign != 0 || !text.starts_with(spelling)) continue;
    sign = value;
    text.remove_prefix(spelling.size());
  }
  if (letter != 0 && sign != 0) return std::nullopt;
  double degrees = 0;
  bool fraction = false;
  bool marked = letter != 0;
  std::size_t part = 0;
  for (double size = 1; part < marks.size() && !text.empty(); ++part, size /= 60) {
    if (fraction) return std::nullopt;  // only the last part has one
    const auto value = take_number(text, mark, fraction);
    if (!value || (part > 0 && *value > 60)) return std::nullopt;
    degrees += *value * size;
    const bool mark_there = take_mark(text, marks[part]);
    if (!mark_there && !text.empty()) return std::nullopt;
    marked |= part > 0 || mark_there;
  }
  if (part == 0 || !text.empty() || !marked) return std::nullopt;
  return (letter < 0 || sign < 0) ? -degrees : degrees;
}

}  // namespace downrange::archive
