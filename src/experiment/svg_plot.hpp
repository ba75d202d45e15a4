#pragma once
/// A plot as inline SVG, drawn in the colours of the page's style sheet.

#include <span>
#include <string>
#include <string_view>

#include "experiment/experiment.hpp"

namespace downrange::experiment {

/// Style rules of the plots' classes; the page defines the colours --ink, --faint and --series-0 .. --series-7 that
/// they use.
[[nodiscard]] std::string_view plot_style();

/// Of each plot a `<figure>` with the drawing, its axes with ticks, and the legend; of several plots side by side, with
/// the same axes. Lines of many points are thinned to what a screen can show: the least and the greatest value in each
/// column of pixels are kept. `row` has at least one plot, and all of them a logarithmic y axis or none.
[[nodiscard]] std::string svg_figures(std::span<const Plot> row);

/// With &, <, > and quotes written as entities.
[[nodiscard]] std::string escaped(std::string_view text);

}  // namespace downrange::experiment
