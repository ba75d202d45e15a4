#pragma once
/// Biases of several radars from one radar's measurements against the other radars' tracks, no GPS needed: kim2011,
/// equations (22)-(36) as corrected in est/ERRATA.md. Methods `pm` and `pm-scaled`.

#include <array>
#include "experiment/biased_track.hpp"

namespace downrange {

/// The biased tracks of one target, one per radar (S >= 2), all at the same instant, with the cross covariances that
/// the common process noise makes. A track that has not started takes no part.
template <int N, int B, int S>
struct LocalTracks {
  std::array<BiasedTrack<N, B>, S> track;
  std::array<bool, S> started{};
  /// P_ab of the errors of tracks a and b where a < b. Zero at a start: of two tracks started from plots of the same
  /// seconds that leaves out what the process noise between the two plots has in common.
  std::array<std::array<Mat<N, N>, S>, S> cross;

  LocalTracks() {
    for (auto& row : cross) row.fill(Mat<N, N>::Zero());
  }

  void start(int a, const BiasedTrack<N, B>& with) {
    track[static_cast<std::size_t>(a)] = with;
    started[static_cast<std::size_t>(a)] = true;
    for (std::size_t b = 0; b < S; ++b) {
      cross[b][static_cast<std::size_t>(a)].setZero();
      cross[static_cast<std::size_t>(a)][b].setZero();
    }
  }

  /// P_ab for either order of a and b.
  [[nodiscard]] Mat<N, N> covariance(std::size_t a, std::size_t b) const {
    if (a == b) return track[a].estimate.cov;
    return a < b ? cross[a][b] : Mat<N, N>(cross[b][a].transpose());
  }
};

/// All tracks to the next instant.
template <int N, int B, int S>
void predict(LocalTracks<N, B, S>& tracks, const Mat<N, N>& Phi, const Mat<N, N>& Q) {
  for (std::size_t a = 0; a < S; ++a) {
    if (!tracks.started[a]) continue;
    tracks.track[a] = predict(tracks.track[a], Phi, Q);
    for (std::size_t b = a + 1; b < S; ++b) {
      if (tracks.started[b]) tracks.cross[a][b] = Phi * tracks.cross[a][b] * Phi.transpose() + Q;
    }
  }
}

/// Radar i's own track takes its measurement; the cross covariances follow: P_ib+ = (I - K H) P_ib.
template <int N, int M, int B, int S>
[[nodiscard]] Update<N, M> update(LocalTracks<N, B, S>& tracks, int i, const Vec<M>& z, const Mat<M, N>& H,
                                  const Mat<M, B>& BC, const Mat<M, M>& R, double gate) {
  const auto own = static_cast<std::size_t>(i);
  const auto u = update<N, M, B>(tracks.track[own], z, H, BC, R, gate);
  tracks.track[own] = u.track;
  const Mat<N, N> ImKH = Mat<N, N>::Identity() - u.evidence.K * H;
  for (std::size_t b = 0; b < own; ++b) tracks.cross[b][own] *= ImKH.transpose();
  for (std::size_t b = own + 1; b < S; ++b) tracks.cross[own][b] = ImKH * tracks.cross[own][b];
  return u.evidence;
}

/// zb = Hb [beta_1 ... beta_S] + wb, cov(wb) = R: rows of the other radars in ascending order, M each. Rows of radars
/// without a track are zero with unit noise: they tell nothing.
template <int M, int B, int S>
struct PseudoMeasurement {
  static constexpr int rows = M * (S - 1);
  Vec<rows> zb = Vec<rows>::Zero();
  Mat<rows, B* S> Hb = Mat<rows, B * S>::Zero();
  Mat<rows, rows> R = Mat<rows, rows>::Identity();
};

/// (22)-(32): radar i's measurement z of the target against every other radar's track, predicted to the measurement.
/// Blocks of R: R_i + H P_ab H' for rows of radars a and b; the printed sum is its diagonal.
template <int N, int M, int B, int S>
[[nodiscard]] PseudoMeasurement<M, B, S> pseudo_measurement(const LocalTracks<N, B, S>& tracks, int i, const Vec<M>& z,
                                                            const Mat<M, N>& H, const Mat<M, B>& BC,
                                                            const Mat<M, M>& R) {
  PseudoMeasurement<M, B, S> pm;
  const auto own = static_cast<std::size_t>(i);
  const auto row = [own](std::size_t a) { return M * static_cast<int>(a < own ? a : a - 1); };
  for (std::size_t a = 0; a < S; ++a) {
    if (a == own || !tracks.started[a]) continue;
    pm.zb.template segment<M>(row(a)) = z - H * tracks.track[a].estimate.mean;
    pm.Hb.template block<M, B>(row(a), B * i) = BC;
    pm.Hb.template block<M, B>(row(a), B * static_cast<int>(a)) = -H * tracks.track[a].G;
    for (std::size_t b = 0; b < S; ++b) {
      if (b == own || !tracks.started[b]) continue;
      pm.R.template block<M, M>(row(a), row(b)) = R + H * tracks.covariance(a, b) * H.transpose();
    }
  }
  return pm;
}

/// Factor on the noise of pseudo measurements that makes the bias covariance of two radars honest (`pm-scaled`). The
/// noise is not white, tracks are used again and again: taken as white it promises 2.1-2.8 times too small a variance.
inline constexpr double honest_pseudo_noise = 2.4;

/// (33)-(36): recursive least squares, one target after the other. `noise_factor` 1: as published.
template <int M, int B, int S>
[[nodiscard]] Update<B * S, M*(S - 1)> estimate_bias(const Gaussian<B * S>& beta, const PseudoMeasurement<M, B, S>& pm,
                                                     double noise_factor, double gate) {
  constexpr int rows = PseudoMeasurement<M, B, S>::rows;
  return kalman_update<B * S, rows>(beta, pm.zb - pm.Hb * beta.mean, pm.Hb, noise_factor * pm.R, gate);
}

}  // namespace downrange
