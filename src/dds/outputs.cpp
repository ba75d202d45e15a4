#include "dds/outputs.hpp"

#include <utility>

#include "dds/convert.hpp"
#include "dds/output_writers.hpp"
#include "dds/topics.hpp"

namespace downrange::dds {
namespace {

std::vector<std::pair<Name, Name>> keys_of(const std::vector<Name>& antennas) {
  std::vector<std::pair<Name, Name>> keys;
  for (const Name& antenna : antennas) keys.emplace_back(antenna, Name{});
  return keys;
}

}  // namespace

OutputWriters::Impl::ObservationOutput::ObservationOutput(Participant& participant, Tally<WriteCounts>& tally)
    : observation(participant, topics::observation, tally), progress(participant, topics::ingest_progress, tally) {
  sample.node_id() = participant.node().c_str();
  report.node_id() = participant.node().c_str();
}

OutputWriters::Impl::ResultOutput::ResultOutput(Participant& participant, Tally<WriteCounts>& tally,
                                                const OutputOptions& options)
    : bias(participant, topics::bias, tally, {options.strength, true}, options.biases),
      trajectory(participant, topics::trajectory, tally, {options.strength, true}, options.trajectories),
      slaving(participant, topics::slaving, tally, {options.strength, true}, keys_of(options.antennas)) {}

OutputWriters::Impl::Impl(Participant& participant, const OutputOptions& options)
    : clock_(participant.clock()),
      node_(participant.node()),
      health_(participant, topics::health, tally),
      status_(participant, topics::status, tally) {
  if (options.observations) observations_.emplace(participant, tally);
  if (options.results) results_.emplace(participant, tally, options);
  health_sample_.node_id() = node_.c_str();
}

void OutputWriters::Impl::emit(const Result& result) {
  std::visit([this](const auto& record) { write(record); }, result);
}

void OutputWriters::Impl::write(const Observation& observation) {
  if (!observations_) return;
  ObservationOutput& output = *observations_;
  to_wire(observation, output.sample);
  if (clock_ == ClockMode::Range) {
    output.report.observations(output.report.observations() + 1);
    output.sample.step(output.report.step());
    to_wire(RangeStamp{output.report.run_id(), output.report.observations()}, output.sample.stamp());
  }
  send(output.observation, output.sample);
}

void OutputWriters::Impl::write(const SensorBias& bias) {
  if (!results_) return;
  to_wire(bias, results_->bias_sample);
  results_->bias.write({bias.sensor, bias.method}, results_->bias_sample, bias.received);
}

void OutputWriters::Impl::write(const Trajectory& trajectory) {
  if (!results_) return;
  to_wire(trajectory, results_->trajectory_sample);
  results_->trajectory.write({trajectory.target, trajectory.method}, results_->trajectory_sample, trajectory.received);
}

void OutputWriters::Impl::write(const SlavingCommand& command) {
  if (!results_) return;
  to_wire(command, results_->slaving_sample);
  results_->slaving.write({command.antenna, {}}, results_->slaving_sample, command.tick);
}

void OutputWriters::Impl::write(const SourceHealth& health) {
  to_wire(health, health_sample_);
  send(health_, health_sample_);
}

void OutputWriters::Impl::publish(const ServiceStatus& status) {
  wire::ServiceStatus sample;
  to_wire(status, sample);
  send(status_, sample);
}

void OutputWriters::Impl::release_silent(Time last_tick) {
  if (!results_ || !plausible(last_tick)) return;
  results_->bias.release_silent(last_tick, [](const auto& key, wire::SensorBias& sample) {
    sample.sensor_id() = key.first.c_str();
    sample.method() = key.second.c_str();
  });
  results_->trajectory.release_silent(last_tick, [](const auto& key, wire::Trajectory& sample) {
    sample.target_id() = key.first.c_str();
    sample.method() = key.second.c_str();
  });
  results_->slaving.release_silent(
      last_tick, [](const auto& key, wire::SlavingCommand& sample) { sample.antenna_id() = key.first.c_str(); });
}

bool OutputWriters::Impl::matched(int readers) const {
  if (!results_) return !observations_ || observations_->observation.readers().count() >= readers;
  return results_->bias.readers() >= readers && results_->trajectory.readers() >= readers &&
         results_->slaving.readers() >= readers;
}

void OutputWriters::Impl::begin_step(const RangeStep& step) {
  if (!observations_) return;
  wire::IngestProgress& report = observations_->report;
  if (report.run_id() != step.run_id) report.observations(0);
  report.run_id(step.run_id);
  report.step(step.step);
}

void OutputWriters::Impl::end_step() {
  if (observations_) send(observations_->progress, observations_->report);
}

void OutputWriters::Impl::greet_centres() {
  if (!observations_) return;
  const Peers& centres = observations_->progress.readers();
  const std::uint64_t met = centres.meetings();
  if (met == observations_->greeted || !observations_->observation.readers().includes(centres)) return;
  wire::IngestProgress greeting;  // of no run
  greeting.node_id() = node_.c_str();
  if (observations_->progress.write(greeting)) observations_->greeted = met;
}

OutputWriters::OutputWriters(Participant& participant, const OutputOptions& options)
    : impl_(std::make_unique<Impl>(participant, options)) {}
OutputWriters::~OutputWriters() = default;

void OutputWriters::emit(const Result& result) { impl_->emit(result); }
void OutputWriters::publish(const ServiceStatus& status) { impl_->publish(status); }
void OutputWriters::release_silent(Time last_tick) { impl_->release_silent(last_tick); }
WriteCounts OutputWriters::counts() const { return impl_->tally.get(); }

int OutputWriters::slaving_readers() const { return impl_->slaving_readers(); }

bool OutputWriters::wait_for_matched(int readers, std::chrono::milliseconds timeout) const {
  return wait_until(timeout, [&] { return impl_->matched(readers); });
}

class OutputReaders::Impl {
 public:
  Impl(Participant& participant, const OutputSelection& selection, OutputCallbacks callbacks)
      : callbacks_(std::move(callbacks)) {
    const EndpointOptions options{0, selection.lossless};
    if (selection.observations) open<Observation>(observation_, participant, topics::observation, options);
    if (selection.bias) open<SensorBias>(bias_, participant, topics::bias, options);
    if (selection.trajectory) open<Trajectory>(trajectory_, participant, topics::trajectory, options);
    if (selection.slaving) open<SlavingCommand>(slaving_, participant, topics::slaving, options);
    if (selection.health) {
      health_.emplace(
          participant, topics::health, tally_, [this](const auto& wire, const auto&) { return take_health(wire); },
          options);
    }
    if (selection.status) {
      status_.emplace(
          participant, topics::status, tally_,
          [this](const auto& wire, const auto&) {
            ServiceStatus status;
            Defect defect = from_wire(wire, status);
            if (defect.empty() && callbacks_.status) callbacks_.status(status);
            return defect;
          },
          options);
    }
  }

