#pragma once
/// An experiment's result for people (text, HTML) and for programs (JSON).

#include <cstddef>
#include <span>
#include <string>

#include "experiment/experiment.hpp"

namespace downrange::experiment {

/// What a figure is called stands on one line of the table up to this many characters.
inline constexpr std::size_t figure_name_width = 59;

/// The table of figures, measured beside the figure to reach, with settings and notes; at most 100 columns.
[[nodiscard]] std::string format_text(const ExperimentResult& result);

/// One object with everything, the plots' curves included. A number that is not finite is null.
[[nodiscard]] std::string format_json(std::span<const ExperimentResult> results);

/// One page that needs nothing but itself: styles and plots are inside, there are no scripts. Follows the reader's
/// light or dark setting and prints on white.
[[nodiscard]] std::string format_html(std::span<const ExperimentResult> results);

}  // namespace downrange::experiment
