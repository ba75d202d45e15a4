#include <algorithm>
#include <cmath>
#include <downrange/est/track/multi_target.hpp>
#include <limits>

namespace downrange {

void SetDistance::fill(std::span<const Eigen::Vector3d> truths, std::span<const Eigen::Vector3d> estimates) {
  costs_.clear();
  for (const Eigen::Vector3d& truth : truths) {
    for (const Eigen::Vector3d& estimate : estimates) {
      const double d = (truth - estimate).norm();
      costs_.push_back(d < c_ ? std::pow(d, p_) : std::numeric_limits<double>::infinity());
    }
  }
}

Gospa SetDistance::gospa(std::span<const Eigen::Vector3d> truths, std::span<const Eigen::Vector3d> estimates) {
  fill(truths, estimates);
  const double unpaired = std::pow(c_, p_) / 2;
  // A truth without partner leaves an estimate without one: both are paid for when a pair is not made.
  const auto partner =
      assignment_.solve(costs_, static_cast<int>(truths.size()), static_cast<int>(estimates.size()), 2 * unpaired);
  Gospa g;
  for (std::size_t i = 0; i < truths.size(); ++i) {
    if (partner[i] == Assignment::none) continue;
    ++g.pairs;
    g.localisation += costs_[i * estimates.size() + static_cast<std::size_t>(partner[i])];
  }
  g.missed = static_cast<int>(truths.size()) - g.pairs;
  g.false_tracks = static_cast<int>(estimates.size()) - g.pairs;
  g.missed_cost = unpaired * g.missed;
  g.false_cost = unpaired * g.false_tracks;
  g.distance = std::pow(g.localisation + g.missed_cost + g.false_cost, 1 / p_);
  return g;
}

double SetDistance::ospa(std::span<const Eigen::Vector3d> truths, std::span<const Eigen::Vector3d> estimates) {
  const std::size_t larger = std::max(truths.size(), estimates.size());
  if (larger == 0) return 0;
  // Pairs are cut off at c, and so is every target of the larger set that stays without one.
  const Gospa g = gospa(truths, estimates);
  const double unpaired = static_cast<double>(larger) - g.pairs;
  return std::pow((g.localisation + std::pow(c_, p_) * unpaired) / static_cast<double>(larger), 1 / p_);
}

}  // namespace downrange
