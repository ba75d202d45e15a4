#pragma once
/// Vectors, matrices and Gaussian estimates of fixed size.

#include <Eigen/Core>

namespace downrange {

template <int N>
using Vec = Eigen::Matrix<double, N, 1>;
template <int N, int M>
using Mat = Eigen::Matrix<double, N, M>;

/// Mean and covariance; the covariance symmetric positive definite.
template <int N>
struct Gaussian {
  Vec<N> mean = Vec<N>::Zero();
  Mat<N, N> cov = Mat<N, N>::Identity();
};

}  // namespace downrange
