#pragma once
/// Fusion of tracks of one target: convex combination, Bar-Shalom-Campo, MAP, information with memory, federated.
///
/// Tracks of one target are never independent: they share its process noise. What a rule does about that is all that
/// tells the rules apart.
///
/// | rule | uses | against the centralised filter |
/// |---|---|---|
/// | `fuse_convex` | nothing | over-confident, for tracks of which nothing is known |
/// | `fuse_bar_shalom_campo` | cross-covariance of two tracks | best of two tracks without memory; honest |
/// | `MapFusion` | joint covariance of fused prior and all tracks | better than without memory; honest |
/// | `fuse_information` | predicted and updated state of each track | equal, when every update is reported; default |
/// | `FederatedFilter` | local filters that give their prior away | equal |
///
/// States are differences of vectors: an angle among them is to be brought within pi of the other track's first.

#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <downrange/est/gaussian.hpp>
#include <limits>
#include <span>
#include <stdexcept>

namespace downrange {

/// A fused track with its evidence.
template <int N>
struct FusedTrack {
  Gaussian<N> state;
  double nis = 0;  ///< how far apart what was fused is, normalised: chi2(dof) if the covariances are right
  int dof = 0;
  Verdict verdict = Verdict::Accepted;  ///< Singular: nothing fused, `state` is the first track or the prior
};

template <int N>
[[nodiscard]] Mat<N, N> symmetric(const Mat<N, N>& P) {
  return (P + P.transpose()) / 2;
}

/// P^-1 by Cholesky: the information of a covariance.
template <int N>
[[nodiscard]] Mat<N, N> information_of(const Mat<N, N>& P) {
  return symmetric<N>(P.llt().solve(Mat<N, N>::Identity()));
}

/// P^-1 = sum P_i^-1, x = P sum P_i^-1 x_i: right for independent errors only. At least one track.
template <int N>
[[nodiscard]] FusedTrack<N> fuse_convex(std::span<const Gaussian<N>> tracks) {
  FusedTrack<N> fused{.state = tracks.front(), .dof = static_cast<int>(tracks.size() - 1) * N};
  Mat<N, N> Y = Mat<N, N>::Zero();
  // About the first track: states of 6e6 m keep their digits.
  Vec<N> y = Vec<N>::Zero();
  for (const Gaussian<N>& track : tracks) {
    const Mat<N, N> Yi = information_of<N>(track.cov);
    const Vec<N> apart = track.mean - tracks.front().mean;
    Y += Yi;
    y += Yi * apart;
    fused.nis += apart.dot(Yi * apart);
  }
  const Eigen::LLT<Mat<N, N>> llt(Y);
  if (llt.info() != Eigen::Success) {
    fused.verdict = Verdict::Singular;
    return fused;
  }
  const Vec<N> shift = llt.solve(y);
  fused.nis -= shift.dot(y);
  fused.state.mean += shift;
  fused.state.cov = symmetric<N>(llt.solve(Mat<N, N>::Identity()));
  return fused;
}

/// (9b): P_ij(k|k-1) = F P_ij F' + Q of two tracks of one target.
template <int N>
[[nodiscard]] Mat<N, N> cross_covariance_predicted(const Mat<N, N>& Pij, const Mat<N, N>& F, const Mat<N, N>& Q) {
  return F * Pij * F.transpose() + Q;
}

/// (9a): P_ij(k|k) = (I - K_i H_i) P_ij(k|k-1) (I - K_j H_j)'; the identity for a track that was not updated.
template <int N>
[[nodiscard]] Mat<N, N> cross_covariance_updated(const Mat<N, N>& ImKHi, const Mat<N, N>& Pij, const Mat<N, N>& ImKHj) {
  return ImKHi * Pij * ImKHj.transpose();
}

/// Best linear combination of two tracks with cross-covariance Pij = cov(x_i, x_j) (Bar-Shalom, Campo 1986, doi
/// 10.1109/TAES.1986.310815). Tracks that make the same error cannot be told apart: Singular, the first stays.
template <int N>
[[nodiscard]] FusedTrack<N> fuse_bar_shalom_campo(const Gaussian<N>& i, const Gaussian<N>& j, const Mat<N, N>& Pij) {
  FusedTrack<N> fused{.state = i, .dof = N};
  const Mat<N, N> S = symmetric<N>(i.cov + j.cov - Pij - Pij.transpose());
  const Eigen::LLT<Mat<N, N>> llt(S);
  if (llt.info() != Eigen::Success) {
    fused.verdict = Verdict::Singular;
    return fused;
  }
  const Mat<N, N> gain = llt.solve((i.cov - Pij).transpose()).transpose();
  const Vec<N> apart = j.mean - i.mean;
  fused.nis = apart.dot(llt.solve(apart));
  fused.state.mean += gain * apart;
  fused.state.cov = symmetric<N>(i.cov - gain * (i.cov - Pij).transpose());
  return fused;
}

/// Sequential MAP fusion with memory (spatial paper, eq. 17): x_F = x_F(k|k-1) + P_xz P_zz^-1 (z - z(k|k-1)), z the
/// stacked tracks, with the covariances of [fused prior | tracks] carried jointly. The fused prior is made of earlier
/// states of these tracks: taken as independent it gives NEES of 9 to 34 and is refused.
template <int N, int S>
class MapFusion {
 public:
  static constexpr int size = (S + 1) * N;
  static constexpr double relative_ridge =
      1e-7;  ///< the joint covariance becomes near singular (errata: 1e-11 diverges)
  using Joint = Mat<size, size>;

