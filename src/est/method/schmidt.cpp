#include <algorithm>
#include <cassert>
#include <cmath>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/est/method/schmidt.hpp>
#include <limits>
#include <span>
#include <utility>

#include "consider.hpp"
#include "time_tags.hpp"
#include "told.hpp"

namespace downrange {
Schmidt::Schmidt(MethodSettings settings)
    : settings_(with_wander_as_states(std::move(settings))),
      arbitration_(settings_),
      models_(model_set(settings_.motion)),
      gps_model_({.noise = MotionModel::Noise::WhiteJerk, .q = settings_.motion.q_ca_m2_s5, .gravity_aware = false}),
      knots_(settings_.gps.alignment.smooth ? settings_.gps.alignment.fixes + 1 : 0),
      first_radar_(knots_at + 9 * knots_),
      starts_near_gps_(std::ranges::none_of(settings_.radars,
                                            [](const RadarModel& radar) { return measures_position(radar.sigma); })),
      layout_(bias_layout(settings_.radars, first_radar_)),
      layout_without_gps_(bias_layout_without_gps(settings_.radars, settings_.gps.no_gps, first_radar_)),
      gates_(settings_.arbitration.gate_probability) {
  assert(knots_ <= max_knots);
  require_room("schmidt", settings_.radars.size(), max_radars,
               first_radar_ + std::max(layout_.size, layout_without_gps_.size));
}

Schmidt::State Schmidt::initial() const {
  State s = state_before_all<State>(settings_, arbitration_);
  reserve(s);
  return s;
}

void Schmidt::reserve(State& state) const {
  if (knots_ == 0) return;
  for (Target& target : state.targets) target.held.reserve(max_held);
}

void Schmidt::size_state(Target& t, Time epoch, bool without_gps) const {
  t.has_state = true;
  t.without_gps = without_gps;
  t.learns_biases = true;
  t.epoch = t.mixed = epoch;
  t.bank.count = models_.count;
  t.bank.probability = models_.initial_probability;
  for (int i = 0; i < t.bank.count; ++i) {
    Hypothesis& h = t.bank.mode[static_cast<std::size_t>(i)];
    h.x.setZero(first_radar_ + layout(t).size);
    h.P.setZero(h.x.size(), h.x.size());
    for (const RadarBlock& block : layout(t).radars) reset_bias(h, block);
  }
}

void Schmidt::leave_regime(Target& t) const {
  const Gaussian<9> motion = combined_motion(t.bank, models_, fused_at, 0);
  const Vec<12> gps = t.bank.mode[0].x.segment<12>(gps_at);
  const Mat<12, 12> P_gps = t.bank.mode[0].P.block<12, 12>(gps_at, gps_at);
  size_state(t, t.epoch, false);
  forget_knots(t);
  for (Radar& radar : t.radars) radar.samples = 0;
  if (t.fused_started) set_motion(t.bank, models_, fused_at, motion);
  for (int i = 0; i < t.bank.count; ++i) reset_block(t.bank.mode[static_cast<std::size_t>(i)], gps_at, gps, P_gps);
  tie_fused_to_bias(t);
}

void Schmidt::tie_fused_to_bias(Target& t) const {
  if (!t.fused_started) return;
  const auto newest = static_cast<std::size_t>(
      std::ranges::max_element(t.life.radars, {}, [](const RadarLife& radar) { return radar.accepted.epoch; }) -
      t.life.radars.begin());
  for (int i = 0; i < t.bank.count; ++i)
    tie_to_bias(t.bank.mode[static_cast<std::size_t>(i)], fused_at, settings_.radars[newest], layout(t).radars[newest]);
}

void Schmidt::start_fused(Target& t, Time epoch, const Gaussian<9>& motion) const {
  t.fused_started = true;
  t.data_epoch = epoch;
  t.bank.probability = models_.initial_probability;
  set_motion(t.bank, models_, fused_at, motion);
}

void Schmidt::start_fused_by_gps(Target& t) const {
  start_fused(t, t.epoch, gps_motion(t));
  for (int i = 0; i < t.bank.count; ++i) {
    // The error is that of the GPS track, whatever else it has in common; only what a model knows by itself is its own.
    Eigen::MatrixXd& P = t.bank.mode[static_cast<std::size_t>(i)].P;
    const bool own_third = i == models_.ballistic ||
                           models_.model[static_cast<std::size_t>(i)].noise == MotionModel::Noise::WhiteAcceleration;
    const int shared = own_third ? 6 : 9;
    const Eigen::Index others = P.rows() - gps_at;
    P.block(fused_at, gps_at, shared, others) = P.block(gps_at, gps_at, shared, others);
    P.block(gps_at, fused_at, others, shared) = P.block(fused_at, gps_at, shared, others).transpose();
  }
}

void Schmidt::start_fused_by(Target& t, const Measurement& plot) const {
  if (has_reference(t, plot.epoch)) return starts_near_gps_ ? start_fused_near_gps(t) : start_fused_by_gps(t);
  const auto source = static_cast<std::size_t>(plot.source);
  const RadarBlock& block = layout(t).radars[source];
  const Hypothesis& known = t.bank.mode[static_cast<std::size_t>(likeliest(t.bank))];
  start_fused(t, plot.epoch,
              first_motion(plot, settings_, block.bias_at(known.x, plot_of(plot.measured).measured.elevation_rad)));
  if (t.without_gps) leave_time_tags_out(t, layout(t));
  for (int i = 0; i < t.bank.count; ++i)
    tie_to_bias(t.bank.mode[static_cast<std::size_t>(i)], fused_at, settings_.radars[source], block);
}

void Schmidt::start_fused_near_gps(Target& t) const {
  constexpr double position_m = 1000;  // beside what radars measure this is next to nothing
  constexpr double velocity_m_s = 100;
  Gaussian<9> motion{.mean = t.bank.mode[0].x.segment<9>(gps_at), .cov = Mat<9, 9>::Zero()};
  motion.cov.diagonal().head<3>().setConstant(position_m * position_m);
  motion.cov.diagonal().segment<3>(3).setConstant(velocity_m_s * velocity_m_s);
  motion.cov.diagonal().tail<3>().setConstant(std::pow(settings_.start.sigma_acceleration_m_s2, 2));
  start_fused(t, t.epoch, motion);
}

void Schmidt::note_learnt(Target& t, int source, const TimedPlot& plot, bool learnt) const {
  Radar& radar = t.radars[static_cast<std::size_t>(source)];
  if (learnt) {
    radar.updated = plot.epoch;
    radar.rejected_in_row = 0;
    radar.opening.used(settings_.arbitration.reopen_after);
    ++radar.samples;
  } else if (arbitration_.explained_by_bias(source, plot, t.epoch, gps_motion(t)) &&
             ++radar.rejected_in_row >= settings_.arbitration.reopen_after) {
    radar.rejected_in_row = 0;
    if (radar.opening.open(plot.epoch, settings_.arbitration.reopen_after))
      open_bias(t.bank, layout(t).radars[static_cast<std::size_t>(source)]);
  }
}

void Schmidt::start(State& s, int target, Time epoch, const Gaussian<9>& estimate) const {
  Target& t = s.targets[static_cast<std::size_t>(target)];
  size_state(t, epoch, false);
  start_fused(t, epoch, estimate);
}

void Schmidt::predict(Target& t, Time to) const {
  const double dt = (to - t.epoch).seconds();
  t.epoch = to;
  if (dt <= 0) return;
  for (int i = 0; i < t.bank.count; ++i) {
    Hypothesis& h = t.bank.mode[static_cast<std::size_t>(i)];
    const MotionModel& model = models_.model[static_cast<std::size_t>(i)];
    if (t.fused_started) predict_motion(h, fused_at, model, dt);
    if (t.gps.started) predict_motion(h, gps_at, gps_model_, dt);
    if (t.fused_started && t.gps.started && model.noise == gps_model_.noise) {
      // One vehicle moves both tracks: the jerk that both models allow for is the same jerk.
      MotionModel shared = gps_model_;
      shared.q = std::min(model.q, gps_model_.q);
      const Mat<3, 3> Q = process_noise(shared, dt);
      for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) {
          h.P.block<3, 3>(fused_at + 3 * row, gps_at + 3 * column).diagonal().array() += Q(row, column);
          h.P.block<3, 3>(gps_at + 3 * row, fused_at + 3 * column).diagonal().array() += Q(row, column);
        }
      }
    }
    if (settings_.gps.error.enabled && t.gps.started)
      predict_gauss_markov(h, gps_error_at, 3, settings_.gps.error.sigma_m, settings_.gps.error.tau_s, dt);
    predict_bias(h, layout(t), dt);
  }
}

