#include <algorithm>
#include <sstream>

#include "experiment/report.hpp"

namespace downrange::experiment {
namespace {

constexpr std::size_t columns = 100;
constexpr std::size_t measured_width = 11;
constexpr std::size_t reach_width = 16;
constexpr std::size_t verdict_width = 13;  // "  falls short"
constexpr std::size_t what_width = columns - measured_width - reach_width - verdict_width;
static_assert(what_width == figure_name_width + 1);
constexpr int digits = 4;

/// Lines of at most `width` characters, broken at blanks; a longer word has a line of its own.
std::vector<std::string> wrapped(const std::string& text, std::size_t width) {
  std::vector<std::string> lines(1);
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (!lines.back().empty() && lines.back().size() + 1 + word.size() > width) lines.emplace_back();
    lines.back() += (lines.back().empty() ? "" : " ") + word;
  }
  return lines;
}

std::string left(std::string text, std::size_t width) {
  if (text.size() < width) text.resize(width, ' ');
  return text;
}

std::string right(const std::string& text, std::size_t width) {
  return text.size() < width ? std::string(width - text.size(), ' ') + text : text;
}

std::string_view verdict(const Figure& figure) { return figure.reached ? "  pass" : "  falls short"; }

/// The name on as many lines as it needs, the numbers beside the last.
void write_row(std::ostream& out, const std::string& what, const std::string& rest) {
  const std::vector<std::string> lines = wrapped(what, figure_name_width);
  for (std::size_t i = 0; i + 1 < lines.size(); ++i) out << lines[i] << '\n';
  out << left(lines.back(), what_width) << rest << '\n';
}

/// Each column as wide as its widest cell, the first one to the left.
void write_table(std::ostream& out, const Table& table) {
  std::vector<std::size_t> width;
  for (const std::string& column : table.columns) width.push_back(column.size());
  for (const std::vector<Cell>& row : table.rows)
    for (std::size_t i = 0; i < row.size(); ++i) width[i] = std::max(width[i], row[i].text.size());
  const auto write_line = [&](const auto& text_of) {
    std::string line = left(text_of(0), width[0]);
    for (std::size_t i = 1; i < width.size(); ++i) line += "  " + right(text_of(i), width[i]);
    out << line << '\n';
  };
  out << '\n' << table.caption << "\n\n";
  write_line([&](std::size_t i) { return table.columns[i]; });
  for (const std::vector<Cell>& row : table.rows) write_line([&](std::size_t i) { return row[i].text; });
}

void write_paragraph(std::ostream& out, const std::string& head, const std::string& text) {
  const std::vector<std::string> lines = wrapped(text, columns - head.size());
  out << head << lines.front() << '\n';
  for (std::size_t i = 1; i < lines.size(); ++i) out << std::string(head.size(), ' ') << lines[i] << '\n';
}

}  // namespace

std::string format_text(const ExperimentResult& result) {
  std::ostringstream out;
  write_paragraph(out, result.name + ": ", result.title);
  out << runs_text(result) << "\n\n";
  write_row(out, "", right("measured", measured_width) + "  to reach");
  for (const Figure& figure : result.figures)
    write_row(out, figure.what,
              right(number_text(figure.measured, digits), measured_width) +
                  (figure.reach.empty() ? "" : "  " + left(figure.reach, reach_width - 2).append(verdict(figure))));

  const auto judged = [](const Figure& figure) { return !figure.reach.empty(); };
  const auto of = std::count_if(result.figures.begin(), result.figures.end(), judged);
  const auto reached = std::count_if(result.figures.begin(), result.figures.end(),
                                     [&](const Figure& figure) { return judged(figure) && figure.reached; });
  out << '\n' << reached << " of " << of << " figures reached.\n";

  for (const Table& table : result.tables) write_table(out, table);
  if (!result.settings.empty()) out << '\n';
  std::size_t widest = 0;
  for (const auto& [key, value] : result.settings) widest = std::max(widest, key.size());
  for (const auto& [key, value] : result.settings) write_paragraph(out, left(key, widest + 2), value);
  if (!result.notes.empty()) out << '\n';
  for (const std::string& note : result.notes) write_paragraph(out, "- ", note);
  return out.str();
}

}  // namespace downrange::experiment
