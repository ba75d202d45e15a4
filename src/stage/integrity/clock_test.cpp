#include "clock_test.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <downrange/est/filter/consistency.hpp>
#include <utility>

namespace downrange::integrity {
namespace {

/// A clock may be off by any time that leaves it on the same flight.
constexpr double any_clock_s = 5;
/// Clocks drift against each other, per square root of a second.
constexpr double drift_s = 1e-3;
/// While one of them is wrong, which ends without notice: a tenth of a second is no jump that the noise does not hide.
constexpr double wrong_drift_s = 2e-2;
/// Of the threshold: right again.
constexpr double right = 0.35;
/// Below this no clock is called wrong.
constexpr double stated_s = 0.01;
/// A jump: two differences in a row that the clocks, as they were, do not explain.
constexpr int jump = 2;
/// Differences that no clock explains, however far it is off: all begins anew.
constexpr int no_clock = 6;
/// Explained, in a row, before anything is said.
constexpr int steady = 4;
constexpr double false_alarm = 1e-7;
/// What stands still tells nothing of clocks; and of biases what holds at one place only.
constexpr double moves_m_s = 10;
/// Of what varies slowly: that it can be inverted.
constexpr double least_slow = 1e-6;

}  // namespace

double ClockTest::threshold() {
  static const double one = chi2_quantile(1 - false_alarm, 1);
  return one;
}

void ClockTest::begin(Time at) {
  x_.setZero();
  P_.setZero();
  begun_ = wrong_ = false;
  misfits_ = fits_ = 0;
  newest_ = since_ = misfit_since_ = at;
}

void ClockTest::know(const KnownBias& first, const KnownBias& second) {
  P_(clocks, clocks) = any_clock_s * any_clock_s;
  P_.block<bias_term_count, bias_term_count>(of_second, of_second) = second.cov;
  P_.block<bias_term_count, bias_term_count>(of_first, of_first) = first.cov;
  P_.block<3, 3>(slow, slow).setIdentity();
  begun_ = true;
}

void ClockTest::open_clocks(Time at) {
  x_[clocks] = 0;
  P_.row(clocks).setZero();
  P_.col(clocks).setZero();
  P_(clocks, clocks) = any_clock_s * any_clock_s;
  since_ = at;
}

void ClockTest::predict(double dt_s, double tau_s) {
  const double kept = tau_s > 0 ? std::exp(-dt_s / tau_s) : 0;
  x_.tail<3>() *= kept;
  P_.rightCols<3>() *= kept;
  P_.bottomRows<3>() *= kept;
  P_.block<3, 3>(slow, slow) += (1 - kept * kept) * Mat<3, 3>::Identity();
  const double drift = wrong_ ? wrong_drift_s : drift_s;
  P_(clocks, clocks) += drift * drift * dt_s;
}

TestResult ClockTest::operator()(const Witness& first, const Sample& a, const Witness& second, const Sample& b,
                                 const Threshold& threshold) {
  if (second.is_receiver() || a.motion.segment<3>(3).norm() < moves_m_s) return {};
  const auto now = difference(first, a, first.prior.mean, second, b, second.prior.mean);
  if (!now) return {};
  // Directions alone, against a radar: what its bias does to them where the target is near is no straight function of
  // it.
  if (!now->ranged && !first.is_receiver()) return {};
  const Time at = a.epoch;
  if (!begun_) {
    begin(at);
    know(first.prior, second.prior);
  }
  predict((at - std::exchange(newest_, at)).seconds(), std::min(first.slow_tau_s, second.slow_tau_s));

  Row H = Row::Zero();
  H.col(clocks) = now->by_second.col(static_cast<Eigen::Index>(BiasTerm::TimeTag));
  H.middleCols<bias_term_count>(of_second) = now->by_second;
  H.middleCols<bias_term_count>(of_first) = now->by_first;
  H.rightCols<3>() =
      Eigen::LLT<Mat<3, 3>>(now->slow_first + now->slow_second + least_slow * now->white).matrixL().toDenseMatrix();
  Vec<3> d = now->d;
  Mat<3, 3> R = now->white + north_jump(now->by_first, first.prior) + north_jump(now->by_second, second.prior);
  if (!now->ranged) {
    H.row(0).setZero();
    d[0] = 0;
    R.row(0).setZero();
    R.col(0).setZero();
    R(0, 0) = 1;
  }
  const auto weigh = [&](Vec<3>& innovation, Mat<3, 3>& S) {
    innovation = wrapped(second, d - H * x_);
    S = H * P_ * H.transpose() + R;
    return threshold.ratio(innovation, S, now->ranged) < 1;
  };
  Vec<3> innovation;
  Mat<3, 3> S;
  bool fits = weigh(innovation, S);
  if (!fits) {
    fits_ = 0;
    if (++misfits_ == 1) misfit_since_ = at;
    if (misfits_ >= no_clock) begin(at);
    if (misfits_ != jump) return {};
    open_clocks(misfit_since_);
    fits = weigh(innovation, S);
    if (!fits) return {};
  }
  misfits_ = 0;
  ++fits_;
  const Eigen::Matrix<double, size, 3> K = S.llt().solve(H * P_).transpose();
  x_ += K * innovation;
  P_ -= K * S * K.transpose();
  P_ = (P_ + P_.transpose()).eval() / 2;

  TestResult result;
  if (const std::optional<ClocksApart> found = apart()) {
    result.whitened[0] = found->by_s / found->sigma_s;
    result.ratio = result.whitened[0] * result.whitened[0] / ClockTest::threshold();
    wrong_ = result.ratio >= 1 || (wrong_ && result.ratio >= right);
    result.apart_m = std::abs(found->by_s) * a.motion.segment<3>(3).norm();
  }
  return result;
}

std::optional<ClocksApart> ClockTest::apart() const {
  if (fits_ < steady) return std::nullopt;
  return ClocksApart{x_[clocks], std::hypot(std::sqrt(std::max(P_(clocks, clocks), 0.0)), stated_s)};
}

}  // namespace downrange::integrity
