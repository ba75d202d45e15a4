#include <algorithm>
#include <cmath>
#include <downrange/est/filter/noise_scale.hpp>
#include <downrange/geo/site.hpp>

namespace downrange {
namespace {

/// Forty sigmas: a fold, a wrong unit, another object. No noise.
constexpr double no_noise = 1600;
constexpr int least_recent = 20;
constexpr double too_many = 0.2;
constexpr double forgetting_of_radar = 1.0 / 500;

}  // namespace

NoiseScale NoiseScale::of_radar(double angle_inflation, bool wander_is_state) {
  NoiseScale scale;
  scale.start_ = {1, angle_inflation, angle_inflation, 1};
  if (!wander_is_state && angle_inflation > 1) scale.least_ = {least, angle_inflation, angle_inflation, least};
  scale.forgetting_ = forgetting_of_radar;
  scale.wait_ = plots_before;
  for (std::size_t i = 0; i < scale.belief_.size(); ++i) scale.belief_[i].b *= scale.start_[i];
  scale.before_ = scale.at_kept_ = scale.belief_;
  return scale;
}

Fix NoiseScale::believed(const Fix& fix) const {
  Fix believed = fix;
  believed.sigma_horizontal_m *= std::sqrt(factor(0));
  believed.sigma_vertical_m *= std::sqrt(factor(1));
  believed.sigma_velocity_m_s *= std::sqrt(factor(2));
  return believed;
}

double NoiseScale::sigma_ratio(int component) const {
  const auto i = static_cast<std::size_t>(component);
  return learnt_[i] ? std::sqrt(belief_[i].scale()) : 0;
}

bool NoiseScale::open(Time epoch, bool held, bool referenced) {
  if (held && !held_) {
    belief_ = at_kept_ = before_;
    recent_ = {};
  }
  held_ = held;
  if (held) return false;
  if (epoch - kept_ >= forgotten) {
    before_ = at_kept_;
    at_kept_ = belief_;
    kept_ = epoch;
  }
  if (referenced && wait_ > 0) --wait_;
  return referenced;
}

void NoiseScale::Recent::add(bool was_rejected) {
  rejected[next] = was_rejected;
  next = static_cast<std::uint8_t>((next + 1U) % rejected.size());
  filled = static_cast<std::uint8_t>(std::min<std::size_t>(filled + 1U, rejected.size()));
}

bool NoiseScale::Recent::many_rejected() const {
  return filled >= least_recent && static_cast<double>(rejected.count()) > too_many * filled;
}

Mat<3, 3> NoiseScale::axes_of(const Fix& fix) { return enu_from_ecef_at(geodetic_from_ecef(fix.position)).R; }

bool NoiseScale::teaches(bool of_range_rate, Verdict verdict, double largest) {
  if (verdict != Verdict::Accepted && verdict != Verdict::Gated) return false;
  const bool rejected = verdict == Verdict::Gated;
  if (rejected && !(largest <= no_noise)) return false;
  Recent& recent = recent_[of_range_rate ? 1 : 0];
  recent.add(rejected);
  // Taught by every outlier, the scale would be that of noise and outliers together.
  return wait_ == 0 && (!rejected || recent.many_rejected());
}

void NoiseScale::add(int component, double sum, int count) {
  const auto i = static_cast<std::size_t>(component);
  Belief& belief = belief_[i];
  const double s = belief.scale();
  const double a = (1 - forgetting_) * belief.a + 0.5 * count;
  const double b = (1 - forgetting_) * belief.b + 0.5 * s * sum;
  if (!std::isfinite(b)) return;  // the innovation was none
  belief = {.a = a, .b = a * std::clamp(b / a, least_[i], most)};
  learnt_[i] = true;
}

}  // namespace downrange