void Schmidt::advance(Target& t, Time to) const {
  interact(t.bank, models_, fused_at, t.mixed, to, scratch_, [&](Time grid) { predict(t, grid); });
  predict(t, to);
}

Outcome Schmidt::apply(State& s, const Measurement& m) const {
  Target& t = s.targets[static_cast<std::size_t>(m.target)];
  if (!t.has_state) size_state(t, m.epoch, settings_.gps.no_gps.enabled);
  advance(t, m.epoch);
  if (m.reset_bias) open_bias(t.bank, layout(t).radars[static_cast<std::size_t>(m.source)]);
  const Outcome outcome = is_fix(m) ? apply_fix(s, m) : apply_plot(s, m);
  count(s.accounts[static_cast<std::size_t>(m.source)], outcome);
  return outcome;
}

Outcome Schmidt::apply_plot(State& s, const Measurement& m) const {
  Target& t = s.targets[static_cast<std::size_t>(m.target)];
  const auto source = static_cast<std::size_t>(m.source);
  if (!t.fused_started && !tells_position(m.measured)) {
    if (!starts_near_gps_ || !has_reference(t, m.epoch)) return {};
    start_fused_near_gps(t);
  }
  if (waits_for_velocity(t, m)) return {};
  Outcome outcome;
  if (t.fused_started) {
    outcome = update_by_plot(s, m);
  } else if (gps_refuses(t, m)) {
    outcome = {.verdict = Verdict::Gated, .nis = 0, .dof = 0};
  } else {
    start_fused_by(t, m);
  }
  if (outcome.verdict != Verdict::Accepted) {
    const Gaussian<9> track = judging_motion(t, m.epoch);
    switch (arbitration_.rejected(t.life, m, outcome.verdict, track)) {
      case Remedy::Restart:
        start_fused_by(t, m);
        break;
      case Remedy::OpenBias:
        open_bias(t.bank, layout(t).radars[source]);
        break;
      case Remedy::Unite:
        downrange::unite(t, fused_at, layout(t), arbitration_, m, track.mean);
        outcome = update_by_plot(s, without_range_rate(m));
        break;
      case Remedy::None:
        break;
    }
  }
  if (outcome.verdict == Verdict::Accepted) note_used(t, m, outcome);
  return outcome;
}

