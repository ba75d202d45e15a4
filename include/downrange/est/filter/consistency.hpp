#pragma once
/// Is a filter's covariance honest: NIS, NEES, chi-square and binomial bands, the mismatch alarm, running statistics.
///
/// Every band comes with its false-alarm rate: the probability with which a filter that is right falls outside.

#include <array>
#include <bitset>
#include <downrange/est/filter/gaussian.hpp>
#include <downrange/est/model/bias_terms.hpp>
#include <limits>

namespace downrange {

/// x with P(chi2(dof) <= x) = probability; infinity for probability 1. dof >= 1, 0 < probability <= 1. Boost.Math.
[[nodiscard]] double chi2_quantile(double probability, int dof);

/// The quantiles of one probability by degrees of freedom, up to the terms of a bias: gates of measurements and biases
/// of different size.
class Gates {
 public:
  explicit Gates(double probability) {
    for (int dof = 1; dof < static_cast<int>(quantile_.size()); ++dof)
      quantile_[static_cast<std::size_t>(dof)] = chi2_quantile(probability, dof);
  }
  [[nodiscard]] double operator[](int dof) const { return quantile_[static_cast<std::size_t>(dof)]; }

 private:
  std::array<double, bias_term_count + 1> quantile_{};
};

/// e' P^-1 e: the NIS of an innovation with S, the NEES of an error with P; chi2(N) where P is right. NaN where P is
/// not positive definite, so that no comparison calls it inside.
template <int N>
[[nodiscard]] double normalised_square(const Vec<N>& e, const Mat<N, N>& P) {
  const Eigen::LLT<Mat<N, N>> llt(P);
  if (llt.info() != Eigen::Success) return std::numeric_limits<double>::quiet_NaN();
  return e.dot(llt.solve(e));
}

struct Band {
  double low = 0;
  double high = 0;

  [[nodiscard]] bool contains(double x) const { return low <= x && x <= high; }  // NaN is outside
};

/// Where the mean over n independent values of chi2(dof) / dof falls: average NIS or NEES per degree of freedom of a
/// right filter. `n` counts independent values: runs at one instant, or the innovations of one run, never the NEES
/// along one run. Two-sided, each side half of `false_alarm`. (Bar-Shalom, Li, Kirubarajan 2001, section 5.4.)
[[nodiscard]] Band average_chi2_band(int dof, int n, double false_alarm);

/// Where the share of n independent trials that succeed with `probability` falls: exact binomial, the narrowest whole
/// counts with at most half of `false_alarm` beyond each side.
[[nodiscard]] Band share_band(double probability, int n, double false_alarm);

/// What the success probability behind `successes` of n trials may be (Clopper, Pearson 1934, doi
/// 10.1093/biomet/26.4.404): it contains the truth with at least 1 - false_alarm. n >= 1.
[[nodiscard]] Band clopper_pearson(int successes, int n, double false_alarm);

/// Share of normalised squares inside their 95 % region, over whatever is added.
struct InsideShare {
  int inside = 0;
  int total = 0;

  /// `square` of `dof` degrees of freedom; NaN counts as outside.
  void add(double square, int dof);
  [[nodiscard]] double share() const { return total > 0 ? static_cast<double>(inside) / total : 1; }
};

/// Rings when the share of NIS inside 95 % over the last `window` innovations falls below 0.93: the model of the source
/// (most often its bias blocks) is wrong (est/THEORY.md section 3). A plain value: part of a filter's checkpoint.
class MismatchAlarm {
 public:
  static constexpr int max_window = 1024;
  static constexpr double threshold = 0.93;
  static constexpr int least_early = 50;
  static constexpr double early_false_alarm = 1e-4;

  /// 1 <= window <= max_window; others are brought into it. Of a right filter, one full window rings falsely with
  /// `false_alarm_rate`: 0.0023 at the default.
  explicit MismatchAlarm(int window = 1000);

  void add(double nis, int dof);
  /// Over a full window by the threshold. Before that, from `least_early` innovations on, where chance leaves a share
  /// so low with less than `early_false_alarm` at each look: GPS at 1 Hz would take a whole flight to fill the window.
  [[nodiscard]] bool rings() const;
  [[nodiscard]] int window() const { return window_; }
  /// How many innovations the share is over: what there is of the window.
  [[nodiscard]] int innovations() const { return filled_; }
  /// Over what there is of the window; 1 before the first.
  [[nodiscard]] double share() const { return filled_ > 0 ? static_cast<double>(inside_) / filled_ : 1; }
  [[nodiscard]] double false_alarm_rate() const;

 private:
  int window_;
  int filled_ = 0;
  int next_ = 0;
  int inside_ = 0;
  std::bitset<max_window> was_inside_;
};

/// Exponentially forgetting statistics of one source's innovations. Plain values: part of a filter's checkpoint.
struct RunningResidual {
  double mean = 0;         ///< of the innovation components, normalised by their 1-sigma
  double mean_square = 1;  ///< of the same
  double nis_per_dof = 1;  ///< 1 when noise and covariance are right
  bool started = false;

  /// `normalised` = mean of nu_i / sqrt(S_ii); `square` = mean of their squares; weight of the newest 1/50.
  void add(double normalised, double square, double nis_over_dof);
};

}  // namespace downrange
