#pragma once
/// Faults as data: what is done to which sources' messages, and when. The same code plays them on simulated flights and
/// on recorded ones; nothing here needs to know the truth (README.md, "Faults").

#include <Eigen/Core>
#include <cstdint>
#include <downrange/stage/event.hpp>
#include <downrange/stage/range_config.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "score/fault_judge.hpp"
#include "sim/scenario.hpp"

namespace downrange::sim {

// ---- what is done to a message. Lengths in the east-north-up axes at the place that the message tells.

/// It is not sent.
struct Silence {};

/// The place is another one: a plot's, or a fix's.
struct Displace {
  Eigen::Vector3d offset_enu_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d drift_enu_m_s = Eigen::Vector3d::Zero();  ///< grows from the action's begin on
  bool velocity_too = false;                                ///< a fix's velocity has the drift
};

/// What a radar or tracker measures: factor * measured + offset; azimuth and elevation of a tracker.
struct Distort {
  Polar factor{1, 1, 1};
  Polar offset;
  double range_fold_m = 0;  ///< range is told modulo this; 0: as it is
};

/// The clock of whoever stamps: positive, it is fast. Fixes and plots.
struct Clock {
  double offset_s = 0;
  double drift = 0;  ///< seconds per second, from the action's begin on
};

/// The receiver repeats its newest fix from before.
struct Freeze {
  bool velocity_lives = false;  ///< the position alone is frozen
  double noise_m = 0;           ///< 1-sigma per axis: not to the bit
};

/// The receiver carries its newest fix from before on at its velocity.
struct DeadReckon {};

/// A fix's velocity times this.
struct VelocityFactor {
  double factor = 1;
};

/// The accuracy that a fix states.
struct StateSigma {
  double position_m = 0;
  double velocity_m_s = 0;
};

/// Each fix comes once more, from another receiver of the vehicle.
struct SecondReceiver {
  Name receiver;
  Eigen::Vector3d offset_enu_m = Eigen::Vector3d::Zero();
};

/// Outliers: the first `lasts_s` of each `every_s`, each plot with `probability`, 0.5 to 1.5 times the sizes either
/// way.
struct Bursts {
  double every_s = 10;
  double lasts_s = 2;
  double probability = 1;
  double range_m = 0;
  double angle_rad = 0;
};

/// Elevations below `below_rad` swing by amplitude * sin(2 pi elevation / period).
struct Multipath {
  double amplitude_rad = 0;
  double period_rad = 0;
  double below_rad = 0;
};

/// The vehicle is in pieces, which move away at random; each plot is of one of them, for `dwell_s` of the same.
struct Pieces {
  int count = 5;
  double speed_m_s = 50;
  double dwell_s = 1;
};

/// Each plot comes once more, of another target that moves away from the vehicle.
struct SecondTarget {
  std::string target;
  Eigen::Vector3d drift_enu_m_s = Eigen::Vector3d::Zero();
};

/// Messages of one target say the other, and the reverse.
struct SwapTargets {
  std::string target;
  std::string with;
};

/// Plots say that they are of another radar; `mutual`: and the reverse.
struct SwapSensors {
  std::string with;
  bool mutual = false;
};

/// The countdown is held and begun again: the first plan is `delay_s` earlier.
struct Recycle {
  double delay_s = 600;
  double hold_before_s = 60;  ///< before the first planned lift-off
  double hold_s = 30;         ///< until the new plan is told
};

using FaultEffect =
    std::variant<Silence, Displace, Distort, Clock, Freeze, DeadReckon, VelocityFactor, StateSigma, SecondReceiver,
                 Bursts, Multipath, Pieces, SecondTarget, SwapTargets, SwapSensors, Recycle>;

struct FaultAction {
  /// Names, "radar:N", "tracker:N", "station:N" (the N-th configured, from 1), "radars", "trackers", "gps" (all
  /// stations), "all".
  std::vector<std::string> sources;
  double after_s = 0;               ///< begins so long after the fault
  std::optional<double> lasts_s{};  ///< none: as the fault
  FaultEffect effect;
  int line = 0;  ///< of the catalogue's file
};

/// A flight other than the catalogue's.
struct FlightVariant {
  std::string name;
  std::optional<double> start_s{};  ///< and the first message of every source that has none of its own
  std::optional<double> end_s{};
  std::vector<std::pair<std::string, double>> track_from_s{};  ///< by "radar:N" or name
  std::optional<double> cutoff_s{};                            ///< no burn after it
  std::vector<Push> pushes{};
  double ballistic_kg_m2 = 0;  ///< as LaunchProfile, the next likewise
  std::optional<Hop> hop{};
};

struct Fault {
  std::string name;
  std::string what;    ///< one sentence for people
  std::string flight;  ///< of the catalogue; empty: the scenario as it is
  std::vector<double> begin_s;
  std::optional<double> lasts_s;  ///< none: for good
  std::vector<int> radars;        ///< flown with so many, the first of the range
  std::vector<FaultAction> actions;
  std::vector<std::string> liars;  ///< as FaultAction::sources
  score::FaultLimits expected;
  int line = 0;
};

struct FaultCatalogue {
  std::filesystem::path file;
  std::filesystem::path scenario;  ///< what the experiment flies; empty: not given
  std::filesystem::path range;
  std::vector<FlightVariant> flights;
  std::vector<Fault> faults;

  /// The one of this name; of an empty name the only one. Throws ScenarioError that tells which there are.
  [[nodiscard]] const Fault& find(const std::string& name) const;
  /// Null for a fault without a flight of its own.
  [[nodiscard]] const FlightVariant* flight_of(const Fault& fault) const;
};

/// Throws ScenarioError (file, line, key, what is allowed).
[[nodiscard]] FaultCatalogue load_faults(const std::filesystem::path& file);

/// The scenario as this variant flies it.
[[nodiscard]] Scenario flown_as(Scenario scenario, const FlightVariant& variant, const RangeConfig& range);

/// Nothing is sent after `end_s`; where it is later than the scenario's end, what went on to the end goes on.
void end_at(Scenario& scenario, double end_s);

/// The range's sources that are meant, in its order; none where the range has none of these. Throws ScenarioError for a
/// word that is neither a pattern nor a source of the range.
[[nodiscard]] std::vector<Name> sources_meant(const std::vector<std::string>& words, const RangeConfig& range,
                                              const std::string& where);

struct Injection {
  const RangeConfig& range;
  Time liftoff;
  double begin_s = 0;  ///< of the fault, after lift-off
  std::uint64_t seed = 1;
};

struct Injected {
  std::vector<Event> events;  ///< in order of `received`
  std::size_t touched = 0;    ///< messages changed, added or left out
};

/// What arrives with the fault in it. `events` are in order of `received`; observations that another node judged pass
/// as they are. Same input, same output. Throws ScenarioError for sources and targets that the range does not have.
[[nodiscard]] Injected inject(const FaultCatalogue& catalogue, const Fault& fault, const Injection& how,
                              std::vector<Event> events);

}  // namespace downrange::sim
