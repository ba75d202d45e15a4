#include <algorithm>
#include <archive/import/table_reader.hpp>
#include <charconv>
#include <text/printable.hpp>

namespace downrange::archive {
namespace {

/// Lines before the header that a file may have: titles, notes, units.
constexpr std::uint64_t header_within = 200;
constexpr std::size_t shown_columns = 40;
constexpr std::size_t shown_values = 8;

/// A column's name in a message.
std::string show_name(const std::string& name, std::size_t index) {
  return name.empty() ? "#" + std::to_string(index + 1) + " (no name)" : text::printable(name, false, 40);
}

std::string list_of(const std::vector<std::string>& names) {
  std::string list;
  for (std::size_t i = 0; i < names.size() && i < shown_columns; ++i) {
    list += (i == 0 ? "" : ", ") + show_name(names[i], i);
  }
  return list + (names.size() > shown_columns ? ", ..." : "");
}

/// Without the empty ones at its end, which a delimiter at the end of each line makes.
std::vector<std::string> header_names(const std::vector<std::string_view>& fields) {
  std::vector<std::string> names(fields.begin(), fields.end());
  while (names.size() > 1 && names.back().empty()) names.pop_back();
  return names;
}

bool all_numbers(const std::vector<std::string>& names) {
  return std::all_of(names.begin(), names.end(), [](const std::string& name) {
    return parse_number<double>(name, DecimalMark::Point).kind == NumberKind::Finite ||
           parse_number<double>(name, DecimalMark::Comma).kind == NumberKind::Finite;
  });
}

/// The number behind the last '#'; 0 when there is none.
std::size_t number_behind(const std::string& column, std::size_t hash) {
  std::size_t number = 0;
  const char* end = column.data() + column.size();
  const auto [stop, error] = std::from_chars(column.data() + hash + 1, end, number);
  return error == std::errc() && stop == end ? number : 0;
}

}  // namespace

std::optional<std::size_t> find_column(const std::vector<std::string>& names, const std::string& column,
                                       std::size_t* how_many) {
  const auto count = static_cast<std::size_t>(std::count(names.begin(), names.end(), column));
  if (how_many != nullptr) *how_many = count;
  if (count == 1) return static_cast<std::size_t>(std::find(names.begin(), names.end(), column) - names.begin());
  const std::size_t hash = column.rfind('#');
  const std::size_t number = hash == std::string::npos ? 0 : number_behind(column, hash);
  if (count > 1 || number == 0) return std::nullopt;
  if (hash == 0) return number <= names.size() ? std::optional(number - 1) : std::nullopt;
  std::size_t seen = 0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == column.substr(0, hash) && ++seen == number) return i;
  }
  return std::nullopt;
}

TableReader::TableReader(const FileMapping& mapping, std::string_view text)
    : mapping_(mapping), text_(text), lines_(text), first_row_(text) {
  if (mapping_.header) {
    find_header();
  } else {
    find_width();
  }
  for (const ColumnMapping& column : mapping_.columns) places_.push_back(place_of(column.column));
  for (const RowFilter& filter : mapping_.filters) filter_places_.push_back(place_of(filter.column));
  declare_all();
}

void TableReader::fail(std::uint64_t line, const std::string& what) const {
  throw ImportError(mapping_.path.string() + (line > 0 ? ":" + std::to_string(line) : "") + ": " + what);
}

std::vector<Delimiter> TableReader::candidates() const {
  if (mapping_.delimiter) return {*mapping_.delimiter};
  return {',', ';', '\t', '|', blanks};
}

std::vector<std::string> TableReader::comments(Delimiter delimiter) const {
  return mapping_.comments ? *mapping_.comments : usual_comments(delimiter);
}

bool TableReader::has_all(const std::vector<std::string>& names) const {
  const auto there = [&](const std::string& column) { return find_column(names, column).has_value(); };
  return std::all_of(mapping_.columns.begin(), mapping_.columns.end(),
                     [&](const ColumnMapping& c) { return there(c.column); }) &&
         std::all_of(mapping_.ignored.begin(), mapping_.ignored.end(), there) &&
         std::all_of(mapping_.filters.begin(), mapping_.filters.end(),
                     [&](const RowFilter& f) { return there(f.column); });
}

