#pragma once
/// What operators ordered of sources, targets and antennas (range/operator), and what of it is in force.

#include <downrange/stage/event.hpp>
#include <downrange/stage/range_config.hpp>
#include <downrange/stage/source_table.hpp>
#include <numbers>
#include <string>
#include <vector>

namespace downrange {

/// An order in force.
struct StandingOrder {
  OperatorOrder order = OperatorOrder::Release;
  Name argument;  ///< of HoldChain and PinAntennaSource: the chain; of PinAntennaTarget: the target
  double azimuth_trim_rad = 0;
  double elevation_trim_rad = 0;
  Name by;
  Remark reason;
  Time since;  ///< when it was given
};

/// Of an antenna; the order of each is Release where there is none.
struct AntennaOrders {
  StandingOrder source;
  StandingOrder target;
  StandingOrder trim;
  StandingOrder stop;
};

/// "stopped by kim (wind); trimmed by 0.250, 0.000 deg by lee (bumped)", as much as a remark holds; empty: none stands.
/// Allocates nothing.
[[nodiscard]] Remark words_of(const AntennaOrders& orders);

/// The newest order on each source (inhibit, force, release; reset of its bias; acknowledgement of its alarm), on each
/// target's chain (hold, release) and on each antenna (pins, trim, stop, release). A value; deterministic; allocates at
/// construction only.
class Orders {
 public:
  /// An antenna that needs more is not trimmed, it is broken.
  static constexpr double most_trim_rad = 5 * std::numbers::pi / 180;
  /// The chain of all sources, as an operator names it.
  static constexpr std::string_view whole_chain = "all";

  explicit Orders(const RangeConfig& config);

  /// What `refusal` speaks against changes nothing, nor does an order that was given before the one in force: a writer
  /// that is met again tells its history once more.
  void note(const OperatorCommand& command);

  /// Why such an order is not carried out, for who gave it; empty: it is. A matter of the configuration and of the
  /// order in force.
  [[nodiscard]] std::string refusal(const OperatorCommand& command) const;

  [[nodiscard]] bool inhibited(SourceId source) const { return stands(source, OperatorOrder::Inhibit); }
  [[nodiscard]] bool forced(SourceId source) const { return stands(source, OperatorOrder::Force); }
  /// Null: none, or it was released.
  [[nodiscard]] const StandingOrder* of(SourceId source) const;

  /// By the target's place in the configuration: "all", "only-radars", and "without-NAME" or "only-NAME" of a radar, a
  /// tracker or "GPS"; empty: nobody holds it.
  [[nodiscard]] Name held_chain(int target) const;
  [[nodiscard]] const StandingOrder* hold_of(int target) const;
  /// By the antenna's place in the configuration.
  [[nodiscard]] const AntennaOrders& of_antenna(int antenna) const {
    return of_antenna_[static_cast<std::size_t>(antenna)];
  }
  /// The newest acknowledgement of a source's alarm; null: none.
  [[nodiscard]] const StandingOrder* acknowledgement_of(SourceId source) const;
  /// When it was last ordered that a sensor's bias begin anew; null: never.
  [[nodiscard]] const StandingOrder* bias_reset_of(SourceId source) const;

 private:
  [[nodiscard]] bool stands(SourceId source, OperatorOrder order) const {
    const StandingOrder* standing = of(source);
    return standing != nullptr && standing->order == order;
  }
  [[nodiscard]] std::string refusal_by_configuration(const OperatorCommand& command) const;
  /// The standing orders that it would replace.
  template <class Visit>
  static void for_each_replaced(auto& self, const OperatorCommand& command, const Visit& visit);
  [[nodiscard]] std::string refusal_of_hold(const OperatorCommand& command) const;
  [[nodiscard]] std::string refusal_of_antenna(const OperatorCommand& command) const;
  /// Empty: it is the name of one.
  [[nodiscard]] std::string refusal_of_chain(const Name& name) const;
  [[nodiscard]] std::string unknown_source(const Name& name) const;

  SourceTable sources_;
  std::vector<Name> targets_;
  std::vector<Name> antennas_;
  std::vector<Name> chains_;  ///< of INTEGRITY, of parts of the sources
  bool simulated_;
  Duration max_future_;
  std::vector<StandingOrder> of_source_;  ///< by SourceId; Release: none
  std::vector<StandingOrder> of_target_;
  std::vector<AntennaOrders> of_antenna_;
  std::vector<StandingOrder> acknowledged_;  ///< by SourceId
  std::vector<StandingOrder> bias_reset_;    ///< likewise
};

}  // namespace downrange
