#include <algorithm>
#include <cmath>
#include <downrange/est/method/joint.hpp>
#include <limits>
#include <utility>

#include "time_tags.hpp"
#include "told.hpp"

namespace downrange {
Joint::Joint(MethodSettings settings)
    : settings_(with_wander_as_states(std::move(settings))),
      arbitration_(settings_),
      models_(model_set(settings_.motion)),
      manoeuvring_(constant_acceleration(settings_.motion)),
      layout_(bias_layout(settings_.radars, first_radar_at)),
      layout_without_gps_(bias_layout_without_gps(settings_.radars, settings_.gps.no_gps, first_radar_at)),
      gates_(settings_.arbitration.gate_probability) {
  require_room("joint", settings_.radars.size(), max_radars,
               first_radar_at + std::max(layout_.size, layout_without_gps_.size));
}

Joint::State Joint::initial() const { return state_before_all<State>(settings_, arbitration_); }

void Joint::size_state(State& s, Target& t, bool without_gps) const {
  t.without_gps = without_gps;
  t.learns_biases = true;
  t.bank.count = models_.count;
  t.bank.probability = models_.initial_probability;
  const BiasLayout& blocks = layout(t);
  const Eigen::Index n = first_radar_at + blocks.size;
  if (settings_.motion.kinematics == Kinematics::Vdie) t.manoeuvre = Manoeuvre(static_cast<int>(n));
  // What another target has found by GPS is this one's prior.
  const Target* teacher = nullptr;
  for (const Target& other : s.targets) {
    if (&other != &t && other.started && !other.without_gps && !without_gps &&
        (teacher == nullptr || other.data_epoch > teacher->data_epoch))
      teacher = &other;
  }
  for (int i = 0; i < t.bank.count; ++i) {
    Hypothesis& h = t.bank.mode[static_cast<std::size_t>(i)];
    h.x.setZero(n);
    h.P.setZero(n, n);
    for (const RadarBlock& block : blocks.radars) reset_bias(h, block);
    if (teacher != nullptr) {
      const Hypothesis& known = teacher->bank.mode[static_cast<std::size_t>(likeliest(teacher->bank))];
      h.x.tail(blocks.size) = known.x.tail(blocks.size);
      h.P.bottomRightCorner(blocks.size, blocks.size) = known.P.bottomRightCorner(blocks.size, blocks.size);
    }
  }
}

void Joint::set_motion(Target& t, const Gaussian<9>& motion) const {
  t.manoeuvre.clear();
  downrange::set_motion(t.bank, models_, motion_at, motion);
  const double variance = settings_.gps.error.enabled ? std::pow(settings_.gps.error.sigma_m, 2) : 0;
  for (int i = 0; i < t.bank.count; ++i)
    reset_block(t.bank.mode[static_cast<std::size_t>(i)], gps_error_at, Vec<3>::Zero(),
                variance * Mat<3, 3>::Identity());
}

void Joint::start(State& s, int target, Time epoch, const Gaussian<9>& estimate) const {
  Target& t = s.targets[static_cast<std::size_t>(target)];
  size_state(s, t, false);
  t.started = true;
  t.epoch = t.mixed = t.data_epoch = epoch;
  set_motion(t, estimate);
}

void Joint::start_by(State& s, const Measurement& m, bool without_gps) const {
  Target& t = s.targets[static_cast<std::size_t>(m.target)];
  size_state(s, t, without_gps);
  t.started = true;
  restart_motion(t, m);
}

void Joint::restart_motion(Target& t, const Measurement& m) const {
  t.epoch = t.mixed = t.data_epoch = m.epoch;
  t.bank.probability = models_.initial_probability;
  if (is_fix(m)) {
    set_motion(t, first_motion(m, settings_, Vec<bias_term_count>::Zero()));
    return;
  }
  const RadarModel& radar = settings_.radars[static_cast<std::size_t>(m.source)];
  const RadarBlock& block = layout(t).radars[static_cast<std::size_t>(m.source)];
  const Hypothesis& known = t.bank.mode[static_cast<std::size_t>(likeliest(t.bank))];
  set_motion(t, first_motion(m, settings_, block.bias_at(known.x, plot_of(m.measured).measured.elevation_rad)));
  if (t.without_gps) leave_time_tags_out(t, layout(t));
  for (int i = 0; i < t.bank.count; ++i) tie_to_bias(t.bank.mode[static_cast<std::size_t>(i)], motion_at, radar, block);
}

void Joint::predict(Target& t, Time to) const {
  const double dt = (to - t.epoch).seconds();
  t.epoch = to;
  if (dt <= 0) return;
  for (int i = 0; i < t.bank.count; ++i) {
    Hypothesis& h = t.bank.mode[static_cast<std::size_t>(i)];
    predict_motion(h, motion_at, models(t).model[static_cast<std::size_t>(i)], dt);
    if (settings_.gps.error.enabled)
      predict_gauss_markov(h, gps_error_at, 3, settings_.gps.error.sigma_m, settings_.gps.error.tau_s, dt);
    predict_bias(h, layout(t), dt);
  }
  if (settings_.motion.kinematics == Kinematics::Vdie)
    t.manoeuvre.predict(motion_at, dt, settings_.gps.error.enabled ? std::exp(-dt / settings_.gps.error.tau_s) : 1);
}

void Joint::advance(Target& t, Time to) const {
  interact(t.bank, models_, motion_at, t.mixed, to, scratch_, [&](Time grid) { predict(t, grid); });
  predict(t, to);
}

Outcome Joint::apply(State& s, const Measurement& m) const {
  Target& t = s.targets[static_cast<std::size_t>(m.target)];
  const bool gps = is_fix(m);
  Outcome outcome;
  bool plot_waits = false;
  if (!t.started) {
    if (!tells_position(m.measured)) return outcome;
    start_by(s, m, !gps && settings_.gps.no_gps.enabled);
    if (gps) (void)is_frozen(t.last_fix, m, {});
  } else {
    advance(t, m.epoch);
    if (m.reset_bias) open_bias(t.bank, layout(t).radars[static_cast<std::size_t>(m.source)]);
    plot_waits = !gps && waits_for_velocity(t, m);
    if (!plot_waits) outcome = gps ? apply_fix(s, m) : apply_plot(s, m);
    const bool contradicted = gps && t.without_gps;  // and arbitrated already
    if (outcome.verdict != Verdict::Accepted && !contradicted) outcome = arbitrate(s, m, outcome);
  }
  count(s.accounts[static_cast<std::size_t>(m.source)], outcome);
  const bool used = !plot_waits && !(gps && t.without_gps);  // a first fix waits for the next ones
  if (outcome.verdict != Verdict::Accepted || !used) return outcome;

  arbitration_.accepted(t.life, m);
  t.data_epoch = m.epoch;
  t.nis = outcome.nis;
  t.nis_dof = outcome.dof;
  if (gps) return outcome;
  Radar& radar = t.radars[static_cast<std::size_t>(m.source)];
  radar.epoch = m.epoch;
  ++radar.samples;
  if (t.without_gps) put_time_tags_in(t, motion_at, layout(t), static_cast<std::size_t>(m.source));
  const RadarBlock& block = layout(t).radars[static_cast<std::size_t>(m.source)];
  if (is_led_astray(t, arbitration_, m, block)) {
    open_bias(t.bank, block);
    restart_motion(t, m);
  }
  if (arbitration_.has_receiver(t.life, m.epoch)) {
    radar.referenced = true;
    radar.updated = m.epoch;
  }
  return outcome;
}

Outcome Joint::arbitrate(State& s, const Measurement& m, const Outcome& rejected) const {
  Target& t = s.targets[static_cast<std::size_t>(m.target)];
  const Gaussian<9> track = combined_motion(t.bank, models(t), motion_at, 0);
  switch (arbitration_.rejected(t.life, m, rejected.verdict, track)) {
    case Remedy::None:
      break;
    case Remedy::Restart:
      restart_motion(t, m);
      return {};
    case Remedy::OpenBias:
      open_bias(t.bank, layout(t).radars[static_cast<std::size_t>(m.source)]);
      break;
    case Remedy::Unite:
      unite(t, motion_at, layout(t), arbitration_, m, track.mean);
      return is_fix(m) ? update_by_fix(s, m) : apply_plot(s, without_range_rate(m));
  }
  return rejected;
}

template <int M, class Linearise>
Outcome Joint::update(Target& t, SourceAccount& account, std::uint64_t heard, const Mat<M, M>& R,
                      const Linearise& linearise, NoiseLesson<M>* lesson) const {
  std::array<BlockJacobian<M>, ModelSet::max_models> jacobian;
  std::array<Evidence<M>, ModelSet::max_models> evidence;
  Vec<ModelSet::max_models> log_likelihoods = Vec<ModelSet::max_models>::Zero();
  double nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < t.bank.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const auto [H, nu] = linearise(t.bank.mode[k], models(t).model[k]);
    jacobian[k] = H;
    evidence[k] = evidence_of<M>(t.bank.mode[k], H, nu, R);
    if (evidence[k].singular) return {.verdict = Verdict::Singular, .nis = 0, .dof = M};
    log_likelihoods[i] = evidence[k].log_likelihood;
    if (evidence[k].nis < nearest) nearest = evidence[k].nis;  // NaN is never the nearest
  }
  // The innovation of the mixture, moment-matched.
  Vec<M> nu = Vec<M>::Zero();
  Mat<M, M> S = Mat<M, M>::Zero();
  for (int i = 0; i < t.bank.count; ++i) nu += t.bank.probability[i] * evidence[static_cast<std::size_t>(i)].nu;
  for (int i = 0; i < t.bank.count; ++i) {
    const Evidence<M>& e = evidence[static_cast<std::size_t>(i)];
    S += t.bank.probability[i] * (e.S + (e.nu - nu) * (e.nu - nu).transpose());
  }
  const double nis = t.bank.count == 1 ? evidence[0].nis : nu.dot(S.llt().solve(nu));
  const Outcome outcome{.verdict = nearest <= gates_[M] ? Verdict::Accepted : Verdict::Gated, .nis = nis, .dof = M};
  const bool accepted = outcome.verdict == Verdict::Accepted;
  for (std::size_t k = 0; k < static_cast<std::size_t>(t.bank.count) && accepted; ++k) {
    if (t.without_gps) {
      const Columns<M> considered = considered_without_gps<M>(layout(t), t.learns_biases, heard, evidence[k].W);
      apply_evidence_but<M>(considered, t.bank.mode[k], evidence[k]);
      evidence[k].W -= considered;  // what the gain was, for the manoeuvre
    } else {
      apply_evidence<M>(t.bank.mode[k], evidence[k]);
    }
  }
  if (accepted) reweigh(t.bank, log_likelihoods);
  if (lesson != nullptr) *lesson = noise_lesson<M>(t.bank, evidence, outcome.verdict);
  if (!accepted) return outcome;
  if (settings_.motion.kinematics == Kinematics::Vdie) {
    t.manoeuvre.update<M>(jacobian[0], evidence[0]);
    t.manoeuvre.decide(t.bank.mode[0], motion_at, t.epoch);
  }
  note_innovation<M>(account, nu, S, nis);
  return outcome;
}

