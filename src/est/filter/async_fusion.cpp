#include <algorithm>
#include <cassert>
#include <downrange/est/filter/async_fusion.hpp>
#include <downrange/est/model/motion.hpp>

namespace downrange {
namespace {

constexpr int max_rows = 3 * max_batch;
using Stacked = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, max_rows, 1>;
using StackedSquare = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, max_rows, max_rows>;
using StateByStacked = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, max_rows>;

/// Hb_i Q(tau) Hb_j' = this times I3, with Hb = H Phi^-1 = [I, -age I] and Q the CV process noise over tau.
double projected_noise(double age_i, double age_j, double tau, double q) {
  return q * (tau * tau * tau / 3 - (age_i + age_j) * tau * tau / 2 + age_i * age_j * tau);
}

}  // namespace

Gaussian<6> fuse_asynchronous(const Gaussian<6>& previous, double T, std::span<const TimedPosition> batch, double q) {
  assert(!batch.empty() && batch.size() <= max_batch);
  const Gaussian<6> x = cv::predict(previous, T, q);  // (36), (37)
  const int n = static_cast<int>(batch.size());

  Stacked nu(3 * n);               // Y - A x
  StateByStacked At(6, 3 * n);     // A', A_i = Hb_i = [I, -age_i I]     (29), (30)
  StateByStacked S(6, 3 * n);      // cov(w, eta) = -Q(t_k, t_i) Hb_i'   (35)
  StackedSquare R(3 * n, 3 * n);   // cov(eta)                           (32)
  StackedSquare AS(3 * n, 3 * n);  // A S
  for (int i = 0; i < n; ++i) {
    const double age_i = batch[static_cast<std::size_t>(i)].age_s;
    const auto& m = batch[static_cast<std::size_t>(i)];
    nu.segment<3>(3 * i) = m.z - (x.mean.head<3>() - age_i * x.mean.tail<3>());
    Mat<6, 3> Hbt;
    Hbt << Mat<3, 3>::Identity(), -age_i * Mat<3, 3>::Identity();
    At.middleCols<3>(3 * i) = Hbt;
    S.middleCols<3>(3 * i) = -cv::process_noise(age_i, q) * Hbt;
    for (int j = 0; j < n; ++j) {
      const double age_j = batch[static_cast<std::size_t>(j)].age_s;
      const double shared = std::min(age_i, age_j);  // Q(t_k, max(t_i, t_j)): the noise both have still to come
      R.block<3, 3>(3 * i, 3 * j) = projected_noise(age_i, age_j, shared, q) * Mat<3, 3>::Identity();
      AS.block<3, 3>(3 * i, 3 * j) = -projected_noise(age_i, age_j, age_j, q) * Mat<3, 3>::Identity();
    }
    R.block<3, 3>(3 * i, 3 * i) += m.R;
  }

  const StateByStacked PAt = x.cov.lazyProduct(At);
  const StateByStacked Cxy = PAt + S;
  const StackedSquare Cyy = At.transpose().lazyProduct(PAt) + AS + AS.transpose() + R;
  const StateByStacked K = Cyy.llt().solve(Cxy.transpose()).transpose();

  const Mat<6, 6> ImKA = Mat<6, 6>::Identity() - K.lazyProduct(At.transpose());
  const StateByStacked KR = K.lazyProduct(R);
  const StateByStacked ImKA_S = ImKA.lazyProduct(S);
  const Mat<6, 6> cross = ImKA_S.lazyProduct(K.transpose());
  const Mat<6, 6> P = ImKA * x.cov * ImKA.transpose() + KR.lazyProduct(K.transpose()) - cross - cross.transpose();
  return {.mean = x.mean + K.lazyProduct(nu), .cov = (P + P.transpose()) / 2};
}

}  // namespace downrange
