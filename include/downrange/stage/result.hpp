#pragma once
/// What the engine emits. Units SI and radians; positions and velocities ECEF; times UTC.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string_view>
#include <variant>
#include <vector>

#include <downrange/est/model/bias_terms.hpp>
#include <downrange/geo/name.hpp>
#include <downrange/geo/site.hpp>
#include <downrange/geo/time.hpp>
#include <downrange/stage/event.hpp>

namespace downrange {

inline constexpr int max_bias_terms = bias_term_count;
inline constexpr int max_state = 9;

/// Entries of the upper triangle of an n x n matrix.
constexpr int triangle_size(int n) { return n * (n + 1) / 2; }

/// One radar's bias as a method knows it. `terms` entries are used of each array.
struct SensorBias {
  Name sensor;
  Name method;
  Time epoch;     ///< newest radar epoch processed
  Time received;  ///< of the event that caused this record
  BiasReference reference = BiasReference::None;
  std::uint64_t samples = 0;
  int terms = 0;
  std::array<BiasTerm, max_bias_terms> term{};
  std::array<BiasState, max_bias_terms> state{};
  std::array<double, max_bias_terms> value{};
  std::array<double, triangle_size(max_bias_terms)> covariance{};  ///< upper triangle row by row of terms x terms

  bool operator==(const SensorBias&) const = default;
};

enum class TrackQuality : std::uint8_t { Good, Coasting };

/// The fused trajectory at `epoch`. State order: position x y z, velocity x y z, (acceleration x y z when
/// state_size is 9), ECEF.
struct Trajectory {
  Name target;
  Name method;
  bool primary = false;  ///< the method that slaving follows
  Time epoch;
  Time received;
  TrackQuality quality = TrackQuality::Good;
  int state_size = 6;
  std::array<double, max_state> state{};
  std::array<double, triangle_size(max_state)> covariance{};  ///< upper triangle row by row, state_size square
  Geodetic geodetic;
  double speed_m_s = 0;        ///< relative to the Earth
  double flight_path_rad = 0;  ///< up from the local horizontal
  double heading_rad = 0;      ///< clockwise from north, [0, 2 pi)
  /// Bit i: source i contributed within the last second: radars as configured, trackers behind them, then stations
  /// whose fixes the track or its biases go by; those from 64 on left out.
  std::uint64_t sources = 0;
  double nis = 0;  ///< of the newest measurement, chi2 with nis_dof degrees of freedom
  int nis_dof = 0;
  Name chain;          ///< of sources, where the method ran on a part of them; empty: all
  double bound_m = 0;  ///< what one lying source can do to the position, where bound_valid
  bool bound_valid = false;
  std::array<double, 3> deviation_m{};  ///< from the nominal trajectory: along, across, vertical; where deviation_valid
  std::array<double, 3> deviation_sigma_m{};
  bool deviation_valid = false;

  bool operator==(const Trajectory&) const = default;
};

enum class SlavingSource : std::uint8_t { Fused, Coasting, SingleSensor, Gps, Nominal };

/// Why a command is not exactly the look angle. Bits.
enum SlavingLimit : std::uint8_t {
  LimitNone = 0,
  LimitElevation = 1,  ///< elevation held at the end of the antenna's travel: the target is outside it
  LimitAzimuth = 2,    ///< azimuth held at the end of the antenna's travel
  LimitRate = 4,       ///< the antenna's axes are too slow for the commands: it lags behind
  LimitUnwrapped = 8,  ///< azimuth went around since the previous command
  LimitKeyhole = 16,   ///< near the zenith azimuth leads or lags on purpose, within what its axis can do
};

/// Where one antenna shall point at the instant `apply_at`.
struct SlavingCommand {
  Name antenna;
  Name target;
  Time tick;                 ///< the tick that issued it
  Time apply_at;             ///< tick + link delay + lead
  Time valid_until;          ///< an antenna must not follow the command after this
  Time data_epoch;           ///< newest measurement behind it; of a nominal trajectory lift-off, before that the tick
  double age_s = 0;          ///< apply_at - data_epoch
  double azimuth_rad = 0;    ///< unwrapped, within the antenna's travel
  double elevation_rad = 0;  ///< beyond 90 deg: over the zenith, azimuth is then that of the back
  double range_m = 0;
  double azimuth_rate_rad_s = 0;  ///< 0 where the axis is held at the end of its travel, elevation likewise
  double elevation_rate_rad_s = 0;
  double range_rate_m_s = 0;
  double sigma_azimuth_rad = 0;  ///< 1-sigma of the axis angle; times cos elevation is on the sky
  double sigma_elevation_rad = 0;
  SlavingSource source = SlavingSource::Fused;
  std::uint8_t limits = LimitNone;
  double azimuth_acceleration_rad_s2 = 0;  ///< where acceleration_valid, elevation likewise
  double elevation_acceleration_rad_s2 = 0;
  bool acceleration_valid = false;
  double probability_in_beam =
      0;  ///< that the target is, by its covariance and off_target_rad; where probability_valid
  bool probability_valid = false;
  double bound_rad = 0;  ///< what one lying source can do to the pointing, where bound_valid
  bool bound_valid = false;
  /// On the sky, between the target and where the antenna can be: what is left of a blend, what the end of its travel,
  /// its rates and accelerations cost.
  double off_target_rad = 0;
  Name chain;  ///< of sources, where it is not all of them
  /// The mount's own pointing error as found from what it read while it tracked: both angles have it added.
  double mount_azimuth_rad = 0;
  double mount_elevation_rad = 0;

