#pragma once
/// What the launch experiment measured, before it is judged and drawn.

#include <string_view>
#include <vector>

#include "experiment/experiment.hpp"
#include "experiment/launch_score.hpp"

namespace downrange::experiment::launch {

struct Flown {
  Contestant contestant;
  Score score;                          ///< over all runs
  std::vector<PlotResidual> residuals;  ///< of the first run
};

struct Result {
  std::vector<Flown> flown;
  Score bound;                 ///< polar blocks
  Score bound_gps_lost;        ///< polar blocks, no fix from 370 s on
  Score bound_default_blocks;  ///< polar, sez_offset and time
  Score bound_time_tag;        ///< polar and time

  /// Null where the method was not asked for.
  [[nodiscard]] const Flown* find(std::string_view label, Case which = Case::Base) const;
};

/// The launch rows of est/THEORY.md section 10; rows of methods that were not flown are left out.
[[nodiscard]] std::vector<Figure> figures(const Result& result);
[[nodiscard]] std::vector<Plot> plots(const Result& result);

}  // namespace downrange::experiment::launch
