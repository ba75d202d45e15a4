#pragma once
/// The methods that the experiment of kim2011 compares, each over one run.

#include <array>
#include <vector>

#include "experiment/kim2011_scenario.hpp"

namespace downrange::experiment::kim2011 {

/// Error of a track as the paper draws it, squared: position m^2, velocity m^2/s^2.
struct TrackError {
  double position = 0;
  double velocity = 0;
};

/// What one method knew after each scan 1 ... scans; entry 0 is the start. Sums over runs are of the same type.
struct Trace {
  struct Scan {
    Vec<biases> square = Vec<biases>::Zero();    ///< of the error, estimate minus truth
    Vec<biases> variance = Vec<biases>::Zero();  ///< as claimed
    double nees = 0;                             ///< chi2(biases) if the covariance is honest
    double inside = 0;                           ///< 1 where that is below its 95 % quantile
    /// Track 1 (nearest to sensor 1) and 32 (farthest), of sensor 1 where a method has tracks of single sensors.
    std::array<TrackError, 2> biased{};
    std::array<TrackError, 2> compensated{};
  };
  std::vector<Scan> scan = std::vector<Scan>(scans + 1);

  Trace& operator+=(const Trace& other);
};
inline constexpr std::array<std::size_t, 2> shown_tracks{0, targets - 1};

/// How a target's track begins: from an estimate without bias that somebody provides (the paper's comparison), or from
/// plots.
enum class Start { BiasFree, Data };

/// Pseudo measurements against the other sensor's tracks, noise times `noise_factor`.
[[nodiscard]] Trace run_pm(const Draw& draw, Start start, double noise_factor);

/// Parity vectors of slots in which every sensor measures twice. Starts from plots by its nature and has no tracks.
[[nodiscard]] Trace run_exx(const Draw& draw);

/// Two-stage. BiasFree: the start is the mean of the starts that `run_pm` gives to its two tracks.
[[nodiscard]] Trace run_ts(const Draw& draw, Start start);

/// The augmented-state filter linearised along the truth: `variance` is the bound.
[[nodiscard]] Trace run_bound(const Draw& draw, Start start);

/// Largest difference, in sigma, between `ts` and the augmented-state filter over all states and scans of a run with a
/// bias-free start, each linearised at its own estimate; of means and of standard deviations.
[[nodiscard]] double ts_against_augmented(const Draw& draw);

}  // namespace downrange::experiment::kim2011
