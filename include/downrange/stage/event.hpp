#pragma once
/// What the engine consumes. Every event says when it was true (`epoch`) and when it reached this node (`received`).
/// Units SI and radians; times UTC. catalogue.hpp lists the events with their topics.

#include <cstdint>
#include <downrange/est/model/measured.hpp>
#include <downrange/geo/frames.hpp>
#include <downrange/geo/name.hpp>
#include <downrange/geo/polar.hpp>
#include <downrange/geo/time.hpp>
#include <string_view>
#include <variant>

namespace downrange {

/// What an instrument's servo does. Order is the wire's: append only.
enum class TrackMode : std::uint8_t {
  Search,
  Acquire,
  Track,
  Coast,
  Slaved,  ///< it points where somebody told it to: no measurement of its own
};
enum class FixType : std::uint8_t { None, TwoDimensional, ThreeDimensional, Differential };
/// Order is the wire's: append only.
enum class MissionEventKind : std::uint8_t { PlannedLiftoff, Liftoff, Staging, Mark, Hold, Recycle };

/// A radar plot: time, space, position information. measured = true + bias + noise.
struct RadarTspi {
  Name sensor;
  Name target;
  std::uint64_t sequence = 0;  ///< counts up per sensor
  Time epoch;
  Time received;
  Polar measured;
  bool range_valid = true;
  bool azimuth_valid = true;
  bool elevation_valid = true;
  double range_rate_m_s = 0;  ///< positive: the target recedes
  bool range_rate_valid = false;
  TrackMode mode = TrackMode::Track;
  double snr_db = 0;
  bool snr_valid = false;
  bool simulated = false;

  bool operator==(const RadarTspi&) const = default;
};

/// Where a telemetry antenna or an optical tracker saw a target: no range. measured = true + bias + noise.
struct AngleTspi {
  Name sensor;
  Name target;
  std::uint64_t sequence = 0;  ///< counts up per sensor
  Time epoch;
  Time received;
  double azimuth_rad = 0;
  double elevation_rad = 0;
  bool azimuth_valid = true;
  bool elevation_valid = true;
  TrackMode mode = TrackMode::Track;
  bool simulated = false;

  bool operator==(const AngleTspi&) const = default;
};

/// A vehicle's own GPS fix as one telemetry ground station relayed it (quick look message).
struct GpsFix {
  Name target;
  Name receiver;               ///< on-board receiver, empty where the vehicle has one
  Name station;                ///< the telemetry station that relayed the fix
  std::uint64_t sequence = 0;  ///< counts up per station
  Time epoch;
  Time received;
  Position<Ecef> position;
  Velocity<Ecef> velocity;
  bool velocity_valid = false;
  double sigma_horizontal_m = 0;  ///< 1-sigma; 0: not stated, the configured value holds
  double sigma_vertical_m = 0;    ///< likewise
  double sigma_velocity_m_s = 0;  ///< likewise, per axis
  FixType fix = FixType::ThreeDimensional;
  std::uint8_t satellites = 0;
  bool satellites_valid = false;  ///< false: their number is not stated
  bool simulated = false;

  bool operator==(const GpsFix&) const = default;
};

/// A mark of the mission clock.
struct MissionEvent {
  Name mission;
  Name label;
  MissionEventKind kind = MissionEventKind::Mark;
  std::uint64_t sequence = 0;
  Time epoch;
  Time received;
  bool simulated = false;

  bool operator==(const MissionEvent&) const = default;
};

/// What an antenna's control unit does. Order is the wire's: append only.
enum class AntennaMode : std::uint8_t { Manual, Program, Slaved, Autotrack };

/// Where an antenna points, as its control unit measures it.
struct AntennaReport {
  Name antenna;
  std::uint64_t sequence = 0;  ///< counts up per antenna
  Time epoch;
  Time received;
  double azimuth_rad = 0;
  double elevation_rad = 0;
  bool azimuth_valid = true;
  bool elevation_valid = true;
  AntennaMode mode = AntennaMode::Manual;
  Time command_tick;  ///< `tick` of the slaving command that it follows; 0: none
  bool simulated = false;

  bool operator==(const AntennaReport&) const = default;
};

/// Where a moving antenna (on a ship, an aircraft) is and how it is turned.
struct PlatformState {
  Name antenna;
  std::uint64_t sequence = 0;  ///< counts up per antenna
  Time epoch;
  Time received;
  Position<Ecef> position;
  Velocity<Ecef> velocity;
  bool velocity_valid = false;
  double heading_rad = 0;  ///< of the antenna's azimuth zero, clockwise from true north
  double sigma_position_m = 0;
  double sigma_heading_rad = 0;
  bool simulated = false;

