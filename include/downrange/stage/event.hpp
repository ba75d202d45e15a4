#pragma once
/// What the engine consumes. Every event says when it was true (`epoch`) and when it reached this node (`received`).
/// Units SI and radians; times UTC.

#include <array>
#include <cstdint>
#include <string_view>
#include <variant>

#include <downrange/geo/frames.hpp>
#include <downrange/geo/name.hpp>
#include <downrange/geo/polar.hpp>
#include <downrange/geo/time.hpp>

namespace downrange {

enum class TrackMode : std::uint8_t { Search, Acquire, Track, Coast };
enum class FixType : std::uint8_t { None, TwoDimensional, ThreeDimensional, Differential };
enum class MissionEventKind : std::uint8_t { PlannedLiftoff, Liftoff, Staging, Mark };

/// A radar plot: time, space, position information. measured = true + bias + noise.
struct RadarTspi {
  Name sensor;
  Name target;
  std::uint64_t sequence = 0;  ///< counts up per sensor
  Time epoch;
  Time received;
  Polar measured;
  double range_rate_m_s = 0;
  bool range_rate_valid = false;
  TrackMode mode = TrackMode::Track;
  double snr_db = 0;
  bool simulated = false;
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
  TrackMode mode = TrackMode::Track;
  bool simulated = false;
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
  bool satellites_stated = false;  ///< else 0 satellites mean that nothing was said of them
  bool simulated = false;
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
};

/// Which of an observation's payloads is valid. Order is the wire's: append only.
enum class ObservationKind : std::uint8_t { Radar, Gps, Angles };

/// Why an observation was accepted or not. Order is the wire's: append only.
enum class Reason : std::uint8_t {
  Accepted,
  UnknownSource,      ///< sensor, station or target not in the configuration
  SimulatedMismatch,  ///< simulated input to a live node, or the reverse
  NotFinite,          ///< NaN or infinity in a used field
  OutOfLimits,        ///< outside the instrument's range or elevation, or no place for a vehicle
  NotTracking,        ///< radar or tracker not in track mode, receiver without a three-dimensional fix
  TooLate,            ///< older than fuse.history_s
  FromFuture,         ///< epoch beyond received + ingest.max_future_ms
  Duplicate,          ///< same target, receiver and epoch (+- 1 ms)
  ClockStep,          ///< epoch runs backwards while the sender's sequence runs forwards
  Gated,              ///< innovation outside the method's gate
  Frozen,             ///< a receiver that repeats one fix while the vehicle moves
  NoPosition,         ///< latitude and longitude 0, or the Earth's centre: what receivers say that know nothing
  AwayFromPad,        ///< before lift-off, farther from the pad than pad.radius_m
};
inline constexpr std::size_t reason_count = 14;
/// The reason in snake_case, as logs, screens and archives show it.
[[nodiscard]] std::string_view to_string(Reason reason);

/// A measurement after ingest: accepted, or rejected with its reason. The one thing that crosses from ingest to align.
struct Observation {
  ObservationKind kind = ObservationKind::Radar;
  Reason verdict = Reason::Accepted;
  Name sensor;  ///< radar, angles-only tracker, or the telemetry station that relayed the fix
  Name target;
  Name receiver;  ///< GPS only
  std::uint64_t sequence = 0;
  std::uint64_t step = 0;  ///< of the range clock; 0 on the wall clock
  Time epoch;
  Time received;
  Polar measured;           ///< Radar; Angles without the range, which is 0
  Position<Ecef> position;  ///< Gps
  Velocity<Ecef> velocity;  ///< Gps, where velocity_valid
  bool velocity_valid = false;
  double sigma_horizontal_m = 0;  ///< Gps, after the configured default was put in
  double sigma_vertical_m = 0;
  double sigma_velocity_m_s = 0;
  bool simulated = false;  ///< the flag of the message it came from
};

/// The node's clock went on without its engine: UTC was stepped forward, or the node was stopped. The ticks after
/// `received` and before `resumed` are not run, in replay neither. The node's own record: no topic carries it.
struct ClockGap {
  Time received;  ///< the last tick run
  Time resumed;
};

using Event = std::variant<MissionEvent, RadarTspi, GpsFix, Observation, AngleTspi, ClockGap>;

[[nodiscard]] Time received_of(const Event& event);
void set_received(Event& event, Time received);

/// The order of events of equal `received` on the range clock: (topic, source, target, sequence). An Observation
/// ranks where the message it came from ranks, so split and all-in-one nodes order alike.
[[nodiscard]] bool step_order_less(const Event& a, const Event& b);

}  // namespace downrange