  /// All tracks and the fused one start from one common prior.
  explicit MapFusion(const Gaussian<N>& prior)
      : mean_(prior.mean), joint_(prior.cov.template replicate<S + 1, S + 1>()) {}

  /// From a joint covariance, fused prior first. Throws std::invalid_argument where the prior is taken as independent
  /// of a track.
  MapFusion(const Vec<N>& prior, const Joint& joint) : mean_(prior), joint_(joint) {
    for (int i = 1; i <= S; ++i) {
      if (joint.template block<N, N>(0, i * N).isZero(0))
        throw std::invalid_argument("MAP fusion: the fused prior cannot be independent of a track it is made of");
    }
  }

  [[nodiscard]] Gaussian<N> state() const { return {mean_, joint_.template topLeftCorner<N, N>()}; }

  /// Every track was predicted by F with the target's process noise Q, which is the same error in all of them.
  void predict(const Mat<N, N>& F, const Mat<N, N>& Q) {
    mean_ = F * mean_;
    for (int i = 0; i <= S; ++i) {
      for (int j = 0; j <= S; ++j) {
        const Mat<N, N> P = joint_.template block<N, N>(i * N, j * N);
        joint_.template block<N, N>(i * N, j * N) = F * P * F.transpose() + Q;
      }
    }
  }

  /// Track i (0-based) was updated with gain K by a measurement of its own with H and R.
  template <int M>
  void updated(int i, const Mat<N, M>& K, const Mat<M, N>& H, const Mat<M, M>& R) {
    const Mat<N, N> ImKH = Mat<N, N>::Identity() - K * H;
    const int at = (i + 1) * N;
    joint_.template middleRows<N>(at) = (ImKH * joint_.template middleRows<N>(at)).eval();
    joint_.template middleCols<N>(at) = (joint_.template middleCols<N>(at) * ImKH.transpose()).eval();
    joint_.template block<N, N>(at, at) += K * R * K.transpose();
  }

  /// Fuses the tracks' states into the prior.
  FusedTrack<N> fuse(std::span<const Vec<N>, static_cast<std::size_t>(S)> tracks) {
    Vec<S * N> nu;  // z - z(k|k-1)
    Mat<N, S * N> Pxz;
    Mat<S * N, S * N> Pzz;
    const auto block = [&](int i, int j) { return joint_.template block<N, N>(i * N, j * N); };
    for (int i = 1; i <= S; ++i) {
      nu.template segment<N>((i - 1) * N) = tracks[static_cast<std::size_t>(i - 1)] - mean_;
      Pxz.template middleCols<N>((i - 1) * N) = block(0, 0) - block(0, i);
      for (int j = 1; j <= S; ++j)
        Pzz.template block<N, N>((i - 1) * N, (j - 1) * N) = block(0, 0) - block(0, j) - block(i, 0) + block(i, j);
    }
    // The ridge is relative to what was subtracted, so that tracks equal to the prior leave a definite matrix too.
    for (int i = 0; i < S * N; ++i) Pzz(i, i) += relative_ridge * (joint_(i % N, i % N) + joint_(N + i, N + i)) / 2;
    FusedTrack<N> fused{.state = state(), .dof = S * N};
    const Eigen::LLT<Mat<S * N, S * N>> llt(Pzz);
    if (llt.info() != Eigen::Success) {
      fused.verdict = Verdict::Singular;
      return fused;
    }
    const Mat<N, S* N> gain = llt.solve(Pxz.transpose()).transpose();
    fused.nis = nu.dot(llt.solve(nu));
    mean_ += gain * nu;
    // The error of the fused track after any gain: (I - sum W_i) e_F + sum W_i e_i. Exact, and definite, with the
    // ridge.
    Joint T = Joint::Identity();
    for (int i = 1; i <= S; ++i) {
      T.template topLeftCorner<N, N>() -= gain.template middleCols<N>((i - 1) * N);
      T.template block<N, N>(0, i * N) = gain.template middleCols<N>((i - 1) * N);
    }
    joint_ = symmetric<size>(T * joint_ * T.transpose());
    fused.state = state();
    return fused;
  }

