#pragma once
/// What an estimator tells of a target and of a radar.

#include <array>
#include <cstdint>
#include <downrange/est/model/bias_terms.hpp>
#include <downrange/est/model/matrix.hpp>
#include <downrange/geo/time.hpp>

namespace downrange {

/// A target's state with covariance, ECEF. Entries beyond `size` are unused.
struct TrackEstimate {
  Time epoch;       ///< the estimate's instant
  Time data_epoch;  ///< newest measurement behind it
  int size = 6;     ///< 6: position, velocity; 9: and acceleration
  Vec<9> mean = Vec<9>::Zero();
  Mat<9, 9> cov = Mat<9, 9>::Zero();
  std::uint64_t sources = 0;  ///< bit i: source i contributed within the last second before data_epoch
  double nis = 0;             ///< of the newest measurement
  int nis_dof = 0;
};

/// A radar's bias with covariance. `terms` entries are used.
struct BiasEstimate {
  static constexpr int max_terms = bias_term_count;

  Time epoch;  ///< newest plot of this radar that was processed
  BiasReference reference = BiasReference::None;
  std::uint64_t samples = 0;
  int terms = 0;
  std::array<BiasTerm, max_terms> term{};
  std::array<BiasState, max_terms> state{};
  Vec<max_terms> value = Vec<max_terms>::Zero();
  Mat<max_terms, max_terms> cov = Mat<max_terms, max_terms>::Zero();
};

}  // namespace downrange
