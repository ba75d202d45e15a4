#include "dds/step_assembly.hpp"

#include <algorithm>
#include <iterator>

namespace downrange::dds {
namespace {

std::string counts_text(std::uint64_t expected, std::uint64_t received) {
  return ": expected " + std::to_string(expected) + ", received " + std::to_string(received);
}

}  // namespace

StepAssembly::StepAssembly(std::uint64_t run_id, bool sensors, const std::vector<Name>& ingest_nodes)
    : run_id_(run_id), sensors_(sensors) {
  for (const Name& node : ingest_nodes) ingest_nodes_[node];
}

void StepAssembly::announce(std::uint64_t step, AnnouncedStep announced) {
  if (step >= next_) steps_.insert_or_assign(step, std::move(announced));
}

void StepAssembly::add(const Event& event, std::uint64_t sequence, const Name& node) {
  if (const auto stream = stream_of(event)) {
    streams_[*stream].waiting.emplace(sequence, event);
  } else {
    const auto found = ingest_nodes_.find(node);
    if (found != ingest_nodes_.end()) found->second.observations.waiting.emplace(sequence, event);
  }
}

void StepAssembly::report(const Name& node, std::uint64_t step, std::uint64_t observations) {
  const auto found = ingest_nodes_.find(node);
  if (found != ingest_nodes_.end()) found->second.reports[step] = observations;
}

std::optional<std::uint64_t> StepAssembly::first_announced() const {
  if (steps_.empty()) return std::nullopt;
  return steps_.begin()->first;
}

std::uint64_t StepAssembly::Stream::received(std::uint64_t last) const {
  const auto end = waiting.upper_bound(last);
  return taken + static_cast<std::uint64_t>(std::distance(waiting.begin(), end));
}

void StepAssembly::Stream::move_to(std::uint64_t last, std::vector<Event>& events) {
  const auto end = waiting.upper_bound(last);
  for (auto it = waiting.begin(); it != end; ++it) events.push_back(it->second);
  waiting.erase(waiting.begin(), end);
  taken = last;
}

std::optional<std::string> StepAssembly::missing() const {
  const auto announced = steps_.find(next_);
  if (announced == steps_.end()) return std::nullopt;
  for (const auto& [source, expected] : announced->second.last_sequence) {
    if (!awaited(source.first)) continue;
    const auto stream = streams_.find(source);
    const std::uint64_t received = stream == streams_.end() ? 0 : stream->second.received(expected);
    if (received < expected) {
      return std::string("topic ") + input_info[source.first].topic + ", source " + std::string(source.second.view()) +
             counts_text(expected, received);
    }
  }
  for (const auto& [name, node] : ingest_nodes_) {
    const auto report = node.reports.find(next_);
    if (report == node.reports.end()) {
      return "ingest node " + std::string(name.view()) + " has not reported the step";
    }
    const std::uint64_t received = node.observations.received(report->second);
    if (received < report->second) {
      return std::string("topic ") + topic_of<Observation> + ", ingest node " + std::string(name.view()) +
             counts_text(report->second, received);
    }
  }
  return std::string();
}

RangeStep StepAssembly::take_next() {
  const auto announced = steps_.find(next_);
  RangeStep step{run_id_, next_, announced->second.time, announced->second.end, {}};
  for (const auto& [source, last] : announced->second.last_sequence) {
    if (awaited(source.first)) streams_[source].move_to(last, step.events);
  }
  for (auto& [name, node] : ingest_nodes_) {
    node.observations.move_to(node.reports.at(next_), step.events);
    node.reports.erase(node.reports.begin(), node.reports.upper_bound(next_));
  }
  for (Event& event : step.events) set_received(event, step.time);
  // Stable: samples of one source that the order holds equal stay as they were sent.
  std::stable_sort(step.events.begin(), step.events.end(), step_order_less);
  steps_.erase(announced);
  ++next_;
  return step;
}

}  // namespace downrange::dds
