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
  const double u = (t - a.time).seconds() / h;
  const Eigen::Vector3d& p0 = a.state.position.m;
  const Eigen::Vector3d dp = b.state.position.m - p0;
  const Eigen::Vector3d m0 = h * a.state.velocity.m_s;
  const Eigen::Vector3d m1 = h * b.state.velocity.m_s;
  // p(u) = p0 + m0 u + c2 u^2 + c3 u^3 with p(1), p'(1) met
  const Eigen::Vector3d c2 = 3 * dp - 2 * m0 - m1;
  const Eigen::Vector3d c3 = m0 + m1 - 2 * dp;
  return TrueState{{p0 + u * (m0 + u * (c2 + u * c3))}, {(m0 + u * (2 * c2 + u * 3 * c3)) / h}};
}

}  // namespace downrange::score
