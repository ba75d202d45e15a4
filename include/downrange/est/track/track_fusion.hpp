#pragma once
/// Fusion of tracks of one target: convex combination, Bar-Shalom-Campo, MAP, information with memory, federated.
///
/// Tracks of one target are never independent: they share its process noise. What a rule does about that is all that
/// tells the rules apart.
///
/// - `fuse_convex` uses nothing of it: over-confident, for tracks of which nothing is known;
/// - `fuse_bar_shalom_campo`, `CampoFusion` use the tracks' cross-covariances: the best of two tracks without memory,
///   honest;
/// - `MapFusion` uses the joint covariance of fused prior and all tracks: better than without memory, honest;
/// - `fuse_information` uses each track before and after its updates: the centralised filter, when every update is
///   reported; default;
/// - `FederatedFilter`'s local filters give their prior away: the centralised filter.
///
/// States are differences of vectors: an angle among them is to be brought within pi of the other track's first.

#include <Eigen/Eigenvalues>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <downrange/est/filter/gaussian.hpp>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>

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

/// Two tracks fused: x_i + gain (x_j - x_i).
template <int N>
struct FusedPair : FusedTrack<N> {
  Mat<N, N> gain = Mat<N, N>::Zero();  ///< zero where the verdict is Singular
};

/// Best linear combination of two tracks with cross-covariance Pij = cov(x_i, x_j) (Bar-Shalom, Campo 1986, doi
/// 10.1109/TAES.1986.310815). Tracks that make the same error cannot be told apart: Singular, the first stays.
template <int N>
[[nodiscard]] FusedPair<N> fuse_bar_shalom_campo(const Gaussian<N>& i, const Gaussian<N>& j, const Mat<N, N>& Pij) {
  FusedPair<N> fused;
  fused.state = i;
  fused.dof = N;
  const Mat<N, N> S = symmetric<N>(i.cov + j.cov - Pij - Pij.transpose());
  const Eigen::LLT<Mat<N, N>> llt(S);
  if (llt.info() != Eigen::Success) {
    fused.verdict = Verdict::Singular;
    return fused;
  }
  fused.gain = llt.solve((i.cov - Pij).transpose()).transpose();
  const Vec<N> apart = j.mean - i.mean;
  fused.nis = apart.dot(llt.solve(apart));
  fused.state.mean += fused.gain * apart;
  fused.state.cov = symmetric<N>(i.cov - fused.gain * (i.cov - Pij).transpose());
  return fused;
}

/// The joint covariance of [fused | track 0 | track 1 ...] of one target: what a rule needs that knows how the tracks'
/// errors hang together. The number of tracks is known at run time; copying one onto another of as many tracks does not
/// allocate, nor does anything but construction.
template <int N>
class CorrelatedTracks {
 public:
  /// The joint covariance becomes near singular (ERRATA.md: with 1e-11 MAP diverges): this share of the variances is
  /// added to that of a difference of tracks.
  static constexpr double relative_ridge = 1e-7;

  /// All tracks and the fused one start from one common prior.
  CorrelatedTracks(const Gaussian<N>& prior, int tracks)
      : mean_(prior.mean), joint_(prior.cov.replicate(tracks + 1, tracks + 1)) {}

  /// Again from one common prior.
  void start(const Gaussian<N>& prior) {
    mean_ = prior.mean;
    for (int i = 0; i <= tracks(); ++i) {
      for (int j = 0; j <= tracks(); ++j) block(i, j) = prior.cov;
    }
  }

  [[nodiscard]] int tracks() const { return static_cast<int>(joint_.cols()) / N - 1; }
  [[nodiscard]] Gaussian<N> state() const { return {mean_, block(0, 0)}; }

  /// Every track was predicted by F with the target's process noise Q, which is the same error in all of them.
  void predict(const Mat<N, N>& F, const Mat<N, N>& Q) {
    mean_ = F * mean_;
    for (int i = 0; i <= tracks(); ++i) {
      for (int j = 0; j <= tracks(); ++j) block(i, j) = cross_covariance_predicted<N>(block(i, j), F, Q);
    }
  }

