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

#include <algorithm>
#include <cmath>
#include <downrange/est/gaussian.hpp>
#include <limits>
#include <utility>

namespace downrange {

/// The estimate of the biases, held as mean and the Cholesky factor of the information matrix: a measurement only adds
/// to it, so it cannot lose definiteness. `Biases` may be Eigen::Dynamic; then `MaxBiases` is what intermediate results
/// on the stack are sized for.
template <int Biases, int MaxBiases = Biases>
class SharedBias {
 public:
  using Vector = Eigen::Matrix<double, Biases, 1>;
  using Square = Eigen::Matrix<double, Biases, Biases>;
  /// M vectors of bias size, on the stack.
  template <int M>
  using Columns = Eigen::Matrix<double, Biases, M, 0, MaxBiases, M>;
  using Column = Columns<1>;

  /// `cov` positive definite.
  SharedBias(Vector mean, const Square& cov) : mean_(std::move(mean)) {
    const Square information = cov.llt().solve(Square::Identity(cov.rows(), cov.cols()));
    L_ = information.llt().matrixL();
  }

  [[nodiscard]] const Vector& mean() const { return mean_; }
  [[nodiscard]] Eigen::Index size() const { return mean_.size(); }

  /// Sigma X = (L L')^-1 X, column by column.
  template <int M>
  [[nodiscard]] Columns<M> times_covariance(Columns<M> X) const {
    for (Eigen::Index i = 0; i < X.cols(); ++i) {
      solve_lower(X.col(i));
      L_.transpose().template triangularView<Eigen::Upper>().solveInPlace(X.col(i));
    }
    return X;
  }
  /// L^-1 X, of which X' Sigma X is the square.
  template <int M>
  [[nodiscard]] Columns<M> whitened(Columns<M> X) const {
    for (Eigen::Index i = 0; i < X.cols(); ++i) solve_lower(X.col(i));
    return X;
  }
  /// One row, which is one column, of the covariance.
  [[nodiscard]] Column covariance_row(int i) const { return times_covariance<1>(Column::Unit(size(), i)); }
  /// Its diagonal.
  [[nodiscard]] Column variances() const {
    Column variance(size());
    for (Eigen::Index i = 0; i < size(); ++i) variance[i] = whitened<1>(Column::Unit(size(), i)).squaredNorm();
    return variance;
  }
  /// All of it.
  [[nodiscard]] Square covariance() const {
    Square cov(size(), size());
    for (int i = 0; i < size(); ++i) cov.col(i) = covariance_row(i);
    return ((cov + cov.transpose()) / 2).eval();
  }

  /// The information of M numbers nu = S (b - mean) + noise of unit covariance; the columns of `S_transposed` are S's
  /// rows.
  template <int M>
  void add(const Columns<M>& S_transposed, const Vec<M>& nu) {
    for (int i = 0; i < M; ++i) rank_one(S_transposed.col(i), 1);
    mean_ += times_covariance<1>(S_transposed * nu);
  }

  /// How the biases before one of them stepped depend on those after: b_before = (I - e_i g') b_after + e_i (offset +
  /// d), d of variance `variance`, independent of b_after.
  struct Step {
    int i = 0;
    Column g;
    double offset = 0;
    double variance = 0;
  };

  /// Bias i takes a random step of variance q: its covariance grows by q, its mean stays. Every track then needs
  /// `loosen` with the result.
  [[nodiscard]] Step loosen(int i, double q) {
    const Column row = L_.row(i).transpose();
    const Column information = L_ * row;  // column i of L L'
    const double variance = q / (1 + q * information[i]);
    rank_one(std::sqrt(variance) * information, -1);
    const Column g = variance * information;
    return {.i = i, .g = g, .offset = g.dot(mean_), .variance = variance};
  }

 private:
  void solve_lower(Eigen::Ref<Eigen::VectorXd> x) const { L_.template triangularView<Eigen::Lower>().solveInPlace(x); }

  /// L L' + sign v v' into L (Gill, Golub, Murray, Saunders 1974). A difference is positive definite wherever this is
  /// called; the floor keeps rounding from saying otherwise.
  void rank_one(Column v, int sign) {
    for (Eigen::Index k = 0; k < size(); ++k) {
      if (v[k] == 0) continue;
      const double l = L_(k, k);
      const double square = sign > 0 ? l * l + v[k] * v[k] : (l - v[k]) * (l + v[k]);
      L_(k, k) = std::sqrt(std::max(square, std::numeric_limits<double>::epsilon() * l * l));
      const double c = L_(k, k) / l;
      const double s = v[k] / l;
      const Eigen::Index below = size() - k - 1;
      L_.col(k).tail(below) = (L_.col(k).tail(below) + sign * s * v.tail(below)) / c;
      v.tail(below) = c * v.tail(below) - s * L_.col(k).tail(below);
    }
  }

  Vector mean_;
  Square L_;
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
  const Columns Y = bias.template whitened<N>(track.V.transpose());
  const Mat<N, N> P = track.estimate.cov + Y.transpose() * Y;
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

/// A bias took a random step. Exact for one target; of several, the errors that the step makes common are taken as
/// independent, which for a slow drift is little.
template <int N, int Biases, int Max>
void loosen(BiasFreeTrack<N, Biases>& track, const typename SharedBias<Biases, Max>::Step& step) {
  const Vec<N> v = track.V.col(step.i);
  track.estimate.mean += step.offset * v;
  track.estimate.cov += step.variance * v * v.transpose();
  track.V.noalias() -= v * step.g.transpose();
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
  const Vec<M> nu_free = nu + S_t.transpose() * bias.mean();
  const Update<N, M> free = kalman_update<N, M>(track.estimate, nu_free, H, R, std::numeric_limits<double>::infinity());

  TwoStageUpdate<M> u{.innovation = nu, .S = free.S, .nis = 0, .verdict = free.verdict};
  if (free.verdict != Verdict::Accepted) return u;
  const Columns Y = bias.template whitened<M>(S_t);
  u.S += Y.transpose() * Y;
  u.nis = nu.dot(u.S.llt().solve(nu));
  if (!(u.nis <= gate)) {  // written so that NaN is gated
    u.verdict = Verdict::Gated;
    return u;
  }
  track.estimate = free.posterior;
  track.V.noalias() -= free.K * S_t.transpose();
  const Eigen::LLT<Mat<M, M>> llt(free.S);
  bias.template add<M>(llt.matrixL().solve(S_t.transpose()).transpose(), llt.matrixL().solve(nu));
  return u;
}

}  // namespace downrange
