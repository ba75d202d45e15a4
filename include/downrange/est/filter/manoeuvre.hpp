#pragma once
/// Kinematics `vdie` inside a filter of many states: constant velocity until input estimation detects an acceleration,
/// then with that acceleration in the state until it has become insignificant.

#include <downrange/est/filter/hypothesis.hpp>
#include <downrange/est/filter/input_estimation.hpp>

namespace downrange {

/// Variable dimension with input estimation (input_estimation.hpp) over the nine states of one motion. While quiet the
/// acceleration is zero with zero covariance; an onset is tried, and the decision taken, on a grid of UTC.
class Manoeuvre {
 public:
  explicit Manoeuvre(int states = 0) : hypotheses_(states) {}

  [[nodiscard]] bool open() const { return open_; }
  /// The target starts anew, quiet.
  void clear();

  /// Beside the prediction of `h` by dt: `gps_error_decay` acts on the three states after the motion.
  void predict(int motion_at, double dt, double gps_error_decay);

  /// Beside an accepted update of `h`.
  template <int M>
  void update(const BlockJacobian<M>& H, const Evidence<M>& e) {
    if (open_ || hypotheses_.count() == 0) return;
    const Columns<M> K = gain(e);
    hypotheses_.template update_with<M>(
        [&H](const Transfer& W) {
          Mat<M, 3> HW = H.of_motion.leftCols(H.motion_size) * W.middleRows(H.motion_at, H.motion_size);
          if (H.radar_size > 0) HW += H.of_radar.leftCols(H.radar_size) * W.middleRows(H.radar_at, H.radar_size);
          return HW;
        },
        K, e.S, e.nu);
  }

  /// After a measurement at `t`: opens or closes the acceleration of `h`, and tries a new onset.
  void decide(Hypothesis& h, int motion_at, Time t);

 private:
  using Transfer = Eigen::Matrix<double, Eigen::Dynamic, 3>;

  InputHypotheses<Eigen::Dynamic, 3> hypotheses_;
  bool open_ = false;
  int quiet_in_row_ = 0;
  Time decided_;
};

}  // namespace downrange
