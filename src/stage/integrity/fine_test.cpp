#include "fine_test.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace downrange::integrity {
namespace {

constexpr std::size_t most = 5;
constexpr std::size_t least = 3;
constexpr Duration steady_span = milliseconds(6000);
constexpr double median_of_samples = 1.5;  // variance of a median over that of a mean

/// Variance of the change of a stationary Gauss-Markov error of unit variance.
double increment(double lag_s, double tau_s) { return 2 * (1 - std::exp(-lag_s / tau_s)); }

struct Instant {
  const Sample* a = nullptr;
  const Sample* b = nullptr;
};

/// Newest first.
std::array<Instant, most> common_instants(const Witness& first, const Witness& second, const ReferenceSpan& span,
                                          std::size_t& count) {
  std::array<Instant, most> found{};
  std::size_t n = 0;
  const Ring<Sample>& all = first.series.samples();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Sample& a = all.newest(i);
    if (a.epoch < span.from) break;
    if (a.epoch > span.to) continue;
    const Sample* b = second.series.at(a.epoch);
    if (b == nullptr) continue;
    if (n == most && span.newest) break;
    found[n % most] = {&a, b};  // of the oldest wanted, older ones replace newer ones
    ++n;
  }
  if (n > most) std::rotate(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(n % most), found.end());
  count = std::min(n, most);
  return found;
}

}  // namespace

std::optional<Reference> reference_of(const Witness& first, const Witness& second, const ReferenceSpan& span,
                                      Knowledge knowledge) {
  std::size_t n = 0;
  const std::array<Instant, most> instants = common_instants(first, second, span, n);
  if (n < least) return std::nullopt;
  Reference r;
  r.epoch = instants[0].a->epoch;
  const bool learnt = knowledge == Knowledge::Learnt;
  r.first = learnt ? first.known_at(r.epoch) : first.prior;
  r.second = learnt ? second.known_at(r.epoch) : second.prior;
  std::array<Vec<3>, most> d;
  Vec<2> side = Vec<2>::Zero();        // of north, on which each saw the target: a reference that mixes both is none
  Mat<3, 3> jump = Mat<3, 3>::Zero();  // all instants are on one side: wrong once, not five times
  const double share = 1 / static_cast<double>(n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto x = difference(first, *instants[i].a, r.first.mean, second, *instants[i].b, r.second.mean);
    if (!x) return std::nullopt;
    const Vec<2> from_south(azimuth_from_south(x->by_first), azimuth_from_south(x->by_second));
    if (i == 0) side = from_south;
    if ((from_south - side).cwiseAbs().maxCoeff() > std::numbers::pi) return std::nullopt;
    d[i] = i == 0 ? x->d : Vec<3>(d[0] + wrapped(second, x->d - d[0]));
    r.white += median_of_samples * share * share * x->white;
    const Mat<3, 3> jump_here = north_jump(x->by_first, r.first) + north_jump(x->by_second, r.second);
    if (jump_here.trace() > jump.trace()) jump = jump_here;
    r.by_first += share * x->by_first;
    r.by_second += share * x->by_second;
  }
  r.white += jump;
  for (int k = 0; k < 3; ++k) {
    std::array<double, most> values{};
    for (std::size_t i = 0; i < n; ++i) values[i] = d[i][k];
    std::sort(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(n));
    r.d[k] = (values[(n - 1) / 2] + values[n / 2]) / 2;
  }
  return r;
}

TestResult steady_test(const Witness& first, const Witness& second, Time at, const Threshold& threshold) {
  const auto r = reference_of(first, second, {.from = at - steady_span, .to = at, .newest = true}, Knowledge::Prior);
  if (!r) return {};
  const double slow_m2 = first.slow_sigma_m * first.slow_sigma_m + second.slow_sigma_m * second.slow_sigma_m;
  TestResult result;
  result.ratio = threshold.ratio(r->d, r->white + slow_m2 * Mat<3, 3>::Identity(), true, &result.whitened);
  result.apart_m = r->d.norm();
  return result;
}

TestResult fine_test(const Witness& first, const Sample& a, const Witness& second, const Sample& b,
                     const Reference& reference, const Threshold& threshold) {
  const auto now = difference(first, a, reference.first.mean, second, b, reference.second.mean);
  if (!now) return {};
  const double lag_s = (a.epoch - reference.epoch).seconds();
  const Vec<3> change = wrapped(second, now->d - reference.d);
  const Mat<3, bias_term_count> by_first = now->by_first - reference.by_first;
  const Mat<3, bias_term_count> by_second = now->by_second - reference.by_second;
  const Mat<3, 3> S = now->white + reference.white + increment(lag_s, first.slow_tau_s) * now->slow_first +
                      increment(lag_s, second.slow_tau_s) * now->slow_second +
                      by_first * reference.first.cov * by_first.transpose() +
                      by_second * reference.second.cov * by_second.transpose() +
                      north_jump(now->by_first, reference.first) + north_jump(now->by_second, reference.second);
  TestResult result;
  result.ratio = threshold.ratio(change, S, now->ranged, &result.whitened);
  result.apart_m = change.cwiseProduct(now->to_metres).norm();
  return result;
}

}  // namespace downrange::integrity
