#include "orders.hpp"

#include <algorithm>

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

}  // namespace

Orders::Orders(const RangeConfig& config)
    : sources_(config),
      simulated_(config.ingest.expect_simulated),
      max_future_(config.ingest.max_future),
      of_source_(sources_.size()),
      of_target_(config.targets.size()) {
  for (const TargetConfig& target : config.targets) targets_.push_back(target.id);
}

int Orders::target_of(const Name& name) const {
  const auto found = std::ranges::find(targets_, name);
  return found == targets_.end() ? -1 : static_cast<int>(found - targets_.begin());
}

std::string Orders::refusal(const OperatorCommand& command) const {
  if (command.simulated != simulated_)
    return simulated_ ? "this node flies a simulated flight and takes its orders only (ingest.expect_simulated = true)"
                      : "an order of a simulated flight, and this node flies a real one";
  if (command.operator_id.empty()) return "it does not say who orders";
  if (command.reason.empty()) return "it gives no reason";
  if (!plausible(command.epoch)) return "its time is none between 1970 and 2100";
  if (command.epoch > command.received + max_future_) return "it is dated in the future: one of the clocks is wrong";
  const bool source = sources_.find(command.subject) != no_source;
  const bool target = target_of(command.subject) >= 0;
  switch (command.order) {
    case OperatorOrder::Inhibit:
    case OperatorOrder::Force:
      return source ? ""
                    : "no source is named " + quoted(command.subject) + ": there are " +
                          list(sources_, [](const Source& s) { return s.name; });
    case OperatorOrder::Release:
      return source || target ? "" : "neither a source nor a target is named " + quoted(command.subject);
    case OperatorOrder::HoldChain:
      return refusal_of_hold(command);
    case OperatorOrder::ResetBias:
    case OperatorOrder::PinAntennaSource:
    case OperatorOrder::PinAntennaTarget:
    case OperatorOrder::TrimAntenna:
    case OperatorOrder::StopAntenna:
    case OperatorOrder::AcknowledgeAlarm:
      break;
  }
  return "this version does not carry out such an order";
}

std::string Orders::refusal_of_hold(const OperatorCommand& command) const {
  if (target_of(command.subject) < 0)
    return "no target is named " + quoted(command.subject) + ": there are " +
           list(targets_, [](const Name& name) { return name; });
  const std::string_view chain = command.argument.view();
  if (chain == whole_chain || chain == "only-radars") return {};
  for (const std::string_view prefix : {"without-", "only-"}) {
    if (!chain.starts_with(prefix)) continue;
    const std::string_view part = chain.substr(prefix.size());
    const SourceId source = sources_.find(Name(part));
    if (part == receiver || (source != no_source && sources_[source].kind != SourceKind::Telemetry)) return {};
  }
  return quoted(command.argument) + " is no chain: all, only-radars, and without- or only- a radar, a tracker or GPS";
}

void Orders::note(const OperatorCommand& command) {
  if (!refusal(command).empty()) return;
  const SourceId source = sources_.find(command.subject);
  const bool holds = command.order == OperatorOrder::HoldChain;
  StandingOrder& standing = !holds && source != no_source
                                ? of_source_[static_cast<std::size_t>(source)]
                                : of_target_[static_cast<std::size_t>(target_of(command.subject))];
  if (command.epoch < standing.since) return;
  standing = {.order = command.order,
              .argument = command.argument,
              .by = command.operator_id,
              .reason = command.reason,
              .since = command.epoch};
}

const StandingOrder* Orders::of(SourceId source) const {
  const StandingOrder& standing = of_source_[static_cast<std::size_t>(source)];
  return standing.order == OperatorOrder::Release ? nullptr : &standing;
}

const StandingOrder* Orders::hold_of(int target) const {
  const StandingOrder& standing = of_target_[static_cast<std::size_t>(target)];
  return standing.order == OperatorOrder::Release ? nullptr : &standing;
}

Name Orders::held_chain(int target) const {
  const StandingOrder* hold = hold_of(target);
  return hold == nullptr ? Name{} : hold->argument;
}

}  // namespace downrange
