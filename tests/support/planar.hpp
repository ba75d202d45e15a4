#pragma once
/// A plane with nearly-constant-velocity targets and random measurements, for tests of bias estimators that are linear.

#include <Eigen/Core>
#include <downrange/est/filter/gaussian.hpp>
#include <random>

namespace downrange::test {

inline Mat<4, 4> planar_transition(double dt) {
  Mat<4, 4> Phi = Mat<4, 4>::Identity();
  Phi.topRightCorner<2, 2>().diagonal().setConstant(dt);
  return Phi;
}

/// White acceleration of density q.
inline Mat<4, 4> planar_noise(double dt, double q) {
  const Mat<2, 2> I = Mat<2, 2>::Identity();
  Mat<4, 4> Q;
  Q << dt * dt * dt / 3 * I, dt * dt / 2 * I, dt * dt / 2 * I, dt * I;
  return q * Q;
}

inline Mat<2, 4> planar_position() { return (Mat<2, 4>() << Mat<2, 2>::Identity(), Mat<2, 2>::Zero()).finished(); }

class RandomMatrices {
 public:
  explicit RandomMatrices(std::uint64_t seed) : rng_(seed) {}

  double normal() { return normal_(rng_); }
  template <int N, int M>
  Mat<N, M> matrix() {
    return Mat<N, M>::NullaryExpr([this] { return normal(); });
  }
  /// Positive definite, eigenvalues of the order of 1 to N.
  template <int N>
  Mat<N, N> covariance() {
    const Mat<N, N> A = matrix<N, N>();
    return A * A.transpose() + Mat<N, N>::Identity();
  }

 private:
  std::mt19937_64 rng_;
  std::normal_distribution<double> normal_;
};

}  // namespace downrange::test
