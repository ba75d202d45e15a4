#pragma once
/// --faults, --fault and --fault-begin, as simulate and replay have them.

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "sim/faults.hpp"

namespace downrange::app {

struct FaultOptions {
  std::string file;
  std::string name;
  std::optional<double> begin_s;

  void add_to(CLI::App& command);
  [[nodiscard]] bool given() const { return !file.empty(); }
};

/// The fault that was asked for, of its file.
class ChosenFault {
 public:
  /// Throws ScenarioError.
  explicit ChosenFault(const FaultOptions& options);
  ChosenFault(const ChosenFault&) = delete;
  ChosenFault& operator=(const ChosenFault&) = delete;

  [[nodiscard]] const sim::Fault& fault() const { return *fault_; }
  /// Null: the fault has no flight of its own.
  [[nodiscard]] const sim::FlightVariant* flight() const { return catalogue_.flight_of(*fault_); }
  /// Plays it, and says so on stderr. Throws ScenarioError, also where no message is touched though the fault does
  /// something.
  [[nodiscard]] std::vector<Event> play(std::vector<Event> events, const RangeConfig& range, Time liftoff,
                                        std::uint64_t seed) const;

 private:
  sim::FaultCatalogue catalogue_;
  const sim::Fault* fault_;
  double begin_s_;
};

/// Lift-off as the mission's messages tell it, the last word counts. Throws std::runtime_error where they do not.
[[nodiscard]] Time liftoff_told(const std::vector<Event>& events, const std::string& archive);

/// The catalogue beside the checkout that this was built from.
[[nodiscard]] std::string default_faults();

}  // namespace downrange::app
