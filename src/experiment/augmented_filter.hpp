#pragma once
/// The filter that method `ts` must equal: every target and every bias in one state. Dense, for comparison only.

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <downrange/est/filter/gaussian.hpp>
#include <vector>

namespace downrange::experiment {

/// State [x_1 ... x_T b], N entries per target.
template <int N>
struct AugmentedFilter {
  Eigen::VectorXd x;
  Eigen::MatrixXd P;

  /// Targets start independent of the biases.
  AugmentedFilter(const std::vector<Gaussian<N>>& targets, const Eigen::VectorXd& bias, const Eigen::MatrixXd& cov)
      : bias_at_(N * static_cast<int>(targets.size())) {
    x.resize(bias_at_ + bias.size());
    P = Eigen::MatrixXd::Zero(x.size(), x.size());
    for (int t = 0; t < static_cast<int>(targets.size()); ++t) {
      x.segment<N>(N * t) = targets[static_cast<std::size_t>(t)].mean;
      P.block<N, N>(N * t, N * t) = targets[static_cast<std::size_t>(t)].cov;
    }
    x.tail(bias.size()) = bias;
    P.bottomRightCorner(bias.size(), bias.size()) = cov;
  }

  [[nodiscard]] Vec<N> target(int t) const { return x.segment<N>(N * t); }
  [[nodiscard]] Mat<N, N> covariance(int t) const { return P.block<N, N>(N * t, N * t); }
  [[nodiscard]] Eigen::VectorXd bias() const { return x.tail(x.size() - bias_at_); }
  [[nodiscard]] Eigen::MatrixXd bias_covariance() const {
    const Eigen::Index n = x.size() - bias_at_;
    return P.bottomRightCorner(n, n);
  }

  /// All targets move alike.
  void predict(const Mat<N, N>& Phi, const Mat<N, N>& Q) {
    for (int k = 0; k < bias_at_; k += N) {
      x.segment<N>(k) = (Phi * x.segment<N>(k)).eval();
      P.middleRows<N>(k) = (Phi * P.middleRows<N>(k)).eval();
    }
    for (int k = 0; k < bias_at_; k += N) {
      P.middleCols<N>(k) = (P.middleCols<N>(k) * Phi.transpose()).eval();
      P.block<N, N>(k, k) += Q;
    }
  }

  /// Innovation nu of target t, Jacobians H by its state and C by the biases from `at` on.
  template <int M, int B>
  void update(int t, const Vec<M>& nu, const Mat<M, N>& H, const Mat<M, B>& C, int at, const Mat<M, M>& R) {
    const Eigen::Matrix<double, Eigen::Dynamic, M> PHt =
        P.middleCols<N>(N * t) * H.transpose() + P.middleCols<B>(bias_at_ + at) * C.transpose();
    const Mat<M, M> S = H * PHt.template middleRows<N>(N * t) + C * PHt.template middleRows<B>(bias_at_ + at) + R;
    const Eigen::LLT<Mat<M, M>> llt(S);
    const Eigen::Matrix<double, Eigen::Dynamic, M> W = llt.matrixL().solve(PHt.transpose()).transpose();
    x += W * llt.matrixL().solve(nu);
    P.noalias() -= W * W.transpose();
  }

 private:
  int bias_at_;
};

}  // namespace downrange::experiment
