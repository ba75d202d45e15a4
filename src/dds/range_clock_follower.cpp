#include <algorithm>
#include <condition_variable>
#include <deque>
#include <map>
#include <optional>
#include <utility>

#include "dds/convert.hpp"
#include "dds/entities.hpp"
#include "dds/output_writers.hpp"
#include "dds/range_clock.hpp"
#include "dds/step_assembly.hpp"
#include "dds/topics.hpp"

namespace downrange::dds {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr std::size_t max_runs = 4;      ///< whose samples are kept while none of their steps is known
constexpr std::size_t max_retired = 16;  ///< runs remembered as not to be followed (any more)
constexpr auto greeting_period = std::chrono::milliseconds(20);

std::string step_text(std::uint64_t run_id, std::uint64_t step) {
  return "step " + std::to_string(step) + " of run " + std::to_string(run_id);
}

}  // namespace

class RangeClockFollower::Impl {
 public:
  Impl(Participant& participant, const FollowerOptions& options, OutputWriters* outputs)
      : options_(options),
        outputs_(outputs),
        node_(participant.node()),
        ack_(participant, topics::clock_ack, write_tally_),
        clock_(participant, topics::clock, tally_,
               [this](const wire::RangeClockV2& sample, const auto&) { return receive(sample); }),
        inputs_(
            participant, {options.sensors, true, options.ingest_nodes},
            [this](const Event& event, const RangeStamp& stamp, const Name& node) { receive(event, stamp, node); }) {
    if (participant.clock() != ClockMode::Range) throw LockstepError("a follower needs the range clock");
    if (!options.ingest_nodes.empty()) {
      progress_.emplace(
          participant, topics::ingest_progress, tally_,
          [this](const wire::IngestProgressV2& sample, const fdds::SampleInfo& info) { return receive(sample, info); });
    }
  }

  std::optional<RangeStep> next(std::chrono::milliseconds wait) {
    const auto end = SteadyClock::now() + wait;
    while (true) {
      greet();
      std::unique_lock lock(mutex_);
      choose_run_locked();
      if (std::optional<RangeStep> step = complete_step_locked()) {
        lock.unlock();
        if (outputs_ != nullptr) outputs_->impl().begin_step(*step);
        return step;
      }
      if (const std::string failure = failure_locked(); !failure.empty()) {
        const RangeStep failed{current_, runs_.at(current_).next_step() - 1, {}, false, {}};
        retire_locked(current_);
        lock.unlock();
        write_ack(failed, failure);
        throw LockstepError(failure);
      }
      const auto now = SteadyClock::now();
      if (now >= end) return std::nullopt;
      changed_.wait_until(lock, std::min(end, now + greeting_period));
    }
  }

  void acknowledge(const RangeStep& step) {
    if (outputs_ != nullptr) outputs_->impl().end_step();
    write_ack(step, {});
    if (!step.end) return;
    const std::scoped_lock lock(mutex_);
    if (runs_.contains(step.run_id)) retire_locked(step.run_id);
  }

  std::optional<std::string> notice() {
    const std::scoped_lock lock(mutex_);
    if (notices_.empty()) return std::nullopt;
    std::string notice = std::move(notices_.front());
    notices_.pop_front();
    return notice;
  }

  [[nodiscard]] ReadCounts counts() const {
    ReadCounts counts = tally_.get();
    const ReadCounts inputs = inputs_.counts();
    counts.samples += inputs.samples;
    counts.malformed += inputs.malformed;
    counts.lost += inputs.lost;
    counts.incompatible += inputs.incompatible;
    if (!inputs.last_malformed.empty()) counts.last_malformed = inputs.last_malformed;
    return counts;
  }

 private:
  // On the middleware's threads.

  Defect receive(const wire::RangeClockV2& sample) {
    AnnouncedStep announced{{sample.time_ns()}, sample.end(), {}};
    for (const wire::SourceCountV2& count : sample.counts()) {
      const std::optional<Name> source = Name::parse(count.source_id().c_str());
      const auto topic = static_cast<InputTopic>(count.topic());
      if (topic >= Inputs::size || !source) return "names an unknown source";
      announced.last_sequence[{topic, *source}] = count.last_sequence_number();
    }
    if (sample.run_id() == 0 || sample.step() == 0) return "has no run or step";
    const std::scoped_lock lock(mutex_);
    if (StepAssembly* run = run_locked(sample.run_id())) run->announce(sample.step(), std::move(announced));
    changed_.notify_all();
    return {};
  }

  void receive(const Event& event, const RangeStamp& stamp, const Name& node) {
    const std::scoped_lock lock(mutex_);
    if (StepAssembly* run = run_locked(stamp.run_id)) run->add(event, stamp.sequence, node);
    changed_.notify_all();
  }

  Defect receive(const wire::IngestProgressV2& sample, const fdds::SampleInfo& info) {
    const std::optional<Name> node = Name::parse(sample.node_id().c_str());
    if (!node) return "names no node";
    const std::scoped_lock lock(mutex_);
    if (sample.run_id() == 0) {
      greeted_by_[*node] = eprosima::fastrtps::rtps::iHandle2GUID(info.publication_handle).guidPrefix;
    } else if (StepAssembly* run = run_locked(sample.run_id())) {
      run->report(*node, sample.step(), sample.observations());
    }
    changed_.notify_all();
    return {};
  }

  // On the caller's thread.

