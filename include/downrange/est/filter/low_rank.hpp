#pragma once
/// What a measurement of few rows does to a covariance of many states. Written by columns and without Eigen's blocked
/// kernels: these pack their operands first, and at such sizes take several times as long.
///
/// P - W W' of the optimal gain instead of Joseph's form, which costs the square of the states for every row of a gain:
/// tests hold it positive definite over a million updates, and symmetric to the bit.

#include <downrange/est/filter/gaussian.hpp>
#include <utility>

namespace downrange {

/// P -= A B' for P of A.rows() x B.rows(). With A = B entries either side of the diagonal are the same sums of the same
/// products: what was symmetric stays so to the bit.
template <class Block, class Left, class Right>
void subtract_product(Block&& P, const Left& A, const Right& B) {
  constexpr auto columns = std::make_integer_sequence<int, Left::ColsAtCompileTime>();
  for (Eigen::Index j = 0; j < B.rows(); ++j) {
    [&]<int... k>(std::integer_sequence<int, k...>) { P.col(j) -= ((A.col(k) * B(j, k)) + ...); }
    (columns);
  }
}

/// X L^-T for lower triangular L, in place: of X = P H' and S = L L' what P loses is the square of the result.
template <class Matrix, int M>
void divide_by_transposed(Matrix& X, const Mat<M, M>& L) {
  for (int j = 0; j < M; ++j) {
    for (int k = 0; k < j; ++k) X.col(j) -= L(j, k) * X.col(k);
    X.col(j) /= L(j, j);
  }
}

/// X L^-1 for lower triangular L, in place.
template <class Matrix, int M>
void divide_by(Matrix& X, const Mat<M, M>& L) {
  for (int j = M - 1; j >= 0; --j) {
    for (int k = j + 1; k < M; ++k) X.col(j) -= L(k, j) * X.col(k);
    X.col(j) /= L(j, j);
  }
}

}  // namespace downrange
