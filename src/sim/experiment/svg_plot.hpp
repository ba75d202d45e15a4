#pragma once
/// A plot as inline SVG, drawn in the colours of the page's style sheet.

#include <string>
#include <string_view>

#include "sim/experiment/experiment.hpp"

namespace downrange::sim {

/// Style rules of the plots' classes; the page defines the colours --ink, --faint and --series-0 .. --series-7 that
/// they use.
[[nodiscard]] std::string_view plot_style();

/// `<figure>` with the drawing, its axes with ticks, and the legend. Lines of many points are thinned to what a screen
/// can show: the least and the greatest value in each column of pixels are kept.
[[nodiscard]] std::string svg_figure(const Plot& plot);

/// With &, <, > and quotes written as entities.
[[nodiscard]] std::string escaped(std::string_view text);

}  // namespace downrange::sim