Outcome Schmidt::update_by_plot(State& s, const Measurement& m) const {
  Target& t = s.targets[static_cast<std::size_t>(m.target)];
  const auto source = static_cast<std::size_t>(m.source);
  const Plot plot = plot_of(m.measured);
  SourceAccount& account = s.accounts[source];
  const bool learns_noise =
      settings_.noise.enabled && account.noise.open(m.epoch, m.noise_held, has_reference(t, m.epoch));
  const Outcome outcome =
      with_components(plot, [&]<int First, int M>() { return correct<First, M>(t, account, m, learns_noise); });
  if (uses_range_rate(settings_.radars[source], plot))
    note_part(account, update_by_range_rate(t, account, source, plot, learns_noise));
  return outcome;
}

void Schmidt::note_used(Target& t, const Measurement& plot, const Outcome& outcome) const {
  const auto source = static_cast<std::size_t>(plot.source);
  if (t.without_gps) put_time_tags_in(t, fused_at, layout(t), source);
  arbitration_.accepted(t.life, plot);
  t.data_epoch = plot.epoch;
  t.nis = outcome.nis;
  t.nis_dof = outcome.dof;
  t.radars[source].epoch = plot.epoch;
  const RadarBlock& block = layout(t).radars[source];
  if (!is_led_astray(t, arbitration_, plot, block)) return;
  open_bias(t.bank, block);
  start_fused_by(t, plot);
}

bool Schmidt::gps_refuses(const Target& t, const Measurement& plot) const {
  if (!has_reference(t, plot.epoch)) return false;
  const auto source = static_cast<std::size_t>(plot.source);
  const RadarModel& radar = settings_.radars[source];
  const Plot seen = plot_of(plot.measured);
  const Vec<3> variance = plot_variance(radar, seen);
  const auto l = linearise_components<0, 3>(t.bank.mode[0], gps_at, gps_model_, radar, layout(t).radars[source],
                                            seen.measured, variance);
  return !(evidence_of<3>(t.bank.mode[0], l.H, l.nu, variance.asDiagonal()).nis <= gates_[3]);
}

