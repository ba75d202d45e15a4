#include <algorithm>
#include <archive/import/columns.hpp>
#include <archive/import/table_reader.hpp>
#include <text/printable.hpp>

namespace downrange::archive {
namespace {

/// Lines before the header that a file may have: titles, notes, units.
constexpr std::uint64_t header_within = 200;
/// Lines that a quoted field may have.
constexpr std::uint64_t lines_of_a_row = 50;
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

/// Fields without the empty ones at their end, which a delimiter at the end of each line makes.
std::size_t filled(const std::vector<std::string_view>& fields) {
  std::size_t size = fields.size();
  while (size > 1 && fields[size - 1].empty()) --size;
  return size;
}

std::vector<std::string> header_names(const std::vector<std::string_view>& fields) {
  return {fields.begin(), fields.begin() + static_cast<std::ptrdiff_t>(filled(fields))};
}

/// A line of digits, signs and points alone, columns of numbers with nothing between them perhaps.
bool is_all_digits(std::string_view text) { return text.find_first_not_of("0123456789.+- ") == std::string_view::npos; }

bool all_numbers(const std::vector<std::string>& names) {
  return std::all_of(names.begin(), names.end(), [](const std::string& name) {
    return parse_number<double>(name, DecimalMark::Point).kind == NumberKind::Finite ||
           parse_number<double>(name, DecimalMark::Comma).kind == NumberKind::Finite;
  });
}

/// What a spreadsheet writes first: "sep=;".
std::optional<Delimiter> declared_separator(std::string_view line) {
  line = trimmed(line);
  if (line.starts_with('"') && line.ends_with('"') && line.size() > 1) line = line.substr(1, line.size() - 2);
  return line.size() == 5 && line.starts_with("sep=") ? std::optional(line[4]) : std::nullopt;
}

}  // namespace

TableReader::TableReader(const FileMapping& mapping, std::string_view text)
    : mapping_(mapping), text_(text), lines_(text), first_row_(text) {
  skip_top();
  if (!mapping_.fixed.empty()) {
    use_fixed_places();
  } else if (!mapping_.given_names.empty()) {
    use(mapping_.given_names, mapping_.delimiter.value_or(','), 0);
  } else if (mapping_.header) {
    find_header();
  } else {
    find_width();
  }
  find_places();
  if (mapping_.fixed.empty()) declare_all();
  check_units();
  first_layout_ = layout_;
}

void TableReader::fail(std::uint64_t line, const std::string& what) const {
  throw ImportError(mapping_.path.string() + (line > 0 ? ":" + std::to_string(line) : "") + ": " + what);
}

void TableReader::skip_top() {
  for (std::uint64_t i = 0; i < mapping_.skip_lines; ++i) {
    if (!lines_.next()) fail(0, "has fewer than the " + std::to_string(mapping_.skip_lines) + " lines of skip_lines");
  }
  first_row_ = lines_;
}

std::vector<Delimiter> TableReader::candidates() const {
  if (mapping_.delimiter) return {*mapping_.delimiter};
  LineReader first = first_row_;
  if (const auto line = first.next()) {
    if (const auto declared = declared_separator(*line)) return {*declared};
  }
  // The later ones are too rare to be tried where no header shows that they are right.
  if (mapping_.header) return {',', ';', '\t', '|', blanks, '^', '~', ':', '&', '\x1F', '\x01'};
  return {',', ';', '\t', '|', blanks};
}

std::vector<std::string> TableReader::comments(Delimiter delimiter) const {
  return mapping_.comments ? *mapping_.comments : usual_comments(delimiter);
}

std::vector<std::string> TableReader::wanted_columns() const {
  std::vector<std::string> columns;
  for (const ColumnMapping& column : mapping_.columns) columns.push_back(column.column);
  for (const RowFilter& filter : mapping_.filters) columns.push_back(filter.column);
  for (const NameColumn* name : mapping_.name_columns()) columns.push_back(name->column);
  return columns;
}

bool TableReader::has_all(const std::vector<std::string>& names) const {
  const auto wanted = wanted_columns();
  return std::all_of(wanted.begin(), wanted.end(),
                     [&](const std::string& column) { return find_column(names, column).has_value(); }) &&
         std::all_of(mapping_.ignored.begin(), mapping_.ignored.end(),
                     [&](const std::string& column) { return !find_columns(names, column).empty(); });
}

void TableReader::use(std::vector<std::string> names, Delimiter delimiter, std::uint64_t line) {
  layout_.names = std::move(names);
  layout_.header_line = line;
  splitter_ = RowSplitter(delimiter);
  comments_ = comments(delimiter);
  first_row_ = lines_;
}

std::string_view TableReader::joined(std::size_t begin, std::string_view last_line) const {
  return text_.substr(begin, static_cast<std::size_t>(last_line.data() - text_.data()) + last_line.size() - begin);
}

std::vector<std::string> TableReader::header_in(std::string_view line, Delimiter delimiter) {
  RowSplitter splitter(delimiter);
  std::vector<std::string> names = header_names(splitter.split(line));
  if (has_all(names)) return names;
  // A line that stands in quotes as a whole, as all others then do.
  if (names.size() == 1 && trimmed(line).starts_with('"')) {
    const std::string inside = names.front();
    std::vector<std::string> inner = header_names(splitter.split(inside));
    if (has_all(inner)) {
      lines_in_quotes_ = true;
      return inner;
    }
    static_cast<void>(splitter.split(line));
  }
  // Names with line breaks in them stand in quotes.
  const auto begin = static_cast<std::size_t>(line.data() - text_.data());
  LineReader ahead = lines_;
  for (std::uint64_t i = 0; splitter.open() && i < lines_of_a_row; ++i) {
    const auto more = ahead.next();
    if (!more) break;
    names = header_names(splitter.split(joined(begin, *more)));
    if (splitter.open() || !has_all(names)) continue;
    lines_ = ahead;
    return names;
  }
  return {};
}

void TableReader::find_header() {
  while (const auto line = lines_.next()) {
    if (lines_.line() > header_within + mapping_.skip_lines) break;
    if (trimmed(*line).empty()) continue;
    const std::uint64_t number = lines_.line();
    for (const Delimiter delimiter : candidates()) {
      // A header may stand in a comment.
      for (const auto& candidate : {std::optional(*line), comment_of(*line, comments(delimiter))}) {
        if (!candidate) continue;
        std::vector<std::string> names = header_in(*candidate, delimiter);
        if (!names.empty()) return use(std::move(names), delimiter, number);
      }
    }
  }
  fail_without_header();
}

/// Names what the first line that is no comment has instead.
void TableReader::fail_without_header() {
  LineReader lines = first_row_;
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
  if (names.size() == 1 && is_all_digits(names.front())) {
    fail(number, "no header line, numbers at once: " + list_of(names) +
                     "; where nothing stands between the columns, write their places: at = [first, last], and header = "
                     "false");
  }
  if (all_numbers(names)) {
    fail(number, "no header line, numbers at once: " + list_of(names) +
                     "; write header = false and name the columns by number: 1 = {...}");
  }
  layout_.names = std::move(names);
  layout_.header_line = number;
  for (const std::string& column : wanted_columns()) static_cast<void>(place_of(column));
  for (const std::string& column : mapping_.ignored) {
    if (find_columns(layout_.names, column).empty()) static_cast<void>(place_of(column));
  }
  fail(number, "no header line; the columns there are: " + list_of(layout_.names));
}

/// Without a header the first row tells how many columns there are, and the delimiter under which they are as many as
/// the mapping has.
void TableReader::find_width() {
  while (const auto line = lines_.next()) {
    const auto is_row = [&](Delimiter d) { return !comment_of(*line, comments(d)); };
    if (trimmed(*line).empty() || !is_row(mapping_.delimiter.value_or(',')) || declared_separator(*line)) continue;
    std::vector<std::pair<Delimiter, std::size_t>> fits;
    std::string found;
    for (const Delimiter delimiter : candidates()) {
      RowSplitter splitter(delimiter);
      std::vector<std::string> names = header_names(splitter.split(*line));
      found += (found.empty() ? "" : ", ") + std::to_string(names.size()) + " under " + show_delimiter(delimiter);
      for (std::size_t i = 0; i < names.size(); ++i) names[i] = std::to_string(i + 1);
      const std::size_t declared = mapping_.columns.size() + mapping_.ignored.size();
      const bool as_many = mapping_.ignore_others || !mapping_.filters.empty() || !mapping_.name_columns().empty() ||
                           names.size() == declared;
      if (has_all(names) && as_many) fits.emplace_back(delimiter, names.size());
    }
    if (fits.size() != 1) {
      fail(lines_.line(),
           std::string(fits.empty() ? "no delimiter gives the columns of the mapping"
                                    : "more than one delimiter gives the columns of the mapping") +
               " (fields: " + found +
               "); declare every column by its number, or write delimiter = ..., or where nothing stands "
               "between the columns their places: at = [first, last]");
    }
    std::vector<std::string> names;
    for (std::size_t i = 0; i < fits.front().second; ++i) names.push_back(std::to_string(i + 1));
    lines_ = first_row_;
    use(std::move(names), fits.front().first, 0);
    return;
  }
  fail(0, "no row: the file is empty" + std::string(text_.empty() ? "" : " but for comments"));
}

/// Columns are known by the mapping's names; the first line that is no comment is not read, unless it holds numbers.
void TableReader::use_fixed_places() {
  std::vector<std::string> names;
  for (const FixedColumn& column : mapping_.fixed) {
    names.push_back(column.name);
    fixed_.push_back(column.place);
  }
  use(std::move(names), blanks, 0);
  LineReader header = lines_;
  while (const auto line = mapping_.header ? header.next() : std::nullopt) {
    if (trimmed(*line).empty() || comment_of(*line, comments_)) continue;
    const auto cells = split_fixed(*line, fixed_);
    if (all_numbers({cells.begin(), cells.end()})) {
      fail(header.line(), "numbers, no header; write header = false");
    }
    lines_ = header;
    first_row_ = lines_;
    layout_.header_line = header.line();
    return;
  }
}

std::size_t TableReader::place_of(const std::string& column) const {
  std::size_t how_many = 0;
  if (const auto place = find_column(layout_.names, column, &how_many)) return *place;
  const std::string name = text::in_quotes(column);
  if (how_many > 1) {
    std::string which;
    for (const std::size_t place : find_columns(layout_.names, column)) {
      which += (which.empty() ? "" : " and ") + std::to_string(place + 1);
    }
    fail(layout_.header_line, "column " + name + " is there " + std::to_string(how_many) + " times (columns " + which +
                                  "): say which, as \"" + column + "#1\" or \"" + column + "#2\"");
  }
  fail(layout_.header_line, "no column " + name + "; the columns there are: " + list_of(layout_.names));
}

void TableReader::find_places() {
  layout_.places.clear();
  layout_.filter_places.clear();
  layout_.name_places.clear();
  for (const ColumnMapping& column : mapping_.columns) layout_.places.push_back(place_of(column.column));
  for (const RowFilter& filter : mapping_.filters) layout_.filter_places.push_back(place_of(filter.column));
  for (const NameColumn* name : mapping_.name_columns()) layout_.name_places.push_back(place_of(name->column));
}

/// Every column of the file is declared: a column that nobody thought of may be the one that matters. One without a
/// name and without a cell is none.
void TableReader::declare_all() {
  std::vector<bool> declared(layout_.names.size(), mapping_.ignore_others);
  for (const auto* places : {&layout_.places, &layout_.filter_places, &layout_.name_places}) {
    for (const std::size_t place : *places) declared[place] = true;
  }
  for (const std::string& column : mapping_.ignored) {
    for (const std::size_t place : find_columns(layout_.names, column)) declared[place] = true;
  }
  for (std::size_t index = 0; index < declared.size(); ++index) {
    const std::string& name = layout_.names[index];
    if (declared[index] || (name.empty() && is_empty_column(index))) continue;
    const bool plain = !name.empty() && std::count(layout_.names.begin(), layout_.names.end(), name) == 1;
    const std::string key = plain ? name : "#" + std::to_string(index + 1);
    fail(layout_.header_line, "column " + (name.empty() ? key : text::in_quotes(name)) +
                                  " is not in the mapping; give it a field, or write: \"" + text::printable(key) +
                                  "\" = \"ignore\" (or other_columns = \"ignore\" for all such)");
  }
}

bool TableReader::is_empty_column(std::size_t index) {
  LineReader lines = first_row_;
  while (const auto line = lines.next()) {
    if (trimmed(*line).empty() || comment_of(*line, comments_)) continue;
    const auto& cells = splitter_.split(*line);
    if (index < cells.size() && !cells[index].empty()) return false;
  }
  return true;
}

/// A unit that the file says is the mapping's.
void TableReader::check_units() {
  for (std::size_t i = 0; i < layout_.places.size(); ++i) {
    const std::string& name = layout_.names[layout_.places[i]];
    const std::string problem = unit_problem(mapping_.columns[i], split_header_name(name).unit);
    if (!problem.empty()) fail(layout_.header_line, "column " + text::in_quotes(name) + ' ' + problem);
  }
}

void TableReader::rewind() {
  lines_ = first_row_;
  layout_ = first_layout_;
  row_ = 0;
  passed_over_ = {};
  filtered_values_.clear();
}

bool TableReader::wanted(const std::vector<std::string_view>& fields) {
  for (std::size_t i = 0; i < layout_.filter_places.size(); ++i) {
    const RowFilter& filter = mapping_.filters[i];
    // Too short a row: to be counted as such, once.
    if (layout_.filter_places[i] >= fields.size()) return mapping_.first_of_names;
    const std::string_view cell = fields[layout_.filter_places[i]];
    const auto number = parse_number<double>(cell, DecimalMark::Point);
    const auto same = [&](const std::string& text) {
      if (cell == text) return true;
      const auto wanted_number = parse_number<double>(text, DecimalMark::Point);
      return !filter.exact && number.kind == NumberKind::Finite && wanted_number.kind == NumberKind::Finite &&
             number.value == wanted_number.value;
    };
    if (std::any_of(filter.texts.begin(), filter.texts.end(), same) == filter.equals) continue;
    if (filter.exact) {
      ++passed_over_.others;
      return false;
    }
    ++passed_over_.filtered;
    if (filtered_values_.size() < shown_values || filtered_values_.contains(std::string(cell))) {
      ++filtered_values_[text::printable(cell, false, 40)];
    }
    return false;
  }
  return true;
}

/// A row whose quoted field goes on in the next lines. A stray quote is none: the lines behind it are rows of their
/// own. On success the row is split, and the lines are passed.
bool TableReader::join_lines(std::string_view line, std::size_t begin) {
  const bool whole = filled(splitter_.split(line)) == width();
  RowSplitter alone(splitter_.delimiter());
  LineReader ahead = lines_;
  for (std::uint64_t i = 0; i < lines_of_a_row; ++i) {
    const auto more = ahead.next();
    if (!more) break;
    const bool row_alone = filled(alone.split(*more)) == width();
    const std::string_view row = joined(begin, *more);
    fields_ = &splitter_.split(row);
    if (splitter_.open()) {
      if (row_alone) break;
      continue;
    }
    if ((whole && row_alone) || filled(*fields_) > width() || fields_->size() < width()) break;
    lines_ = ahead;
    row_text_ = row;
    return true;
  }
  return false;
}

void TableReader::split(std::string_view line) {
  row_text_ = line;
  row_line_ = lines_.line();
  if (!fixed_.empty()) {
    fixed_fields_ = split_fixed(line, fixed_);
    fields_ = &fixed_fields_;
    return;
  }
  if (lines_in_quotes_) {
    line_inside_ = splitter_.split(line).front();
    fields_ = &splitter_.split(line_inside_);
    return;
  }
  fields_ = &splitter_.split(line);
  if (!splitter_.open()) return;
  const auto begin = static_cast<std::size_t>(line.data() - text_.data());
  if (!join_lines(line, begin)) fields_ = &splitter_.split(line);
}

/// Files that were put together have their headers between the rows; the columns may stand in another order.
bool TableReader::is_other_header() {
  if (layout_.places.empty() || layout_.header_line == 0 || !fixed_.empty()) return false;
  const std::string& mark = layout_.names[layout_.places.front()];
  if (mark.empty() || std::find(fields_->begin(), fields_->end(), mark) == fields_->end()) return false;
  std::vector<std::string> names = header_names(*fields_);
  if (names == layout_.names) return true;
  const auto there = std::count_if(layout_.places.begin(), layout_.places.end(), [&](std::size_t place) {
    return std::find(names.begin(), names.end(), layout_.names[place]) != names.end();
  });
  if (2 * static_cast<std::size_t>(there) <= layout_.places.size()) return false;
  layout_.names = std::move(names);
  layout_.header_line = row_line_;
  find_places();
  const LineReader first = first_row_;
  first_row_ = lines_;
  declare_all();
  first_row_ = first;
  check_units();
  return true;
}

/// A line of units beneath the header.
bool TableReader::is_first_header_or_units() {
  if (row_ > 0 || layout_.header_line == 0 || !fixed_.empty() || !is_unit_row(*fields_, layout_.places)) return false;
  for (std::size_t i = 0; i < layout_.places.size(); ++i) {
    const std::string problem = unit_problem(mapping_.columns[i], without_brackets((*fields_)[layout_.places[i]]));
    if (!problem.empty()) {
      fail(row_line_,
           "the line of units, at column " + text::in_quotes(layout_.names[layout_.places[i]]) + ", " + problem);
    }
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
    if (layout_.header_line == 0 && row_ == 0 && declared_separator(*line)) continue;
    split(*line);
    if (is_other_header() || is_first_header_or_units()) {
      ++passed_over_.headers;
      continue;
    }
    ++row_;
    if (wanted(*fields_)) return true;
  }
  return false;
}

}  // namespace downrange::archive
