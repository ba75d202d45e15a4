#pragma once
/// What operators ordered of sources and targets (range/operator), and what of it is in force.

#include <downrange/stage/event.hpp>
#include <downrange/stage/range_config.hpp>
#include <downrange/stage/source_table.hpp>
#include <string>
#include <vector>

namespace downrange {

/// An order in force.
struct StandingOrder {
  OperatorOrder order = OperatorOrder::Release;
  Name argument;  ///< of HoldChain: the chain
  Name by;
  Remark reason;
  Time since;  ///< when it was given
};

/// The newest order on each source (inhibit, force, release) and on each target's chain (hold, release). A value;
/// deterministic; allocates at construction only.
class Orders {
 public:
  /// The chain of all sources, as an operator names it.
  static constexpr std::string_view whole_chain = "all";

  explicit Orders(const RangeConfig& config);

  /// What `refusal` speaks against changes nothing, nor does an order that was given before the one in force: a writer
  /// that is met again tells its history once more.
  void note(const OperatorCommand& command);

  /// Why such an order is not carried out, for who gave it; empty: it is. A matter of the configuration alone.
  [[nodiscard]] std::string refusal(const OperatorCommand& command) const;

  [[nodiscard]] bool inhibited(SourceId source) const { return stands(source, OperatorOrder::Inhibit); }
  [[nodiscard]] bool forced(SourceId source) const { return stands(source, OperatorOrder::Force); }
  /// Null: none, or it was released.
  [[nodiscard]] const StandingOrder* of(SourceId source) const;

  /// By the target's place in the configuration: "all", "only-radars", and "without-NAME" or "only-NAME" of a radar, a
  /// tracker or "GPS"; empty: nobody holds it.
  [[nodiscard]] Name held_chain(int target) const;
  [[nodiscard]] const StandingOrder* hold_of(int target) const;

 private:
  [[nodiscard]] bool stands(SourceId source, OperatorOrder order) const {
    const StandingOrder* standing = of(source);
    return standing != nullptr && standing->order == order;
  }
  [[nodiscard]] int target_of(const Name& name) const;
  [[nodiscard]] std::string refusal_of_hold(const OperatorCommand& command) const;

  SourceTable sources_;
  std::vector<Name> targets_;
  bool simulated_;
  Duration max_future_;
  std::vector<StandingOrder> of_source_;  ///< by SourceId; Release: none
  std::vector<StandingOrder> of_target_;
};

}  // namespace downrange
