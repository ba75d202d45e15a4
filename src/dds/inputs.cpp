#include "dds/inputs.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "dds/convert.hpp"
#include "dds/entities.hpp"
#include "dds/input_writers.hpp"
#include "dds/topics.hpp"

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
    if (selection.mission) {
      mission_.emplace(participant, topics::mission, tally_,
                       [this](const auto& wire, const auto&) { return take<MissionEvent>(wire); });
    }
    if (selection.sensors) {
      radar_.emplace(participant, topics::radar_tspi, tally_,
                     [this](const auto& wire, const auto&) { return take<RadarTspi>(wire); });
      angles_.emplace(participant, topics::angles, tally_,
                      [this](const auto& wire, const auto&) { return take<AngleTspi>(wire); });
      gps_.emplace(participant, topics::gps, tally_,
                   [this](const auto& wire, const auto&) { return take<GpsFix>(wire); });
    }
    if (!ingest_nodes_.empty()) {
      observation_.emplace(participant, topics::observation, tally_,
                           [this](const auto& wire, const auto&) { return take_observation(wire); });
    }
  }

  [[nodiscard]] ReadCounts counts() const { return tally_.get(); }

  [[nodiscard]] bool matched(int writers) const {
    const auto met = [writers](const auto& reader) { return !reader || reader->writers().count() >= writers; };
    return met(mission_) && met(radar_) && met(angles_) && met(gps_) && met(observation_);
  }

 private:
  template <class Input, class Wire>
  Defect take(const Wire& wire, const Name& node = {}) {
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

  Defect take_observation(const wire::Observation& wire) {
    const std::optional<Name> node = Name::parse(wire.node_id().c_str());
    if (!node || std::find(ingest_nodes_.begin(), ingest_nodes_.end(), *node) == ingest_nodes_.end()) {
      return {};  // another centre's business
    }
    return take<Observation>(wire, *node);
  }

  const ClockMode clock_;
  const std::vector<Name> ingest_nodes_;
  const Callback callback_;
  Tally<ReadCounts> tally_;
  std::optional<TopicReader<wire::MissionEventPubSubType>> mission_;
  std::optional<TopicReader<wire::RadarTspiPubSubType>> radar_;
  std::optional<TopicReader<wire::AngleTspiPubSubType>> angles_;
  std::optional<TopicReader<wire::GpsFixPubSubType>> gps_;
  std::optional<TopicReader<wire::ObservationPubSubType>> observation_;
};

InputReader::InputReader(Participant& participant, const InputSelection& selection, Callback callback)
    : impl_(std::make_unique<Impl>(participant, selection, std::move(callback))) {}
InputReader::~InputReader() = default;

ReadCounts InputReader::counts() const { return impl_->counts(); }

bool InputReader::wait_for_matched(int writers, std::chrono::milliseconds timeout) const {
  return wait_until(timeout, [&] { return impl_->matched(writers); });
}

InputWriters::Impl::Impl(Participant& participant)
    : mission_(participant, topics::mission, tally),
      radar_(participant, topics::radar_tspi, tally),
      angles_(participant, topics::angles, tally),
      gps_(participant, topics::gps, tally) {}

const Peers& InputWriters::Impl::readers(InputTopic topic) const {
  switch (topic) {
    case InputTopic::Mission:
      return mission_.readers();
    case InputTopic::RadarTspi:
      return radar_.readers();
    case InputTopic::Gps:
      return gps_.readers();
    case InputTopic::Angles:
      break;
  }
  return angles_.readers();
}

bool InputWriters::Impl::write(const Event& event, const RangeStamp& stamp) {
  const auto send = [&stamp](const auto& input, auto& sample, auto& writer) {
    to_wire(input, sample);
    to_wire(stamp, sample.stamp());
    return writer.write(sample);
  };
  if (const auto* plot = std::get_if<RadarTspi>(&event)) return send(*plot, radar_sample_, radar_);
  if (const auto* angles = std::get_if<AngleTspi>(&event)) return send(*angles, angles_sample_, angles_);
  if (const auto* fix = std::get_if<GpsFix>(&event)) return send(*fix, gps_sample_, gps_);
  if (const auto* mark = std::get_if<MissionEvent>(&event)) return send(*mark, mission_sample_, mission_);
  return false;
}

InputWriters::InputWriters(Participant& participant) : impl_(std::make_unique<Impl>(participant)) {}
InputWriters::~InputWriters() = default;

bool InputWriters::write(const Event& event, const RangeStamp& stamp) { return impl_->write(event, stamp); }
WriteCounts InputWriters::counts() const { return impl_->tally.get(); }

bool InputWriters::wait_for_matched(int readers, std::chrono::milliseconds timeout) const {
  return wait_until(timeout, [&] {
    return std::ranges::all_of(input_topics,
                               [&](InputTopic topic) { return impl_->readers(topic).count() >= readers; });
  });
}

}  // namespace downrange::dds
