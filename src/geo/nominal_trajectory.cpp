#include <algorithm>
#include <cmath>
#include <downrange/geo/nominal_trajectory.hpp>
#include <iterator>
#include <stdexcept>

namespace downrange {

NominalTrajectory::NominalTrajectory(std::vector<NominalSample> samples) : samples_(std::move(samples)) {
  if (samples_.size() < 2) throw std::invalid_argument("a nominal trajectory needs two samples or more");
  const auto finite = [](const NominalSample& s) {
    return std::isfinite(s.t_s) && s.state.position.m.allFinite() && s.state.velocity.m_s.allFinite();
  };
  if (!std::all_of(samples_.begin(), samples_.end(), finite))
    throw std::invalid_argument("a nominal trajectory has numbers that are not finite");
  const auto not_later = [](const NominalSample& a, const NominalSample& b) { return !(a.t_s < b.t_s); };
  if (std::adjacent_find(samples_.begin(), samples_.end(), not_later) != samples_.end())
    throw std::invalid_argument("the times of a nominal trajectory must increase");
}

std::optional<PositionVelocity> NominalTrajectory::at(double t_s) const {
  if (samples_.empty() || !(t_s >= samples_.front().t_s && t_s <= samples_.back().t_s)) return std::nullopt;
  const auto later = [](double t, const NominalSample& sample) { return t < sample.t_s; };
  const auto upper = std::upper_bound(std::next(samples_.begin()), std::prev(samples_.end()), t_s, later);
  const NominalSample& a = *std::prev(upper);
  const double h_s = upper->t_s - a.t_s;
  return hermite(a.state, upper->state, h_s, (t_s - a.t_s) / h_s);
}

std::vector<NominalSample> with_velocities(std::vector<NominalSample> samples) {
  const auto slope = [&](std::size_t i) -> Eigen::Vector3d {  // of the chord from sample i to the next
    return (samples[i + 1].state.position.m - samples[i].state.position.m) / (samples[i + 1].t_s - samples[i].t_s);
  };
  const auto span = [&](std::size_t i) { return samples[i + 1].t_s - samples[i].t_s; };
  if (samples.size() < 2) return samples;
  const std::size_t last = samples.size() - 1;
  if (last == 1) {
    samples[0].state.velocity.m_s = samples[1].state.velocity.m_s = slope(0);
    return samples;
  }
  for (std::size_t i = 0; i <= last; ++i) {
    const std::size_t left =
        std::clamp<std::size_t>(i, 1, last - 1) - 1;  // of the three that the parabola goes through
    const Eigen::Vector3d d1 = slope(left);
    const Eigen::Vector3d d2 = (slope(left + 1) - d1) / (span(left) + span(left + 1));
    const double from_first = samples[i].t_s - samples[left].t_s;
    samples[i].state.velocity.m_s = d1 + d2 * (2 * from_first - span(left));
  }
  return samples;
}

}  // namespace downrange
