#include "stage/slave/pass.hpp"

#include <algorithm>
#include <cmath>
#include <downrange/geo/earth.hpp>

namespace downrange {
namespace {

/// Below the ground by kilometres wherever on Earth: the pass is over.
constexpr double deep_m = 6.34e6;

PositionVelocity fallen(const PositionVelocity& x, double h) {
  const Eigen::Vector3d& p = x.position.m;
  const Eigen::Vector3d& v1 = x.velocity.m_s;
  const auto acceleration = [](const Eigen::Vector3d& at, const Eigen::Vector3d& v) {
    return free_fall_acceleration({at}, {v});
  };
  const Eigen::Vector3d a1 = acceleration(p, v1);
  const Eigen::Vector3d v2 = v1 + h / 2 * a1;
  const Eigen::Vector3d a2 = acceleration(p + h / 2 * v1, v2);
  const Eigen::Vector3d v3 = v1 + h / 2 * a2;
  const Eigen::Vector3d a3 = acceleration(p + h / 2 * v2, v3);
  const Eigen::Vector3d v4 = v1 + h * a3;
  const Eigen::Vector3d a4 = acceleration(p + h * v3, v4);
  return {{p + h / 6 * (v1 + 2 * v2 + 2 * v3 + v4)}, {v1 + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)}};
}

}  // namespace

void PredictedPath::fall(Time from, const PositionVelocity& state) {
  from_ = from;
  states_.assign(1, state);
  while (states_.size() < most_states) {
    const PositionVelocity next = fallen(states_.back(), step_s);
    if (!(next.position.m.norm() > deep_m)) return;
    states_.push_back(next);
  }
}

void PredictedPath::follow(Time from, const NominalTrajectory& nominal, double t_plus_s,
                           const Displacement<Ecef>& offset) {
  from_ = from;
  states_.clear();
  while (states_.size() < most_states) {
    const auto planned = nominal.at(t_plus_s + step_s * static_cast<double>(states_.size()));
    if (!planned) return;
    states_.push_back({planned->position + offset, planned->velocity});
  }
}

PositionVelocity PredictedPath::at(double s) const {
  const auto last = static_cast<double>(states_.size() - 1);
  const double place = std::clamp(s / step_s, 0.0, last);
  const auto i = static_cast<std::size_t>(std::min(std::floor(place), std::max(last - 1, 0.0)));
  if (i + 1 >= states_.size()) return states_[i];
  return hermite(states_[i], states_[i + 1], step_s, place - static_cast<double>(i));
}

PassPoint seen_at(const PredictedPath& path, double s, const Site& site, const RefractionTable* air) {
  const Polar q = polar_from_enu(site.enu_of(path.at(s).position));
  const double bent = air == nullptr ? 0 : air->at_true(q.range_m, q.elevation_rad).refraction.elevation_rad;
  return {.s = s, .azimuth_rad = q.azimuth_rad, .elevation_rad = q.elevation_rad + bent};
}

void Pass::see(const PredictedPath& path, const Site& site, const RefractionTable* air, double lowest_rad) {
  points_.clear();
  for (std::size_t i = 0; i < path.states().size(); ++i) {
    PassPoint point = seen_at(path, PredictedPath::step_s * static_cast<double>(i), site, air);
    if (!(point.elevation_rad >= lowest_rad)) {
      if (points_.empty()) continue;
      return;
    }
    if (!points_.empty())
      point.azimuth_rad = points_.back().azimuth_rad + wrap_pi(point.azimuth_rad - points_.back().azimuth_rad);
    points_.push_back(point);
  }
}

}  // namespace downrange
