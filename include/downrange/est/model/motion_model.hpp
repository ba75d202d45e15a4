#pragma once
/// How a vehicle moves: the models of est/THEORY.md section 2 on one state of nine entries, ECEF: position (m),
/// velocity (m/s), and a third part in m/s^2 that is the acceleration, or the specific force where gravity is known to
/// the model.

#include <cstdint>
#include <downrange/est/model/matrix.hpp>

namespace downrange {

/// One motion model.
struct MotionModel {
  enum class Noise : std::uint8_t { WhiteAcceleration, WhiteJerk };

  Noise noise = Noise::WhiteJerk;
  double q = 10;  ///< power spectral density: m^2/s^3 of acceleration, m^2/s^5 of jerk
  /// J2 gravity, Coriolis and centrifugal acceleration are known: the third part of the state is the specific force.
  bool gravity_aware = false;
};

/// The mean after dt seconds (either sign); the free-fall acceleration is taken at the middle of steps of at most 1 s.
[[nodiscard]] Vec<9> predict_mean(const MotionModel& model, const Vec<9>& x, double dt);

/// Process noise over |dt| as the coefficients of 3 x 3 identity blocks (position, velocity, third part squared); for
/// dt < 0 the signs of a prediction towards the past.
[[nodiscard]] Mat<3, 3> process_noise(const MotionModel& model, double dt);

/// Mean and covariance after dt seconds (either sign).
[[nodiscard]] Gaussian<9> predict(const MotionModel& model, const Gaussian<9>& x, double dt);

/// A motion between two instants at which it is known: x(t) = from x(before) + to x(after) + noise, as coefficients of
/// 3 x 3 identity blocks. Of a model that is not gravity-aware, with white jerk.
struct Bridge {
  Mat<3, 3> from;
  Mat<3, 3> to;
  Mat<3, 3> noise;  ///< covariance
};
/// `since_before`, `until_after` >= 0 s, their sum > 0.
[[nodiscard]] Bridge bridge(const MotionModel& model, double since_before, double until_after);

/// Acceleration relative to the rotating Earth, m/s^2.
[[nodiscard]] Vec<3> acceleration(const MotionModel& model, const Vec<9>& x);

}  // namespace downrange
