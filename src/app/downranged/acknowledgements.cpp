#include "acknowledgements.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <downrange/stage/catalogue.hpp>
#include <numbers>
#include <string_view>

namespace downrange::app {
namespace {

/// As many as ServiceStatusV4 holds.
constexpr std::size_t newest_kept = 8;
/// Far more than a flight has, of marks and of messages that are told from those told once more.
constexpr std::size_t most_kept = 256;
constexpr double deg = std::numbers::pi / 180;

std::string order_text(const OperatorCommand& command) {
  static constexpr std::array<std::string_view, 10> words{
      "inhibit",           "release", "force", "reset the bias of",       "hold", "pin the source of",
      "pin the target of", "trim",    "stop",  "acknowledge the alarm of"};
  std::string text = fmt::format("{} {}", words.at(static_cast<std::size_t>(command.order)), command.subject.view());
  if (command.order == OperatorOrder::TrimAntenna)
    text += fmt::format(" by {:.3f} deg in azimuth, {:.3f} in elevation", command.azimuth_trim_rad / deg,
                        command.elevation_trim_rad / deg);
  if (!command.argument.empty()) text += fmt::format(" on {}", command.argument.view());
  return text;
}

std::string mark_text(const MissionEvent& event) {
  static constexpr std::array<std::string_view, 6> words{"planned lift-off", "lift-off", "staging", "mark", "hold",
                                                         "recycle"};
  std::string text(words.at(static_cast<std::size_t>(event.kind)));
  if (!event.label.empty()) text += fmt::format(" '{}'", event.label.view());
  return text;
}

/// Whether `later` takes the place of `earlier`.
bool replaces(const OperatorCommand& later, const OperatorCommand& earlier) {
  if (later.subject != earlier.subject) return false;
  const auto of_source = [](OperatorOrder o) { return o == OperatorOrder::Inhibit || o == OperatorOrder::Force; };
  return later.order == OperatorOrder::Release || later.order == earlier.order ||
         (of_source(later.order) && of_source(earlier.order));
}

}  // namespace

std::optional<std::string> Acknowledgements::note(const Event& event) {
  if (told_before(event)) return std::nullopt;
  if (const auto* command = std::get_if<OperatorCommand>(&event)) {
    const std::string refusal = orders_.refusal(*command);
    orders_.note(*command);
    acknowledge(input_index<OperatorCommand>, command->operator_id, command->sequence, refusal);
    // An engine that begins anew has learnt no bias that could be forgotten.
    if (refusal.empty() && command->order != OperatorOrder::ResetBias) keep(event);
    return fmt::format("operator {}: {}{} ({})", command->operator_id.view(), order_text(*command),
                       refusal.empty() ? "" : " REFUSED: " + refusal, command->reason.view());
  }
  if (const auto* mark = std::get_if<MissionEvent>(&event)) {
    const std::string refusal = mission_.refusal(*mark);
    mission_.note(*mark);
    acknowledge(input_index<MissionEvent>, mark->mission, mark->sequence, refusal);
    if (refusal.empty()) keep(event);
    return fmt::format("mission {}: {}{}", mark->mission.view(), mark_text(*mark),
                       refusal.empty() ? "" : " REFUSED: " + refusal);
  }
  return std::nullopt;
}

void Acknowledgements::acknowledge(std::size_t topic, const Name& sender, std::uint64_t sequence,
                                   const std::string& refusal) {
  newest_.insert(newest_.begin(), dds::Acknowledgement{topic, sender, sequence, Remark(refusal)});
  if (newest_.size() > newest_kept) newest_.pop_back();
}

bool Acknowledgements::told_before(const Event& event) {
  const auto* command = std::get_if<OperatorCommand>(&event);
  if (command == nullptr) return false;
  const std::pair told(command->operator_id, command->sequence);
  if (std::ranges::find(told_, told) != told_.end()) return true;
  if (told_.size() == most_kept) told_.erase(told_.begin());
  told_.push_back(told);
  return false;
}

void Acknowledgements::keep(const Event& event) {
  if (const auto* command = std::get_if<OperatorCommand>(&event)) {
    std::erase_if(taken_, [&](const Event& earlier) {
      const auto* other = std::get_if<OperatorCommand>(&earlier);
      return other != nullptr && replaces(*command, *other);
    });
  } else {
    const auto is_mark = [](const Event& e) { return std::holds_alternative<MissionEvent>(e); };
    if (static_cast<std::size_t>(std::ranges::count_if(taken_, is_mark)) >= most_kept)
      taken_.erase(std::ranges::find_if(taken_, is_mark));
  }
  taken_.push_back(event);
}

std::vector<Event> Acknowledgements::in_force(Time now) const {
  std::vector<Event> events = taken_;
  for (Event& event : events) {
    set_received(event, now);
    if (auto* command = std::get_if<OperatorCommand>(&event)) command->epoch = std::min(command->epoch, now);
  }
  return events;
}

}  // namespace downrange::app
