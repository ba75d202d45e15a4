#include "dds/outputs.hpp"

#include <utility>

#include "dds/convert.hpp"
#include "dds/output_writers.hpp"
#include "dds/topics.hpp"

namespace downrange::dds {

OutputWriters::Impl::Impl(Participant& participant, const OutputOptions& options)
    : clock_(participant.clock()), node_(participant.node()), status_(participant, topics::status, tally) {
  Outputs::for_each([&]<class Record>() {
    if constexpr (owned<Record>) {
      if (options.results)
        output<Record>().emplace(participant, tally, EndpointOptions{options.strength, true},
                                 options.owned_keys<Record>());
    } else if (options.observations || !std::is_same_v<Record, Observation>) {
      output<Record>().emplace(participant, tally).sample().node_id() = node_.c_str();
    }
  });
  if (!options.observations) return;
  progress_.emplace(participant, tally);
  progress_->report.node_id() = node_.c_str();
}

void OutputWriters::Impl::emit(const Result& result) {
  std::visit([this](const auto& record) { write(record); }, result);
}

template <class Record>
void OutputWriters::Impl::write(const Record& record) {
  auto& writer = output<Record>();
  if (!writer) return;
  if constexpr (owned<Record>) {
    writer->write(record);
  } else {
    to_wire(record, writer->sample());
    if constexpr (std::is_same_v<Record, Observation>) stamp(writer->sample());
    writer->send();
  }
}

void OutputWriters::Impl::stamp(Wire<Observation>& sample) {
  if (clock_ != ClockMode::Range) return;
  auto& report = progress_->report;
  report.observations(report.observations() + 1);
  sample.step(report.step());
  to_wire(RangeStamp{report.run_id(), report.observations()}, sample.stamp());
}

void OutputWriters::Impl::publish(const ServiceStatus& status) {
  wire::ServiceStatusV4 sample;
  to_wire(status, sample);
  static_cast<void>(status_.write(sample));
}

bool OutputWriters::Impl::matched(int least) const {
  if (!std::get<Output<Trajectory>>(outputs_)) return !progress_ || readers<Observation>() >= least;
  bool met = true;
  Outputs::for_each([&]<class Record>() {
    if (owned<Record>) met = met && readers<Record>() >= least;
  });
  return met;
}

void OutputWriters::Impl::begin_step(const RangeStep& step) {
  if (!progress_) return;
  auto& report = progress_->report;
  if (report.run_id() != step.run_id) report.observations(0);
  report.run_id(step.run_id);
  report.step(step.step);
}

void OutputWriters::Impl::end_step() {
  if (progress_) static_cast<void>(progress_->writer.write(progress_->report));
}

void OutputWriters::Impl::greet_centres() {
  if (!progress_) return;
  const Peers& centres = progress_->writer.readers();
  const std::uint64_t met = centres.meetings();
  if (met == progress_->greeted || !output<Observation>()->peers().includes(centres)) return;
  wire::IngestProgressV2 greeting;  // of no run
  greeting.node_id() = node_.c_str();
  if (progress_->writer.write(greeting)) progress_->greeted = met;
}

OutputWriters::OutputWriters(Participant& participant, const OutputOptions& options)
    : impl_(std::make_unique<Impl>(participant, options)) {}
OutputWriters::~OutputWriters() = default;

void OutputWriters::emit(const Result& result) { impl_->emit(result); }
void OutputWriters::publish(const ServiceStatus& status) { impl_->publish(status); }
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
    Outputs::for_each([&]<class Record>() {
      const bool own = MessageInfo<Record>::delivery == Delivery::Owned;
      const bool is_command = std::is_same_v<Record, SlavingCommand>;
      const bool wanted = std::is_same_v<Record, Observation> ? selection.observations
                          : own ? selection.results && (is_command || !selection.commands_only)
                                : selection.health;
      if (wanted) open<Record>(participant, options);
    });
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
    return met(status_) && std::apply([&](const auto&... reader) { return (met(reader) && ...); }, readers_);
  }

 private:
  template <class Record>
  using Reader = std::optional<TopicReader<PubSubTypeOf<Record>>>;

  template <class Record>
  void open(Participant& participant, const EndpointOptions& options) {
    std::get<Reader<Record>>(readers_).emplace(
        participant, topic_of<Record>, tally_,
        [this](const auto& wire, const auto&) { return this->template receive<Record>(wire); }, options);
  }

  template <class Record>
  Defect receive(const Wire<Record>& wire) {
    Record record;
    Defect defect = from_wire(wire, record);
    if (!defect.empty()) return defect;
    if constexpr (std::is_same_v<Record, SourceHealth>) {
      if (callbacks_.health) {
        const std::optional<Name> node = Name::parse(wire.node_id().c_str());
        if (!node || node->empty()) return "node_id is empty or longer than 31 characters";
        callbacks_.health(record, *node);
        return {};
      }
    }
    if (callbacks_.result) callbacks_.result(record);
    return {};
  }

  const OutputCallbacks callbacks_;
  Tally<ReadCounts> tally_;
  Outputs::Tuple<Reader> readers_;
  std::optional<TopicReader<wire::ServiceStatusV4PubSubType>> status_;
};

OutputReaders::OutputReaders(Participant& participant, const OutputSelection& selection, OutputCallbacks callbacks)
    : impl_(std::make_unique<Impl>(participant, selection, std::move(callbacks))) {}
OutputReaders::~OutputReaders() = default;

ReadCounts OutputReaders::counts() const { return impl_->counts(); }

bool OutputReaders::wait_for_matched(int writers, std::chrono::milliseconds timeout) const {
  return wait_until(timeout, [&] { return impl_->matched(writers); });
}

}  // namespace downrange::dds
