#pragma once
/// What two witnesses say of the same instant, held against each other: where the first one says the target is, as the
/// second one would measure it.

#include <downrange/est/model/matrix.hpp>
#include <optional>

#include "witness.hpp"

namespace downrange::integrity {

using BiasVector = Vec<bias_term_count>;

/// Second minus first, in the second's coordinates: range (m), azimuth, elevation (rad), or ECEF (m).
struct Difference {
  Vec<3> d = Vec<3>::Zero();
  Mat<3, 3> white = Mat<3, 3>::Zero();       ///< covariance of the noise of both, medians taken into account
  Mat<3, 3> slow_first = Mat<3, 3>::Zero();  ///< stationary covariance of what varies slowly
  Mat<3, 3> slow_second = Mat<3, 3>::Zero();
  Mat<3, bias_term_count> by_first = Mat<3, bias_term_count>::Zero();  ///< d(d)/d(bias)
  Mat<3, bias_term_count> by_second = Mat<3, bias_term_count>::Zero();
  Vec<3> to_metres = Vec<3>::Ones();  ///< of each coordinate
  bool ranged = true;                 ///< false: the first coordinate means nothing
};

/// `first` tells a position. None where the geometry has no answer (a plot at its own site).
[[nodiscard]] std::optional<Difference> difference(const Witness& first, const Sample& a, const BiasVector& bias_a,
                                                   const Witness& second, const Sample& b, const BiasVector& bias_b);

/// Where a sensor saw the target, as its scale of azimuth counts, (-pi, pi]. `by`: d(d)/d(bias) of that sensor. 0 for a
/// receiver.
[[nodiscard]] double azimuth_from_south(const Mat<3, bias_term_count>& by);

/// What to add to the covariance of a difference where it cannot be told on which side of north a sensor saw the
/// target: the scale of azimuth counts from south, so that what it does jumps there by a full turn.
/// Zero elsewhere, and for a receiver.
[[nodiscard]] Mat<3, 3> north_jump(const Mat<3, bias_term_count>& by, const KnownBias& bias);

/// d' S^-1 d over the coordinates that mean something, as a multiple of its threshold; infinity where S is not positive
/// definite or d not finite. `whitened`, if given, receives L^-1 d, S = L L'.
class Threshold {
 public:
  Threshold();
  [[nodiscard]] double ratio(const Vec<3>& d, const Mat<3, 3>& S, bool ranged, Vec<3>* whitened = nullptr) const;
  [[nodiscard]] double chi2(bool ranged) const { return ranged ? three_ : two_; }

 private:
  double three_;
  double two_;
};

/// Where a witness says that the target is, its bias taken as zero. None: it tells directions only.
[[nodiscard]] std::optional<Position<Ecef>> told_position(const Witness& witness, const Sample& sample);

/// Where a bias makes a radar see a target that is where the sample says, m, ECEF, from the truth.
[[nodiscard]] Vec<3> displacement(const Witness& radar, const Sample& sample, const BiasVector& bias);

/// Angles of `d` wrapped, where `second` measures angles.
[[nodiscard]] Vec<3> wrapped(const Witness& second, Vec<3> d);

/// Covariance of a receiver's noise, ECEF, m^2.
[[nodiscard]] Mat<3, 3> fix_noise(const Vec<3>& position, double sigma_horizontal_m, double sigma_vertical_m);

}  // namespace downrange::integrity