template <int M>
bool Schmidt::knows_less(const Hypothesis& h, const BlockJacobian<M>& H, const Mat<M, M>& R) {
  const Mat<M, 9> J = H.of_motion.template leftCols<9>();
  const Mat<M, M> of_motion = J * h.P.template block<9, 9>(fused_at, fused_at) * J.transpose();
  return (of_motion.diagonal().array() > R.diagonal().array()).any();
}

template <int First, int M>
Outcome Schmidt::correct(Target& t, SourceAccount& account, const Measurement& m, bool learns_noise) const {
  const auto source = static_cast<std::size_t>(m.source);
  const RadarModel& radar = settings_.radars[source];
  const RadarBlock& block = layout(t).radars[source];
  const Plot plot = plot_of(m.measured);
  const Vec<M> variance = plot_variance(radar, plot).segment<M>(First).cwiseProduct(account.noise.factors<M>(First));
  const Mat<M, M> R = variance.asDiagonal();

  const std::uint64_t heard = radars_heard(t, source);
  // What the fused track and what the GPS track say of the plot; its noise is common to both.
  std::array<Linearisation<M>, ModelSet::max_models> by_fused;
  std::array<Evidence<M>, ModelSet::max_models> of_fused;
  Vec<ModelSet::max_models> log_likelihoods = Vec<ModelSet::max_models>::Zero();
  double nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < t.bank.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    by_fused[k] = linearise_components<First, M>(t.bank.mode[k], fused_at, models_.model[k], radar, block,
                                                 plot.measured, variance);
    of_fused[k] = evidence_of<M>(t.bank.mode[k], by_fused[k].H, by_fused[k].nu, R);
    if (of_fused[k].singular) return {.verdict = Verdict::Singular, .nis = 0, .dof = M};
    log_likelihoods[i] = of_fused[k].log_likelihood;
    if (of_fused[k].nis < nearest) nearest = of_fused[k].nis;
  }
  Outcome outcome{.verdict = nearest <= gates_[M] ? Verdict::Accepted : Verdict::Gated,
                  .nis = of_fused[static_cast<std::size_t>(likeliest(t.bank))].nis,
                  .dof = M};
  // GPS track and biases are the same in all modes: one judges for all.
  const bool referenced = has_reference(t, m.epoch);  // never in the regime without GPS
  const auto count = static_cast<std::size_t>(t.bank.count);
  std::array<Evidence<M>, ModelSet::max_models> of_gps;
  if (referenced) {
    const auto l =
        linearise_components<First, M>(t.bank.mode[0], gps_at, gps_model_, radar, block, plot.measured, variance);
    for (std::size_t k = 0; k < count; ++k) of_gps[k] = evidence_of<M>(t.bank.mode[k], l.H, l.nu, R);
  }
  const bool agrees = referenced && of_gps[0].nis <= gates_[M] &&
                      std::ranges::none_of(std::span(of_gps).first(count), &Evidence<M>::singular);
  if (referenced && m.epoch - t.data_epoch >= settings_.arbitration.restart_after) {
    const auto k = static_cast<std::size_t>(likeliest(t.bank));
    const bool lost = knows_less<M>(t.bank.mode[k], by_fused[k].H, R);
    if (agrees && (lost || outcome.verdict != Verdict::Accepted)) {
      start_fused_by(t, m);
      return {};
    }
    if (lost) outcome.verdict = Verdict::Gated;  // that it allows this plot says nothing
  }
  if (arbitration_.alone_against_gps(t.life, m, referenced && !agrees)) outcome.verdict = Verdict::Gated;
  const bool learns = agrees && knots_ == 0;  // else when the next fixes have come
  const bool follows = outcome.verdict == Verdict::Accepted;
  for (std::size_t k = 0; k < count; ++k) {
    if (t.without_gps) {
      if (follows)
        update_considering_gps(t.bank.mode[k], of_fused[k],
                               considered_without_gps<M>(layout(t), t.learns_biases, heard, of_fused[k].W));
      continue;
    }
    Mat<9, M> of_A = Mat<9, M>::Zero();
    if (learns) of_A = of_gps[k].W.template middleRows<9>(fused_at);
    if (learns && follows)
      of_A -= of_fused[k].W.template middleRows<9>(fused_at) * in_common(of_fused[k], by_fused[k].H, of_gps[k], R);
    if (follows) update_track(t.bank.mode[k], first_radar_, of_fused[k]);
    if (learns) update_biases(t.bank.mode[k], first_radar_, of_gps[k], of_A);
  }
  if ((referenced && knots_ == 0) || (t.without_gps && follows))
    note_learnt(t, m.source, {.epoch = m.epoch, .plot = plot}, learns || t.without_gps);
  if (knots_ > 0 && t.knot_count > 0 && t.held.size() < max_held)
    t.held.push_back({.epoch = m.epoch, .source = m.source, .plot = plot});
  if (follows) reweigh(t.bank, log_likelihoods);
  if (learns_noise) account.noise.update_scale<M>(First, variance, noise_lesson<M>(t.bank, of_fused, outcome.verdict));
  if (!follows) return outcome;
  const Evidence<M>& shown = of_fused[static_cast<std::size_t>(likeliest(t.bank))];
  note_innovation<M>(account, shown.nu, shown.S, shown.nis);
  return outcome;
}

