#pragma once
/// Are the covariances of the fused track honest: many seeds of named profiles through the service's engine, everything
/// drawn from what the configuration assumes (est/THEORY.md section 4a).

#include <cstdint>
#include <downrange/est/model/sensors.hpp>
#include <downrange/stage/event.hpp>
#include <downrange/stage/range_config.hpp>
#include <span>
#include <string>
#include <vector>

#include "experiment/experiment.hpp"
#include "experiment/flights_replay.hpp"
#include "score/errors.hpp"
#include "score/truth.hpp"

namespace downrange::experiment {

namespace honesty {

/// Seconds of one entry of Track::share.
inline constexpr double bin_s = 10;

/// What is flown: a truth at a range, with nothing of its sensors fixed but their settings.
struct Profile {
  std::string name;
  RangeConfig range;
  Name target;
  Time liftoff;
  double end_s = 0;        ///< of the flight, after lift-off
  double gps_rate_hz = 1;  ///< fixes of the receiver
  score::TruthFunction truth;
};

/// Two radars at Naro: the launch of est/THEORY.md section 10 from lift-off on, and a satellite at 400 km.
[[nodiscard]] Profile launch_profile();
[[nodiscard]] Profile orbit_pass_profile();
/// The truth of a recorded flight at its range, with everything drawn anew.
[[nodiscard]] Profile profile_of(const flights::RecordedFlight& flight);

/// Of a source that told the truth.
struct Exclusion {
  std::uint64_t seed = 0;
  Name source;
  double at_s = 0;  ///< after lift-off
};

/// Position errors of the primary method on ticks twice a second, of one or more seeds.
struct Track {
  score::Share inside;                     ///< the 95 % region
  std::vector<score::Share> share{};       ///< the same in bins of 10 s from lift-off
  std::vector<score::Squares> error{};     ///< likewise; metres
  std::vector<score::Squares> promised{};  ///< likewise: the trace of the covariance
  score::Squares nees;                     ///< its sum and count: mean NEES is sum / count
  score::Squares position;                 ///< metres
  std::vector<double> shares{};            ///< of each seed that has a track
  int without_track = 0;                   ///< seeds
  std::vector<Exclusion> excluded{};       ///< the first of each seed where INTEGRITY excluded a source: none lied

  Track& operator+=(const Track& other);
  [[nodiscard]] double nees_per_dof() const { return nees.sum / static_cast<double>(nees.count) / 3; }
  /// Of the mean of the seeds' shares.
  [[nodiscard]] double standard_error() const;
};

/// The true bias of a radar is drawn from the prior that is in force with or without GPS, as its wander is; white noise
/// has the sigma that the filter is told, inflation included; GPS has the configured noise and the slow error of the
/// filter's model. Nothing is late by more than 0.3 s, nothing is lost.
[[nodiscard]] Track fly(const Profile& profile, bool gps, std::uint64_t seed);

/// What `fly` flies: its messages in order of arrival, and the range with ticks alone and no antennas.
[[nodiscard]] std::vector<Event> events_of(const Profile& profile, bool gps, std::uint64_t seed);
[[nodiscard]] RangeConfig range_of(const Profile& profile);
/// The radars as the methods are told of them, with the priors and the wander in force.
[[nodiscard]] std::vector<RadarModel> radars_in_force(const RangeConfig& range, bool gps);
/// The runs of one seed do not overlap those of the next.
[[nodiscard]] std::uint64_t seed_of_run(std::uint64_t seed, int run);

}  // namespace honesty

/// launch, the truths of `recorded`, orbit_pass.
[[nodiscard]] std::vector<honesty::Profile> honesty_profiles(std::span<const flights::RecordedFlight> recorded);

/// Over honesty_profiles. Throws std::invalid_argument for a method that is not compared.
[[nodiscard]] ExperimentResult run_honesty(const ExperimentOptions& options,
                                           std::span<const flights::RecordedFlight> recorded);

/// The one that is compared: the service's default.
[[nodiscard]] const std::vector<std::string>& honesty_methods();
inline constexpr int honesty_runs = 200;

/// Without GPS: how near two radars that calibrate each other come to the best that is possible, and whether one alone
/// is harmed (est/without-gps.md). Profiles as of run_honesty.
[[nodiscard]] ExperimentResult run_without_gps(const ExperimentOptions& options,
                                               std::span<const flights::RecordedFlight> recorded);
inline constexpr int without_gps_runs = 20;

}  // namespace downrange::experiment
