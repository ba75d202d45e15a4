#include <algorithm>
#include <archive/import/columns.hpp>
#include <charconv>

namespace downrange::archive {
namespace {

constexpr Quantity with_units[] = {Quantity::Time,  Quantity::Length,       Quantity::Angle,
                                   Quantity::Speed, Quantity::Acceleration, Quantity::Number};

/// Small letters, one blank for each run of blanks and line breaks.
std::string folded(std::string_view text) {
  std::string out;
  for (const char c : trimmed(text)) {
    const bool blank = c == ' ' || c == '\t' || c == '\r' || c == '\n';
    if (blank && (out.empty() || out.back() == ' ')) continue;
    out += blank ? ' ' : c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  if (out.ends_with(' ')) out.pop_back();
  return out;
}

/// The number behind the last '#'; 0 when there is none.
std::size_t number_behind(const std::string& column, std::size_t hash) {
  std::size_t number = 0;
  const char* end = column.data() + column.size();
  const auto [stop, error] = std::from_chars(column.data() + hash + 1, end, number);
  return error == std::errc() && stop == end ? number : 0;
}

/// "az#2", "#3".
std::optional<std::size_t> numbered_column(const std::vector<std::string>& names, const std::string& column) {
  const std::size_t hash = column.rfind('#');
  const std::size_t number = hash == std::string::npos ? 0 : number_behind(column, hash);
  if (number == 0) return std::nullopt;
  if (hash == 0) return number <= names.size() ? std::optional(number - 1) : std::nullopt;
  std::size_t seen = 0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == column.substr(0, hash) && ++seen == number) return i;
  }
  return std::nullopt;
}

template <class Same>
std::vector<std::size_t> all_of(const std::vector<std::string>& names, Same same) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (same(names[i])) found.push_back(i);
  }
  return found;
}

const UnitInfo* any_unit(std::string_view text) {
  for (const Quantity quantity : with_units) {
    if (const UnitInfo* found = find_unit(quantity, text)) return found;
  }
  return nullptr;
}

}  // namespace

std::string_view without_brackets(std::string_view text) {
  text = trimmed(text);
  const bool square = text.starts_with('[') && text.ends_with(']');
  const bool round = text.starts_with('(') && text.ends_with(')');
  return square || round ? trimmed(text.substr(1, text.size() - 2)) : text;
}

HeaderName split_header_name(std::string_view text) {
  text = trimmed(text);
  const char close = text.empty() ? '\0' : text.back();
  if (close != ']' && close != ')') return {text, {}};
  const std::size_t open = text.rfind(close == ']' ? '[' : '(');
  if (open == std::string_view::npos || open == 0) return {text, {}};
  return {trimmed(text.substr(0, open)), trimmed(text.substr(open + 1, text.size() - open - 2))};
}

std::vector<std::size_t> find_columns(const std::vector<std::string>& names, const std::string& column) {
  auto found = all_of(names, [&](const std::string& n) { return n == column; });
  if (!found.empty()) return found;
  if (const auto place = numbered_column(names, column)) return {*place};
  const std::string wanted = folded(column);
  found = all_of(names, [&](const std::string& n) { return folded(n) == wanted; });
  if (!found.empty() || wanted.empty()) return found;
  return all_of(names, [&](const std::string& n) { return folded(split_header_name(n).name) == wanted; });
}

std::optional<std::size_t> find_column(const std::vector<std::string>& names, const std::string& column,
                                       std::size_t* how_many) {
  const auto found = find_columns(names, column);
  if (how_many != nullptr) *how_many = found.size();
  return found.size() == 1 ? std::optional(found.front()) : std::nullopt;
}

std::string unit_problem(const ColumnMapping& column, std::string_view said) {
  const Quantity quantity = info_of(column.field).quantity;
  const bool has_unit = !column.unit.empty() && !column.text && !column.packed && !column.scaled;
  if (said.empty() || !has_unit || column.column.starts_with('#')) return {};
  const UnitInfo* unit = find_unit(quantity, said);
  if (unit != nullptr && unit->name == column.unit) return {};
  const UnitInfo* other = unit != nullptr ? unit : any_unit(said);
  if (other == nullptr || other->quantity == Quantity::Number) return {};
  return "says " + std::string(other->name) + ", the mapping says unit = \"" + column.unit + "\": write unit = \"" +
         std::string(unit != nullptr ? unit->name : column.unit) +
         (unit != nullptr ? "\"" : "\" under the right column's name") +
         ", or name the column by its number (\"#3\") where the file is wrong";
}

bool is_unit_row(const std::vector<std::string_view>& fields, const std::vector<std::size_t>& places) {
  bool known = false;
  for (const std::size_t place : places) {
    if (place >= fields.size()) return false;
    const std::string_view field = fields[place];
    const std::string_view text = without_brackets(field);
    if (any_unit(text) != nullptr && text != "1") {
      known = true;
    } else if (text.find_first_of("0123456789") != std::string_view::npos) {
      return false;
    } else {
      known |= text.size() != field.size();
    }
  }
  return known;
}

}  // namespace downrange::archive
