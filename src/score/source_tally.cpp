#include "score/source_tally.hpp"

#include <algorithm>
#include <downrange/est/filter/consistency.hpp>
#include <limits>

#include "score/errors.hpp"

namespace downrange::score {

SystematicError IntervalMeans::rms_of_means() const {
  Eigen::Vector3d sum_of_squares = Eigen::Vector3d::Zero();
  for (const auto& [interval, entry] : intervals_) sum_of_squares += (entry.first / entry.second).cwiseAbs2();
  const Eigen::Vector3d rms =
      (sum_of_squares / static_cast<double>(std::max<std::size_t>(intervals_.size(), 1))).cwiseSqrt();
  return {rms[0], rms[1], rms[2]};
}

void add_consistency(const std::vector<HealthSample>& health, SourceScore& score) {
  const int full = MismatchAlarm().window();
  double inside = 0;
  std::uint64_t begin = std::numeric_limits<std::uint64_t>::max();  // of what is counted so far
  for (auto h = health.rbegin(); h != health.rend(); ++h) {
    if (h->mismatch) ++score.mismatch_s;
    if (h->window == full) score.least_nis_inside_95 = std::min(score.least_nis_inside_95.value_or(1), h->inside_95);
    const auto window = static_cast<std::uint64_t>(h->window);
    if (window == 0 || h->judged > begin) continue;
    score.nis_count += window;
    inside += h->inside_95 * h->window;
    begin = h->judged - std::min(window, h->judged);
  }
  if (score.nis_count == 0) return;
  score.nis_inside_95 = inside / static_cast<double>(score.nis_count);
  // Health is told once a second: the seconds in which the method had something of the source.
  double heard_s = 0;
  std::uint64_t last = 0;
  for (const HealthSample& h : health) {
    if (h.judged > last) ++heard_s;
    last = h.judged;
  }
  score.nis_independent = heard_s / alike_for_s;
  score.nis_band = honest_band(score.nis_inside_95, score.nis_independent);
}

}  // namespace downrange::score
