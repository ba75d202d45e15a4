#pragma once
/// The pad is a surveyed point: until lift-off the vehicle stands there, and what a witness says that stands there with
/// it is right or wrong by itself.

#include <downrange/geo/site.hpp>

#include "coarse_test.hpp"

namespace downrange::integrity {

class PadTest {
 public:
  explicit PadTest(const Site& pad);

  /// The mean of a receiver's last fixes, or a sensor's newest sample with its prior, against the pad. Nothing of a
  /// witness that does not see something stand still, or has fewer than five samples; one of a receiver that tells
  /// its velocity.
  [[nodiscard]] TestResult operator()(const Witness& witness, const Threshold& threshold) const;

 private:
  Site pad_;
  Witness surveyor_;  ///< a receiver on the pad that is right
};

}  // namespace downrange::integrity
