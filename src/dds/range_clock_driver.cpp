#include <algorithm>
#include <condition_variable>
#include <map>
#include <optional>
#include <random>
#include <utility>

#include "dds/convert_field.hpp"
#include "dds/entities.hpp"
#include "dds/input_writers.hpp"
#include "dds/range_clock.hpp"
#include "dds/topics.hpp"

namespace downrange::dds {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t max_sources = 256;  ///< bound of RangeClock.counts

std::uint64_t new_run_id() {
  std::random_device random;
  return (std::uint64_t{random()} << 32U | random()) | 1U;  // never 0
}

std::string quoted(const Name& name) { return "'" + std::string(name.view()) + "'"; }

}  // namespace

class RangeClockDriver::Impl {
 public:
  Impl(Participant& participant, const DriverOptions& options)
      : options_(checked(participant, options)),
        run_id_(new_run_id()),
        nodes_(silent_nodes(options)),
        inputs_(participant),
        clock_(participant, topics::clock, write_tally_),
        acks_(participant, topics::clock_ack, read_tally_,
              [this](const wire::ClockAckV3& ack, const fdds::SampleInfo& info) { return receive(ack, info); }) {
    sample_.run_id(run_id_);
  }

  void wait_for_nodes(std::chrono::milliseconds timeout) {
    if (wait_until(timeout, [this] { return absent().empty(); })) return;
    throw LockstepError("not ready within " + std::to_string(timeout.count()) + " ms: " + absent());
  }

  void step(Time time, std::span<const Event> events) {
    if (steps() > 0 && time.ns <= sample_.time_ns()) throw LockstepError("time of a step must rise");
    await_window();
    for (const Event& event : events) write(event);
    sample_.time_ns(time.ns);
    write_clock();
  }

  void finish() {
    await_window();
    sample_.end(true);
    write_clock();
    await(steps());
  }

  [[nodiscard]] std::uint64_t run_id() const { return run_id_; }
  [[nodiscard]] std::uint64_t steps() const { return sample_.step(); }

  [[nodiscard]] std::uint64_t acknowledged() const {
    const std::scoped_lock lock(mutex_);
    return acknowledged_locked();
  }

 private:
  struct Node {
    bool heard = false;
    GuidPrefix_t participant;  ///< from which it was heard
    unsigned topics = 0;       ///< bits as ClockAck says; 0: not ready
    std::uint64_t step = 0;    ///< of this run, acknowledged
    std::string failure;       ///< in this run
  };

  static const DriverOptions& checked(const Participant& participant, const DriverOptions& options) {
    if (participant.clock() != ClockMode::Range) throw LockstepError("a driver needs the range clock");
    if (options.nodes.empty() || options.window < 1) throw LockstepError("a driver needs nodes and a window");
    return options;
  }
  static std::map<Name, Node> silent_nodes(const DriverOptions& options) {
    std::map<Name, Node> nodes;
    for (const Name& name : options.nodes) nodes[name];
    return nodes;
  }

  Defect receive(const wire::ClockAckV3& ack, const fdds::SampleInfo& info) {
    const std::optional<Name> name = Name::parse(ack.node_id().c_str());
    const std::scoped_lock lock(mutex_);
    const auto found = name ? nodes_.find(*name) : nodes_.end();
    if (found == nodes_.end()) return {};  // a node that is not waited for
    Node& node = found->second;
    node.heard = true;
    node.participant = eprosima::fastrtps::rtps::iHandle2GUID(info.publication_handle).guidPrefix;
    node.topics = ack.topics();
    if (ack.run_id() == run_id_) {
      node.step = ack.step();
      node.failure = ack.failure().to_string();
    }
    changed_.notify_all();
    return {};
  }

  [[nodiscard]] bool ready_locked(const Node& node) const {
    const auto met = [&](InputTopic topic) {
      return (node.topics & bit_of(topic)) == 0 || inputs_.readers(topic).has(node.participant);
    };
    bool all_met = node.heard && node.topics != 0 && clock_.readers().has(node.participant);
    for (InputTopic topic = 0; topic < Inputs::size; ++topic) all_met = all_met && met(topic);
    return all_met;
  }

  /// The nodes that are not ready, as text.
  [[nodiscard]] std::string absent() const {
    const std::scoped_lock lock(mutex_);
    std::string text;
    for (const auto& [name, node] : nodes_) {
      if (!ready_locked(node)) text += (text.empty() ? "node " : ", node ") + quoted(name);
    }
    return text;
  }

