#include "service.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <downrange/stage/catalogue.hpp>
#include <downrange/stage/source_table.hpp>
#include <exception>

#include "stage/impact.hpp"

namespace downrange::app {
namespace {

using namespace std::chrono_literals;

constexpr auto status_interval = 1s;
/// How long the range clock may be silent before this node looks at its own affairs.
constexpr auto step_wait = 10ms;
/// An engine that is further behind its wall clock (a step of UTC, a stopped process) does not run every tick to catch
/// up.
constexpr Duration longest_catch_up = milliseconds(500);
/// For inputs that still wait when the service is told to stop.
constexpr auto last_inputs = 300ms;

dds::ParticipantOptions participant_options(const config::ServiceConfig& config) {
  const bool range_clock = config.clock.mode == config::ClockMode::Range;
  return {config.dds.domain, config.dds.profiles, config.node.id,
          range_clock ? dds::ClockMode::Range : dds::ClockMode::Wall};
}

/// Of an owned result, the keys that are to be expected: each has a writer of its own. Every owned result has one of
/// these.
template <class Record>
std::vector<OwnedKey> expected_keys(const RangeConfig& range) = delete;

template <>
std::vector<OwnedKey> expected_keys<SlavingCommand>(const RangeConfig& range) {
  std::vector<OwnedKey> keys;
  for (const AntennaConfig& antenna : range.antennas) keys.emplace_back(antenna.id, Name{});
  return keys;
}

template <>
std::vector<OwnedKey> expected_keys<AntennaAccount>(const RangeConfig& range) {
  return expected_keys<SlavingCommand>(range);
}

template <>
std::vector<OwnedKey> expected_keys<Integrity>(const RangeConfig& range) {
  std::vector<OwnedKey> keys;
  for (const TargetConfig& target : range.targets) keys.emplace_back(target.id, Name{});
  return keys;
}

template <>
std::vector<OwnedKey> expected_keys<ImpactPoint>(const RangeConfig& range) {
  std::vector<OwnedKey> keys;
  for (const Name& chain : impact_chains(range))
    for (const TargetConfig& target : range.targets) keys.emplace_back(target.id, chain);
  return keys;
}

template <>
std::vector<OwnedKey> expected_keys<Trajectory>(const RangeConfig& range) {
  std::vector<OwnedKey> keys;
  for (const Name& method : range.fuse.methods)
    for (const TargetConfig& target : range.targets) keys.emplace_back(target.id, method);
  return keys;
}

template <>
std::vector<OwnedKey> expected_keys<SensorBias>(const RangeConfig& range) {
  std::vector<OwnedKey> keys;
  for (const Name& method : range.fuse.methods)
    for (const Source& source : SourceTable(range))
      if (source.kind != SourceKind::Telemetry) keys.emplace_back(source.name, method);
  return keys;
}

dds::OutputOptions output_options(const config::ServiceConfig& config) {
  dds::OutputOptions options;
  options.strength = config.node.strength;
  options.observations = config.node.stages.ingest;
  options.results = config.node.stages.fuse;
  Outputs::for_each([&]<class Record>() {
    if constexpr (MessageInfo<Record>::delivery == Delivery::Owned)
      options.owned_keys<Record>() = expected_keys<Record>(config.range);
  });
  return options;
}

/// Nodes whose observations come in place of the sensors' own samples.
std::vector<Name> ingest_nodes(const config::ServiceConfig& config) {
  return config.node.stages.ingest ? std::vector<Name>{} : config.dds.ingest_nodes;
}

/// Sources, and antennas, which tell where they point and stand.
std::vector<Name> sender_names(const RangeConfig& range) {
  std::vector<Name> names;
  for (const Source& source : SourceTable(range)) names.push_back(source.name);
  for (const AntennaConfig& antenna : range.antennas) {
    if (std::ranges::find(names, antenna.id) == names.end()) names.push_back(antenna.id);
  }
  return names;
}

const config::ServiceConfig& checked(const config::ServiceConfig& config) {
  if (config.archive.enabled) require_archive_folder(config.archive);
  return config;
}

}  // namespace

Service::MiddlewareLog::MiddlewareLog() {
  dds::set_log_sink([](const dds::LogLine& line) {
    spdlog::log(line.error ? spdlog::level::err : spdlog::level::warn, "dds: {}: {}", line.category, line.text);
  });
}
Service::MiddlewareLog::~MiddlewareLog() { dds::set_log_sink({}); }

Service::Service(const config::ServiceConfig& config, std::function<void()> on_failure, std::function<Time()> utc)
    : config_(checked(config)),
      on_failure_(std::move(on_failure)),
      utc_(std::move(utc)),
      participant_(participant_options(config_)),
      outputs_(participant_, output_options(config_)),
      queue_(sender_names(config_.range), config_.node.queue) {
  for (const std::string& note : participant_.notes()) spdlog::warn("dds: {}", note);
  const bool sensors = config_.node.stages.ingest;
  if (config_.clock.mode == config::ClockMode::Wall) {
    flight_ = std::make_unique<Flight>(config_, outputs_, open_recorder(), utc_);
    state_ = "running";
    const auto enqueue = [this](const Event& event, const dds::RangeStamp&, const Name&) {
      if (takes(event)) queue_.push(event);
    };
    input_ = std::make_unique<dds::InputReader>(participant_, dds::InputSelection{sensors, true, ingest_nodes(config_)},
                                                enqueue);
  } else {
    state_ = "waiting for the range clock";
    const auto timeout = std::chrono::milliseconds(config_.clock.step_timeout.ns / 1'000'000);
    follower_ = std::make_unique<dds::RangeClockFollower>(
        participant_, dds::FollowerOptions{sensors, ingest_nodes(config_), timeout}, &outputs_);
  }
  thread_ = std::thread([this] { run(); });
}

Service::~Service() { stop(); }

void Service::stop() {
  stop_ = true;
  queue_.close();
  if (thread_.joinable()) thread_.join();
}

void Service::run() {
  try {
    if (input_) {
      follow_wall_clock();
    } else {
      follow_range_clock();
    }
    end_flight();
    state_ = "stopped";
    publish_status();
  } catch (const std::exception& error) {
    failure_ = error.what();
    on_failure_();
  }
}

// A timer only hands in ticks: what has arrived by `now` goes before the ticks up to `now`.
void Service::follow_wall_clock() {
  while (!stop_) {
    const Time now = utc_();
    if (const auto step = utc_watch_.look(now, Clock::now())) take_step(*step);
    consume_arrived();
    leave_out_ticks(now);
    flight_->advance(now);
    beat();
    const Time next_tick = ceil_to_grid(now + Duration{1}, config_.range.tick);
    // At most a tick: UTC may have been stepped back in between.
    queue_.wait(std::chrono::nanoseconds(std::min(next_tick - utc_(), config_.range.tick).ns));
  }
  consume_the_rest();
}

void Service::take_step(Duration step) {
  const double s = static_cast<double>(step.ns) * 1e-9;
  if (step > Duration{0}) {
    spdlog::warn("UTC stepped forward {:.1f} s", s);
    return;
  }
  spdlog::error("UTC stepped back {:.1f} s: flight restarted", -s);
  state_ = fmt::format("UTC back {:.1f} s: restarted", -s);  // the status has room for 31 characters
  begin_flight_anew();
}

void Service::leave_out_ticks(Time now) {
  const Time last = flight_->last_tick();
  if (!plausible(last) || now - last <= std::max(longest_catch_up, config_.range.tick + config_.range.tick)) return;
  spdlog::warn("engine {:.1f} s behind its clock: the ticks of that time are left out", (now - last).seconds());
  flight_->consume(ClockGap{.epoch = now, .received = last});
}

void Service::consume_arrived() {
  // As many as there were at first: a flood must not hold up the ticks.
  for (std::size_t waiting = queue_.depth(); waiting > 0 && !stop_; --waiting) {
    consume_oldest();
    beat();
  }
}

void Service::consume_the_rest() {
  const auto end = Clock::now() + last_inputs;
  while (queue_.depth() > 0 && Clock::now() < end) consume_oldest();
  if (queue_.depth() > 0) spdlog::warn("stopped before {} inputs that had arrived were used", queue_.depth());
}

void Service::consume_oldest() {
  std::optional<Event> event = queue_.pop();
  if (!event) return;
  // Stamped before UTC was stepped back, it would take the new engine to a time yet to come.
  set_received(*event, std::min(received_of(*event), utc_()));
  leave_out_ticks(received_of(*event));
  flight_->consume(*event);
  if (is_mark(*event)) next_status_ = Clock::now();  // who gave it waits for the answer
  latency_.add(utc_() - received_of(*event));
}

void Service::follow_range_clock() {
  while (!stop_) {
    const std::optional<dds::RangeStep> step = next_step();
    if (step) consume(*step);
    beat();
  }
}

std::optional<dds::RangeStep> Service::next_step() {
  try {
    std::optional<dds::RangeStep> step = follower_->next(step_wait);
    while (const std::optional<std::string> notice = follower_->notice()) spdlog::warn("range clock: {}", *notice);
    return step;
  } catch (const dds::LockstepError& error) {
    spdlog::error("range clock: flight stopped: {}", error.what());
    end_flight();
    state_ = "flight stopped: lockstep lost";
    return std::nullopt;
  }
}

void Service::consume(const dds::RangeStep& step) {
  const auto start = Clock::now();
  if (step.step == 1) {
    begin_flight();
    state_ = "running";
    spdlog::info("range clock: run {} begins", step.run_id);
  }
  if (!flight_) return;
  for (const Event& event : step.events) {
    if (takes(event)) flight_->consume(event);
  }
  flight_->advance(step.time);
  if (!step.events.empty()) latency_.add({std::chrono::nanoseconds(Clock::now() - start).count()});
  if (step.end) {
    spdlog::info("range clock: run {} ends after step {}", step.run_id, step.step);
    end_flight();
    state_ = "waiting for the range clock";
  }
  // Last: an acknowledged end means that the archive is closed.
  follower_->acknowledge(step);
}

void Service::begin_flight() {
  end_flight();
  std::unique_ptr<Recorder> recorder;
  archive_failure_.clear();
  try {
    recorder = open_recorder();
  } catch (const archive::ArchiveError& error) {
    archive_failure_ = error.what();
    spdlog::error("archive cannot be opened, tracking goes on without it: {}", archive_failure_);
  }
  flight_ = std::make_unique<Flight>(config_, outputs_, std::move(recorder), input_ ? utc_ : std::function<Time()>{});
}

void Service::begin_flight_anew() {
  const std::vector<Event> in_force = flight_->acknowledgements().in_force(utc_());
  begin_flight();
  for (const Event& event : in_force) flight_->consume(event);
}

std::unique_ptr<Recorder> Service::open_recorder() const {
  return config_.archive.enabled ? std::make_unique<Recorder>(config_, utc_()) : nullptr;
}

std::string Service::archive_state() {
  if (!config_.archive.enabled) return "off";
  if (!flight_) return "waiting";
  return flight_->recorder() != nullptr ? flight_->recorder()->state() : "failed: " + archive_failure_;
}

void Service::end_flight() {
  if (!flight_) return;
  consumed_before_ += flight_->consumed();
  emitted_before_ += flight_->emitted();
  expired_before_ += flight_->expired();
  flight_.reset();
}

bool Service::takes(const Event& event) const {
  const std::vector<Name>& sources = config_.node.sources;
  if (sources.empty() || !is_measured(event)) return true;
  return std::ranges::find(sources, source_of(event)) != sources.end();
}

void Service::beat() {
  ++progress_;
  const auto now = Clock::now();
  if (now >= next_status_) {
    publish_status();
    next_status_ = now + status_interval;
  }
}

void Service::publish_status() {
  const dds::ReadCounts read = read_counts();
  const dds::WriteCounts written = outputs_.counts();
  const EventQueue::Losses queue = queue_.losses();

  dds::ServiceStatus status;
  status.node = config_.node.id;
  status.stages = config_.node.stages;
  status.version = DOWNRANGE_VERSION;
  status.configuration_hash = config_.hash;
  status.clock = participant_.clock();
  status.time = utc_();
  status.queue_depth = static_cast<std::uint32_t>(queue_.depth());
  status.consumed = consumed_before_;
  status.emitted = emitted_before_;
  status.archive_state = archive_state();
  if (flight_) {
    status.last_tick = flight_->last_tick();
    status.consumed += flight_->consumed();
    status.emitted += flight_->emitted();
  }
  const auto now = Clock::now();
  if (const double since_s = std::chrono::duration<double>(now - reported_.at).count();
      reported_.at != Clock::time_point{} && since_s > 0) {
    status.consumed_per_s = static_cast<double>(status.consumed - reported_.consumed) / since_s;
    status.emitted_per_s = static_cast<double>(status.emitted - reported_.emitted) / since_s;
  }
  status.dropped = queue.dropped + queue.refused + read.malformed + read.lost;
  status.write_failures = written.failures;
  status.latency_us = {latency_.quantile_us(0.5), latency_.quantile_us(0.95), latency_.quantile_us(0.99),
                       latency_.max_us()};
  status.state = state_;
  status.mismatch = report_mismatches();
  status.utc = read_utc_state();
  if (flight_) status.acknowledgements = flight_->acknowledgements().newest();
  outputs_.publish(status);
  report_losses(status.dropped, queue, read, written);
  reported_.at = now;
  reported_.consumed = status.consumed;
  reported_.emitted = status.emitted;
}

dds::ReadCounts Service::read_counts() const { return input_ ? input_->counts() : follower_->counts(); }

void Service::report_losses(std::uint64_t dropped, const EventQueue::Losses& queue, const dds::ReadCounts& read,
                            const dds::WriteCounts& written) {
  if (dropped != reported_.dropped) {
    spdlog::warn(
        "inputs lost so far: {} (queue full {}{}, of unknown sources {}, malformed {}, lost in transport {}) {}",
        dropped, queue.dropped,
        queue.worst.empty() ? "" : fmt::format(", most of {}: {}", queue.worst, queue.worst_dropped), queue.refused,
        read.malformed, read.lost, read.last_malformed);
  }
  if (written.failures != reported_.write_failures) {
    spdlog::error("results not written so far: {}: {}", written.failures, written.last_failure);
  }
  const std::uint64_t expired = expired_before_ + (flight_ ? flight_->expired() : 0);
  if (expired != reported_.expired) spdlog::warn("commands not sent so far, for they had expired: {}", expired);
  reported_.dropped = dropped;
  reported_.write_failures = written.failures;
  reported_.expired = expired;
}

std::string Service::report_mismatches() {
  const std::vector<std::string> mismatches = participant_.mismatches();
  for (const std::string& mismatch : new_mismatches_.among(mismatches)) spdlog::warn("does not match: {}", mismatch);
  if (mismatches.empty()) return {};
  return fmt::format("{} of others: {}", mismatches.size(), mismatches.front());
}

}  // namespace downrange::app
