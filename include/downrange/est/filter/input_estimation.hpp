#pragma once
/// Input estimation: when did an unknown constant input begin, and how large is it (method `vdie`).
///
/// Hwang Bo, Hong, Choi, Choi, "Maneuvering-target tracking using the federated Kalman filter with multiple sensors",
/// eq. (14)-(18), corrected as est/ERRATA.md says: the input persists, T(n) = 0 at the onset n and then
/// T(k) = P(k|k) P^-1(k|k-1) [F T(k-1) + I]; the paper prints an impulse. Written for W = T B, the effect of a unit
/// input on the filter's state, and with P(k|k) P^-1(k|k-1) = I - K H, so that nothing is inverted and F, B and the
/// interval may differ from step to step; with several measurements at one instant the filter updates by one after the
/// other.

#include <algorithm>
#include <array>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/est/filter/gaussian.hpp>
#include <optional>

namespace downrange {

/// An input of U entries, and which hypothesis it comes from.
template <int U>
struct InputEstimate {
  Vec<U> u = Vec<U>::Zero();
  Mat<U, U> R_u = Mat<U, U>::Identity();
  double significance = 0;  ///< u' R_u^-1 u: chi2(U) when there is no input; twice the log likelihood ratio
  double age_s = 0;         ///< how long ago the input began
  int hypothesis = 0;       ///< 0: the oldest
};

/// State corrected for the input: x + W u, P + W R_u W'.
template <int N, int U>
[[nodiscard]] Gaussian<N> corrected(const Gaussian<N>& x, const InputEstimate<U>& input, const Mat<N, U>& W) {
  const Mat<N, N> P = x.cov + W * input.R_u * W.transpose();
  return {.mean = x.mean + W * input.u, .cov = (P + P.transpose()) / 2};
}

/// State corrected for the input and extended by it: [x + W u, u], with cov(x + W u, u) = W R_u.
template <int N, int U>
[[nodiscard]] Gaussian<N + U> extended(const Gaussian<N>& x, const InputEstimate<U>& input, const Mat<N, U>& W) {
  const Gaussian<N> state = corrected<N, U>(x, input, W);
  Gaussian<N + U> y;
  y.mean << state.mean, input.u;
  const Mat<N, U> cross = W * input.R_u;
  y.cov << state.cov, cross, cross.transpose(), input.R_u;
  return y;
}

/// Hypotheses that an input of U entries began at one of the last L onsets, run beside any linear(ised) filter of N
/// states that knows nothing of it. N may be Eigen::Dynamic: then the number of states is given once, and nothing is
/// allocated afterwards.
template <int N, int U, int L = 6>
class InputHypotheses {
 public:
  using Transfer = Mat<N, U>;

  explicit InputHypotheses(int states = N) {
    for (Hypothesis& h : hypotheses_) h.W = Transfer::Zero(states, U);
  }

  void clear() { count_ = 0; }
  [[nodiscard]] int count() const { return count_; }

  /// The input may have begun now; the oldest of L onsets is forgotten.
  void open() {
    if (count_ == L) {
      std::rotate(hypotheses_.begin(), hypotheses_.begin() + 1, hypotheses_.end());
      --count_;
    }
    Hypothesis& h = hypotheses_[static_cast<std::size_t>(count_++)];
    h.W.setZero();
    h.D.setZero();
    h.A.setZero();
    h.age_s = 0;
  }

  /// The filter predicted over dt seconds: `advance(W)` makes F W + B of each transfer, in place.
  template <class Advance>
  void predict_with(double dt, const Advance& advance) {
    for (int i = 0; i < count_; ++i) {
      Hypothesis& h = hypotheses_[static_cast<std::size_t>(i)];
      advance(h.W);
      h.age_s += dt;
    }
  }
  void predict(double dt, const Mat<N, N>& F, const Mat<N, U>& B) {
    predict_with(dt, [&](Transfer& W) { W = (F * W + B).eval(); });
  }

