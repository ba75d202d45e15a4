#pragma once
/// Two-stage estimation of targets and of the biases of the sensors that all of them are seen by (method `ts`). After
/// B. Friedland, Treatment of bias in recursive filtering, IEEE Trans. AC 14, 1969, with the biases shared.
///
/// Given the biases, the targets are independent: p(x_1 ... x_T, b) = p(b) prod_t N(x_t; x~_t + V_t b, P~_t). Each
/// target has a filter that takes all sensors' measurements as if b were zero, x~ with P~, and its sensitivity V = d x~
/// / d b; one b is common to them. A measurement touches its own target and b, nothing else: the cost of one is
/// independent of the number of targets, and the result is that of the filter with the state [x_1 ... x_T b] (tested to
/// 1e-8 sigma).
///
/// Whatever is linearised belongs at the compensated estimate x~ + V b^.

#include <downrange/est/filter/gaussian.hpp>
#include <downrange/est/filter/low_rank.hpp>
#include <limits>
#include <utility>

namespace downrange {

/// The estimate of the biases. `Biases` may be Eigen::Dynamic; then `MaxBiases` is what intermediate results on the
/// stack are sized for.
template <int Biases, int MaxBiases = Biases>
class SharedBias {
 public:
  using Vector = Eigen::Matrix<double, Biases, 1>;
  using Square = Eigen::Matrix<double, Biases, Biases>;
  /// M vectors of bias size, on the stack.
  template <int M>
  using Columns = Eigen::Matrix<double, Biases, M, 0, MaxBiases, M>;

  /// `cov` positive definite.
  SharedBias(Vector mean, Square cov) : mean_(std::move(mean)), cov_(std::move(cov)) {}

  [[nodiscard]] const Vector& mean() const { return mean_; }
  [[nodiscard]] const Square& covariance() const { return cov_; }
  [[nodiscard]] Eigen::Index size() const { return mean_.size(); }

  /// Kalman update of M numbers: `Y` = covariance times the transposed Jacobian, S = L L' of the innovation nu.
  template <int M>
  void apply(Columns<M> Y, const Mat<M, M>& L, const Vec<M>& nu) {
    divide_by_transposed<Columns<M>, M>(Y, L);
    mean_ += Y.lazyProduct(L.template triangularView<Eigen::Lower>().solve(nu));
    subtract_product(cov_, Y, Y);
  }

  /// Random steps of the biases, and how the biases before depend on those after: b_before = b_after - s with
  /// s | b_after ~ N(D P^-1 (b_after - mean), D - D P^-1 D), D = diag(variance), P the covariance after.
  struct Step {
    explicit Step(Eigen::Index size) : variance(Vector::Zero(size)), factor(Square::Identity(size, size)) {}

    Vector variance;  ///< of each bias's step; 0: it does not step. Given by the caller
    Square factor;    ///< Cholesky factor of P, lower. Made by `loosen`
  };

  /// The covariance grows by the steps, the mean stays. Every track then needs `loosen` with the same step.
  void loosen(Step& step) {
    cov_.diagonal() += step.variance;
    step.factor = cov_;
    Eigen::LLT<Eigen::Ref<Square>> in_place(step.factor);
  }