  [[nodiscard]] std::uint64_t acknowledged_locked() const {
    std::uint64_t least = UINT64_MAX;
    for (const auto& [name, node] : nodes_) least = std::min(least, node.step);
    return least;
  }

  void throw_failure_locked() const {
    for (const auto& [name, node] : nodes_) {
      if (!node.failure.empty()) throw LockstepError("node " + quoted(name) + ": " + node.failure);
    }
  }

  void await_window() {
    const auto window = static_cast<std::uint64_t>(options_.window);
    if (steps() >= window) await(steps() + 1 - window);
  }

  /// Until every node has acknowledged `step`.
  void await(std::uint64_t step) {
    std::unique_lock lock(mutex_);
    std::uint64_t seen = acknowledged_locked();
    auto end = Clock::now() + options_.timeout;
    while (true) {
      throw_failure_locked();
      const std::uint64_t acknowledged = acknowledged_locked();
      if (acknowledged >= step) return;
      if (std::exchange(seen, acknowledged) < acknowledged) end = Clock::now() + options_.timeout;
      if (Clock::now() >= end) throw silence_locked();
      changed_.wait_until(lock, end);
    }
  }

  [[nodiscard]] LockstepError silence_locked() const {
    const auto slowest = std::min_element(nodes_.begin(), nodes_.end(),
                                          [](const auto& a, const auto& b) { return a.second.step < b.second.step; });
    return LockstepError("node " + quoted(slowest->first) + " has acknowledged step " +
                         std::to_string(slowest->second.step) + " of " + std::to_string(steps()) +
                         " and nothing more for " + std::to_string(options_.timeout.count()) + " ms");
  }

  void write(const Event& event) {
    const auto stream = stream_of(event);
    if (!stream) throw LockstepError("an observation cannot be driven: it is made by an ingest node");
    const auto [found, added] = streams_.try_emplace(*stream, sample_.counts().size());
    if (added) {
      if (sample_.counts().size() == max_sources) throw LockstepError("more than 256 sources in one run");
      sample_.counts().emplace_back();
      sample_.counts().back().topic(same_number<wire::InputTopic>(stream->first));
      sample_.counts().back().source_id() = stream->second.c_str();
    }
    wire::SourceCountV2& count = sample_.counts()[found->second];
    count.last_sequence_number(count.last_sequence_number() + 1);
    if (!inputs_.write(event, {run_id(), count.last_sequence_number()})) {
      throw LockstepError(inputs_.tally.get().last_failure);
    }
  }

  void write_clock() {
    sample_.step(sample_.step() + 1);
    if (!clock_.write(sample_)) throw LockstepError(write_tally_.get().last_failure);
  }

  const DriverOptions options_;
  const std::uint64_t run_id_;
  wire::RangeClockV2 sample_;  ///< newest step written; its counts are the samples written so far
  std::map<std::pair<InputTopic, Name>, std::size_t> streams_;  ///< place in sample_.counts()

  mutable std::mutex mutex_;  ///< of nodes_
  std::condition_variable changed_;
  std::map<Name, Node> nodes_;

  Tally<WriteCounts> write_tally_;
  Tally<ReadCounts> read_tally_;
  InputWriters::Impl inputs_;
  TopicWriter<wire::RangeClockV2PubSubType> clock_;
  TopicReader<wire::ClockAckV3PubSubType> acks_;
};

RangeClockDriver::RangeClockDriver(Participant& participant, const DriverOptions& options)
    : impl_(std::make_unique<Impl>(participant, options)) {}
RangeClockDriver::~RangeClockDriver() = default;

void RangeClockDriver::wait_for_nodes(std::chrono::milliseconds timeout) { impl_->wait_for_nodes(timeout); }
void RangeClockDriver::step(Time time, std::span<const Event> events) { impl_->step(time, events); }
void RangeClockDriver::finish() { impl_->finish(); }
std::uint64_t RangeClockDriver::run_id() const { return impl_->run_id(); }
std::uint64_t RangeClockDriver::steps() const { return impl_->steps(); }
std::uint64_t RangeClockDriver::acknowledged() const { return impl_->acknowledged(); }

}  // namespace downrange::dds
