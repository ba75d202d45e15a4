#include "orders.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "stage/decimal.hpp"
#include "stage/integrity/chain_plan.hpp"

namespace downrange {
namespace {

std::string quoted(const Name& name) { return "'" + std::string(name.view()) + "'"; }

template <class Entries, class Text>
std::string list(const Entries& entries, Text text) {
  constexpr std::size_t room = 60;  // a refusal is a remark
  std::string all;
  std::size_t left = entries.size();
  for (const auto& entry : entries) {
    if (all.size() > room) return all + " and " + std::to_string(left) + " more";
    all += (all.empty() ? "" : ", ") + std::string(text(entry).view());
    --left;
  }
  return all;
}

std::optional<std::size_t> place_of(const std::vector<Name>& names, const Name& name) {
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) return std::nullopt;
  return static_cast<std::size_t>(found - names.begin());
}

std::string no_such(const std::string& kind, const Name& name, const std::vector<Name>& names) {
  if (names.empty()) return "no " + kind + " is configured";
  return "no " + kind + " is named " + quoted(name) + ": there are " + list(names, [](const Name& n) { return n; });
}

void replace(StandingOrder& standing, const OperatorCommand& command) {
  if (command.epoch < standing.since) return;
  standing = {.order = command.order,
              .argument = command.argument,
              .azimuth_trim_rad = command.azimuth_trim_rad,
              .elevation_trim_rad = command.elevation_trim_rad,
              .by = command.operator_id,
              .reason = command.reason,
              .since = command.epoch};
}

/// Null: none.
const StandingOrder* standing(const StandingOrder& order) {
  return order.order == OperatorOrder::Release ? nullptr : &order;
}

/// As much as a remark holds.
class Words {
 public:
  void add(std::string_view text) {
    const std::size_t room = std::min(text.size(), text_.size() - 1 - used_);
    std::copy_n(text.begin(), room, text_.begin() + static_cast<std::ptrdiff_t>(used_));
    used_ += room;
  }
  /// "stopped by kim (wind)", where that stands.
  void add(const StandingOrder& order, std::string_view what, std::string_view of = {}) {
    if (order.order == OperatorOrder::Release) return;
    for (const std::string_view part :
         {std::string_view(used_ > 0 ? "; " : ""), what, of, std::string_view(" by "), order.by.view(),
          std::string_view(" ("), order.reason.view(), std::string_view(")")})
      add(part);
  }
  [[nodiscard]] Remark remark() const { return {text_.data()}; }

 private:
  std::array<char, Remark::max_size + 1> text_{};
  std::size_t used_ = 0;
};

}  // namespace

Remark words_of(const AntennaOrders& orders) {
  constexpr double deg = std::numbers::pi / 180;
  Words words;
  words.add(orders.stop, "stopped");
  words.add(orders.target, "sent to ", orders.target.argument.view());
  words.add(orders.source, "pinned to ", orders.source.argument.view());
  Words trim;
  trim.add(decimal(orders.trim.azimuth_trim_rad / deg, 3).view());
  trim.add(", ");
  trim.add(decimal(orders.trim.elevation_trim_rad / deg, 3).view());
  trim.add(" deg");
  words.add(orders.trim, "trimmed by ", trim.remark().view());
  return words.remark();
}

Orders::Orders(const RangeConfig& config)
    : sources_(config),
      simulated_(config.ingest.expect_simulated),
      max_future_(config.ingest.max_future),
      of_source_(sources_.size()),
      of_target_(config.targets.size()),
      of_antenna_(config.antennas.size()),
      acknowledged_(sources_.size()),
      bias_reset_(sources_.size()) {
  for (const TargetConfig& target : config.targets) targets_.push_back(target.id);
  for (const AntennaConfig& antenna : config.antennas) antennas_.push_back(antenna.id);
  for (const ChainPlan& chain : chains_of(config)) chains_.push_back(chain.name);
}

std::string Orders::unknown_source(const Name& name) const {
  return "no source is named " + quoted(name) + ": there are " + list(sources_, [](const Source& s) { return s.name; });
}

std::string Orders::refusal(const OperatorCommand& command) const {
  std::string refusal = refusal_by_configuration(command);
  if (!refusal.empty()) return refusal;
  const StandingOrder* newer = nullptr;
  bool changes = false;
  for_each_replaced(*this, command, [&](const StandingOrder& standing) {
    if (command.epoch < standing.since) {
      newer = &standing;
    } else {
      changes = true;
    }
  });
  if (changes || newer == nullptr) return {};
  return "it was given " + std::string(decimal((newer->since - command.epoch).seconds(), 1).view()) +
         " s before the order of " + quoted(newer->by) + " that is in force, or one of the clocks is wrong";
}

