#include "stage/slave/platform.hpp"

#include <cmath>
#include <downrange/geo/polar.hpp>
#include <numbers>

namespace downrange {
namespace {

/// On the ground, at sea or in the air.
constexpr double radius_min_m = 6.35e6;
constexpr double radius_max_m = 6.42e6;
constexpr double speed_max_m_s = 1000;
/// The heading goes on turning as it did between two reports that far apart: nearer ones tell their noise.
constexpr double shortest_turn_s = 1;
constexpr double longest_turn_s = 4;
constexpr double turn_rate_max_rad_s = 0.5;

bool can_be(const PlatformState& s) {
  const double radius = s.position.m.norm();
  const bool place = s.position.m.allFinite() && radius >= radius_min_m && radius <= radius_max_m;
  const bool speed = !s.velocity_valid || (s.velocity.m_s.allFinite() && s.velocity.m_s.norm() <= speed_max_m_s);
  const bool sigmas = s.sigma_position_m >= 0 && std::isfinite(s.sigma_position_m) && s.sigma_heading_rad >= 0 &&
                      std::isfinite(s.sigma_heading_rad);
  return place && speed && sigmas && std::isfinite(s.heading_rad) && plausible(s.epoch) &&
         s.epoch <= s.received + Platform::oldest;
}

}  // namespace

void Platform::note(const PlatformState& state) {
  if (!can_be(state)) return;
  const bool first = !newest_ || state.received - newest_->received > oldest;
  if (!first && state.epoch <= newest_->epoch) return;
  if (first) before_ = since_ = std::nullopt;
  note_heading({.epoch = state.epoch, .rad = state.heading_rad});
  newest_ = state;
}

void Platform::note_heading(const Heading& heading) {
  if (!since_ || (heading.epoch - since_->epoch).seconds() >= shortest_turn_s) {
    before_ = since_;
    since_ = heading;
  }
  turn_rate_rad_s_.reset();
  if (!before_) return;
  turned_over_s_ = (heading.epoch - before_->epoch).seconds();
  const double rate = wrap_pi(heading.rad - before_->rad) / turned_over_s_;
  if (turned_over_s_ <= longest_turn_s && std::abs(rate) <= turn_rate_max_rad_s) turn_rate_rad_s_ = rate;
}

std::optional<Platform::Place> Platform::at(Time t) const {
  if (!newest_ || t - newest_->epoch > oldest) return std::nullopt;
  const double dt = (t - newest_->epoch).seconds();
  Place place;
  if (newest_->velocity_valid) place.velocity = newest_->velocity;
  place.turn_rate_rad_s = turn_rate_rad_s_.value_or(0);
  const Position<Ecef> position{newest_->position.m + dt * place.velocity.m_s};
  place.site = Site(geodetic_from_ecef(position), newest_->heading_rad + dt * place.turn_rate_rad_s);
  place.sigma_position_m = newest_->sigma_position_m;
  const double of_rate = turn_rate_rad_s_ ? std::numbers::sqrt2 * dt / turned_over_s_ : 0;
  place.sigma_heading_rad = std::hypot(1, of_rate) * newest_->sigma_heading_rad;
  return place;
}

}  // namespace downrange
