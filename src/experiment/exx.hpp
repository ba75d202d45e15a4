#pragma once
/// Biases of asynchronous radars from measurements alone: the target's state is eliminated from the measurements of a
/// time slot. X. Lin, Y. Bar-Shalom, T. Kirubarajan, Multisensor-multitarget bias estimation for general asynchronous
/// sensors, IEEE Trans. AES 41(3), 2005 (method `exx`), derived here for any linear motion with process noise.

#include <Eigen/QR>
#include <array>
#include <downrange/est/filter/gaussian.hpp>

namespace downrange {

/// `L` measurements of one target in order of time, L M > N. With the state x at the first of them, the stack is
///   z_k = H_k Phi(k, 1) x + H_k u_k + BC_k beta + w_k,   u_k the process noise since the first,
/// and rows T orthogonal to the stacked H_k Phi(k, 1) (parity vectors) leave  T z = T BC beta + T (H u + w). Slots are
/// disjoint in time, so their noise is independent of each other's; what is known of the state from earlier slots is
/// given up, N of L M numbers.
template <int N, int M, int B, int S, int L>
class ParitySlot {
 public:
  static_assert(L * M > N, "a slot eliminates N state variables and must have measurements left");
  static constexpr int rows = L * M - N;
  struct Parity {
    Vec<rows> z;
    Mat<rows, B * S> J;  ///< of [beta_1 ... beta_S]
    Mat<rows, rows> R;
  };

  void clear() { count_ = 0; }
  [[nodiscard]] bool complete() const { return count_ == L; }

  /// Next measurement, of `radar`; Phi and Q lead to it from the one before (not read for the first). Not when
  /// complete.
  void add(const Mat<N, N>& Phi, const Mat<N, N>& Q, int radar, const Vec<M>& z, const Mat<M, N>& H,
           const Mat<M, B>& BC, const Mat<M, M>& R) {
    const int k = count_++;
    const int row = M * k;
    if (k == 0) {
      J_.setZero();
      noise_.setZero();
      transition_.setIdentity();
    } else {
      transition_ = Phi * transition_;
      for (int l = 0; l < k; ++l) process_[l] = Phi * process_[l];  // cov(u_k, u_l)
    }
    process_[k] = k == 0 ? Mat<N, N>(Mat<N, N>::Zero()) : Mat<N, N>(process_[k - 1] * Phi.transpose() + Q);
    H_[k] = H;
    z_.template segment<M>(row) = z;
    A_.template middleRows<M>(row) = H * transition_;
    J_.template block<M, B>(row, B * radar) = BC;
    for (int l = 0; l <= k; ++l) {
      const Mat<M, M> block = H * process_[l] * H_[l].transpose();
      noise_.template block<M, M>(row, M * l) = block;
      noise_.template block<M, M>(M * l, row) = block.transpose();
    }
    noise_.template block<M, M>(row, row) += R;
  }

  /// Of a complete slot.
  [[nodiscard]] Parity parity() const {
    const Eigen::HouseholderQR<Mat<L * M, N>> qr(A_);
    const Mat<L * M, L* M> full = qr.householderQ();
    const Mat<L * M, rows> T = full.template rightCols<rows>();
    const Mat<rows, rows> R = T.transpose() * noise_ * T;
    return {T.transpose() * z_, T.transpose() * J_, (R + R.transpose()) / 2};
  }

 private:
  int count_ = 0;
  Mat<N, N> transition_;
  std::array<Mat<N, N>, L> process_;  ///< cov(u_k, u_l) of the newest k
  std::array<Mat<M, N>, L> H_;
  Vec<L * M> z_;
  Mat<L * M, N> A_;
  Mat<L * M, B * S> J_;
  Mat<L * M, L * M> noise_;
};

}  // namespace downrange
