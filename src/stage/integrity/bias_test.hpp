#pragma once
/// Plausibility of what GPS taught of the radars' biases: posterior against prior, per block of terms. What is beyond
/// belief in one radar is that radar's; the same in all radars is the receiver's (its clock, its datum).

#include <array>
#include <downrange/est/filter/estimates.hpp>
#include <span>
#include <vector>

#include "difference.hpp"

namespace downrange::integrity {

/// One sensor's bias against its prior.
struct BiasPlausibility {
  double ratio = 0;  ///< of the least plausible block, chi2 over its threshold at 1e-6
  BiasBlock block = BiasBlock::Polar;
  double value = 0;  ///< of that block's least plausible term, in prior sigmas
  BiasTerm term = BiasTerm::OffsetRange;
};

class BiasTest {
 public:
  BiasTest();

  /// Nothing, unless the sensor's bias was learnt from GPS.
  [[nodiscard]] BiasPlausibility plausibility(const BiasModel& prior, const BiasEstimate& bias) const;

 private:
  std::array<double, 7> threshold_{};  ///< by degrees of freedom
};

/// Where the biases of all sensors move the target, along the same way: the displacement is the reference's, not
/// theirs. `displacement`: of each sensor, m, ECEF, at the target.
[[nodiscard]] bool common_to_all(std::span<const Vec<3>> displacement);

}  // namespace downrange::integrity
