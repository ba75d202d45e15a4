#pragma once
/// Plausibility of what GPS taught of the radars' biases: posterior against prior, per block of terms. What is beyond
/// belief in one radar is that radar's; the same in all radars is the receiver's (its clock, its datum).

#include <array>
#include <downrange/est/filter/estimates.hpp>
#include <span>
#include <vector>

#include "difference.hpp"
#include "identification.hpp"

namespace downrange::integrity {

/// One sensor's bias against its prior.
struct BiasPlausibility {
  double ratio = 0;  ///< of the least plausible block, chi2 over its threshold: ten times the quantile at 1e-6
  BiasBlock block = BiasBlock::Polar;
  double value = 0;  ///< of that block's least plausible term, in prior sigmas
  BiasTerm term = BiasTerm::OffsetRange;
};

/// What GPS taught of one radar.
struct LearntBias {
  int witness = 0;
  BiasPlausibility plausibility;
  bool implausible = false;                         ///< and that lasts
  std::array<double, bias_term_count> excess{};     ///< of each term, in prior sigmas
  std::array<double, bias_term_count> ignorance{};  ///< posterior sigma over prior sigma; 1 of what is not estimated
  Vec<3> displacement = Vec<3>::Zero();             ///< where the bias moves the target, m, ECEF, at the target
};

class BiasTest {
 public:
  BiasTest();

  /// `witness` and `displacement` are left to the caller. Nothing implausible, unless the bias was learnt from GPS.
  [[nodiscard]] LearntBias operator()(const BiasModel& prior, const BiasEstimate& bias) const;

 private:
  [[nodiscard]] BiasPlausibility plausibility(const BiasModel& prior, const BiasEstimate& bias) const;

  std::array<double, 7> threshold_{};  ///< by degrees of freedom
};

/// Whose fault implausible biases are.
struct BiasBlame {
  bool receivers = false;   ///< all radars would be biased the same way: their reference is
  WitnessSet radars = 0;    ///< another one, taught by the same reference, is as it should be
  WitnessSet disputed = 0;  ///< radars of which nobody can tell
};
[[nodiscard]] BiasBlame blame(std::span<const LearntBias> radars);

/// The clocks of all radars would be off alike, each perhaps within belief, together beyond it: chi2 of their mean over
/// its threshold, and how far that moves the target. Then it is the receiver's clock. Nothing of fewer than two radars.
struct CommonClock {
  double ratio = 0;
  double apart_m = 0;
};
[[nodiscard]] CommonClock common_clock(std::span<const LearntBias> radars);

}  // namespace downrange::integrity