Outcome Joint::apply_fix(State& s, const Measurement& m) const {
  Target& t = s.targets[static_cast<std::size_t>(m.target)];
  const Gaussian<9> motion = combined_motion(t.bank, models(t), motion_at, 0);
  if (is_frozen(t.last_fix, m, velocity_of(motion))) return {.verdict = Verdict::Frozen, .nis = 0, .dof = 3};
  return t.without_gps ? first_fix(s, m) : update_by_fix(s, m);
}

Outcome Joint::update_by_fix(State& s, const Measurement& m) const {
  Target& t = s.targets[static_cast<std::size_t>(m.target)];
  SourceAccount& account = s.accounts[static_cast<std::size_t>(m.source)];
  // The noise is the receiver's, whichever station relays it: the first has it for all.
  NoiseScale& noise = s.accounts[settings_.radars.size()].noise;
  const bool learns = settings_.noise.enabled && noise.open(m.epoch, m.noise_held, true);
  const Fix fix = noise.believed(fix_of(m));
  if (arbitration_.is_no_gps_error(combined_three(t.bank, gps_error_at)))
    give_error_to_motion(t.bank, motion_at, gps_error_at, settings_.gps.error.sigma_m);
  const auto use = [&]<int M>() {
    NoiseLesson<M> lesson;
    const Outcome outcome = update<M>(
        t, account, 0, fix_noise<M>(fix),
        [&](const Hypothesis& h, const MotionModel&) {
          return std::pair(fix_jacobian<M>(motion_at), fix_residual<M>(h, motion_at, fix));
        },
        learns ? &lesson : nullptr);
    if (learns) noise.update_scale<M>(fix, lesson);
    return outcome;
  };
  const bool with_velocity = fix.velocity_valid && settings_.gps_use.velocity;
  return with_velocity ? use.template operator()<6>() : use.template operator()<3>();
}

