#include <cmath>
#include <nlohmann/json.hpp>

#include "experiment/report.hpp"

namespace downrange::experiment {
namespace {

using nlohmann::json;

json of(const Figure& figure) {
  json j{{"what", figure.what}, {"measured", figure.measured}};
  if (figure.reach.empty()) return j;
  j["reach"] = figure.reach;
  j["reached"] = figure.reached;
  return j;
}

json of(const Table& table) {
  json rows = json::array();
  for (const std::vector<Cell>& cells : table.rows) {
    json row = json::object();
    for (std::size_t i = 0; i < cells.size(); ++i)
      row[table.columns[i]] = std::isfinite(cells[i].number) ? json(cells[i].number) : json(cells[i].text);
    rows.push_back(std::move(row));
  }
  return {{"caption", table.caption}, {"columns", table.columns}, {"rows", std::move(rows)}};
}

json of(const Plot& plot) {
  json curves = json::array();
  for (const Curve& curve : plot.curves)
    curves.push_back(
        {{"label", curve.label}, {"dashed", curve.dashed}, {"points", curve.points}, {"x", curve.x}, {"y", curve.y}});
  return {{"title", plot.title}, {"x_label", plot.x_label}, {"y_label", plot.y_label},
          {"log_y", plot.log_y}, {"row", plot.row},         {"curves", std::move(curves)}};
}

json of(const ExperimentResult& result) {
  json settings = json::object();
  for (const auto& [key, value] : result.settings) settings[key] = value;
  json figures = json::array();
  for (const Figure& figure : result.figures) figures.push_back(of(figure));
  json tables = json::array();
  for (const Table& table : result.tables) tables.push_back(of(table));
  json plots = json::array();
  for (const Plot& plot : result.plots) plots.push_back(of(plot));
  json j{{"name", result.name},
         {"title", result.title},
         {"all_reached", all_reached(result)},
         {"settings", std::move(settings)},
         {"figures", std::move(figures)},
         {"tables", std::move(tables)},
         {"plots", std::move(plots)},
         {"notes", result.notes}};
  if (result.runs > 0) {
    j["runs"] = result.runs;
    j["seed"] = result.seed;
  }
  return j;
}

}  // namespace

std::string format_json(std::span<const ExperimentResult> results) {
  json experiments = json::array();
  for (const ExperimentResult& result : results) experiments.push_back(of(result));
  return json{{"experiments", std::move(experiments)}}.dump(1);
}

}  // namespace downrange::experiment
