// The GPS track of method schmidt: the one that biases are learnt from.
#include <algorithm>
#include <array>
#include <cmath>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/est/method/schmidt.hpp>
#include <span>

#include "consider.hpp"
#include "told.hpp"

namespace downrange {

bool Schmidt::has_reference(const Target& t, Time at) const {
  return t.gps.confirmed && at - t.gps_epoch <= settings_.gps.max_age;
}

Gaussian<9> Schmidt::gps_motion(const Target& t) {
  const Hypothesis& h = t.bank.mode[0];
  return {.mean = h.x.segment<9>(gps_at), .cov = h.P.block<9, 9>(gps_at, gps_at)};
}

void Schmidt::start_gps(Target& t, const Measurement& m) const {
  t.gps_epoch = m.epoch;
  forget_knots(t);
  const Gaussian<9> motion = first_motion(m, settings_, Vec<bias_term_count>::Zero());
  const double variance = settings_.gps.error.enabled ? std::pow(settings_.gps.error.sigma_m, 2) : 0;
  for (int i = 0; i < t.bank.count; ++i) {
    Hypothesis& h = t.bank.mode[static_cast<std::size_t>(i)];
    reset_block(h, gps_at, motion.mean, motion.cov);
    reset_block(h, gps_error_at, Vec<3>::Zero(), variance * Mat<3, 3>::Identity());
  }
  add_knot(t);
}

template <int M>
Outcome Schmidt::update_by_fix(Target& t, SourceAccount& account, const Measurement& m) const {
  const bool learns = settings_.noise.enabled && account.noise.open(m.epoch, m.noise_held, t.gps.confirmed);
  const Fix fix = account.noise.believed(fix_of(m));
  std::array<Evidence<M>, ModelSet::max_models> evidence;
  const auto compute_evidence = [&] {
    for (int i = 0; i < t.bank.count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      evidence[k] = evidence_of<M>(t.bank.mode[k], fix_jacobian<M>(gps_at),
                                   fix_residual<M>(t.bank.mode[k], gps_at, fix), fix_noise<M>(fix));
    }
  };
  if (arbitration_.is_no_gps_error(combined_three(t.bank, gps_error_at)))
    give_error_to_motion(t.bank, gps_at, gps_error_at, settings_.gps.error.sigma_m);
  compute_evidence();
  // The GPS track is the same in all modes: one judges for all.
  const Evidence<M>& e = evidence[0];
  const auto count = static_cast<std::size_t>(t.bank.count);
  const Mat<9, 9> before = gps_motion(t).cov;
  if (!e.singular && e.nis > gates_[M] && t.gps.confirmed && Arbitration::may_be_engine_event(t.life)) {
    Mat<9, 9> opened = before;
    Arbitration::add_engine_event(opened, t.epoch - t.gps_epoch);
    const auto set = [&](const Mat<9, 9>& cov) {
      for (std::size_t k = 0; k < count; ++k) t.bank.mode[k].P.block<9, 9>(gps_at, gps_at) = cov;
    };
    set(opened);
    compute_evidence();
    if (!(e.nis <= gates_[M])) set(before);
  }
  if (std::ranges::any_of(std::span(evidence).first(count), &Evidence<M>::singular))
    return {.verdict = Verdict::Singular, .nis = 0, .dof = M};
  const Outcome outcome{.verdict = e.nis <= gates_[M] ? Verdict::Accepted : Verdict::Gated, .nis = e.nis, .dof = M};
  if (learns) account.noise.update_scale<M>(fix, noise_lesson<M>(t.bank, evidence, outcome.verdict));
  if (outcome.verdict != Verdict::Accepted) return outcome;
  for (int i = 0; i < t.bank.count; ++i)
    update_considering_first<M>(t.bank.mode[static_cast<std::size_t>(i)], evidence[static_cast<std::size_t>(i)],
                                gps_at);
  note_innovation<M>(account, e.nu, e.S, e.nis);
  return outcome;
}

Outcome Schmidt::apply_fix(State& s, const Measurement& m) const {
  Target& t = s.targets[static_cast<std::size_t>(m.target)];
  SourceAccount& account = s.accounts[static_cast<std::size_t>(m.source)];
  const Hypothesis& h = t.bank.mode[0];
  TrackVelocity velocity;
  if (t.gps.started)
    velocity = {.m_s = h.x.segment<3>(gps_at + 3),
                .sigma_m_s = std::sqrt(h.P.block<3, 3>(gps_at + 3, gps_at + 3).trace())};
  if (is_frozen(t.last_fix, m, velocity)) return {.verdict = Verdict::Frozen, .nis = 0, .dof = 3};
  const auto update = [&] {
    const bool with_velocity = fix_of(m).velocity_valid && settings_.gps_use.velocity;
    return with_velocity ? update_by_fix<6>(t, account, m) : update_by_fix<3>(t, account, m);
  };
  return update_gps_track(
      arbitration_, t.life, t.gps, m, judging_motion(t, m.epoch).mean, fused_agrees(t, m), [&] { start_gps(t, m); },
      update, [&] { believe(t, m); }, [&] { unite(t, m); });
}

void Schmidt::believe(Target& t, const Measurement& fix) const {
  if (t.without_gps) leave_regime(t);
  t.gps_epoch = fix.epoch;
  add_knot(t);
  if (knots_ > 0) release_held(t);
}

void Schmidt::unite(Target& t, const Measurement& fix) const {
  for (int i = 0; i < t.bank.count; ++i)
    loosen_biases(t.bank.mode[static_cast<std::size_t>(i)], layout(t), Arbitration::recent_radars(t.life, fix.epoch));
  tie_fused_to_bias(t);
}

Gaussian<9> Schmidt::judging_motion(const Target& t, Time at) const {
  if (t.fused_started && Arbitration::recent_radars(t.life, at) != 0)
    return combined_motion(t.bank, models_, fused_at, 0);
  return gps_motion(t);
}

bool Schmidt::fused_agrees(const Target& t, const Measurement& fix) const {
  if (!t.fused_started || Arbitration::recent_radars(t.life, fix.epoch) == 0) return false;
  const Gaussian<9> motion = combined_motion(t.bank, models_, fused_at, 0);
  const Mat<3, 3> S = motion.cov.topLeftCorner<3, 3>() + fix_covariance(fix_of(fix));
  return normalised_square<3>(fix_of(fix).position.m - motion.mean.head<3>(), S) <= gates_[3];
}

std::optional<TrackEstimate> Schmidt::gps_track(const State& state, int target, Time at) const {
  const Target& t = state.targets[static_cast<std::size_t>(target)];
  if (!t.gps.confirmed) return std::nullopt;
  const Gaussian<9> x = downrange::predict(gps_model_, gps_motion(t), (at - t.epoch).seconds());
  TrackEstimate e;
  e.epoch = at;
  e.data_epoch = t.gps_epoch;
  e.size = 9;
  e.mean = x.mean;
  e.cov = x.cov;
  return e;
}

}  // namespace downrange
