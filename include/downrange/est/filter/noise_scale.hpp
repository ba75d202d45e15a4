#pragma once
/// The noise of a source as its innovations show it, where the configured sigma is wrong: a scale of each variance,
/// with an inverse-gamma belief (S. Sarkka, J. Hartikainen, Non-linear noise adaptive Kalman filtering via variational
/// Bayes, 2013, arXiv 1302.0681; what is added to it stands in est/THEORY.md section 11).

#include <array>
#include <bitset>
#include <cstdint>
#include <downrange/est/filter/gaussian.hpp>
#include <downrange/est/model/measurement.hpp>

namespace downrange {

/// Of joint, schmidt and ts.
struct AdaptiveNoiseSettings {
  bool enabled = true;  ///< the scales are learnt; else every sigma holds as configured
};

/// Of an innovation nu with covariance S = H P H' + R = L L', `whitened` = L^-1 nu: w w' - S^-1 with w = S^-1 nu. Given
/// nu, the noise v has E[v v'] = R + R (w w' - S^-1) R, whatever gain the filter uses: zero in the mean where R is
/// right.
template <int M>
[[nodiscard]] Mat<M, M> noise_excess(const Mat<M, M>& L, const Vec<M>& whitened) {
  const Mat<M, M> L_inverse = L.template triangularView<Eigen::Lower>().solve(Mat<M, M>::Identity());
  const Vec<M> w = L_inverse.transpose() * whitened;
  return w * w.transpose() - L_inverse.transpose() * L_inverse;
}

/// What one measurement tells of its noise.
template <int M>
struct NoiseLesson {
  Verdict verdict = Verdict::Singular;
  /// Accepted: `noise_excess`; gated: nu nu' - S. Of several models of the motion the mean by their probabilities, of
  /// an accepted one by those after it. Of other verdicts nothing is learnt.
  Mat<M, M> excess = Mat<M, M>::Zero();
};

/// The scales of one source: of range, azimuth, elevation and range rate, or of a receiver's horizontal and vertical
/// position and velocity in east-north-up at the fix. A value, part of a filter's checkpoint; shared by all targets.
///
/// For each measurement: `open`, then with its outcome `update_scale`. What is not opened teaches nothing.
class NoiseScale {
 public:
  static constexpr int max_components = 4;
  static constexpr int range_rate = 3;
  static constexpr double least = 0.04;  ///< of the configured variance
  static constexpr double most = 100;
  /// A radar's scales wait until its biases are known roughly.
  static constexpr int plots_before = 200;
  /// When it is held, what was learnt within this before, or up to twice as long, is forgotten.
  static constexpr Duration forgotten = milliseconds(10'000);

  NoiseScale() = default;  ///< of a receiver
  /// `angle_inflation`: the factor on the configured variances of its angles that the noise R, as the filter is given
  /// it, contains. Where it stands for slow pointing errors (`wander_is_state` is false), which white noise cannot
  /// show, the scales of angles do not fall below it.
  [[nodiscard]] static NoiseScale of_radar(double angle_inflation, bool wander_is_state);

  /// What the variance given for a component is to be multiplied by.
  [[nodiscard]] double factor(int component) const {
    const auto i = static_cast<std::size_t>(component);
    return belief_[i].scale() / start_[i];
  }
  template <int M>
  [[nodiscard]] Vec<M> factors(int first) const {
    Vec<M> factors;
    for (int i = 0; i < M; ++i) factors[i] = factor(first + i);
    return factors;
  }
  /// The fix with its sigmas as they are believed to be.
  [[nodiscard]] Fix believed(const Fix& fix) const;

  /// The 1-sigma over the configured one; 0: nothing was learnt of this component.
  [[nodiscard]] double sigma_ratio(int component) const;

  /// Before a measurement is used: does it teach? `referenced`: its target has GPS; without, nothing changes.
  /// `held`: as of Measurement::noise_held; nothing changes, and what was learnt shortly before is forgotten.
  [[nodiscard]] bool open(Time epoch, bool held, bool referenced);

  /// Of a plot's components from `first` on, `variance` as they were used.
  template <int M>
  void update_scale(int first, const Vec<M>& variance, const NoiseLesson<M>& lesson) {
    const Vec<M> seen = relative<M>(lesson.verdict, variance, lesson.excess.diagonal());
    if (!teaches(first == range_rate, lesson.verdict, seen.maxCoeff())) return;
    for (int i = 0; i < M; ++i) add<1>(first + i, seen.template segment<1>(i));
  }
  /// Of a fix of position, or position and velocity, `used` with these sigmas.
  template <int M>
  void update_scale(const Fix& used, const NoiseLesson<M>& lesson) {
    const Mat<3, 3> R_enu_ecef = axes_of(used);
    Vec<M> variance = Vec<M>::Constant(used.sigma_velocity_m_s * used.sigma_velocity_m_s);
    variance.template head<2>().setConstant(used.sigma_horizontal_m * used.sigma_horizontal_m);
    variance[2] = used.sigma_vertical_m * used.sigma_vertical_m;
    Vec<M> excess = lesson.excess.diagonal();
    excess.template head<3>() =
        (R_enu_ecef * lesson.excess.template topLeftCorner<3, 3>() * R_enu_ecef.transpose()).diagonal();
    const Vec<M> seen = relative<M>(lesson.verdict, variance, excess);
    if (!teaches(false, lesson.verdict, seen.maxCoeff())) return;
    add<2>(0, seen.template segment<2>(0));
    add<1>(1, seen.template segment<1>(2));
    if constexpr (M == 6) add<3>(2, seen.template segment<3>(3));
  }

 private:
  /// Inverse gamma of shape a and scale b; at first worth sixteen plots, or eight fixes.
  struct Belief {
    double a = 8;
    double b = 8;
    [[nodiscard]] double scale() const { return b / a; }
  };
  using Beliefs = std::array<Belief, max_components>;
  /// The verdicts of the last hundred measurements, or of what there is.
  struct Recent {
    std::bitset<100> rejected;
    std::uint8_t next = 0;
    std::uint8_t filled = 0;

    void add(bool was_rejected);
    [[nodiscard]] bool many_rejected() const;
  };

  [[nodiscard]] static Mat<3, 3> axes_of(const Fix& fix);
  /// E[v^2] / R.
  template <int M>
  [[nodiscard]] static Vec<M> relative(Verdict verdict, const Vec<M>& variance, const Vec<M>& excess) {
    if (verdict == Verdict::Accepted) return Vec<M>::Ones() + variance.cwiseProduct(excess);
    return (Vec<M>::Ones() + excess.cwiseQuotient(variance)).cwiseMax(0);
  }
  /// `largest`: of the values of E[v^2] / R.
  [[nodiscard]] bool teaches(bool of_range_rate, Verdict verdict, double largest);
  /// Values of E[v^2] / R.
  template <int N>
  void add(int component, const Vec<N>& seen) {
    add(component, seen.cwiseMin(16).sum(), N);
  }
  void add(int component, double sum, int count);

  std::array<double, max_components> start_{1, 1, 1, 1};  ///< what R contains of the scale
  std::array<double, max_components> least_{least, least, least, least};
  double forgetting_ = 1.0 / 100;  ///< per measurement
  int wait_ = 0;                   ///< measurements before anything is learnt
  Beliefs belief_{};
  std::bitset<max_components> learnt_;
  std::array<Recent, 2> recent_{};  ///< of position, and of range rate
  bool held_ = false;
  Beliefs before_{};  ///< at `kept_` less `forgotten`, or at the begin
  Beliefs at_kept_{};
  Time kept_;
};

}  // namespace downrange
