#pragma once
/// The channels of our archives: which topic carries which record.

#include <archive/bytes.hpp>
#include <archive/record.hpp>
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace downrange::archive {

/// A schema's id is its number here: append only.
enum class RecordKind : std::uint8_t {
  RadarTspi,
  GpsFix,
  MissionEvent,
  Observation,
  SensorBias,
  Trajectory,
  SlavingCommand,
  SourceHealth,
  LastTick,
  Truth,
  AngleTspi,
  ClockGap,
};

/// One MCAP channel. Its schema's id is 1 + its record kind.
struct Channel {
  std::uint16_t id;
  RecordKind kind;
  Role role;
  std::string_view topic;

  [[nodiscard]] std::uint16_t schema_id() const { return static_cast<std::uint16_t>(1 + static_cast<int>(kind)); }
};

// Two channels share the topic of observations: an event that a centre consumed must not be taken for a result of it.
inline constexpr Channel radar_channel{1, RecordKind::RadarTspi, Role::Input, "range/radar_tspi"};
inline constexpr Channel gps_channel{2, RecordKind::GpsFix, Role::Input, "range/gps"};
inline constexpr Channel mission_channel{3, RecordKind::MissionEvent, Role::Input, "range/mission"};
inline constexpr Channel observation_in_channel{4, RecordKind::Observation, Role::Input, "downrange/observation"};
inline constexpr Channel observation_out_channel{5, RecordKind::Observation, Role::Output, "downrange/observation"};
inline constexpr Channel bias_channel{6, RecordKind::SensorBias, Role::Output, "downrange/bias"};
inline constexpr Channel trajectory_channel{7, RecordKind::Trajectory, Role::Output, "downrange/trajectory"};
inline constexpr Channel slaving_channel{8, RecordKind::SlavingCommand, Role::Output, "downrange/slaving"};
inline constexpr Channel health_channel{9, RecordKind::SourceHealth, Role::Output, "downrange/health"};
inline constexpr Channel last_tick_channel{10, RecordKind::LastTick, Role::Mark, "downrange/last_tick"};
inline constexpr Channel truth_channel{11, RecordKind::Truth, Role::Truth, "sim/truth"};
inline constexpr Channel angles_channel{12, RecordKind::AngleTspi, Role::Input, "range/angles"};
inline constexpr Channel clock_gap_channel{13, RecordKind::ClockGap, Role::Input, "downrange/clock_gap"};
inline constexpr std::array channels{
    radar_channel, gps_channel,        mission_channel,  observation_in_channel, observation_out_channel,
    bias_channel,  trajectory_channel, slaving_channel,  health_channel,         last_tick_channel,
    truth_channel, angles_channel,     clock_gap_channel};

/// The word of a channel's metadata key "role": "input", "output", "mark", "truth".
[[nodiscard]] std::string_view to_string(Role role);
[[nodiscard]] std::optional<Role> role_named(std::string_view name);

/// Full name of the Protobuf message, e.g. "downrange.record.RadarTspi".
[[nodiscard]] std::string_view schema_name(RecordKind kind);
/// The kind of records whose message has this full name.
[[nodiscard]] std::optional<RecordKind> kind_of_schema(std::string_view name);

/// Content of the MCAP Schema record, FileDescriptorSet included.
[[nodiscard]] Bytes schema_record(const Channel& channel);
/// Content of the MCAP Channel record.
[[nodiscard]] Bytes channel_record(const Channel& channel);

}  // namespace downrange::archive
