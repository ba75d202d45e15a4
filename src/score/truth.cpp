#include "score/truth.hpp"

#include <algorithm>
#include <iterator>
#include <stdexcept>

namespace downrange::score {

TruthTable::TruthTable(std::vector<TruthSample> samples) : samples_(std::move(samples)) {
  if (samples_.size() < 2) throw std::invalid_argument("a truth table needs two samples or more");
  const auto not_later = [](const TruthSample& a, const TruthSample& b) { return !(a.time < b.time); };
  if (std::adjacent_find(samples_.begin(), samples_.end(), not_later) != samples_.end())
    throw std::invalid_argument("the times of a truth table must increase");
}

std::optional<TrueState> TruthTable::at(Time t) const {
  if (t < samples_.front().time || t > samples_.back().time) return std::nullopt;
  const auto later = [](Time time, const TruthSample& sample) { return time < sample.time; };
  const auto upper = std::upper_bound(std::next(samples_.begin()), std::prev(samples_.end()), t, later);
  const TruthSample& a = *std::prev(upper);
  const TruthSample& b = *upper;
  const double h = (b.time - a.time).seconds();
  return hermite(a.state, b.state, h, (t - a.time).seconds() / h);
}

}  // namespace downrange::score
