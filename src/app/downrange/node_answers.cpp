#include "node_answers.hpp"

#include <algorithm>
#include <text/printable.hpp>

namespace downrange::app {

void NodeAnswers::add(const dds::ServiceStatus& status) {
  {
    const std::scoped_lock lock(mutex_);
    Node& node = nodes_[status.node];
    node.concerned = !slaves_ || status.stages.slave;
    for (const dds::Acknowledgement& a : status.acknowledgements) {
      if (a.topic == topic_ && a.sender == sender_ && a.sequence == sequence_) node.answer = a;
    }
    if (status.state == "stopped") nodes_.erase(status.node);
  }
  heard_.notify_all();
}

bool NodeAnswers::all_answered_locked() const {
  return !nodes_.empty() &&
         std::ranges::all_of(nodes_, [](const auto& node) { return node.second.answer.has_value(); });
}

bool NodeAnswers::wait_for_nodes(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  return heard_.wait_for(lock, timeout, [this] { return !nodes_.empty(); });
}

bool NodeAnswers::wait_for_all(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  return heard_.wait_for(lock, timeout, [this] { return all_answered_locked(); });
}

bool NodeAnswers::all_in_force() const {
  const std::scoped_lock lock(mutex_);
  const auto concerned = [](const auto& node) { return node.second.concerned; };
  return all_answered_locked() && std::ranges::any_of(nodes_, concerned) &&
         std::ranges::all_of(nodes_,
                             [&](const auto& node) { return !concerned(node) || node.second.answer->refusal.empty(); });
}

std::string NodeAnswers::text() const {
  const std::scoped_lock lock(mutex_);
  std::string text;
  for (const auto& [name, node] : nodes_) {
    const auto& answer = node.answer;
    text += "node " + std::string(name.view()) + ": ";
    if (!node.concerned) {
      text += "points no antennas\n";
    } else if (!answer) {
      text += "NO ANSWER\n";
    } else {
      text += answer->refusal.empty() ? "in force\n" : "REFUSED: " + std::string(answer->refusal.view()) + '\n';
    }
  }
  return text::printable(text, true);
}

}  // namespace downrange::app