  /// The filter was updated with gain K (N x M) by innovation nu with covariance S; `observe(W)` is H W (M x U). Not to
  /// be called for a measurement that the filter refused.
  template <int M, class Observe, class Gain>
  void update_with(const Observe& observe, const Gain& K, const Mat<M, M>& S, const Vec<M>& nu) {
    const Eigen::LLT<Mat<M, M>> llt(S);
    for (int i = 0; i < count_; ++i) {
      Hypothesis& h = hypotheses_[static_cast<std::size_t>(i)];
      const Mat<M, U> HW = observe(h.W);
      const Mat<M, U> weighted = llt.solve(HW);
      h.D.noalias() += HW.transpose() * weighted;  // (17), first line: (H M B)' S^-1 (H M B)
      h.A.noalias() += weighted.transpose() * nu;  // (17), second line, sign corrected
      h.W -= K.lazyProduct(HW);                    // (15): (I - K H) [F W + B]
    }
  }
  template <int M>
  void update(const Mat<M, N>& H, const Mat<N, M>& K, const Mat<M, M>& S, const Vec<M>& nu) {
    update_with<M>([&](const Transfer& W) -> Mat<M, U> { return H * W; }, K, S, nu);
  }

  /// W of hypothesis i, 0 the oldest: the effect of a unit input on the filter's state.
  [[nodiscard]] const Transfer& transfer(int i) const { return hypotheses_[static_cast<std::size_t>(i)].W; }

  /// Of hypothesis i: u = D^-1 A (17), R_u = D^-1 (18). None while the data do not determine every entry.
  [[nodiscard]] std::optional<InputEstimate<U>> estimate(int i) const {
    const Hypothesis& h = hypotheses_[static_cast<std::size_t>(i)];
    const Eigen::LLT<Mat<U, U>> llt(h.D);
    constexpr double undetermined = 1e-12;  // reciprocal condition: what is left would be rounding
    if (llt.info() != Eigen::Success || !(llt.rcond() > undetermined)) return std::nullopt;
    const Vec<U> u = llt.solve(h.A);
    return InputEstimate<U>{
        .u = u, .R_u = llt.solve(Mat<U, U>::Identity()), .significance = h.A.dot(u), .age_s = h.age_s, .hypothesis = i};
  }

  /// The most likely onset: the largest significance, for all hypotheses explain the same data.
  [[nodiscard]] std::optional<InputEstimate<U>> best() const {
    std::optional<InputEstimate<U>> found;
    for (int i = 0; i < count_; ++i) {
      const auto e = estimate(i);
      if (e && (!found || e->significance > found->significance)) found = e;
    }
    return found;
  }

 private:
  struct Hypothesis {
    Transfer W;
    Mat<U, U> D = Mat<U, U>::Zero();
    Vec<U> A = Vec<U>::Zero();
    double age_s = 0;
  };

  std::array<Hypothesis, static_cast<std::size_t>(L)> hypotheses_{};
  int count_ = 0;
};

struct VdieSettings {
  double detection_probability = 0.9973;  ///< of chi2(U): the 3 sigma of the paper
  double quiet_probability = 0.95;        ///< of chi2(U): below this quantile the acceleration is insignificant
  int quiet_scans = 2;                    ///< so many scans in a row end the manoeuvre
};

/// Variable dimension filter (Bar-Shalom, Birmiwal 1982, doi 10.1109/TAES.1982.309274) whose manoeuvres are found and
/// started by input estimation: N quiet states; while a manoeuvre lasts also its U inputs (accelerations).
template <int N, int U>
class VariableDimension {
 public:
  /// One step of motion: x <- F x + B u, noise Q; `Q_input` is what the input may change by.
  struct Step {
    double dt = 0;
    Mat<N, N> F;
    Mat<N, U> B;
    Mat<N, N> Q;
    Mat<U, U> Q_input;
  };

