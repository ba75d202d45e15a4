#pragma once
/// Is a filter's covariance honest: chi-square bands and running innovation statistics.

namespace downrange {

/// x with P(chi2(dof) <= x) = probability; infinity for probability 1. dof >= 1, 0 < probability <= 1. Boost.Math.
[[nodiscard]] double chi2_quantile(double probability, int dof);

/// Exponentially forgetting statistics of one source's innovations. Plain values: part of a filter's checkpoint.
struct RunningResidual {
  double mean = 0;         ///< of the innovation components, normalised by their 1-sigma
  double mean_square = 1;  ///< of the same
  double nis_per_dof = 1;  ///< 1 when noise and covariance are right
  bool started = false;

  /// `normalised` = mean of nu_i / sqrt(S_ii); `square` = mean of their squares; weight of the newest 1/50.
  void add(double normalised, double square, double nis_over_dof);
};

}  // namespace downrange
