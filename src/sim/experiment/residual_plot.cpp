#include "sim/experiment/residual_plot.hpp"

namespace downrange::sim {

Plot residual_plot(std::string title, std::string row, const std::vector<Residual>& residuals,
                   const Component& component) {
  constexpr std::size_t points_shown = 600;
  Curve residual{.label = "residual", .points = true};
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
  return {.title = std::move(title),
          .x_label = "time after lift-off, s",
          .y_label = "plot - track, " + std::string(component.unit),
          .curves = {std::move(residual), std::move(upper), std::move(lower)},
          .row = std::move(row)};
}

}  // namespace downrange::sim
