#include "departure.hpp"

#include <algorithm>
#include <cmath>

#include "indices.hpp"

namespace downrange {
namespace {

/// Nearer fixes tell more noise than motion; farther ones may hide anything.
constexpr Duration least_step = milliseconds(900);
constexpr Duration most_step = milliseconds(5000);
/// From fix to fix, so that there are three of them.
constexpr int steps = 2;
/// Faster than any transport to the pad, far slower than a launch three seconds on.
constexpr double moving_m_s = 10;
constexpr double noise_sigmas = 6;
/// What a launch vehicle's velocity changes at most.
constexpr double acceleration_m_s2 = 100;

}  // namespace

Departure::Departure(const RangeConfig& config) : targets_(config.targets), motions_(config.targets.size()) {}

void Departure::note(const Observation& observation) {
  const int index = index_of(targets_, observation.target);
  const auto* measured = std::get_if<Fix>(&observation.measured);
  if (index < 0 || measured == nullptr) return;
  const Fix& fix = *measured;
  Target& t = motions_[static_cast<std::size_t>(index)];
  if (t.motion) return;
  const Duration apart = t.last ? observation.epoch - t.last->epoch : Duration{0};
  if (t.last && apart < least_step) return;  // too near, or late
  const double dt = apart.seconds();
  const double noise_m = noise_sigmas * std::hypot(fix.sigma_horizontal_m, fix.sigma_vertical_m);
  bool moves = false;
  if (t.last && apart <= most_step) {
    const Eigen::Vector3d slope = (fix.position.m - t.last->fix.position.m) / dt;
    const bool with_velocity = fix.velocity_valid && t.last->fix.velocity_valid;
    const Eigen::Vector3d expected =
        with_velocity ? Eigen::Vector3d((fix.velocity.m_s + t.last->fix.velocity.m_s) / 2) : t.slope_m_s;
    const bool as_expected = (slope - expected).norm() <= noise_m / dt + acceleration_m_s2 * dt;
    const double speed = with_velocity ? expected.norm() : slope.norm() - noise_m / dt;
    moves = speed >= moving_m_s && (as_expected || (!with_velocity && t.moving == 0));
    t.slope_m_s = slope;
  }
  if (moves && t.moving == 0) t.moving_since = t.last->epoch;
  t.moving = moves ? t.moving + 1 : 0;
  if (t.moving >= steps) t.motion = t.moving_since;
  t.last = {.epoch = observation.epoch, .fix = fix};
}

void Departure::recycle() { std::ranges::fill(motions_, Target{}); }

std::optional<Time> Departure::motion(const Name& target) const {
  const int index = index_of(targets_, target);
  return index < 0 ? std::nullopt : motions_[static_cast<std::size_t>(index)].motion;
}

}  // namespace downrange