  /// Track i (0-based) was updated with gain K by a measurement of its own with H and R.
  template <int M>
  void updated(int i, const Mat<N, M>& K, const Mat<M, N>& H, const Mat<M, M>& R) {
    const Mat<N, N> ImKH = Mat<N, N>::Identity() - K * H;
    const int at = i + 1;
    for (int j = 0; j <= tracks(); ++j) block(at, j) = (ImKH * block(at, j)).eval();
    for (int j = 0; j <= tracks(); ++j) block(j, at) = (block(j, at) * ImKH.transpose()).eval();
    block(at, at) += K * R * K.transpose();
  }

  /// Track i starts anew from the fused one: its error is that one's.
  void designated(int i) {
    const int at = i + 1;
    for (int j = 0; j <= tracks(); ++j) {
      if (j == at) continue;
      block(at, j) = Mat<N, N>(block(0, j));
      block(j, at) = Mat<N, N>(block(j, 0));
    }
    block(at, at) = Mat<N, N>(block(0, 0));
  }

 protected:
  CorrelatedTracks(const Vec<N>& prior, Eigen::MatrixXd joint) : mean_(prior), joint_(std::move(joint)) {}

  /// cov of the errors of i and j; 0: the fused track, 1: track 0.
  auto block(int i, int j) { return joint_.template block<N, N>(i * N, j * N); }
  [[nodiscard]] Mat<N, N> block(int i, int j) const { return joint_.template block<N, N>(i * N, j * N); }
  /// Relative to what is subtracted, so that tracks which are equal leave a definite matrix too.
  [[nodiscard]] Vec<N> ridge(int i, int j) const {
    return relative_ridge * (block(i, i).diagonal() + block(j, j).diagonal()) / 2;
  }

  Vec<N> mean_;

 private:
  Eigen::MatrixXd joint_;
};

/// Bar-Shalom-Campo of any number of tracks, one after the other: the track fused so far is a known linear combination
/// of tracks, so its cross-covariance with the next one is known exactly. No memory: what is fused is not fed back. For
/// more than two tracks the combination is honest, not quite the best there is.
template <int N>
class CampoFusion : public CorrelatedTracks<N> {
 public:
  using CorrelatedTracks<N>::CorrelatedTracks;

  /// Fuses the tracks whose bit is set in `live` (at least one).
  FusedTrack<N> fuse(std::span<const Vec<N>> tracks, std::uint64_t live) {
    assert(static_cast<int>(tracks.size()) == this->tracks() && live != 0);
    FusedTrack<N> fused;
    bool first = true;
    for (int i = 1; i <= this->tracks(); ++i) {
      if ((live >> (i - 1) & 1) == 0) continue;
      const Gaussian<N> next{tracks[static_cast<std::size_t>(i - 1)], this->block(i, i)};
      Mat<N, N> gain = Mat<N, N>::Identity();
      if (first) {
        fused.state = next;
      } else {
        const Gaussian<N> loose{next.mean, next.cov + Mat<N, N>(this->ridge(0, i).asDiagonal())};
        const FusedPair<N> pair = fuse_bar_shalom_campo<N>(fused.state, loose, this->block(0, i));
        gain = pair.gain;
        fused = {.state = pair.state, .nis = fused.nis + pair.nis, .dof = fused.dof + N, .verdict = pair.verdict};
      }
      // cov(x_F + gain (x_i - x_F), x_k)
      for (int k = 1; k <= this->tracks(); ++k) {
        const Mat<N, N> of_fused = first ? Mat<N, N>(Mat<N, N>::Zero()) : Mat<N, N>(this->block(0, k));
        this->block(0, k) = of_fused + gain * (Mat<N, N>(this->block(i, k)) - of_fused);
        this->block(k, 0) = Mat<N, N>(this->block(0, k)).transpose();
      }
      this->block(0, 0) = fused.state.cov;
      first = false;
    }
    this->mean_ = fused.state.mean;
    return fused;
  }
};

