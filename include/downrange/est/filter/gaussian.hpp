#pragma once
/// The linear measurement update that every filter shares.

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cstdint>
#include <downrange/est/model/matrix.hpp>

namespace downrange {

enum class Verdict : std::uint8_t {
  Accepted,
  Gated,     ///< normalised innovation squared above the gate, or NaN
  Frozen,    ///< a receiver that repeats one fix while the vehicle moves
  Singular,  ///< innovation covariance not positive definite
};

template <int N, int M>
struct Update {
  Gaussian<N> posterior;            ///< The prior, untouched, unless verdict == Accepted.
  Vec<M> innovation;                ///< nu = z - h(x), angles wrapped by the model.
  Mat<M, M> S;                      ///< Innovation covariance H P H' + R.
  Mat<N, M> K = Mat<N, M>::Zero();  ///< Gain; zero unless verdict == Accepted.
  double nis = 0;                   ///< nu' S^-1 nu, chi2(M) if the model is right.
  Verdict verdict = Verdict::Accepted;
};

/// Kalman update in Joseph form (Bucy, Joseph 1968): the covariance stays symmetric and positive definite for any gain.
/// `innovation` = z - h(prior.mean), `H` its Jacobian, `R` positive definite, `gate` a chi2(M) quantile (infinity:
/// none).
template <int N, int M>
[[nodiscard]] Update<N, M> kalman_update(const Gaussian<N>& prior, const Vec<M>& innovation, const Mat<M, N>& H,
                                         const Mat<M, M>& R, double gate) {
  Update<N, M> u{.posterior = prior, .innovation = innovation, .S = {}};
  const Mat<N, M> PHt = prior.cov.lazyProduct(H.transpose());
  u.S = H.lazyProduct(PHt) + R;
  const Eigen::LLT<Mat<M, M>> llt(u.S);
  if (llt.info() != Eigen::Success) {
    u.verdict = Verdict::Singular;
    return u;
  }
  u.nis = innovation.dot(llt.solve(innovation));
  if (!(u.nis <= gate)) {  // written so that NaN is gated
    u.verdict = Verdict::Gated;
    return u;
  }
  u.K = llt.solve(PHt.transpose()).transpose();
  const Mat<N, N> ImKH = Mat<N, N>::Identity() - u.K.lazyProduct(H);
  u.posterior.mean += u.K * innovation;
  // Lazy: from nine states on Eigen would take its blocked kernels, which at this size cost three times as much.
  const Mat<N, N> ImKH_P = ImKH.lazyProduct(prior.cov);
  const Mat<N, M> KR = u.K.lazyProduct(R);
  const Mat<N, N> P = ImKH_P.lazyProduct(ImKH.transpose()) + KR.lazyProduct(u.K.transpose());
  u.posterior.cov = (P + P.transpose()) / 2;
  return u;
}

}  // namespace downrange