template <class Visit>
void Orders::for_each_replaced(auto& self, const OperatorCommand& command, const Visit& visit) {
  const SourceId source = self.sources_.find(command.subject);
  const auto antenna = place_of(self.antennas_, command.subject);
  const auto target = place_of(self.targets_, command.subject);
  switch (command.order) {
    case OperatorOrder::Release:
      // Sensors and antennas may share a name: then both are released.
      if (source != no_source) visit(self.of_source_[static_cast<std::size_t>(source)]);
      if (target) visit(self.of_target_[*target]);
      if (!antenna) return;
      visit(self.of_antenna_[*antenna].source);
      visit(self.of_antenna_[*antenna].target);
      visit(self.of_antenna_[*antenna].trim);
      return visit(self.of_antenna_[*antenna].stop);
    case OperatorOrder::Inhibit:
    case OperatorOrder::Force:
      return visit(self.of_source_[static_cast<std::size_t>(source)]);
    case OperatorOrder::ResetBias:
      return visit(self.bias_reset_[static_cast<std::size_t>(source)]);
    case OperatorOrder::AcknowledgeAlarm:
      return visit(self.acknowledged_[static_cast<std::size_t>(source)]);
    case OperatorOrder::HoldChain:
      return visit(self.of_target_[*target]);
    case OperatorOrder::PinAntennaSource:
      return visit(self.of_antenna_[*antenna].source);
    case OperatorOrder::PinAntennaTarget:
      return visit(self.of_antenna_[*antenna].target);
    case OperatorOrder::TrimAntenna:
      return visit(self.of_antenna_[*antenna].trim);
    case OperatorOrder::StopAntenna:
      return visit(self.of_antenna_[*antenna].stop);
  }
}

std::string Orders::refusal_by_configuration(const OperatorCommand& command) const {
  if (command.simulated != simulated_)
    return simulated_ ? "this node flies a simulated flight and takes its orders only (ingest.expect_simulated = true)"
                      : "an order of a simulated flight, and this node flies a real one";
  if (command.operator_id.empty()) return "it does not say who orders";
  if (command.reason.empty()) return "it gives no reason";
  if (!plausible(command.epoch)) return "its time is none between 1970 and 2100";
  if (command.epoch > command.received + max_future_) return "it is dated in the future: one of the clocks is wrong";
  const SourceId source = sources_.find(command.subject);
  const bool known = source != no_source;
  switch (command.order) {
    case OperatorOrder::Inhibit:
    case OperatorOrder::Force:
    case OperatorOrder::AcknowledgeAlarm:
      return known ? "" : unknown_source(command.subject);
    case OperatorOrder::ResetBias:
      if (known && sources_[source].kind == SourceKind::Telemetry)
        return quoted(command.subject) + " relays a receiver: no bias of it is estimated";
      return known ? "" : unknown_source(command.subject);
    case OperatorOrder::Release:
      if (known || place_of(targets_, command.subject) || place_of(antennas_, command.subject)) return {};
      return "neither a source, a target nor an antenna is named " + quoted(command.subject);
    case OperatorOrder::HoldChain:
      return refusal_of_hold(command);
    case OperatorOrder::PinAntennaSource:
    case OperatorOrder::PinAntennaTarget:
    case OperatorOrder::TrimAntenna:
    case OperatorOrder::StopAntenna:
      return refusal_of_antenna(command);
  }
  return "this version does not carry out such an order";
}

std::string Orders::refusal_of_hold(const OperatorCommand& command) const {
  if (!place_of(targets_, command.subject)) return no_such("target", command.subject, targets_);
  return refusal_of_chain(command.argument);
}

std::string Orders::refusal_of_antenna(const OperatorCommand& command) const {
  if (!place_of(antennas_, command.subject)) return no_such("antenna", command.subject, antennas_);
  if (command.order == OperatorOrder::PinAntennaSource) return refusal_of_chain(command.argument);
  if (command.order == OperatorOrder::PinAntennaTarget)
    return place_of(targets_, command.argument) ? "" : no_such("target", command.argument, targets_);
  if (command.order != OperatorOrder::TrimAntenna) return {};
  const auto small = [](double trim_rad) { return std::abs(trim_rad) <= most_trim_rad; };  // not NaN either
  return small(command.azimuth_trim_rad) && small(command.elevation_trim_rad) ? ""
                                                                              : "a trim is at most 5 deg either way";
}

std::string Orders::refusal_of_chain(const Name& name) const {
  if (name.view() == whole_chain || std::ranges::find(chains_, name) != chains_.end()) return {};
  if (chains_.empty()) return "there is no chain but all: INTEGRITY is off, or one source is alone";
  return "no chain is named " + quoted(name) + ": there are all, " + list(chains_, [](const Name& n) { return n; });
}

void Orders::note(const OperatorCommand& command) {
  if (refusal(command).empty())
    for_each_replaced(*this, command, [&](StandingOrder& standing) { replace(standing, command); });
}

const StandingOrder* Orders::of(SourceId source) const {
  return standing(of_source_[static_cast<std::size_t>(source)]);
}

const StandingOrder* Orders::hold_of(int target) const {
  return standing(of_target_[static_cast<std::size_t>(target)]);
}

Name Orders::held_chain(int target) const {
  const StandingOrder* hold = hold_of(target);
  return hold == nullptr ? Name{} : hold->argument;
}

const StandingOrder* Orders::acknowledgement_of(SourceId source) const {
  return standing(acknowledged_[static_cast<std::size_t>(source)]);
}

const StandingOrder* Orders::bias_reset_of(SourceId source) const {
  return standing(bias_reset_[static_cast<std::size_t>(source)]);
}

}  // namespace downrange