  bool operator==(const PlatformState&) const = default;
};

/// What an operator may order. Order is the wire's: append only.
enum class OperatorOrder : std::uint8_t {
  Inhibit,           ///< a source: not used
  Release,           ///< a source, a target's chain, an antenna: as without any order
  Force,             ///< a source: nobody may exclude it
  ResetBias,         ///< of a sensor on the ground: begins anew with its prior
  HoldChain,         ///< a target stays on a chain
  PinAntennaSource,  ///< an antenna follows a chain, whatever its target's others follow
  PinAntennaTarget,
  TrimAntenna,       ///< added to an antenna's commands
  StopAntenna,       ///< no commands for an antenna
  AcknowledgeAlarm,  ///< of a source, as long as it lasts
};

/// An operator's order, with name and reason.
struct OperatorCommand {
  Name operator_id;
  OperatorOrder order = OperatorOrder::Release;
  Name subject;   ///< the source, target or antenna it is about
  Name argument;  ///< chain, source or target, where the order has one
  double azimuth_trim_rad = 0;
  double elevation_trim_rad = 0;
  Remark reason;
  std::uint64_t sequence = 0;  ///< counts up per operator
  Time epoch;                  ///< when it was given
  Time received;
  bool simulated = false;

  bool operator==(const OperatorCommand&) const = default;
};

/// Why an observation was accepted or not. Order is the wire's: append only.
enum class Reason : std::uint8_t {
  Accepted,
  UnknownSource,      ///< sensor, station or target not in the configuration
  SimulatedMismatch,  ///< simulated input to a live node, or the reverse
  NotFinite,          ///< NaN or infinity in a used field
  OutOfLimits,        ///< outside the instrument's range or elevation, or no place for a vehicle
  NotTracking,        ///< not in track mode, a plot with neither range nor angles, no three-dimensional fix
  TooLate,            ///< older than fuse.history_s
  FromFuture,         ///< epoch beyond received + ingest.max_future_ms
  Duplicate,          ///< same target, receiver and epoch (+- 1 ms)
  ClockStep,          ///< epoch runs backwards while the sender's sequence runs forwards
  Gated,              ///< innovation outside the method's gate
  Frozen,             ///< a receiver that repeats one fix while the vehicle moves
  NoPosition,         ///< latitude and longitude 0, or the Earth's centre: what receivers say that know nothing
  AwayFromPad,        ///< farther from the pad than pad.radius_m, or than a vehicle may have come since lift-off
  Slaved,             ///< the instrument follows somebody's pointing: no measurement of its own
  Inhibited,          ///< an operator ordered that the source is not used
};
inline constexpr std::size_t reason_count = 16;
/// The reason in snake_case, as logs, screens and archives show it.
[[nodiscard]] std::string_view to_string(Reason reason);

/// A measurement after ingest: accepted, or rejected with its reason. The one thing that crosses from ingest to align.
struct Observation {
  Reason verdict = Reason::Accepted;
  Name sensor;  ///< radar, angles-only tracker, or the telemetry station that relayed the fix
  Name target;
  Name receiver;  ///< of a fix
  std::uint64_t sequence = 0;
  std::uint64_t step = 0;  ///< of the range clock; 0 on the wall clock
  Time epoch;
  Time received;
  Measured measured;
  bool simulated = false;  ///< the flag of the message it came from

  bool operator==(const Observation&) const = default;
};

/// The node's clock went on without its engine: UTC was stepped forward, or the node was stopped. The ticks after
/// `received` and before `epoch` are not run, in replay neither. Of no length: the node is there, and has heard nothing
/// yet, or nothing for long. The node's own record: no topic carries it.
struct ClockGap {
  Time epoch;     ///< where the engine goes on
  Time received;  ///< the last tick run

  bool operator==(const ClockGap&) const = default;
};

/// The order of the alternatives is free; that of catalogue.hpp is the order of processing.
using Event = std::variant<MissionEvent, RadarTspi, GpsFix, Observation, AngleTspi, OperatorCommand, AntennaReport,
                           PlatformState, ClockGap>;

[[nodiscard]] Time received_of(const Event& event);
void set_received(Event& event, Time received);

/// Who an event came from: sensor, station, antenna, mission or operator.
[[nodiscard]] Name source_of(const Event& event);

/// Orders and marks of the mission clock: few, and none may be lost (Delivery::Mark).
[[nodiscard]] bool is_mark(const Event& event);

/// The order of events of equal `received` on the range clock: (topic, source, target, sequence). An Observation
/// ranks where the message it came from ranks, so split and all-in-one nodes order alike.
[[nodiscard]] bool step_order_less(const Event& a, const Event& b);

}  // namespace downrange