Outcome Joint::first_fix(State& s, const Measurement& m) const {
  Target& t = s.targets[static_cast<std::size_t>(m.target)];
  const Vec<9> track = combined_motion(t.bank, models(t), motion_at, 0).mean;
  switch (arbitration_.first_fixes(t.life, m, track)) {
    case FirstFixes::Contradicted:
      return {.verdict = Verdict::Gated, .nis = 0, .dof = 0};
    case FirstFixes::Hold:
      start_by(s, m, false);
      break;
    case FirstFixes::Wait:
      break;
  }
  return {};
}

template <int M, class Linearise>
Outcome Joint::update_by_radar(Target& t, SourceAccount& account, std::uint64_t heard, bool learns, int first,
                               const Vec<M>& configured, const Linearise& linearise) const {
  const Vec<M> variance = configured.cwiseProduct(account.noise.factors<M>(first));
  NoiseLesson<M> lesson;
  const Outcome outcome =
      update<M>(t, account, heard, Mat<M, M>(variance.asDiagonal()), linearise, learns ? &lesson : nullptr);
  if (learns) account.noise.update_scale<M>(first, variance, lesson);
  return outcome;
}

Outcome Joint::apply_plot(State& s, const Measurement& m) const {
  Target& t = s.targets[static_cast<std::size_t>(m.target)];
  const auto source = static_cast<std::size_t>(m.source);
  const RadarModel& radar = settings_.radars[source];
  const RadarBlock& block = layout(t).radars[source];
  const Plot plot = plot_of(m.measured);
  SourceAccount& account = s.accounts[source];
  const std::uint64_t heard = radars_heard(t, source);
  const bool learns =
      settings_.noise.enabled && account.noise.open(m.epoch, m.noise_held, arbitration_.has_receiver(t.life, m.epoch));
  const Outcome outcome = with_components(plot, [&]<int First, int M>() {
    const Vec<M> variance = plot_variance(radar, plot).segment<M>(First);
    return update_by_radar<M>(
        t, account, heard, learns, First, variance, [&](const Hypothesis& h, const MotionModel& model) {
          const auto l = linearise_components<First, M>(h, motion_at, model, radar, block, plot.measured, variance);
          return std::pair(l.H, l.nu);
        });
  });
  if (!uses_range_rate(radar, plot)) return outcome;
  // Judged by itself: neither takes the other along when it is wrong.
  note_part(account, update_by_radar<1>(t, account, heard, learns, NoiseScale::range_rate,
                                        Vec<1>(range_rate_variance(radar, plot)),
                                        [&](const Hypothesis& h, const MotionModel& model) {
                                          const auto l = linearise_range_rate(h, motion_at, model, radar, block, plot);
                                          return std::pair(l.H, l.nu);
                                        }));
  return outcome;
}

std::optional<TrackEstimate> Joint::fused(const State& state, int target, std::optional<Time> at) const {
  const Target& t = state.targets[static_cast<std::size_t>(target)];
  if (!t.started) return std::nullopt;
  return track_of(t, models(t), motion_at, at);
}

BiasEstimate Joint::bias(const State& state, int radar) const {
  const auto r = static_cast<std::size_t>(radar);
  const Target* best = best_informed(state.targets, r, [](const Target& t) { return t.started; });
  if (best == nullptr) return {};
  const Radar& known = best->radars[r];
  const bool frozen = known.referenced && known.epoch - known.updated > settings_.gps.max_age;
  return bias_known_by(*best, layout(*best).radars[r], r, known.referenced, frozen);
}

}  // namespace downrange
