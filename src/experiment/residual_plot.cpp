#include "experiment/residual_plot.hpp"

#include <algorithm>
#include <cmath>

namespace downrange::experiment {
namespace {

/// Half the height of the plot: what 98 % of the residuals stay within, or the band where that is wider.
double y_most(const Curve& residual, const Curve& upper) {
  const auto quantile = [](std::vector<double> values, double share) {
    if (values.empty()) return 1.0;
    const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + at, values.end());
    return values[static_cast<std::size_t>(at)];
  };
  std::vector<double> magnitudes;
  for (const double y : residual.y) magnitudes.push_back(std::abs(y));
  return 1.3 * std::max(quantile(std::move(magnitudes), 0.98), quantile(upper.y, 0.5));
}

}  // namespace

Plot residual_plot(std::string title, std::string row, const std::vector<Residual>& residuals,
                   const Component& component) {
  constexpr std::size_t points_shown = 600;
  Curve residual{.label = "residual (far ones on the edge)", .points = true};
  Curve upper{.label = "+-2 sigma promised", .dashed = true};
  Curve lower{.dashed = true};
  const std::size_t every = residuals.size() / points_shown + 1;
  for (std::size_t i = 0; i < residuals.size(); i += every) {
    const Residual& r = residuals[i];
    const double sigma = r.sigma[component.index] / component.scale;
    for (Curve* curve : {&residual, &upper, &lower}) curve->x.push_back(r.t_s);
    residual.y.push_back(r.value[component.index] / component.scale);
    upper.y.push_back(2 * sigma);
    lower.y.push_back(-2 * sigma);
  }
  Plot plot{.title = std::move(title),
            .x_label = "time after lift-off, s",
            .y_label = "plot - track, " + std::string(component.unit),
            .y_most = y_most(residual, upper),
            .row = std::move(row)};
  plot.curves = {std::move(residual), std::move(upper), std::move(lower)};
  return plot;
}

}  // namespace downrange::experiment