  bool operator==(const SlavingCommand&) const = default;
};

/// Why a pass is where it is said to be. Order is the wire's: append only.
enum class PassBasis : std::uint8_t {
  FreeFall,        ///< as the target flies on without thrust
  Plan,            ///< its nominal trajectory, moved to where it is
  PlannedLiftoff,  ///< the same, with lift-off when it is planned: it stands on the pad
};

/// One antenna's account: what operators have ordered of it, and when it sees its target, that is, above its horizon
/// and the lower end of its elevation travel.
struct AntennaAccount {
  Name antenna;
  Name target;  ///< that it follows
  Time tick;
  Remark orders;            ///< of operators that stand, with who and why; cut at its end; empty: none
  bool pass_valid = false;  ///< it is known when it sees its target; else what follows means nothing
  PassBasis basis = PassBasis::FreeFall;
  bool in_view = false;                ///< at `tick`; acquisition has been
  bool acquisition_valid = false;      ///< false: it is in view, or will not be within the prediction
  Time acquisition;                    ///< of signal
  double acquisition_azimuth_rad = 0;  ///< [0, 2 pi)
  bool loss_valid = false;             ///< false: it does not come into view, or is still seen when the prediction ends
  Time loss;                           ///< of signal, after the acquisition
  double loss_azimuth_rad = 0;
  bool highest_valid = false;        ///< it is, or comes, into view
  double highest_elevation_rad = 0;  ///< of the rest of the pass, refraction included
  Time highest;

  bool operator==(const AntennaAccount&) const = default;
};

/// What INTEGRITY thinks of a source. Order is the wire's: append only.
enum class IntegrityVerdict : std::uint8_t { Agrees, Suspect, Excluded, Ambiguous };

/// What speaks most against a source. Order is the wire's: append only.
enum class Finding : std::uint8_t {
  None,
  CoarsePosition,  ///< tracks of disjoint or nested sets of sources differ
  CoarseVelocity,
  FinePosition,     ///< a fix against a radar's plots, or radar against radar, with the biases of seconds ago
  Clock,            ///< on the same path, but at another time
  ImplausibleBias,  ///< what was learnt of its bias is far outside what was assumed
  CommonBias,       ///< the same term in all radars: it is the GPS's
  DifferingCopy,    ///< stations relay one fix differently
  OffPad,           ///< before lift-off it does not see the vehicle where the pad is
  Impossible,       ///< no vehicle does that: it repeats one position
};

/// One source of a target, as INTEGRITY judges it.
struct SourceIntegrity {
  Name sensor{};
  IntegrityVerdict verdict = IntegrityVerdict::Agrees;
  Finding why = Finding::None;
  Time since{};               ///< of this verdict
  Time onset{};               ///< it disagreed no later than this; 0: it does not
  double test_value = 0;      ///< of the test that speaks most against it, in units of its threshold
  std::uint64_t against = 0;  ///< bit i: it disagrees with sources[i] of the record
  double apart_m = 0;         ///< how far from these; m/s where `why` is of a velocity, s where of a clock
  double agree_m = 0;         ///< how far these are from each other; 0: one alone, or not known
  Name by{};                  ///< "integrity", or the operator who ordered it; empty where nobody did

  bool operator==(const SourceIntegrity&) const = default;
};

/// Which sources of a target agree, who is excluded, and how far one lying source can move the track.
struct Integrity {
  Name target;
  Time time;     ///< the tick that judged
  Time liftoff;  ///< announced or found from motion, where liftoff_valid
  bool liftoff_valid = false;
  Name chain;          ///< selected: empty, "without-NAME" or "only-NAME"
  Name held_by;        ///< the operator who holds the target on `chain`; empty: INTEGRITY selects
  double bound_m = 0;  ///< where bound_valid; else nothing bounds what one lie can do
  bool bound_valid = false;
  std::uint64_t events = 0;              ///< counts up with every change of a verdict or of the chain
  std::vector<SourceIntegrity> sources;  ///< those that report the target, in the order of the source table

  bool operator==(const Integrity&) const = default;
};

/// An impact point, and the present place, against one boundary.
struct BoundaryDistance {
  Name boundary{};
  double distance_m = 0;           ///< of the impact point, along the ground; positive inside
  double present_distance_m = 0;   ///< of the point below the target, likewise
  double time_s = 0;               ///< until the impact point, going on as it moves now, crosses it; where time_valid
  bool time_valid = false;         ///< it moves, by more than three sigmas of its velocity, and towards the boundary
  double probability_outside = 0;  ///< of the impact point, by its covariance

