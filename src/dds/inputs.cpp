#include "dds/inputs.hpp"

#include <algorithm>
#include <mutex>
#include <optional>
#include <utility>

#include "dds/convert.hpp"
#include "dds/entities.hpp"
#include "dds/input_writers.hpp"

namespace downrange::dds {
namespace {

Time utc_now() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return {std::chrono::duration_cast<std::chrono::nanoseconds>(now).count()};
}

}  // namespace

class InputReader::Impl {
 public:
  Impl(Participant& participant, const InputSelection& selection, Callback callback)
      : clock_(participant.clock()), ingest_nodes_(selection.ingest_nodes), callback_(std::move(callback)) {
    Inputs::for_each([&]<class Input>() {
      if (is_measurement<Input> ? selection.sensors : selection.mission) open<Input>(participant);
    });
    if (!ingest_nodes_.empty()) {
      observation_.emplace(participant, topic_of<Observation>, tally_,
                           [this](const auto& wire, const auto&) { return receive_observation(wire); });
    }
  }

  [[nodiscard]] ReadCounts counts() const { return tally_.get(); }

  [[nodiscard]] bool matched(int writers) const {
    const auto met = [writers](const auto& reader) { return !reader || reader->writers().count() >= writers; };
    return met(observation_) && std::apply([&](const auto&... reader) { return (met(reader) && ...); }, readers_);
  }

 private:
  template <class Record>
  using Reader = std::optional<TopicReader<PubSubTypeOf<Record>>>;

  template <class Input>
  void open(Participant& participant) {
    std::get<Reader<Input>>(readers_).emplace(
        participant, topic_of<Input>, tally_,
        [this](const auto& wire, const auto&) { return this->template receive<Input>(wire); });
  }

  template <class Input>
  Defect receive(const Wire<Input>& wire, const Name& node = {}) {
    Input input;
    Defect defect = from_wire(wire, input);
    if (!defect.empty()) return defect;
    const RangeStamp stamp = from_wire(wire.stamp());
    if (clock_ == ClockMode::Wall) {
      if (stamp.run_id != 0) return "is stamped for a run on the range clock";
      input.received = utc_now();
    } else if (stamp.run_id == 0) {
      return "has no stamp of a run on the range clock";
    }
    callback_(input, stamp, node);
    return {};
  }

  Defect receive_observation(const Wire<Observation>& wire) {
    const std::optional<Name> node = Name::parse(wire.node_id().c_str());
    if (!node || std::find(ingest_nodes_.begin(), ingest_nodes_.end(), *node) == ingest_nodes_.end()) {
      return {};  // another centre's business
    }
    return receive<Observation>(wire, *node);
  }

  const ClockMode clock_;
  const std::vector<Name> ingest_nodes_;
  const Callback callback_;
  Tally<ReadCounts> tally_;
  Inputs::Tuple<Reader> readers_;
  Reader<Observation> observation_;
};

InputReader::InputReader(Participant& participant, const InputSelection& selection, Callback callback)
    : impl_(std::make_unique<Impl>(participant, selection, std::move(callback))) {}
InputReader::~InputReader() = default;

ReadCounts InputReader::counts() const { return impl_->counts(); }

bool InputReader::wait_for_matched(int writers, std::chrono::milliseconds timeout) const {
  return wait_until(timeout, [&] { return impl_->matched(writers); });
}

const Peers& InputWriters::Impl::readers(InputTopic topic) const {
  const Peers* readers = nullptr;
  Inputs::for_each([&]<class Input>() {
    if (input_index<Input> == topic) readers = &std::get<Output<Input>>(outputs_).writer->readers();
  });
  return *readers;
}

bool InputWriters::Impl::write(const Event& event, const RangeStamp& stamp) {
  return std::visit(
      [&]<class Record>(const Record& record) {
        if constexpr (Inputs::contains<Record>) {
          auto& [writer, sample] = std::get<Output<Record>>(outputs_);
          to_wire(record, sample);
          to_wire(stamp, sample.stamp());
          return writer->write(sample);
        } else {
          return false;
        }
      },
      event);
}

InputWriters::InputWriters(Participant& participant) : impl_(std::make_unique<Impl>(participant)) {}
InputWriters::~InputWriters() = default;

bool InputWriters::write(const Event& event, const RangeStamp& stamp) { return impl_->write(event, stamp); }
WriteCounts InputWriters::counts() const { return impl_->tally.get(); }

bool InputWriters::wait_for_matched(int readers, std::chrono::milliseconds timeout) const {
  return wait_until(timeout, [&] {
    for (InputTopic topic = 0; topic < Inputs::size; ++topic) {
      if (impl_->readers(topic).count() < readers) return false;
    }
    return true;
  });
}

bool InputWriters::wait_for_reader(std::size_t topic, std::chrono::milliseconds timeout) const {
  return wait_until(timeout, [&] { return impl_->readers(topic).count() > 0; });
}

class AntennaReportWriter::Impl {
 public:
  explicit Impl(Participant& participant) : writer_(participant, topic_of<AntennaReport>, tally) {}

  [[nodiscard]] bool write(const AntennaReport& report) {
    const std::scoped_lock lock(mutex_);
    to_wire(report, sample_);
    return writer_.write(sample_);
  }

  Tally<WriteCounts> tally;

 private:
  std::mutex mutex_;
  TopicWriter<PubSubTypeOf<AntennaReport>> writer_;
  Wire<AntennaReport> sample_;
};

AntennaReportWriter::AntennaReportWriter(Participant& participant) : impl_(std::make_unique<Impl>(participant)) {}
AntennaReportWriter::~AntennaReportWriter() = default;

bool AntennaReportWriter::write(const AntennaReport& report) { return impl_->write(report); }
WriteCounts AntennaReportWriter::counts() const { return impl_->tally.get(); }

}  // namespace downrange::dds