  VariableDimension(const Gaussian<N>& start, const VdieSettings& settings)
      : settings_(settings),
        detection_(chi2_quantile(settings.detection_probability, U)),
        quiet_(chi2_quantile(settings.quiet_probability, U)),
        state_{.mean = Vec<N + U>::Zero(), .cov = Mat<N + U, N + U>::Zero()} {
    state_.mean.template head<N>() = start.mean;
    state_.cov.template topLeftCorner<N, N>() = start.cov;
  }

  [[nodiscard]] bool manoeuvring() const { return manoeuvring_; }
  [[nodiscard]] Gaussian<N> state() const {
    return {.mean = state_.mean.template head<N>(), .cov = state_.cov.template topLeftCorner<N, N>()};
  }
  /// Mean zero and covariance zero while there is no manoeuvre.
  [[nodiscard]] Gaussian<U> input() const {
    return {.mean = state_.mean.template tail<U>(), .cov = state_.cov.template bottomRightCorner<U, U>()};
  }

  void predict(const Step& step) {
    if (!manoeuvring_) {
      hypotheses_.open();
      hypotheses_.predict(step.dt, step.F, step.B);
    }
    Mat<N + U, N + U> F = Mat<N + U, N + U>::Identity();
    F.template topLeftCorner<N, N>() = step.F;
    F.template topRightCorner<N, U>() = step.B;
    Mat<N + U, N + U> P = F * state_.cov * F.transpose();
    P.template topLeftCorner<N, N>() += step.Q;
    if (manoeuvring_) P.template bottomRightCorner<U, U>() += step.Q_input;
    state_ = {.mean = F * state_.mean, .cov = (P + P.transpose()) / 2};
  }

  /// One measurement; several at one instant one after the other. `innovation` = z - h(state), H over the N states.
  template <int M>
  Update<N, M> update(const Vec<M>& innovation, const Mat<M, N>& H, const Mat<M, M>& R, double gate) {
    Mat<M, N + U> H_all = Mat<M, N + U>::Zero();
    H_all.template leftCols<N>() = H;
    const Update<N + U, M> u = kalman_update<N + U, M>(state_, innovation, H_all, R, gate);
    if (u.verdict == Verdict::Accepted) {
      if (!manoeuvring_) {
        const Mat<M, N> HP = H * state_.cov.template topLeftCorner<N, N>();
        const Mat<N, M> K = u.S.llt().solve(HP).transpose();
        hypotheses_.template update<M>(H, K, u.S, innovation);
      }
      state_ = u.posterior;
    }
    return {.posterior = state(), .innovation = innovation, .S = u.S, .nis = u.nis, .verdict = u.verdict};
  }

  /// After all measurements of one instant: opens the acceleration where input estimation finds one, closes it when it
  /// has become insignificant.
  void decide() {
    if (!manoeuvring_) {
      const auto found = hypotheses_.best();
      if (!found || !(found->significance > detection_)) return;
      state_ = extended<N, U>(state(), *found, hypotheses_.transfer(found->hypothesis));
      manoeuvring_ = true;
      quiet_in_row_ = 0;
      return;
    }
    const Gaussian<U> u = input();
    quiet_in_row_ = normalised_square<U>(u.mean, u.cov) <= quiet_ ? quiet_in_row_ + 1 : 0;
    if (quiet_in_row_ < settings_.quiet_scans) return;
    state_.mean.template tail<U>().setZero();
    state_.cov.template rightCols<U>().setZero();
    state_.cov.template bottomRows<U>().setZero();
    manoeuvring_ = false;
    hypotheses_.clear();
  }

 private:
  VdieSettings settings_;
  double detection_;
  double quiet_;
  Gaussian<N + U> state_;  ///< the last U entries zero while there is no manoeuvre
  bool manoeuvring_ = false;
  int quiet_in_row_ = 0;
  InputHypotheses<N, U> hypotheses_;
};

}  // namespace downrange
