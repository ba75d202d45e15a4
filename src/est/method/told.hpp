#pragma once
/// What joint and schmidt have in common, which hold each radar's bias once per target: how their states begin, and
/// what they tell of their targets: whose word on a radar counts.

#include <cstddef>
#include <downrange/est/filter/hypothesis.hpp>
#include <downrange/est/method/target_life.hpp>
#include <stdexcept>
#include <string>
#include <utility>

namespace downrange {

/// Before any measurement.
template <class State>
[[nodiscard]] State state_before_all(const MethodSettings& settings, const Arbitration& arbitration) {
  State s;
  s.targets.resize(static_cast<std::size_t>(settings.targets));
  for (auto& target : s.targets) {
    target.life = arbitration.unborn();
    target.radars.resize(settings.radars.size());
  }
  s.accounts = accounts_of(settings, true);
  return s;
}

/// Throws std::invalid_argument for more radars or states than a method has room for.
inline void require_room(const char* method, std::size_t radars, std::size_t most_radars, int states) {
  if (radars > most_radars || states > max_states)
    throw std::invalid_argument(std::string("method ") + method + " takes at most " + std::to_string(most_radars) +
                                " radars");
}

/// Of the targets that have `started`, one with GPS before one without, then the one that saw the radar last; null:
/// none.
template <class Targets, class Started>
[[nodiscard]] const typename Targets::value_type* best_informed(const Targets& targets, std::size_t radar,
                                                                Started started) {
  const typename Targets::value_type* best = nullptr;
  const auto rank = [radar](const auto& t) { return std::pair(!t.without_gps, t.radars[radar].epoch); };
  for (const auto& t : targets) {
    if (started(t) && (best == nullptr || rank(t) > rank(*best))) best = &t;
  }
  return best;
}

/// Covariance union of the motion at `motion_at`, whose mean is `track`, with a measurement that it refused.
template <class Target>
void unite(Target& target, int motion_at, const BiasLayout& layout, const Arbitration& rules, const Measurement& m,
           const Vec<9>& track) {
  const Mat<6, 6> term = Arbitration::union_term(rules.away_from(target.life, m, track));
  const std::uint64_t loosened = Arbitration::loosened_by(target.life, m);
  for (int i = 0; i < target.bank.count; ++i) {
    Hypothesis& h = target.bank.mode[static_cast<std::size_t>(i)];
    h.P.block<6, 6>(motion_at, motion_at) += term;
    loosen_biases(h, layout, loosened);
  }
}

/// Has any radar but this one had plots accepted?
template <class Radars>
[[nodiscard]] bool others_contribute(const Radars& radars, std::size_t radar) {
  for (std::size_t other = 0; other < radars.size(); ++other) {
    if (other != radar && radars[other].samples > 0) return true;
  }
  return false;
}

/// One radar that nobody has helped, no receiver: after an accepted plot, whether bias and motion begin anew with it.
template <class Target>
[[nodiscard]] bool is_led_astray(Target& target, const Arbitration& rules, const Measurement& plot,
                                 const RadarBlock& block) {
  if (!target.without_gps || others_contribute(target.radars, static_cast<std::size_t>(plot.source))) return false;
  const Hypothesis& likely = target.bank.mode[static_cast<std::size_t>(likeliest(target.bank))];
  return rules.led_astray(target.life, plot, prior_misfit(likely, block), block.terms);
}

/// The bias of one radar as `target` knows it; `by_gps`: GPS is what it was found by.
template <class Target>
[[nodiscard]] BiasEstimate bias_known_by(const Target& target, const RadarBlock& block, std::size_t radar, bool by_gps,
                                         bool frozen) {
  const auto& known = target.radars[radar];
  BiasEstimate b = combined_bias(target.bank, block);
  b.epoch = known.epoch;
  b.samples = known.samples;
  if (by_gps) {
    b.reference = BiasReference::Gps;
  } else if (known.samples > 0 && others_contribute(target.radars, radar)) {
    b.reference = BiasReference::CrossRadar;
  }
  b.state = bias_states(b, block.prior_sigma(), frozen);
  return b;
}

/// The target's track at `at`, or at its newest data: the motion at `motion_at` of its bank.
template <class Target>
[[nodiscard]] TrackEstimate track_of(const Target& target, const ModelSet& models, int motion_at,
                                     std::optional<Time> at) {
  TrackEstimate e;
  e.epoch = at.value_or(target.data_epoch);
  e.data_epoch = target.data_epoch;
  e.size = models.model[0].noise == MotionModel::Noise::WhiteAcceleration ? 6 : 9;
  const Gaussian<9> x = combined_motion(target.bank, models, motion_at, (e.epoch - target.epoch).seconds());
  e.mean = x.mean;
  e.cov = x.cov;
  e.sources = Arbitration::recent_sources(target.life, target.data_epoch);
  e.nis = target.nis;
  e.nis_dof = target.nis_dof;
  return e;
}

}  // namespace downrange
