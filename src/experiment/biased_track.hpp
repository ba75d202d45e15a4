#pragma once
/// A track by one radar that does not know its bias, and how much of the bias is in it: H. W. Kim et al., Multisensor
/// bias estimation with pseudo measurement for asynchronous sensors, 2011, equations (8)-(21) and (37)-(41) as
/// corrected in est/ERRATA.md.

#include <downrange/est/filter/gaussian.hpp>

namespace downrange {

/// x^b = x + G beta: `estimate.mean` is x^b, the estimate made of biased measurements; x the estimate that the same
/// measurements without bias would have given, with covariance `estimate.cov`; beta the radar's B bias terms.
template <int N, int B>
struct BiasedTrack {
  Gaussian<N> estimate;
  Mat<N, B> G = Mat<N, B>::Zero();  ///< zero for a track started free of bias
};

/// (13), (14): by the transition Phi with process noise Q.
template <int N, int B>
[[nodiscard]] BiasedTrack<N, B> predict(const BiasedTrack<N, B>& track, const Mat<N, N>& Phi, const Mat<N, N>& Q) {
  const Mat<N, N> P = Phi * track.estimate.cov * Phi.transpose() + Q;
  return {{Phi * track.estimate.mean, (P + P.transpose()) / 2}, Phi * track.G};
}

template <int N, int M, int B>
struct BiasedTrackUpdate {
  BiasedTrack<N, B> track;  ///< The prior, untouched, unless evidence.verdict == Accepted.
  Update<N, M> evidence;
};

/// (16)-(21): z = H x + BC beta + w, cov(w) = R. `gate`, a chi2(M) quantile, judges the innovation as if there were no
/// bias: with a bias unknown by more than the noise use infinity, or gate the pseudo measurement instead.
template <int N, int M, int B>
[[nodiscard]] BiasedTrackUpdate<N, M, B> update(const BiasedTrack<N, B>& track, const Vec<M>& z, const Mat<M, N>& H,
                                                const Mat<M, B>& BC, const Mat<M, M>& R, double gate) {
  BiasedTrackUpdate<N, M, B> u{track, kalman_update<N, M>(track.estimate, z - H * track.estimate.mean, H, R, gate)};
  u.track.estimate = u.evidence.posterior;
  u.track.G += u.evidence.K * (BC - H * track.G);  // (20): (I - K H) G + K B C; K is zero unless accepted
  return u;
}

/// One measurement of a position with its bias matrix.
template <int M, int B>
struct BiasedPosition {
  Vec<M> z;
  Mat<M, B> BC;
  Mat<M, M> R;
};

/// (8)-(11): start from two positions T > 0 seconds apart, `z0` before `z1`, of a nearly-constant-velocity target,
/// state [position, velocity], white acceleration of density q. The q T / 3 of est/ERRATA.md in the velocity is there.
template <int M, int B>
[[nodiscard]] BiasedTrack<2 * M, B> two_point_start(const BiasedPosition<M, B>& z0, const BiasedPosition<M, B>& z1,
                                                    double T, double q) {
  BiasedTrack<2 * M, B> track;
  track.estimate.mean << z1.z, (z1.z - z0.z) / T;
  track.G << z1.BC, (z1.BC - z0.BC) / T;
  const Mat<M, M> P_vv = (z1.R + z0.R) / (T * T) + q * T / 3 * Mat<M, M>::Identity();
  track.estimate.cov << z1.R, z1.R / T, z1.R / T, P_vv;
  return track;
}

/// (38), (41): the track without its bias as far as that is known. The correlation of track and bias error is left out;
/// it is measured to be 3 % of the position variance (est/ERRATA.md).
template <int N, int B>
[[nodiscard]] Gaussian<N> compensate(const BiasedTrack<N, B>& track, const Gaussian<B>& beta) {
  const Mat<N, N> P = track.estimate.cov + track.G * beta.cov * track.G.transpose();
  return {track.estimate.mean - track.G * beta.mean, (P + P.transpose()) / 2};
}

}  // namespace downrange
