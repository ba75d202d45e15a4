#pragma once
/// Inside src/dds: the wire type of each message of stage/catalogue.hpp with the conversions to and from it, and the
/// inputs by number.
/// to_wire never fails. from_wire trusts nothing: a sample whose enumerators, sizes or names the types do not allow
/// gives the defect and leaves the target in an unspecified state. Numbers are not judged: that is ingest's work.

#include <downrange.h>
#include <downrangePubSubTypes.h>

#include <array>
#include <cstdint>
#include <downrange/stage/catalogue.hpp>
#include <optional>
#include <string>
#include <utility>

namespace downrange::dds {

/// Why a sample cannot be used; empty: it can.
using Defect = std::string;

template <class Record>
struct WireOf;
template <class Record>
using PubSubTypeOf = typename WireOf<Record>::PubSubType;
template <class Record>
using Wire = typename PubSubTypeOf<Record>::type;

template <>
struct WireOf<MissionEvent> {
  using PubSubType = wire::MissionEventV2PubSubType;
  static constexpr auto topic = wire::INPUT_MISSION;
};
void to_wire(const MissionEvent& from, Wire<MissionEvent>& to);
[[nodiscard]] Defect from_wire(const Wire<MissionEvent>& from, MissionEvent& to);

template <>
struct WireOf<RadarTspi> {
  using PubSubType = wire::RadarTspiV2PubSubType;
  static constexpr auto topic = wire::INPUT_RADAR_TSPI;
};
void to_wire(const RadarTspi& from, Wire<RadarTspi>& to);
[[nodiscard]] Defect from_wire(const Wire<RadarTspi>& from, RadarTspi& to);

template <>
struct WireOf<GpsFix> {
  using PubSubType = wire::GpsFixV2PubSubType;
  static constexpr auto topic = wire::INPUT_GPS;
};
void to_wire(const GpsFix& from, Wire<GpsFix>& to);
[[nodiscard]] Defect from_wire(const Wire<GpsFix>& from, GpsFix& to);

template <>
struct WireOf<AngleTspi> {
  using PubSubType = wire::AngleTspiV2PubSubType;
  static constexpr auto topic = wire::INPUT_ANGLES;
};
void to_wire(const AngleTspi& from, Wire<AngleTspi>& to);
[[nodiscard]] Defect from_wire(const Wire<AngleTspi>& from, AngleTspi& to);

template <>
struct WireOf<OperatorCommand> {
  using PubSubType = wire::OperatorCommandV2PubSubType;
  static constexpr auto topic = wire::INPUT_OPERATOR;
};
void to_wire(const OperatorCommand& from, Wire<OperatorCommand>& to);
[[nodiscard]] Defect from_wire(const Wire<OperatorCommand>& from, OperatorCommand& to);

template <>
struct WireOf<AntennaReport> {
  using PubSubType = wire::AntennaReportV2PubSubType;
  static constexpr auto topic = wire::INPUT_ANTENNA;
};
void to_wire(const AntennaReport& from, Wire<AntennaReport>& to);
[[nodiscard]] Defect from_wire(const Wire<AntennaReport>& from, AntennaReport& to);

template <>
struct WireOf<PlatformState> {
  using PubSubType = wire::PlatformStateV2PubSubType;
  static constexpr auto topic = wire::INPUT_PLATFORM;
};
void to_wire(const PlatformState& from, Wire<PlatformState>& to);
[[nodiscard]] Defect from_wire(const Wire<PlatformState>& from, PlatformState& to);

template <>
struct WireOf<Observation> {
  using PubSubType = wire::ObservationV2PubSubType;
};
void to_wire(const Observation& from, Wire<Observation>& to);
[[nodiscard]] Defect from_wire(const Wire<Observation>& from, Observation& to);

template <>
struct WireOf<SensorBias> {
  using PubSubType = wire::SensorBiasV2PubSubType;
};
void to_wire(const SensorBias& from, Wire<SensorBias>& to);
[[nodiscard]] Defect from_wire(const Wire<SensorBias>& from, SensorBias& to);

template <>
struct WireOf<Trajectory> {
  using PubSubType = wire::TrajectoryV2PubSubType;
};
void to_wire(const Trajectory& from, Wire<Trajectory>& to);
[[nodiscard]] Defect from_wire(const Wire<Trajectory>& from, Trajectory& to);

template <>
struct WireOf<Integrity> {
  using PubSubType = wire::IntegrityV3PubSubType;
};
void to_wire(const Integrity& from, Wire<Integrity>& to);
[[nodiscard]] Defect from_wire(const Wire<Integrity>& from, Integrity& to);

template <>
struct WireOf<SlavingCommand> {
  using PubSubType = wire::SlavingCommandV4PubSubType;
};
void to_wire(const SlavingCommand& from, Wire<SlavingCommand>& to);
[[nodiscard]] Defect from_wire(const Wire<SlavingCommand>& from, SlavingCommand& to);

template <>
struct WireOf<AntennaAccount> {
  using PubSubType = wire::AntennaAccountV4PubSubType;
};
void to_wire(const AntennaAccount& from, Wire<AntennaAccount>& to);
[[nodiscard]] Defect from_wire(const Wire<AntennaAccount>& from, AntennaAccount& to);

template <>
struct WireOf<ImpactPoint> {
  using PubSubType = wire::ImpactPointV3PubSubType;
};
void to_wire(const ImpactPoint& from, Wire<ImpactPoint>& to);
[[nodiscard]] Defect from_wire(const Wire<ImpactPoint>& from, ImpactPoint& to);

template <>
struct WireOf<SourceHealth> {
  using PubSubType = wire::SourceHealthV5PubSubType;
};
void to_wire(const SourceHealth& from, Wire<SourceHealth>& to);
/// Counts of reasons that this program does not know are left out.
[[nodiscard]] Defect from_wire(const Wire<SourceHealth>& from, SourceHealth& to);

template <class Record>
inline constexpr const char* topic_of = MessageInfo<Record>::topic.data();

/// Of an input: its place in Inputs, which is wire::InputTopic.
using InputTopic = std::size_t;
/// Whether every input has the number in wire::InputTopic that its place in Inputs is.
[[nodiscard]] constexpr bool input_numbers_agree() {
  bool agree = true;
  Inputs::for_each(
      [&]<class Input>() { agree = agree && Inputs::index_of<Input>() == std::size_t{WireOf<Input>::topic}; });
  return agree;
}
static_assert(input_numbers_agree(), "wire::InputTopic and Inputs list the same topics in the same order");
static_assert(Inputs::size <= 32, "ClockAck.topics has a bit for each");

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
