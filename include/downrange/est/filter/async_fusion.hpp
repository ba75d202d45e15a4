#pragma once
/// Optimal fusion of asynchronous position measurements in one batch (song2015 section 4).

#include <downrange/est/filter/gaussian.hpp>
#include <span>

namespace downrange {

/// A position measured inside a fusion interval.
struct TimedPosition {
  double age_s = 0;                 ///< tau >= 0: fusion instant t_k minus the instant measured
  Vec<3> z = Vec<3>::Zero();        ///< m
  Mat<3, 3> R = Mat<3, 3>::Zero();  ///< m^2, positive definite
};

/// Most measurements one batch may hold; the matrices live on the stack.
inline constexpr int max_batch = 16;

/// State at t_k from the estimate at t_{k-1} = t_k - T and all positions measured in (t_{k-1}, t_k], any order, equal
/// times allowed. CV motion, white acceleration PSD q (m^2/s^3).
///
/// Song 2015 eq. (29)-(39) after Hu, Duan, Zhou 2010 (doi 10.1109/TAES.2010.5595618), corrected as est/ERRATA.md
/// says: the noise of every measurement referred to t_k is correlated with the others through the process noise (32)
/// and with the process noise itself (35). Computed in the equivalent gain form (no inverse of P), generalised Joseph
/// covariance. Equals the sequential Kalman filter to 1e-9. 1 to max_batch measurements.
[[nodiscard]] Gaussian<6> fuse_asynchronous(const Gaussian<6>& previous, double T, std::span<const TimedPosition> batch,
                                            double q);

}  // namespace downrange