Outcome Schmidt::update_by_range_rate(Target& t, SourceAccount& account, std::size_t source, const Plot& plot,
                                      bool learns_noise) const {
  const RadarModel& radar = settings_.radars[source];
  const RadarBlock& block = layout(t).radars[source];
  const Vec<1> R(range_rate_variance(radar, plot) * account.noise.factor(NoiseScale::range_rate));
  const std::uint64_t heard = radars_heard(t, source);
  std::array<Evidence<1>, ModelSet::max_models> evidence;
  Vec<ModelSet::max_models> log_likelihoods = Vec<ModelSet::max_models>::Zero();
  double nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < t.bank.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const auto l = linearise_range_rate(t.bank.mode[k], fused_at, models_.model[k], radar, block, plot);
    evidence[k] = evidence_of<1>(t.bank.mode[k], l.H, l.nu, Mat<1, 1>(R));
    if (evidence[k].singular) return {.verdict = Verdict::Singular, .nis = 0, .dof = 1};
    log_likelihoods[i] = evidence[k].log_likelihood;
    if (evidence[k].nis < nearest) nearest = evidence[k].nis;
  }
  const Evidence<1>& shown = evidence[static_cast<std::size_t>(likeliest(t.bank))];
  const Outcome outcome{
      .verdict = nearest <= gates_[1] ? Verdict::Accepted : Verdict::Gated, .nis = shown.nis, .dof = 1};
  const bool accepted = outcome.verdict == Verdict::Accepted;
  if (accepted) note_innovation<1>(account, shown.nu, shown.S, shown.nis);
  for (int i = 0; i < t.bank.count && accepted; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (t.without_gps) {
      update_considering_gps(t.bank.mode[k], evidence[k],
                             considered_without_gps<1>(layout(t), t.learns_biases, heard, evidence[k].W));
    } else {
      update_track(t.bank.mode[k], first_radar_, evidence[k]);
    }
  }
  if (accepted) reweigh(t.bank, log_likelihoods);
  if (learns_noise)
    account.noise.update_scale<1>(NoiseScale::range_rate, R, noise_lesson<1>(t.bank, evidence, outcome.verdict));
  return outcome;
}

std::optional<TrackEstimate> Schmidt::fused(const State& state, int target, std::optional<Time> at) const {
  const Target& t = state.targets[static_cast<std::size_t>(target)];
  if (!t.fused_started) return std::nullopt;
  return track_of(t, models_, fused_at, at);
}

BiasEstimate Schmidt::bias(const State& state, int radar) const {
  const auto r = static_cast<std::size_t>(radar);
  const Target* best = best_informed(state.targets, r, [](const Target& t) { return t.has_state; });
  if (best == nullptr) return {};
  const Radar& known = best->radars[r];
  const bool by_gps = !best->without_gps && known.samples > 0;
  // A plot that waits for fixes has not lost its reference.
  const bool referenced =
      knots_ > 0 ? has_reference(*best, known.epoch) : known.epoch - known.updated <= settings_.gps.max_age;
  return bias_known_by(*best, layout(*best).radars[r], r, by_gps, by_gps && !referenced);
}

}  // namespace downrange
