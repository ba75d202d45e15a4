#pragma once
/// What becomes of operators' orders and of the marks of the mission clock at this node: for the status, and for the
/// log.

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dds/service_status.hpp"
#include "stage/mission_clock.hpp"
#include "stage/orders.hpp"

namespace downrange::app {

class Acknowledgements {
 public:
  explicit Acknowledgements(const RangeConfig& config) : orders_(config), mission_(config) {}

  /// An event that the engine consumed. What the log is to say of it; none: neither an order nor a mark, or an order
  /// that was told before: a writer that is met again tells its history once more.
  [[nodiscard]] std::optional<std::string> note(const Event& event);

  /// The newest first, at most as many as a status holds.
  [[nodiscard]] const std::vector<dds::Acknowledgement>& newest() const { return newest_; }

  /// What is in force, to be handed to an engine that begins anew at `now`: orders and marks in the order in which they
  /// came.
  [[nodiscard]] std::vector<Event> in_force(Time now) const;

 private:
  void acknowledge(std::size_t topic, const Name& sender, std::uint64_t sequence, const std::string& refusal);
  [[nodiscard]] bool told_before(const Event& event);
  void keep(const Event& event);

  Orders orders_;
  MissionClock mission_;
  std::vector<dds::Acknowledgement> newest_;
  std::vector<Event> taken_;                          ///< orders: those that stand
  std::vector<std::pair<Name, std::uint64_t>> told_;  ///< operators' messages, by sender and sequence
};

}  // namespace downrange::app