  bool operator==(const BoundaryDistance&) const = default;
};

/// Where a target falls when its engines stop at `epoch`: in vacuum, over the rotating ellipsoid.
struct ImpactPoint {
  Name target;
  Name chain;                 ///< of sources: empty, the selected one; else one that is independent of others
  Time epoch;                 ///< the tick
  Time received;              ///< likewise
  bool impact_valid = false;  ///< false: there is no estimate, or it does not come down
  Geodetic point;             ///< where impact_valid, as the next two
  double time_to_impact_s = 0;
  std::array<double, 3> covariance_m2{};  ///< east-east, east-north, north-north, at the impact point
  double data_age_s = 0;                  ///< of the newest measurement behind the estimate; 0: there is none
  double data_loss_timer_s = 0;           ///< since the chain's last accepted measurement, by its epoch
  double data_loss_limit_s = 0;           ///< at this T+, where data_loss_limit_valid
  bool data_loss_limit_valid = false;     ///< a limit is configured, and the vehicle has lifted off
  /// In the order of the configuration; empty without an estimate. What is of the impact point, only where
  /// impact_valid.
  std::vector<BoundaryDistance> boundaries;

  bool operator==(const ImpactPoint&) const = default;
};

/// Why a source is not qualified. Order is the wire's: append only.
enum class Disqualification : std::uint8_t {
  None,
  Silent,     ///< nothing came for three of its nominal periods (a second at least), of GPS for align.gps_max_age
  Rejected,   ///< all its messages for some seconds, or its receiver is frozen, or it is not configured
  Inhibited,  ///< by an operator
  Excluded,   ///< by INTEGRITY
};

using SigmaRatios = std::array<double, 4>;

/// Running account of one source at one node.
struct SourceHealth {
  Name sensor;
  Name target;
  Time time;
  double rate_hz = 0;                               ///< messages over the last second
  double latency_s = 0;                             ///< received - epoch, running mean
  std::array<std::uint64_t, reason_count> count{};  ///< by Reason; [Accepted] is what stands after the method's gate
  double residual_mean = 0;                         ///< of the normalised innovations, running
  double residual_sigma = 0;                        ///< 1 when noise and covariance are right
  /// In units: root mean square of what the source differs from the track, over about ten seconds, and beside each what
  /// noise and covariance let expect. A radar's range, a fix's position per axis. 0 where nothing of that kind was
  /// weighed.
  double residual_m = 0;
  double expected_m = 0;
  double residual_rad = 0;  ///< angles, on the sky, per axis
  double expected_rad = 0;
  /// What the method has learnt of the source's noise, as 1-sigma over the configured one: of range, azimuth,
  /// elevation, range rate; of a receiver's horizontal and vertical position and velocity. 0: nothing of that.
  SigmaRatios sigma_ratio{};
  double nis = 0;                                 ///< running mean over degrees of freedom; 1 when right
  bool qualified = false;                         ///< delivering and not mostly rejected
  Disqualification why = Disqualification::None;  ///< it is not qualified
  Reason rejected_for = Reason::Accepted;         ///< of the newest message, where `why` is Rejected
  double nis_inside_95 = 1;  ///< share of the last `nis_count` NIS inside their 95 % region: 0.95 when right
  int nis_count = 0;         ///< up to the mismatch alarm's window; 0: nothing was weighed, the share says nothing
  /// The mismatch alarm rings: what the filter assumes of this source (most often its bias blocks) is wrong. The source
  /// stays qualified and in use.
  bool mismatch = false;
  bool suspect = false;  ///< INTEGRITY doubts it, and does not exclude it
  bool forced = false;   ///< an operator's order: INTEGRITY may not exclude it
  Time since;            ///< it is so since: qualified, suspect, or not qualified for what `why` says
  Name by;               ///< who says so: "integrity" or an operator; empty: the account itself
  Remark reason;         ///< the operator's
  Name acknowledged_by;  ///< who has seen that it is not qualified, suspect or mismatched; empty: nobody

  bool operator==(const SourceHealth&) const = default;
};

/// Why it is not qualified, in snake_case: "silent", or the reason of its rejection. Empty where it is, or none is
/// known.
[[nodiscard]] std::string_view why_not_qualified(const SourceHealth& health);

/// How far the source may be relied on, in one figure: 0, it is not qualified; else the share of its newest NIS inside
/// their 95 % region over that which is right, at most 1, over the largest of its learnt sigma ratios, at least 1.
[[nodiscard]] double figure_of_merit(const SourceHealth& health);

using Result = std::variant<Observation, SensorBias, Trajectory, Integrity, SlavingCommand, AntennaAccount, ImpactPoint,
                            SourceHealth>;

/// Receives results in the order the engine made them. Called from the engine's thread; must not throw.
class ResultSink {
 public:
  virtual ~ResultSink() = default;
  virtual void emit(const Result& result) = 0;
};

}  // namespace downrange