/// Sequential MAP fusion with memory (spatial paper, eq. 17): x_F = x_F(k|k-1) + P_xz P_zz^-1 (z - z(k|k-1)), z the
/// stacked tracks, with the covariances of [fused prior | tracks] carried jointly. The fused prior is made of earlier
/// states of these tracks: taken as independent it gives NEES of 9 to 34 and is refused. At most S tracks.
template <int N, int S>
class MapFusion : public CorrelatedTracks<N> {
 public:
  static constexpr int size = (S + 1) * N;
  using Joint = Mat<size, size>;

  /// All tracks and the fused one start from one common prior. 1 to S tracks.
  explicit MapFusion(const Gaussian<N>& prior, int tracks = S) : CorrelatedTracks<N>(prior, tracks) {
    assert(tracks >= 1 && tracks <= S);
  }

  /// S tracks, from a joint covariance, fused prior first. Throws std::invalid_argument where the prior is taken as
  /// independent of a track.
  MapFusion(const Vec<N>& prior, const Joint& joint) : CorrelatedTracks<N>(prior, joint) {
    for (int i = 1; i <= S; ++i) {
      if (joint.template block<N, N>(0, i * N).isZero(0))
        throw std::invalid_argument("MAP fusion: the fused prior cannot be independent of a track it is made of");
    }
  }

  /// Fuses all tracks' states into the prior.
  FusedTrack<N> fuse(std::span<const Vec<N>> tracks) { return fuse(tracks, ~std::uint64_t{0}); }

  /// Fuses those whose bit is set in `live` (at least one).
  FusedTrack<N> fuse(std::span<const Vec<N>> tracks, std::uint64_t live) {
    assert(static_cast<int>(tracks.size()) == this->tracks());
    std::array<int, static_cast<std::size_t>(S)> taken{};
    int n = 0;
    for (int i = 1; i <= this->tracks(); ++i)
      if ((live >> (i - 1) & 1) != 0) taken[static_cast<std::size_t>(n++)] = i;

    Stacked nu(n * N);  // z - z(k|k-1)
    StateByStacked Pxz(N, n * N);
    StackedSquare Pzz(n * N, n * N);
    const Mat<N, N> P = this->block(0, 0);
    for (int a = 0; a < n; ++a) {
      const int i = taken[static_cast<std::size_t>(a)];
      nu.template segment<N>(a * N) = tracks[static_cast<std::size_t>(i - 1)] - this->mean_;
      Pxz.template middleCols<N>(a * N) = P - this->block(0, i);
      for (int b = 0; b < n; ++b) {
        const int j = taken[static_cast<std::size_t>(b)];
        Pzz.template block<N, N>(a * N, b * N) = P - this->block(0, j) - this->block(i, 0) + this->block(i, j);
      }
      Pzz.diagonal().template segment<N>(a * N) += this->ridge(0, i);
    }
    FusedTrack<N> fused{.state = this->state(), .dof = n * N};
    const Eigen::LLT<StackedSquare> llt(Pzz);
    if (llt.info() != Eigen::Success) {
      fused.verdict = Verdict::Singular;
      return fused;
    }
    const StateByStacked gain = llt.solve(Pxz.transpose()).transpose();
    fused.nis = nu.dot(llt.solve(nu));
    this->mean_ += gain * nu;

    // The error of the fused track after any gain: (I - sum W_i) e_F + sum W_i e_i. Exact, and definite, with the
    // ridge.
    Mat<N, N> kept = Mat<N, N>::Identity();
    for (int a = 0; a < n; ++a) kept -= gain.template middleCols<N>(a * N);
    const auto of_fused = [&](int column) {
      Mat<N, N> sum = kept * this->block(0, column);
      for (int a = 0; a < n; ++a)
        sum += gain.template middleCols<N>(a * N) * this->block(taken[static_cast<std::size_t>(a)], column);
      return sum;
    };
    const Mat<N, N> with_prior = of_fused(0);
    for (int k = 1; k <= this->tracks(); ++k) this->block(0, k) = of_fused(k);
    for (int k = 1; k <= this->tracks(); ++k) this->block(k, 0) = Mat<N, N>(this->block(0, k)).transpose();
    Mat<N, N> cov = with_prior * kept.transpose();
    for (int a = 0; a < n; ++a)
      cov += this->block(0, taken[static_cast<std::size_t>(a)]) * gain.template middleCols<N>(a * N).transpose();
    this->block(0, 0) = symmetric<N>(cov);
    fused.state = this->state();
    return fused;
  }