void TableReader::use(std::vector<std::string> names, Delimiter delimiter, std::uint64_t line) {
  names_ = std::move(names);
  splitter_ = RowSplitter(delimiter);
  comments_ = comments(delimiter);
  header_line_ = line;
  first_row_ = lines_;
}

void TableReader::find_header() {
  while (const auto line = lines_.next()) {
    if (lines_.line() > header_within) break;
    if (trimmed(*line).empty()) continue;
    for (const Delimiter delimiter : candidates()) {
      RowSplitter splitter(delimiter);
      // A header may stand in a comment.
      for (const auto& candidate : {std::optional(*line), comment_of(*line, comments(delimiter))}) {
        if (!candidate) continue;
        std::vector<std::string> names = header_names(splitter.split(*candidate));
        if (has_all(names)) return use(std::move(names), delimiter, lines_.line());
      }
    }
  }
  fail_without_header();
}

/// Names what the first line that is no comment has instead.
void TableReader::fail_without_header() {
  LineReader lines(text_);
  std::vector<std::string> names;
  std::uint64_t number = 0;
  while (const auto line = lines.next()) {
    if (trimmed(*line).empty() || comment_of(*line, comments(mapping_.delimiter.value_or(',')))) continue;
    number = lines.line();
    for (const Delimiter delimiter : candidates()) {
      RowSplitter splitter(delimiter);
      auto found = header_names(splitter.split(*line));
      if (found.size() > names.size()) names = std::move(found);
    }
    // Perhaps the mapping's delimiter alone is wrong.
    for (const Delimiter other : {',', ';', '\t', '|', blanks}) {
      RowSplitter splitter(other);
      const auto found = header_names(splitter.split(*line));
      if (mapping_.delimiter && has_all(found)) {
        fail(number, "under the delimiter " + show_delimiter(*mapping_.delimiter) +
                         " the columns are: " + list_of(names) + "; write delimiter = " + show_delimiter(other));
      }
    }
    break;
  }
  if (number == 0) fail(0, "no header line: the file is empty" + std::string(text_.empty() ? "" : " but for comments"));
  if (all_numbers(names)) {
    fail(number, "no header line, numbers at once: " + list_of(names) +
                     "; write header = false and name the columns by number: 1 = {...}");
  }
  names_ = std::move(names);
  header_line_ = number;
  for (const ColumnMapping& column : mapping_.columns) static_cast<void>(place_of(column.column));
  for (const std::string& column : mapping_.ignored) static_cast<void>(place_of(column));
  for (const RowFilter& filter : mapping_.filters) static_cast<void>(place_of(filter.column));
  fail(number, "no header line; the columns there are: " + list_of(names_));
}

/// Without a header the first row tells how many columns there are, and the delimiter under which they are as many as
/// the mapping has.
void TableReader::find_width() {
  while (const auto line = lines_.next()) {
    const auto is_row = [&](Delimiter d) { return !comment_of(*line, comments(d)); };
    if (trimmed(*line).empty() || !is_row(mapping_.delimiter.value_or(','))) continue;
    std::vector<std::pair<Delimiter, std::size_t>> fits;
    std::string found;
    for (const Delimiter delimiter : candidates()) {
      RowSplitter splitter(delimiter);
      std::vector<std::string> names = header_names(splitter.split(*line));
      found += (found.empty() ? "" : ", ") + std::to_string(names.size()) + " under " + show_delimiter(delimiter);
      for (std::size_t i = 0; i < names.size(); ++i) names[i] = std::to_string(i + 1);
      const std::size_t declared = mapping_.columns.size() + mapping_.ignored.size();
      const bool as_many = mapping_.ignore_others || !mapping_.filters.empty() || names.size() == declared;
      if (has_all(names) && as_many) fits.emplace_back(delimiter, names.size());
    }
    if (fits.size() != 1) {
      fail(lines_.line(), std::string(fits.empty() ? "no delimiter gives the columns of the mapping"
                                                   : "more than one delimiter gives the columns of the mapping") +
                              " (fields: " + found + "); declare every column by its number, or write delimiter = ...");
    }
    std::vector<std::string> names;
    for (std::size_t i = 0; i < fits.front().second; ++i) names.push_back(std::to_string(i + 1));
    use(std::move(names), fits.front().first, 0);
    first_row_ = LineReader(text_);
    lines_ = first_row_;
    return;
  }
  fail(0, "no row: the file is empty" + std::string(text_.empty() ? "" : " but for comments"));
}