  /// The run's assembly; null for a run that is not followed any more.
  StepAssembly* run_locked(std::uint64_t run_id) {
    const auto found = runs_.find(run_id);
    if (found != runs_.end()) return &found->second;
    if (std::find(retired_.begin(), retired_.end(), run_id) != retired_.end()) return nullptr;
    if (runs_.size() >= max_runs) {
      const auto stale = std::find_if(runs_.begin(), runs_.end(), [this](const auto& run) {
        return run.first != current_ && !run.second.first_announced();
      });
      if (stale == runs_.end()) return nullptr;
      retire_locked(stale->first);
    }
    return &runs_.try_emplace(run_id, run_id, options_.sensors, options_.ingest_nodes).first->second;
  }

  void retire_locked(std::uint64_t run_id) {
    runs_.erase(run_id);
    retired_.push_back(run_id);
    if (retired_.size() > max_retired) retired_.pop_front();
    if (run_id == current_) current_ = 0;
    announced_at_.reset();
  }

  /// Takes up a run that begins; leaves alone one that was under way before this node listened.
  void choose_run_locked() {
    for (auto it = runs_.begin(); it != runs_.end();) {
      const auto& [run_id, assembly] = *it++;
      const std::optional<std::uint64_t> first = assembly.first_announced();
      if (run_id == current_ || !first) continue;
      if (*first != 1) {
        notices_.push_back("run " + std::to_string(run_id) +
                           " is under way already (first step seen: " + std::to_string(*first) + "): not joined");
        retire_locked(run_id);
        continue;
      }
      const std::uint64_t begun = run_id;
      if (current_ != 0) {
        notices_.push_back("run " + std::to_string(current_) + " was broken off at step " +
                           std::to_string(runs_.at(current_).next_step() - 1) + ": a new run begins");
        retire_locked(current_);
      }
      current_ = begun;
      return;
    }
  }

  std::optional<RangeStep> complete_step_locked() {
    if (current_ == 0) return std::nullopt;
    StepAssembly& run = runs_.at(current_);
    const std::optional<std::string> missing = run.missing();
    if (!missing || !missing->empty()) return std::nullopt;
    announced_at_.reset();
    return run.take_next();
  }

  /// Why the current run cannot go on; empty: it may.
  std::string failure_locked() {
    if (current_ == 0) return {};
    const StepAssembly& run = runs_.at(current_);
    if (!run.first_announced()) return {};
    const auto now = SteadyClock::now();
    if (!announced_at_) announced_at_ = now;
    if (now < *announced_at_ + options_.timeout) return {};
    return step_text(current_, run.next_step()) + " is not complete after " + std::to_string(options_.timeout.count()) +
           " ms: " + run.missing().value_or("topic range/clock, the step itself is lost");
  }

  /// Whether every ingest node's writers have met this node's readers.
  [[nodiscard]] bool ingest_nodes_met() const {
    const std::scoped_lock lock(mutex_);
    return std::all_of(options_.ingest_nodes.begin(), options_.ingest_nodes.end(), [this](const Name& node) {
      const auto found = greeted_by_.find(node);
      return found != greeted_by_.end() && progress_->writers().has(found->second);
    });
  }

  /// Between runs, tells the centre's nodes and the driver whether this node is ready.
  void greet() {
    {
      const std::scoped_lock lock(mutex_);
      if (current_ != 0) return;
    }
    if (outputs_ != nullptr) outputs_->impl().greet_centres();
    const bool ready = ingest_nodes_met();
    if (std::exchange(told_ready_, ready) != ready) write_ack({}, {});
  }

  void write_ack(const RangeStep& step, const std::string& failure) {
    unsigned read = 0;
    for (InputTopic topic = 0; topic < Inputs::size; ++topic) {
      if (options_.sensors || !input_info[topic].measurement) read |= bit_of(topic);
    }
    wire::ClockAckV3 ack;
    ack.node_id() = node_.c_str();
    ack.run_id(step.run_id);
    ack.step(step.step);
    if (told_ready_) ack.topics(read);
    ack.failure() = failure;
    // A refused acknowledgement shows at the driver as a silent node.
    static_cast<void>(ack_.write(ack));
  }

  const FollowerOptions options_;
  OutputWriters* const outputs_;
  const Name node_;
  bool told_ready_ = false;  ///< what the driver was told last; the caller's thread only

  mutable std::mutex mutex_;  ///< of all down to the tallies
  std::condition_variable changed_;
  std::map<std::uint64_t, StepAssembly> runs_;
  std::deque<std::uint64_t> retired_;
  std::uint64_t current_ = 0;                            ///< run followed; 0: none
  std::optional<SteadyClock::time_point> announced_at_;  ///< since when the next step is awaited
  std::map<Name, GuidPrefix_t> greeted_by_;              ///< ingest node -> its participant
  std::deque<std::string> notices_;

  Tally<WriteCounts> write_tally_;
  Tally<ReadCounts> tally_;
  TopicWriter<wire::ClockAckV3PubSubType> ack_;
  std::optional<TopicReader<wire::IngestProgressV2PubSubType>> progress_;
  TopicReader<wire::RangeClockV2PubSubType> clock_;
  InputReader inputs_;
};

RangeClockFollower::RangeClockFollower(Participant& participant, const FollowerOptions& options, OutputWriters* outputs)
    : impl_(std::make_unique<Impl>(participant, options, outputs)) {}
RangeClockFollower::~RangeClockFollower() = default;

std::optional<RangeStep> RangeClockFollower::next(std::chrono::milliseconds wait) { return impl_->next(wait); }
void RangeClockFollower::acknowledge(const RangeStep& step) { impl_->acknowledge(step); }
std::optional<std::string> RangeClockFollower::notice() { return impl_->notice(); }
ReadCounts RangeClockFollower::counts() const { return impl_->counts(); }

}  // namespace downrange::dds