 private:
  Vec<N> mean_;
  Joint joint_;  ///< of [fused | track 0 | track 1 ...]
};

/// What a track says at one instant: before and after the measurements since its last report.
template <int N>
struct TrackReport {
  Gaussian<N> predicted;
  Gaussian<N> updated;
};

/// Information fusion with memory: P^-1 = P(k|k-1)^-1 + sum [P_i(k|k)^-1 - P_i(k|k-1)^-1]. What each track has learnt
/// since its last report is new and independent of everything else: the centralised filter, when every track reports
/// each update and predicts as the fused one does. `prior` is the fused track predicted to the reports' instant.
template <int N>
[[nodiscard]] FusedTrack<N> fuse_information(const Gaussian<N>& prior, std::span<const TrackReport<N>> reports) {
  FusedTrack<N> fused{.state = prior};
  Mat<N, N> Y = information_of<N>(prior.cov);
  Vec<N> y = Vec<N>::Zero();  // about the prior
  for (const TrackReport<N>& r : reports) {
    const Mat<N, N> before = information_of<N>(r.predicted.cov);
    const Mat<N, N> after = information_of<N>(r.updated.cov);
    Y += after - before;
    y += after * (r.updated.mean - prior.mean) - before * (r.predicted.mean - prior.mean);
  }
  const Eigen::LLT<Mat<N, N>> llt(symmetric<N>(Y));
  if (llt.info() != Eigen::Success) {
    fused.verdict = Verdict::Singular;
    return fused;
  }
  const Vec<N> shift = llt.solve(y);
  fused.state.mean += shift;
  fused.state.cov = symmetric<N>(llt.solve(Mat<N, N>::Identity()));

  // Evidence: shift ~ N(0, P(k|k-1) - P), of the rank of what was measured.
  const Eigen::LLT<Mat<N, N>> prior_root(prior.cov);
  const Mat<N, N> gained =
      prior_root.matrixL().solve(prior_root.matrixL().solve(prior.cov - fused.state.cov).transpose().eval());
  const Eigen::SelfAdjointEigenSolver<Mat<N, N>> eigen(symmetric<N>(gained));
  const Vec<N> whitened = eigen.eigenvectors().transpose() * prior_root.matrixL().solve(shift);
  constexpr double nothing_learnt = 1e-9;  // share of the variance
  for (int i = 0; i < N; ++i) {
    if (eigen.eigenvalues()[i] < nothing_learnt) continue;
    fused.nis += whitened[i] * whitened[i] / eigen.eigenvalues()[i];
    ++fused.dof;
  }
  return fused;
}

/// Federated filter in fusion-reset mode (federated paper, eq. 5-9 corrected): local filter i works with beta_i times
/// the fused covariance *and* beta_i times the process noise, sum 1/beta_i = 1, and the fused track is P^-1 = sum
/// P_i^-1. Equals the centralised filter.
template <int N, int S>
class FederatedFilter {
 public:
  using Shares = std::array<double, static_cast<std::size_t>(S)>;

  /// Throws std::invalid_argument unless beta_i >= 1 and sum 1/beta_i = 1.
  FederatedFilter(const Gaussian<N>& start, const Shares& beta) : beta_(beta), fused_(start) {
    double sum = 0;
    for (const double b : beta) sum += b >= 1 ? 1 / b : std::numeric_limits<double>::quiet_NaN();
    constexpr double rounding = 1e-12;
    if (!(std::abs(sum - 1) < rounding)) throw std::invalid_argument("federated filter: sum of 1/beta is not 1");
    share();
  }

  [[nodiscard]] const Gaussian<N>& state() const { return fused_; }
  [[nodiscard]] const Gaussian<N>& local(int i) const { return local_[static_cast<std::size_t>(i)]; }

  /// The fused state stays as it was until the next `fuse`.
  void predict(const Mat<N, N>& F, const Mat<N, N>& Q) {
    for (std::size_t i = 0; i < local_.size(); ++i) {
      local_[i].mean = F * local_[i].mean;
      local_[i].cov = symmetric<N>(F * local_[i].cov * F.transpose() + beta_[i] * Q);
    }
  }

  /// A measurement of sensor i; `innovation` = z - h(local(i).mean).
  template <int M>
  Update<N, M> update(int i, const Vec<M>& innovation, const Mat<M, N>& H, const Mat<M, M>& R, double gate) {
    Gaussian<N>& x = local_[static_cast<std::size_t>(i)];
    const auto u = kalman_update<N, M>(x, innovation, H, R, gate);
    x = u.posterior;
    return u;
  }

  /// Fuses the local states and gives each its share of the result.
  FusedTrack<N> fuse() {
    const auto fused = fuse_convex<N>(local_);
    if (fused.verdict == Verdict::Accepted) fused_ = fused.state;
    share();
    return fused;
  }

 private:
  void share() {
    for (std::size_t i = 0; i < local_.size(); ++i) local_[i] = {.mean = fused_.mean, .cov = beta_[i] * fused_.cov};
  }

  Shares beta_;
  Gaussian<N> fused_;
  std::array<Gaussian<N>, static_cast<std::size_t>(S)> local_;
};

}  // namespace downrange
