#include <algorithm>
#include <array>
#include <boost/math/distributions/beta.hpp>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <downrange/est/filter/consistency.hpp>

namespace downrange {
namespace {

namespace bm = boost::math;

/// The 95 % quantile is asked for with every innovation: the few sizes that measurements and states have, once.
double chi2_95(int dof) {
  constexpr int known = 16;
  static const auto table = [] {
    std::array<double, known + 1> quantiles{};
    for (int k = 1; k <= known; ++k) quantiles[static_cast<std::size_t>(k)] = chi2_quantile(0.95, k);
    return quantiles;
  }();
  return dof <= known ? table[static_cast<std::size_t>(dof)] : chi2_quantile(0.95, dof);
}

bool inside_95(double square, int dof) { return square <= chi2_95(dof); }

}  // namespace

double chi2_quantile(double probability, int dof) {
  if (probability >= 1) return std::numeric_limits<double>::infinity();
  return bm::quantile(bm::chi_squared(dof), probability);
}

Band average_chi2_band(int dof, int n, double false_alarm) {
  const bm::chi_squared sum(static_cast<double>(dof) * n);
  const double count = static_cast<double>(dof) * n;
  return {.low = bm::quantile(sum, false_alarm / 2) / count,
          .high = bm::quantile(bm::complement(sum, false_alarm / 2)) / count};
}

Band share_band(double probability, int n, double false_alarm) {
  const bm::binomial trials(n, probability);
  // Whole counts: the quantile is where to look, the exact tail decides.
  int low = std::clamp(static_cast<int>(bm::quantile(trials, false_alarm / 2)), 0, n);
  while (low > 0 && bm::cdf(trials, low - 1) > false_alarm / 2) --low;
  while (low < n && bm::cdf(trials, low) <= false_alarm / 2) ++low;
  int high = std::clamp(static_cast<int>(bm::quantile(bm::complement(trials, false_alarm / 2))), 0, n);
  while (high < n && bm::cdf(bm::complement(trials, high)) > false_alarm / 2) ++high;
  while (high > 0 && bm::cdf(bm::complement(trials, high - 1)) <= false_alarm / 2) --high;
  return {.low = static_cast<double>(low) / n, .high = static_cast<double>(high) / n};
}

Band clopper_pearson(int successes, int n, double false_alarm) {
  const int k = successes;
  Band band{.low = 0, .high = 1};
  if (k > 0) band.low = bm::quantile(bm::beta_distribution<>(k, n - k + 1), false_alarm / 2);
  if (k < n) band.high = bm::quantile(bm::complement(bm::beta_distribution<>(k + 1, n - k), false_alarm / 2));
  return band;
}

void InsideShare::add(double square, int dof) {
  inside += inside_95(square, dof) ? 1 : 0;
  ++total;
}

MismatchAlarm::MismatchAlarm(int window) : window_(std::clamp(window, 1, max_window)) {}

void MismatchAlarm::add(double nis, int dof) {
  const auto place = static_cast<std::size_t>(next_);
  const bool inside = inside_95(nis, dof);
  if (filled_ == window_) {
    inside_ -= was_inside_[place] ? 1 : 0;
  } else {
    ++filled_;
  }
  was_inside_[place] = inside;
  inside_ += inside ? 1 : 0;
  next_ = (next_ + 1) % window_;
}

bool MismatchAlarm::rings() const {
  if (filled_ == window_) return share() < threshold;
  return filled_ >= least_early && bm::cdf(bm::binomial(filled_, 0.95), inside_) < early_false_alarm;
}

double MismatchAlarm::false_alarm_rate() const {
  const double least = std::ceil(threshold * window_);  // the fewest inside that do not ring
  return least > 0 ? bm::cdf(bm::binomial(window_, 0.95), least - 1) : 0;
}

void RunningResidual::add(double normalised, double square, double nis_over_dof) {
  constexpr double weight = 1.0 / 50;
  const double gain = started ? weight : 1.0;
  started = true;
  mean += gain * (normalised - mean);
  mean_square += gain * (square - mean_square);
  nis_per_dof += gain * (nis_over_dof - nis_per_dof);
}

}  // namespace downrange
