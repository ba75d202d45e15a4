#pragma once
/// One simulated flight: every message of every source in the order of arrival, and the truth behind them.

#include <cstdint>
#include <downrange/stage/event.hpp>
#include <downrange/stage/range_config.hpp>
#include <optional>
#include <vector>

#include "sim/scenario.hpp"
#include "sim/sensor_models.hpp"

namespace downrange::sim {

/// What was put into one radar's plots.
struct RadarTruth {
  Name sensor;
  RadarBias bias;
  std::vector<std::uint64_t> outlier_sequences;
};

/// What all sensors of `scenario` say of a vehicle that flies as `truth`, appended to `events` in no order; the radars'
/// own truth. `seed` as of Simulation.
[[nodiscard]] std::vector<RadarTruth> simulate_sensors(const Scenario& scenario, const score::TruthFunction& truth,
                                                       std::uint64_t seed, std::vector<Event>& events);

/// By `received`, equal times as the range clock orders them.
void sort_by_arrival(std::vector<Event>& events);

class Simulation {
 public:
  /// Flies `scenario`; `seed` draws noise, dropouts, delays and the per-run biases (scenario.seed is the file's wish).
  Simulation(const Scenario& scenario, std::uint64_t seed);

  /// Ordered by `received`, equal times as the range clock orders them.
  [[nodiscard]] const std::vector<Event>& events() const { return events_; }

  /// The target's true state; on the pad before lift-off; nothing from 30 s after the scenario's end.
  [[nodiscard]] std::optional<score::TrueState> truth(Time t) const { return trajectory_.at(t); }

  [[nodiscard]] const LaunchTrajectory& trajectory() const { return trajectory_; }
  [[nodiscard]] const std::vector<RadarTruth>& radars() const { return radars_; }

 private:
  LaunchTrajectory trajectory_;
  std::vector<RadarTruth> radars_;
  std::vector<Event> events_;
};

}  // namespace downrange::sim
