#pragma once
/// Coarse test: do two witnesses see the same target, with nothing known of their biases but what is configured or
/// calibrated? Finds units, signs, folds, wrong sites, seconds; asks no filter.

#include "difference.hpp"

namespace downrange::integrity {

/// What a test of two witnesses says.
struct TestResult {
  double ratio = 0;                  ///< chi2 over its threshold at 1e-6
  double apart_m = 0;                ///< by how much they disagree
  Vec<3> whitened = Vec<3>::Zero();  ///< the disagreement, of unit covariance where there is none
};

/// Position; the samples are of one instant.
[[nodiscard]] TestResult coarse_test(const Witness& first, const Sample& a, const Witness& second, const Sample& b,
                                     const Threshold& threshold);

}  // namespace downrange::integrity