 private:
  using Stacked = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, S * N, 1>;
  using StackedSquare = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, S * N, S * N>;
  using StateByStacked = Eigen::Matrix<double, N, Eigen::Dynamic, 0, N, S * N>;
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
/// P_i^-1. Equals the centralised filter where every sensor measures at the instants of fusion; a measurement between
/// two of them meets more process noise than the centralised filter would give it: the covariance is then too large,
/// never too small. At most S sensors.
template <int N, int S>
class FederatedFilter {
 public:
  using Shares = std::array<double, static_cast<std::size_t>(S)>;

  /// S sensors. Throws std::invalid_argument unless beta_i >= 1 and sum 1/beta_i = 1.
  FederatedFilter(const Gaussian<N>& start, const Shares& beta) : sensors_(S), beta_(beta), fused_(start) {
    double sum = 0;
    for (const double b : beta) sum += b >= 1 ? 1 / b : std::numeric_limits<double>::quiet_NaN();
    constexpr double rounding = 1e-12;
    if (!(std::abs(sum - 1) < rounding)) throw std::invalid_argument("federated filter: sum of 1/beta is not 1");
    share();
  }

  /// 1 to S sensors with equal shares.
  FederatedFilter(const Gaussian<N>& start, int sensors) : sensors_(static_cast<std::size_t>(sensors)), fused_(start) {
    assert(sensors >= 1 && sensors <= S);
    beta_.fill(sensors);
    share();
  }

  [[nodiscard]] const Gaussian<N>& state() const { return fused_; }
  [[nodiscard]] const Gaussian<N>& local(int i) const { return local_[static_cast<std::size_t>(i)]; }
  /// What the local states say together, as `fuse` makes it; nothing is given back to them.
  [[nodiscard]] FusedTrack<N> fused_now() const {
    return fuse_convex<N>(std::span<const Gaussian<N>>(local_.data(), sensors_));
  }

  /// The fused state stays as it was until the next `fuse`.
  void predict(const Mat<N, N>& F, const Mat<N, N>& Q) {
    for (std::size_t i = 0; i < sensors_; ++i) {
      local_[i].mean = F * local_[i].mean;
      local_[i].cov = symmetric<N>(F * local_[i].cov * F.transpose() + beta_[i] * Q);
    }
  }

  /// A measurement of sensor i; `innovation` = z - h(local(i).mean).
  template <int M>
  Update<N, M> update(int i, const Vec<M>& innovation, const Mat<M, N>& H, const Mat<M, M>& R, double gate) {
    Gaussian<N>& x = local_[static_cast<std::size_t>(i)];
    auto u = kalman_update<N, M>(x, innovation, H, R, gate);
    x = u.posterior;
    return u;
  }

  /// Fuses the local states and gives each its share of the result.
  FusedTrack<N> fuse() {
    auto fused = fused_now();
    if (fused.verdict == Verdict::Accepted) fused_ = fused.state;
    share();
    return fused;
  }

 private:
  void share() {
    for (std::size_t i = 0; i < sensors_; ++i) local_[i] = {.mean = fused_.mean, .cov = beta_[i] * fused_.cov};
  }

  std::size_t sensors_;
  Shares beta_{};
  Gaussian<N> fused_;
  std::array<Gaussian<N>, static_cast<std::size_t>(S)> local_;
};

}  // namespace downrange