  [[nodiscard]] ReadCounts counts() const { return tally_.get(); }

  [[nodiscard]] bool matched(int writers) const {
    const auto met = [writers](const auto& reader) { return !reader || reader->writers().count() >= writers; };
    return met(observation_) && met(bias_) && met(trajectory_) && met(slaving_) && met(health_) && met(status_);
  }

 private:
  template <class Record, class Reader>
  void open(std::optional<Reader>& reader, Participant& participant, const char* topic,
            const EndpointOptions& options) {
    reader.emplace(
        participant, topic, tally_,
        [this](const auto& wire, const auto&) {
          Record record;
          Defect defect = from_wire(wire, record);
          if (defect.empty() && callbacks_.result) callbacks_.result(record);
          return defect;
        },
        options);
  }

  Defect take_health(const wire::SourceHealth& wire) {
    SourceHealth health;
    Name node;
    Defect defect = from_wire(wire, health, node);
    if (!defect.empty()) return defect;
    if (callbacks_.health) {
      callbacks_.health(health, node);
    } else if (callbacks_.result) {
      callbacks_.result(health);
    }
    return {};
  }

  const OutputCallbacks callbacks_;
  Tally<ReadCounts> tally_;
  std::optional<TopicReader<wire::ObservationPubSubType>> observation_;
  std::optional<TopicReader<wire::SensorBiasPubSubType>> bias_;
  std::optional<TopicReader<wire::TrajectoryPubSubType>> trajectory_;
  std::optional<TopicReader<wire::SlavingCommandPubSubType>> slaving_;
  std::optional<TopicReader<wire::SourceHealthPubSubType>> health_;
  std::optional<TopicReader<wire::ServiceStatusPubSubType>> status_;
};

OutputReaders::OutputReaders(Participant& participant, const OutputSelection& selection, OutputCallbacks callbacks)
    : impl_(std::make_unique<Impl>(participant, selection, std::move(callbacks))) {}
OutputReaders::~OutputReaders() = default;

ReadCounts OutputReaders::counts() const { return impl_->counts(); }

bool OutputReaders::wait_for_matched(int writers, std::chrono::milliseconds timeout) const {
  return wait_until(timeout, [&] { return impl_->matched(writers); });
}

}  // namespace downrange::dds
