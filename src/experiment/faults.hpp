#pragma once
/// A catalogue of faults flown through the engine, each scenario against what its author expects.

#include <downrange/stage/range_config.hpp>
#include <string>
#include <vector>

#include "experiment/experiment.hpp"
#include "score/fault_judge.hpp"
#include "sim/faults.hpp"

namespace downrange::experiment {
namespace faults {

/// What there is to fly; read by the caller.
struct Plan {
  sim::FaultCatalogue catalogue;
  sim::Scenario scenario;
  RangeConfig range;              ///< with as many radars as any scenario has
  std::vector<std::string> only;  ///< names of faults or of scenarios, "gps-*" for all that begin so; empty: everything
};

/// A line of the table: a fault, when it begins, and how many radars there are.
struct Row {
  const sim::Fault* fault = nullptr;
  double begin_s = 0;
  int radars = 0;
  std::string name;  ///< "gps-step-200@150/2"
};

/// In the order of the catalogue. Throws std::invalid_argument for a name in `only` that none has.
[[nodiscard]] std::vector<Row> rows_of(const Plan& plan);

/// A row, flown with one seed after the other.
struct Flown {
  Row row;
  std::vector<score::FaultScore> scores;
  std::vector<std::string> missed;  ///< what was not as expected with any seed, each once
};

/// Flies every row with `options.runs` seeds on `options.jobs` threads; results do not depend on their number.
[[nodiscard]] std::vector<Flown> fly(const Plan& plan, const ExperimentOptions& options);

[[nodiscard]] Table table_of(const std::vector<Flown>& flown);
/// What mounts that follow the commands made of them.
[[nodiscard]] Table antennas_of(const std::vector<Flown>& flown);
[[nodiscard]] std::vector<Figure> figures_of(const std::vector<Flown>& flown);
[[nodiscard]] std::vector<Figure> antenna_figures_of(const std::vector<Flown>& flown);
/// Error, bound, who is accused and what is followed over time, of the first seed.
[[nodiscard]] std::vector<Plot> plots_of(const std::vector<Flown>& flown);

}  // namespace faults

inline constexpr int fault_seeds = 3;  ///< that the expectations are stated for

/// Throws std::invalid_argument as `rows_of`, ScenarioError as `inject`.
[[nodiscard]] ExperimentResult run_faults(const ExperimentOptions& options, const faults::Plan& plan);

}  // namespace downrange::experiment