std::size_t TableReader::place_of(const std::string& column) const {
  std::size_t how_many = 0;
  if (const auto place = find_column(names_, column, &how_many)) return *place;
  const std::string name = text::in_quotes(column);
  if (how_many > 1) {
    std::string which;
    for (std::size_t i = 0; i < names_.size(); ++i) {
      if (names_[i] == column) which += (which.empty() ? "" : " and ") + std::to_string(i + 1);
    }
    fail(header_line_, "column " + name + " is there " + std::to_string(how_many) + " times (columns " + which +
                           "): say which, as \"" + column + "#1\" or \"" + column + "#2\"");
  }
  fail(header_line_, "no column " + name + "; the columns there are: " + list_of(names_));
}

/// Every column of the file is declared: a column that nobody thought of may be the one that matters.
void TableReader::declare_all() {
  std::vector<bool> declared(names_.size(), mapping_.ignore_others);
  for (const std::size_t place : places_) declared[place] = true;
  for (const std::size_t place : filter_places_) declared[place] = true;
  for (const std::string& column : mapping_.ignored) declared[place_of(column)] = true;
  const auto forgotten = std::find(declared.begin(), declared.end(), false);
  if (forgotten == declared.end()) return;
  const auto index = static_cast<std::size_t>(forgotten - declared.begin());
  const std::string& name = names_[index];
  const bool plain = !name.empty() && std::count(names_.begin(), names_.end(), name) == 1;
  const std::string key = plain ? name : "#" + std::to_string(index + 1);
  fail(header_line_, "column " + (name.empty() ? key : text::in_quotes(name)) +
                         " is not in the mapping; give it a field, or write: \"" + text::printable(key) +
                         "\" = \"ignore\" (or other_columns = \"ignore\" for all such)");
}

void TableReader::rewind() {
  lines_ = first_row_;
  row_ = 0;
  passed_over_ = {};
  filtered_values_.clear();
}

bool TableReader::wanted(const std::vector<std::string_view>& fields) {
  for (std::size_t i = 0; i < filter_places_.size(); ++i) {
    const RowFilter& filter = mapping_.filters[i];
    if (filter_places_[i] >= fields.size()) return true;  // too short a row: to be counted as such
    const std::string_view cell = fields[filter_places_[i]];
    const auto number = parse_number<double>(cell, DecimalMark::Point);
    const auto same = [&](const std::string& text) {
      if (cell == text) return true;
      const auto wanted_number = parse_number<double>(text, DecimalMark::Point);
      return number.kind == NumberKind::Finite && wanted_number.kind == NumberKind::Finite &&
             number.value == wanted_number.value;
    };
    if (std::any_of(filter.texts.begin(), filter.texts.end(), same) == filter.equals) continue;
    ++passed_over_.filtered;
    if (filtered_values_.size() < shown_values || filtered_values_.contains(std::string(cell))) {
      ++filtered_values_[text::printable(cell, false, 40)];
    }
    return false;
  }
  return true;
}

bool TableReader::next() {
  while (const auto line = lines_.next()) {
    if (trimmed(*line).empty()) continue;
    if (comment_of(*line, comments_)) {
      ++passed_over_.comments;
      continue;
    }
    fields_ = &splitter_.split(*line);
    if (mapping_.header &&
        std::equal(names_.begin(), names_.end(), fields_->begin(),
                   fields_->begin() + static_cast<std::ptrdiff_t>(std::min(names_.size(), fields_->size())))) {
      ++passed_over_.headers;
      continue;
    }
    ++row_;
    if (wanted(*fields_)) return true;
  }
  return false;
}

}  // namespace downrange::archive
