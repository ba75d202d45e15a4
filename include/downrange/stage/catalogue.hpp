#pragma once
/// The one list of the range's messages. Order of processing, event queue, DDS readers and writers, archive channels,
/// replay and the tests' samples fold over it: a record that is missing here does not compile where it is used.
///
/// A new message: its struct (event.hpp or result.hpp), a MessageInfo and a place in a list here; its wire type
/// (idl/downrange.idl, src/dds/wire_catalogue.hpp, src/dds/convert_*.cpp) and its record (idl/archive.proto,
/// src/archive/record_catalogue.hpp, src/archive/*_proto.cpp); a sample in tests/support/samples.hpp.

#include <array>
#include <cstdint>
#include <downrange/stage/event.hpp>
#include <downrange/stage/result.hpp>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>

namespace downrange {

/// A list of types.
template <class... Records>
struct RecordList {
  static constexpr std::size_t size = sizeof...(Records);

  /// `function` is called for each record of the list, which is its template argument.
  template <class Function>
  static constexpr void for_each(Function&& function) {
    (function.template operator()<Records>(), ...);
  }
  /// A tuple with one `Of` for each record.
  template <template <class> class Of>
  using Tuple = std::tuple<Of<Records>...>;
  /// A variant of them, and of `More` behind them.
  template <class... More>
  using Variant = std::variant<Records..., More...>;
  /// Position of Record, `size` when it is not in the list.
  template <class Record>
  static constexpr std::size_t index_of() {
    std::size_t index = 0;
    static_cast<void>(((std::is_same_v<Record, Records> ? true : (++index, false)) || ...));
    return index;
  }
  template <class Record>
  static constexpr bool contains = index_of<Record>() < size;
};
/// Both lists, one behind the other; for decltype.
template <class... A, class... B>
RecordList<A..., B...> operator+(RecordList<A...>, RecordList<B...>);

/// What comes from outside. Their order is that of events of equal `received` and the wire's InputTopic: append only.
using Inputs = RecordList<MissionEvent, RadarTspi, GpsFix, AngleTspi, OperatorCommand, AntennaReport, PlatformState>;

/// Those of them that ingest judges, in the order of Measured's alternatives.
using Measurements = RecordList<RadarTspi, GpsFix, AngleTspi>;
static_assert(Measurements::size == std::variant_size_v<Measured>);

/// What the engine makes, in the order of the stages.
using Outputs = RecordList<Observation, SensorBias, Trajectory, Integrity, SlavingCommand, AntennaAccount, ImpactPoint,
                           SourceHealth>;

/// How the middleware is to treat a topic: the quality-of-service profile of config/dds-qos.xml that has its name.
enum class Delivery : std::uint8_t {
  Stream,  ///< every sample counts, none is news to who joins late
  Mark,    ///< few samples, and who joins late gets them
  Owned,   ///< of several nodes the strongest that is alive is heard
  State,   ///< the newest sample says all
};

[[nodiscard]] constexpr std::string_view to_string(Delivery delivery) {
  constexpr std::array<std::string_view, 4> names{"stream", "mark", "owned", "state"};
  return names.at(static_cast<std::size_t>(delivery));
}

/// The key of a result that nodes own: both parts, the second empty where the topic has one key.
using OwnedKey = std::pair<Name, Name>;

/// Of one message:
///   topic      its name on DDS and in archives
///   delivery   see above
///   source     who made it (sensor, station, antenna, mission, operator): what queues and counts go by
///   target     the second part of its key, empty where it has none
/// and of a result that nodes own, in place of source and target, its key.
template <class Record>
struct MessageInfo;

template <>
struct MessageInfo<MissionEvent> {
  static constexpr std::string_view topic = "range/mission";
  static constexpr Delivery delivery = Delivery::Mark;
  static Name source(const MissionEvent& e) { return e.mission; }
  static Name target(const MissionEvent&) { return {}; }
};

template <>
struct MessageInfo<RadarTspi> {
  static constexpr std::string_view topic = "range/radar_tspi";
  static constexpr Delivery delivery = Delivery::Stream;
  static Name source(const RadarTspi& e) { return e.sensor; }
  static Name target(const RadarTspi& e) { return e.target; }
};

template <>
struct MessageInfo<GpsFix> {
  static constexpr std::string_view topic = "range/gps";
  static constexpr Delivery delivery = Delivery::Stream;
  static Name source(const GpsFix& e) { return e.station; }
  static Name target(const GpsFix& e) { return e.target; }
};

template <>
struct MessageInfo<AngleTspi> {
  static constexpr std::string_view topic = "range/angles";
  static constexpr Delivery delivery = Delivery::Stream;
  static Name source(const AngleTspi& e) { return e.sensor; }
  static Name target(const AngleTspi& e) { return e.target; }
};

template <>
struct MessageInfo<OperatorCommand> {
  static constexpr std::string_view topic = "range/operator";
  static constexpr Delivery delivery = Delivery::Mark;
  static Name source(const OperatorCommand& e) { return e.operator_id; }
  static Name target(const OperatorCommand&) { return {}; }
};

template <>
struct MessageInfo<AntennaReport> {
  static constexpr std::string_view topic = "range/antenna";
  static constexpr Delivery delivery = Delivery::Stream;
  static Name source(const AntennaReport& e) { return e.antenna; }
  static Name target(const AntennaReport&) { return {}; }
};

template <>
struct MessageInfo<PlatformState> {
  static constexpr std::string_view topic = "range/platform";
  static constexpr Delivery delivery = Delivery::Stream;
  static Name source(const PlatformState& e) { return e.antenna; }
  static Name target(const PlatformState&) { return {}; }
};

template <>
struct MessageInfo<Observation> {
  static constexpr std::string_view topic = "downrange/observation";
  static constexpr Delivery delivery = Delivery::Stream;
  static Name source(const Observation& e) { return e.sensor; }
  static Name target(const Observation& e) { return e.target; }
};

/// In archives alone.
template <>
struct MessageInfo<ClockGap> {
  static constexpr std::string_view topic = "downrange/clock_gap";
  static Name source(const ClockGap&) { return {}; }
  static Name target(const ClockGap&) { return {}; }
};

template <>
struct MessageInfo<SensorBias> {
  static constexpr std::string_view topic = "downrange/bias";
  static constexpr Delivery delivery = Delivery::Owned;
  static OwnedKey key(const SensorBias& r) { return {r.sensor, r.method}; }
};

template <>
struct MessageInfo<Trajectory> {
  static constexpr std::string_view topic = "downrange/trajectory";
  static constexpr Delivery delivery = Delivery::Owned;
  static OwnedKey key(const Trajectory& r) { return {r.target, r.method}; }
};

/// Owned, as the trajectory is: whom the antennas follow says whom they do not follow.
template <>
struct MessageInfo<Integrity> {
  static constexpr std::string_view topic = "downrange/integrity";
  static constexpr Delivery delivery = Delivery::Owned;
  static OwnedKey key(const Integrity& r) { return {r.target, {}}; }
};

template <>
struct MessageInfo<SlavingCommand> {
  static constexpr std::string_view topic = "downrange/slaving";
  static constexpr Delivery delivery = Delivery::Owned;
  static OwnedKey key(const SlavingCommand& r) { return {r.antenna, {}}; }
};

template <>
struct MessageInfo<AntennaAccount> {
  static constexpr std::string_view topic = "downrange/antenna";
  static constexpr Delivery delivery = Delivery::Owned;
  static OwnedKey key(const AntennaAccount& r) { return {r.antenna, {}}; }
};

template <>
struct MessageInfo<ImpactPoint> {
  static constexpr std::string_view topic = "downrange/impact";
  static constexpr Delivery delivery = Delivery::Owned;
  static OwnedKey key(const ImpactPoint& r) { return {r.target, r.chain}; }
};

template <>
struct MessageInfo<SourceHealth> {
  static constexpr std::string_view topic = "downrange/health";
  static constexpr Delivery delivery = Delivery::State;
};

/// The place of an input's topic in the order of processing, and its number on the wire.
template <class Input>
inline constexpr std::size_t input_index = Inputs::index_of<Input>();

/// The input_index of the message that a measurement came in, by the index of Measured's alternative.
inline constexpr auto input_of_measured = []<class... Records>(RecordList<Records...>) {
  return std::array{input_index<Records>...};
}(Measurements{});

}  // namespace downrange
