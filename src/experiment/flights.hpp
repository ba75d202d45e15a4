#pragma once
/// Recorded flights through the engine, against the last rows of est/THEORY.md section 10.

#include <downrange/stage/event.hpp>
#include <downrange/stage/range_config.hpp>
#include <span>
#include <string>
#include <vector>

#include "experiment/experiment.hpp"
#include "experiment/flights_replay.hpp"

namespace downrange::experiment {

/// The methods that fly side by side, the service's default first.
[[nodiscard]] const std::vector<std::string>& flight_methods();

namespace flights {

/// All replays of one flight.
struct FlightResult {
  std::string name;
  RangeConfig range;
  std::vector<Name> radars;  ///< those that see the flight, in the range's order
  std::vector<Flown> flown;

  /// Null where the methods asked for left it out.
  [[nodiscard]] const Flown* find(std::string_view label) const;
};

/// Flies every replay of every flight on `options.jobs` threads; results do not depend on their number.
[[nodiscard]] std::vector<FlightResult> fly(std::span<const RecordedFlight> flights, const ExperimentOptions& options);

/// The rows of section 10 for the flights it names (falcon_heavy_demo, falcon9_crs11); other flights are shown without
/// figures to reach.
[[nodiscard]] std::vector<Figure> figures(const FlightResult& flight);
[[nodiscard]] std::vector<Plot> plots(const FlightResult& flight);
[[nodiscard]] std::vector<std::string> notes(const FlightResult& flight);

}  // namespace flights

/// Table, plots and notes of flights that were flown.
[[nodiscard]] ExperimentResult flights_result(std::span<const flights::FlightResult> flown);

/// `fly` and `flights_result`. Nothing is drawn: runs and seed of `options` mean nothing. Throws std::invalid_argument
/// for a method that is not compared.
[[nodiscard]] ExperimentResult run_flights(const ExperimentOptions& options,
                                           std::span<const flights::RecordedFlight> recorded);

}  // namespace downrange::experiment
