#pragma once
/// Nearly-constant-velocity motion in three axes, state [position x y z m, velocity x y z m/s], any Cartesian frame.

#include <downrange/est/model/matrix.hpp>

namespace downrange::cv {

/// Transition over dt seconds (dt may be negative: towards the past).
[[nodiscard]] Mat<6, 6> transition(double dt);

/// Process noise over |dt| of white acceleration with power spectral density q in m^2/s^3 (song2015 eq. 4).
[[nodiscard]] Mat<6, 6> process_noise(double dt, double q);

/// Prediction by dt seconds.
[[nodiscard]] Gaussian<6> predict(const Gaussian<6>& x, double dt, double q);

}  // namespace downrange::cv
