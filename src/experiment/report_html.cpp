#include <algorithm>
#include <sstream>

#include "experiment/report.hpp"
#include "experiment/svg_plot.hpp"

namespace downrange::experiment {
namespace {

constexpr int digits = 4;

// Series colours are told apart by people with any colour vision, on white and on near black.
constexpr std::string_view page_style = R"(:root { color-scheme: light dark;
  --paper: #ffffff; --ink: #1b1f24; --faint: #dfe3e8; --pass: #0a6b3d; --short: #a8200d;
  --series-0: #0072b2; --series-1: #d55e00; --series-2: #009e73; --series-3: #b0589a;
  --series-4: #a67c00; --series-5: #3f9fd8; --series-6: #7a4b2a; --series-7: #6b6f76; }
@media (prefers-color-scheme: dark) { :root {
  --paper: #14171b; --ink: #e4e7eb; --faint: #31363d; --pass: #5fd39a; --short: #ff8f7a;
  --series-0: #4ea8de; --series-1: #f28e4c; --series-2: #35c79a; --series-3: #d98cc3;
  --series-4: #e0bb4f; --series-5: #9fd3f5; --series-6: #c79a77; --series-7: #a3a9b2; } }
@media print { :root {
  --paper: #ffffff; --ink: #000000; --faint: #dddddd; --pass: #0a6b3d; --short: #a8200d;
  --series-0: #0072b2; --series-1: #d55e00; --series-2: #009e73; --series-3: #b0589a;
  --series-4: #a67c00; --series-5: #3f9fd8; --series-6: #7a4b2a; --series-7: #6b6f76; }
  section { break-before: page; } section:first-of-type { break-before: auto; } nav { display: none; } }
body { background: var(--paper); color: var(--ink); font: 16px/1.5 system-ui, sans-serif; max-width: 64rem;
  margin: 0 auto; padding: 1.5rem; }
a { color: var(--series-0); }
table { border-collapse: collapse; width: 100%; font-size: .92rem; }
caption { text-align: left; font-weight: 600; padding-bottom: .4rem; }
th, td { text-align: left; padding: .25rem .7rem .25rem 0; border-bottom: 1px solid var(--faint); vertical-align: top; }
td.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
th.number { text-align: right; }
td.reach { white-space: nowrap; }
.pass { color: var(--pass); } .short { color: var(--short); font-weight: 700; }
div.wide { overflow-x: auto; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .1rem 1.2rem; font-size: .92rem; }
dt { font-weight: 600; } dd { margin: 0; }
@media (max-width: 40rem) { dl { display: block; } dd { margin: 0 0 .4rem; } }
)";

void write_figures(std::ostream& out, const ExperimentResult& result) {
  out << "<table><caption>Figures, measured beside the figure to reach</caption>\n<thead><tr><th "
         "scope=\"col\">what</th>"
         "<th scope=\"col\" class=\"number\">measured</th><th scope=\"col\">to reach</th><th scope=\"col\">verdict</th>"
         "</tr></thead>\n<tbody>\n";
  for (const Figure& figure : result.figures) {
    out << "<tr><td>" << escaped(figure.what) << "</td><td class=\"number\">" << number_text(figure.measured, digits)
        << "</td><td class=\"reach\">" << escaped(figure.reach) << "</td>";
    if (figure.reach.empty())
      out << "<td></td></tr>\n";
    else
      out << (figure.reached ? "<td class=\"pass\">pass</td></tr>\n" : "<td class=\"short\">falls short</td></tr>\n");
  }
  out << "</tbody></table>\n";
}

void write_table(std::ostream& out, const Table& table) {
  out << "<div class=\"wide\"><table><caption>" << escaped(table.caption) << "</caption>\n<thead><tr>";
  for (std::size_t i = 0; i < table.columns.size(); ++i)
    out << "<th scope=\"col\"" << (i > 0 ? " class=\"number\">" : ">") << escaped(table.columns[i]) << "</th>";
  out << "</tr></thead>\n<tbody>\n";
  for (const std::vector<Cell>& row : table.rows) {
    out << "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i)
      out << (i > 0 ? "<td class=\"number\">" : "<td>") << escaped(row[i].text) << "</td>";
    out << "</tr>\n";
  }
  out << "</tbody></table></div>\n";
}

void write_section(std::ostream& out, const ExperimentResult& result) {
  out << "<section id=\"" << escaped(result.name) << "\">\n<h2>" << escaped(result.name) << ": "
      << escaped(result.title) << "</h2>\n<p>" << runs_text(result) << ".</p>\n";
  write_figures(out, result);
  for (const Table& table : result.tables) write_table(out, table);
  if (!result.plots.empty())
    out << "<p>Curves are drawn in the legend's order: one that is not seen is covered by a later one.</p>\n";
  for (auto first = result.plots.begin(); first != result.plots.end();) {
    const auto is_beside = [first](const Plot& plot) { return !plot.row.empty() && plot.row == first->row; };
    const auto last = std::find_if_not(std::next(first), result.plots.end(), is_beside);
    out << svg_figures(std::span(first, last));
    first = last;
  }
  if (!result.notes.empty()) out << "<h3>Notes</h3>\n<ul>\n";
  for (const std::string& note : result.notes) out << "<li>" << escaped(note) << "</li>\n";
  if (!result.notes.empty()) out << "</ul>\n";
  if (!result.settings.empty()) out << "<h3>Settings</h3>\n<dl>\n";
  for (const auto& [key, value] : result.settings)
    out << "<dt>" << escaped(key) << "</dt><dd>" << escaped(value) << "</dd>\n";
  if (!result.settings.empty()) out << "</dl>\n";
  out << "</section>\n";
}

}  // namespace

std::string format_html(std::span<const ExperimentResult> results) {
  std::ostringstream out;
  const std::string title =
      results.size() == 1 ? "Downrange experiment " + results.front().name : std::string("Downrange experiments");
  out << "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>"
      << escaped(title) << "</title>\n<style>\n"
      << page_style << plot_style() << "</style></head>\n<body>\n<h1>" << escaped(title) << "</h1>\n";
  if (results.size() > 1) {
    out << "<nav aria-label=\"Experiments\"><ul>\n";
    for (const ExperimentResult& result : results) {
      const auto missed = std::count_if(result.figures.begin(), result.figures.end(),
                                        [](const Figure& figure) { return !figure.reached; });
      out << "<li><a href=\"#" << escaped(result.name) << "\">" << escaped(result.name) << "</a>: "
          << (missed == 0 ? std::string("every figure reached") : std::to_string(missed) + " figures fall short")
          << "</li>\n";
    }
    out << "</ul></nav>\n";
  }
  out << "<main>\n";
  for (const ExperimentResult& result : results) write_section(out, result);
  out << "</main>\n</body></html>\n";
  return out.str();
}

}  // namespace downrange::experiment
