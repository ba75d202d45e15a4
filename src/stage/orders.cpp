#include "orders.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace downrange {
namespace {

/// The vehicle's receiver, whichever stations relay it, as chains name it.
constexpr std::string_view receiver = "GPS";

std::string quoted(const Name& name) { return "'" + std::string(name.view()) + "'"; }

template <class Entries, class Text>
std::string list(const Entries& entries, Text text) {
  std::string all;
  for (const auto& entry : entries) all += (all.empty() ? "" : ", ") + std::string(text(entry).view());
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

}  // namespace

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
}

std::string Orders::unknown_source(const Name& name) const {
  return "no source is named " + quoted(name) + ": there are " + list(sources_, [](const Source& s) { return s.name; });
}

std::string Orders::refusal(const OperatorCommand& command) const {
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
  const std::string_view chain = name.view();
  if (chain == whole_chain || chain == "only-radars") return {};
  for (const std::string_view prefix : {"without-", "only-"}) {
    if (!chain.starts_with(prefix)) continue;
    const std::string_view part = chain.substr(prefix.size());
    const SourceId source = sources_.find(Name(part));
    if (part == receiver || (source != no_source && sources_[source].kind != SourceKind::Telemetry)) return {};
  }
  return quoted(name) + " is no chain: all, only-radars, and without- or only- a radar, a tracker or GPS";
}

void Orders::note(const OperatorCommand& command) {
  if (!refusal(command).empty()) return;
  const SourceId source = sources_.find(command.subject);
  const auto antenna = [&]() -> AntennaOrders& { return of_antenna_[*place_of(antennas_, command.subject)]; };
  switch (command.order) {
    case OperatorOrder::Release:
      return note_release(command);
    case OperatorOrder::Inhibit:
    case OperatorOrder::Force:
      return replace(of_source_[static_cast<std::size_t>(source)], command);
    case OperatorOrder::ResetBias:
      return replace(bias_reset_[static_cast<std::size_t>(source)], command);
    case OperatorOrder::AcknowledgeAlarm:
      return replace(acknowledged_[static_cast<std::size_t>(source)], command);
    case OperatorOrder::HoldChain:
      return replace(of_target_[*place_of(targets_, command.subject)], command);
    case OperatorOrder::PinAntennaSource:
      return replace(antenna().source, command);
    case OperatorOrder::PinAntennaTarget:
      return replace(antenna().target, command);
    case OperatorOrder::TrimAntenna:
      return replace(antenna().trim, command);
    case OperatorOrder::StopAntenna:
      return replace(antenna().stop, command);
  }
}

void Orders::note_release(const OperatorCommand& command) {
  // Sensors and antennas may share a name: then both are released.
  if (const SourceId source = sources_.find(command.subject); source != no_source)
    replace(of_source_[static_cast<std::size_t>(source)], command);
  if (const auto target = place_of(targets_, command.subject)) replace(of_target_[*target], command);
  if (const auto antenna = place_of(antennas_, command.subject)) {
    AntennaOrders& orders = of_antenna_[*antenna];
    for (StandingOrder* order : {&orders.source, &orders.target, &orders.trim, &orders.stop}) replace(*order, command);
  }
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
