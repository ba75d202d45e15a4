#pragma once
/// Inside src/dds: the wire type of each message of stage/catalogue.hpp, and the inputs by number.

#include <downrange.h>
#include <downrangePubSubTypes.h>

#include <array>
#include <cstdint>
#include <downrange/stage/catalogue.hpp>
#include <optional>
#include <utility>

namespace downrange::dds {

template <class Record>
struct WireOf;
template <>
struct WireOf<MissionEvent> {
  using PubSubType = wire::MissionEventV2PubSubType;
};
template <>
struct WireOf<RadarTspi> {
  using PubSubType = wire::RadarTspiV2PubSubType;
};
template <>
struct WireOf<GpsFix> {
  using PubSubType = wire::GpsFixV2PubSubType;
};
template <>
struct WireOf<AngleTspi> {
  using PubSubType = wire::AngleTspiV2PubSubType;
};
template <>
struct WireOf<OperatorCommand> {
  using PubSubType = wire::OperatorCommandV2PubSubType;
};
template <>
struct WireOf<AntennaReport> {
  using PubSubType = wire::AntennaReportV2PubSubType;
};
template <>
struct WireOf<PlatformState> {
  using PubSubType = wire::PlatformStateV2PubSubType;
};
template <>
struct WireOf<Observation> {
  using PubSubType = wire::ObservationV2PubSubType;
};
template <>
struct WireOf<SensorBias> {
  using PubSubType = wire::SensorBiasV2PubSubType;
};
template <>
struct WireOf<Trajectory> {
  using PubSubType = wire::TrajectoryV2PubSubType;
};
template <>
struct WireOf<Integrity> {
  using PubSubType = wire::IntegrityV3PubSubType;
};
template <>
struct WireOf<SlavingCommand> {
  using PubSubType = wire::SlavingCommandV2PubSubType;
};
template <>
struct WireOf<SourceHealth> {
  using PubSubType = wire::SourceHealthV3PubSubType;
};

template <class Record>
using PubSubTypeOf = typename WireOf<Record>::PubSubType;
template <class Record>
using Wire = typename PubSubTypeOf<Record>::type;

template <class Record>
inline constexpr const char* topic_of = MessageInfo<Record>::topic.data();

/// Of an input: its place in Inputs, which is wire::InputTopic.
using InputTopic = std::size_t;
static_assert(Inputs::size == wire::INPUT_PLATFORM + 1, "wire::InputTopic and Inputs list the same topics");
static_assert(Inputs::size <= 8, "ClockAck.topics has a bit for each");

template <class Record>
inline constexpr bool is_measurement = Measurements::contains<Record>;

/// Of each input, by InputTopic.
struct InputInfo {
  const char* topic;
  bool measurement;  ///< judged by ingest: a centre reads observations instead
};
inline constexpr auto input_info = []<class... Records>(RecordList<Records...>) {
  return std::array{InputInfo{topic_of<Records>, is_measurement<Records>}...};
}(Inputs{});

/// In ClockAck.topics.
[[nodiscard]] constexpr unsigned bit_of(InputTopic topic) { return 1U << topic; }

/// The topic and the source of an input. Nothing of an observation, which an ingest node makes.
[[nodiscard]] inline std::optional<std::pair<InputTopic, Name>> stream_of(const Event& event) {
  return std::visit(
      []<class Record>(const Record& record) -> std::optional<std::pair<InputTopic, Name>> {
        if constexpr (Inputs::contains<Record>) {
          return std::pair{input_index<Record>, MessageInfo<Record>::source(record)};
        } else {
          return std::nullopt;
        }
      },
      event);
}

}  // namespace downrange::dds