 private:
  Vector mean_;
  Square cov_;
};

/// One target's filter: x given b is N(estimate.mean + V b, estimate.cov). `V` is N x (number of biases).
template <int N, int Biases>
struct BiasFreeTrack {
  Gaussian<N> estimate;
  Mat<N, Biases> V;
};

/// x~ + V b^: what measurements and motion are linearised at.
template <int N, int Biases, int Max>
[[nodiscard]] Vec<N> compensated_mean(const BiasFreeTrack<N, Biases>& track, const SharedBias<Biases, Max>& bias) {
  return track.estimate.mean + track.V * bias.mean();
}

/// The target's estimate: x~ + V b^, P~ + V Sigma V'.
template <int N, int Biases, int Max>
[[nodiscard]] Gaussian<N> compensated(const BiasFreeTrack<N, Biases>& track, const SharedBias<Biases, Max>& bias) {
  using Columns = typename SharedBias<Biases, Max>::template Columns<N>;
  const Columns Y = bias.covariance().lazyProduct(track.V.transpose());
  const Mat<N, N> P = track.estimate.cov + track.V.lazyProduct(Y);
  return {compensated_mean(track, bias), (P + P.transpose()) / 2};
}

/// By a linear motion with process noise Q; `phi(X)` multiplies any matrix X of N rows by the transition, in place.
template <int N, int Biases, class Transition>
void predict(BiasFreeTrack<N, Biases>& track, const Transition& phi, const Mat<N, N>& Q) {
  phi(track.estimate.mean);
  phi(track.V);
  Mat<N, N>& P = track.estimate.cov;
  phi(P);
  P.transposeInPlace();
  phi(P);
  P = ((P + P.transpose()) / 2 + Q).eval();
}

/// Biases took random steps (`bias` has loosened already). Exact for one target; of several, the errors that a step
/// makes common are taken as independent, which for a slow drift is little.
template <int N, int Biases, int Max>
void loosen(BiasFreeTrack<N, Biases>& track, const SharedBias<Biases, Max>& bias,
            const typename SharedBias<Biases, Max>::Step& step) {
  using Columns = typename SharedBias<Biases, Max>::template Columns<N>;
  const Columns DV = step.variance.asDiagonal() * track.V.transpose();
  Columns T = DV;  // P^-1 D V'
  step.factor.template triangularView<Eigen::Lower>().solveInPlace(T);
  step.factor.transpose().template triangularView<Eigen::Upper>().solveInPlace(T);
  // x~ + V (b_after - s): the mean of s moves x~ and V, its spread is noise.
  track.estimate.mean += T.transpose().lazyProduct(bias.mean());
  const Mat<N, N> noise = track.V.lazyProduct(DV) - DV.transpose().lazyProduct(T);
  track.estimate.cov += (noise + noise.transpose()) / 2;
  track.V -= T.transpose();
}

/// What an update has seen.
template <int M>
struct TwoStageUpdate {
  Vec<M> innovation;
  Mat<M, M> S;     ///< of the innovation, what is not known of the biases included
  double nis = 0;  ///< chi2(M) if the model is right
  Verdict verdict = Verdict::Accepted;
};

/// One measurement of one target: innovation nu = z - h(x^, b^) at the compensated mean, Jacobians H by the state and C
/// by the biases from index `at` on (M x their number; no columns: a sensor without bias), noise R. Unless Accepted,
/// nothing changes. `gate`: a chi2(M) quantile.
template <int N, int M, int Biases, int Max, class Jacobian>
[[nodiscard]] TwoStageUpdate<M> update(SharedBias<Biases, Max>& bias, BiasFreeTrack<N, Biases>& track, const Vec<M>& nu,
                                       const Mat<M, N>& H, const Eigen::MatrixBase<Jacobian>& C, int at,
                                       const Mat<M, M>& R, double gate) {
  using Columns = typename SharedBias<Biases, Max>::template Columns<M>;
  // Given b: nu + S b^ = S b + H (x - x~) + w with S = H V + C.
  Columns S_t = track.V.transpose().lazyProduct(H.transpose());
  S_t.middleRows(at, C.cols()) += C.transpose();
  const Vec<M> nu_free = nu + S_t.transpose().lazyProduct(bias.mean());
  const Update<N, M> free = kalman_update<N, M>(track.estimate, nu_free, H, R, std::numeric_limits<double>::infinity());

  TwoStageUpdate<M> u{.innovation = nu, .S = free.S, .nis = 0, .verdict = free.verdict};
  if (free.verdict != Verdict::Accepted) return u;
  const Columns Y = bias.covariance().lazyProduct(S_t);
  u.S += S_t.transpose().lazyProduct(Y);
  const Eigen::LLT<Mat<M, M>> llt(u.S);
  u.nis = nu.dot(llt.solve(nu));
  if (!(u.nis <= gate)) {  // written so that NaN is gated
    u.verdict = Verdict::Gated;
    return u;
  }
  track.estimate = free.posterior;
  subtract_product(track.V, free.K, S_t);
  bias.template apply<M>(Y, llt.matrixL(), nu);
  return u;
}

}  // namespace downrange
