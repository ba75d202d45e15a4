#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <downrange/est/method/ts.hpp>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace downrange {
namespace {

/// Random walks of the biases advance on this grid of UTC: every step costs all targets.
constexpr Duration drift_step = milliseconds(1000);
/// From the plot's own place to the one that a bias of a degree moves it to, to a millimetre.
constexpr int newton_steps = 4;
/// Above this correlation two radars' terms cannot be told apart.
constexpr double alike = 0.99;

Eigen::Index index(BiasTerm term) { return static_cast<Eigen::Index>(term); }

/// What is looked for without GPS: the regime's priors, but constant biases.
BiasLayout layout_of(const MethodSettings& settings) {
  std::vector<RadarModel> radars = settings.radars;
  for (RadarModel& radar : radars) radar.wander = {};
  if (settings.gps.no_gps.enabled) {
    const BiasLayout tight = bias_layout_without_gps(radars, settings.gps.no_gps, 0);
    for (std::size_t i = 0; i < radars.size(); ++i) radars[i].bias = tight.radars[i].model;
  }
  return bias_layout(radars, 0);
}

template <int M>
Outcome outcome_of(SourceAccount& account, const TwoStageUpdate<M>& u) {
  if (u.verdict == Verdict::Accepted) note_innovation<M>(account, u.innovation, u.S, u.nis);
  return {.verdict = u.verdict, .nis = u.nis, .dof = M};
}

template <int M>
NoiseLesson<M> lesson_of(const TwoStageUpdate<M>& u) {
  if (u.verdict != Verdict::Accepted)
    return {.verdict = u.verdict, .excess = u.innovation * u.innovation.transpose() - u.S};
  const Eigen::LLT<Mat<M, M>> llt(u.S);
  return {.verdict = u.verdict, .excess = noise_excess<M>(llt.matrixL(), llt.matrixL().solve(u.innovation))};
}

}  // namespace

template <int N>
Ts<N>::Ts(MethodSettings settings)
    : settings_(std::move(settings)),
      arbitration_(settings_),
      motion_{.noise = MotionModel::Noise::WhiteJerk, .q = settings_.motion.q_ca_m2_s5, .gravity_aware = false},
      layout_(layout_of(settings_)),
      drifts_(std::ranges::any_of(layout_.radars,
                                  [](const RadarBlock& block) {
                                    return std::ranges::any_of(block.model.terms, [&](BiasTerm term) {
                                      return block.model.drift[index(term)] > 0;
                                    });
                                  })),
      step_(layout_.size),
      gates_(settings_.arbitration.gate_probability) {
  if (settings_.radars.size() > max_radars)
    throw std::invalid_argument("method ts takes at most " + std::to_string(max_radars) + " radars");
}

template <int N>
typename Ts<N>::State Ts<N>::initial() const {
  Hypothesis prior{.x = Eigen::VectorXd::Zero(layout_.size), .P = Eigen::MatrixXd::Zero(layout_.size, layout_.size)};
  for (const RadarBlock& block : layout_.radars) reset_bias(prior, block);
  Target target;
  target.track = {{Vec<N>::Zero(), Mat<N, N>::Identity()}, Mat<N, Eigen::Dynamic>::Zero(N, layout_.size)};
  target.life = arbitration_.unborn();
  return {.bias = Shared(prior.x, prior.P),
          .drifted = std::nullopt,
          .targets = std::vector<Target>(static_cast<std::size_t>(settings_.targets), target),
          .radars = std::vector<Radar>(settings_.radars.size()),
          .accounts = accounts_of(settings_, false)};
}

template <int N>
void Ts<N>::restart(Target& t, Time epoch, const Gaussian<9>& motion) const {
  t.started = true;
  t.epoch = t.data_epoch = epoch;
  t.track.estimate.mean.setZero();
  t.track.estimate.mean.template head<9>() = motion.mean;
  t.track.estimate.cov.setZero();
  t.track.estimate.cov.template topLeftCorner<9, 9>() = motion.cov;
  t.track.estimate.cov.diagonal().template tail<N - 9>().setConstant(std::pow(settings_.gps.error.sigma_m, 2));
  t.track.V.setZero();
}

template <int N>
void Ts<N>::restart_by(State& s, const Measurement& m) const {
  Target& t = s.targets[static_cast<std::size_t>(m.target)];
  if (is_fix(m)) return restart(t, m.epoch, first_motion(m, settings_, Vec<bias_term_count>::Zero()));

  // The position where the radar, with the bias known so far, would have measured the plot: h(p, b^) = z.
  const auto source = static_cast<std::size_t>(m.source);
  const RadarModel& radar = settings_.radars[source];
  const RadarBlock& block = layout_.radars[source];
  const Plot plot = plot_of(m.measured);
  const Vec<bias_term_count> bias = block.bias(s.bias.mean());
  Gaussian<9> motion = first_motion(m, settings_, bias);
  PredictedPlot predicted;
  Mat<3, 3> d_position;  // d p / d plot
  for (int step = 0; step < newton_steps; ++step) {
    predicted = predict_plot(radar, motion.mean, bias);
    d_position = predicted.d_motion.leftCols<3>().inverse();
    motion.mean.head<3>() += d_position * plot_residual(plot.measured, predicted.q);
  }
  // Given b the plot's noise is all that is wrong, and where the target was within a time tag of unknown size.
  double tau_variance = 0;
  for (int i = 0; i < block.terms; ++i) {
    if (block.term[static_cast<std::size_t>(i)] == BiasTerm::TimeTag)
      tau_variance = std::pow(block.prior_sigma()[i], 2);
  }
  motion.cov.topLeftCorner<3, 3>() = d_position * plot_variance(radar, plot).asDiagonal() * d_position.transpose() +
                                     tau_variance * motion.cov.block<3, 3>(3, 3);
  restart(t, m.epoch, motion);
  for (int i = 0; i < block.terms; ++i) {
    const Vec<3> per_bias = -d_position * predicted.d_bias.col(index(block.term[static_cast<std::size_t>(i)]));
    t.track.V.col(block.at + i).template head<3>() = per_bias;
    t.track.estimate.mean.template head<3>() -= per_bias * s.bias.mean()[block.at + i];
  }
}

template <int N>
void Ts<N>::start(State& s, int target, Time epoch, const Gaussian<9>& estimate) const {
  restart(s.targets[static_cast<std::size_t>(target)], epoch, estimate);
}

template <int N>
void Ts<N>::predict(Target& t, Time to) const {
  const double dt = (to - t.epoch).seconds();
  t.epoch = to;
  if (dt <= 0) return;
  const double phi = N == 12 ? std::exp(-dt / settings_.gps.error.tau_s) : 1;
  const Mat<3, 3> of_motion = process_noise(motion_, dt);
  Mat<N, N> Q = Mat<N, N>::Zero();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      Q.template block<3, 3>(3 * row, 3 * column).diagonal().setConstant(of_motion(row, column));
  }
  Q.diagonal().template tail<N - 9>().setConstant(std::pow(settings_.gps.error.sigma_m, 2) * (1 - phi * phi));
  const auto transition = [dt, phi](auto& X) {
    X.template topRows<3>() += dt * X.template middleRows<3>(3) + dt * dt / 2 * X.template middleRows<3>(6);
    X.template middleRows<3>(3) += dt * X.template middleRows<3>(6);
    X.template bottomRows<N - 9>() *= phi;
  };
  downrange::predict(t.track, transition, Q);
}

template <int N>
void Ts<N>::loosen_all(State& s) const {
  s.bias.loosen(step_);
  for (Target& t : s.targets) loosen(t.track, s.bias, step_);
}

template <int N>
void Ts<N>::drift(State& s, Time to) const {
  const Time grid = ceil_to_grid(to, drift_step);
  const double dt = s.drifted ? (grid - *s.drifted).seconds() : 0;
  if (!s.drifted || grid > *s.drifted) s.drifted = grid;
  if (dt <= 0) return;
  for (const RadarBlock& block : layout_.radars) {
    for (int i = 0; i < block.terms; ++i) {
      const double per_root_second = block.model.drift[index(block.term[static_cast<std::size_t>(i)])];
      step_.variance[block.at + i] = per_root_second * per_root_second * dt;
    }
  }
  loosen_all(s);
}

template <int N>
Outcome Ts<N>::apply(State& s, const Measurement& m) const {
  Target& t = s.targets[static_cast<std::size_t>(m.target)];
  const bool gps = is_fix(m);
  if (drifts_) drift(s, m.epoch);
  Outcome outcome;
  if (!t.started) {
    if (!tells_position(m.measured)) return outcome;
    restart_by(s, m);
    if (gps) (void)is_frozen(t.last_fix, m, {});
  } else {
    predict(t, m.epoch);
    if (m.reset_bias) loosen_priors(s, std::uint64_t{1} << m.source, 1);
    outcome = gps ? apply_fix(s, m) : apply_plot(s, m);
    if (outcome.verdict != Verdict::Accepted) outcome = arbitrate(s, m, outcome);
  }
  count(s.accounts[static_cast<std::size_t>(m.source)], outcome);
  if (outcome.verdict != Verdict::Accepted) return outcome;

  arbitration_.accepted(t.life, m);
  t.data_epoch = m.epoch;
  t.nis = outcome.nis;
  t.nis_dof = outcome.dof;
  if (gps) return outcome;
  Radar& radar = s.radars[static_cast<std::size_t>(m.source)];
  radar.epoch = m.epoch;
  ++radar.samples;
  if (arbitration_.has_receiver(t.life, m.epoch)) radar.referenced = true;
  return outcome;
}

template <int N>
Outcome Ts<N>::arbitrate(State& s, const Measurement& m, const Outcome& rejected) const {
  Target& t = s.targets[static_cast<std::size_t>(m.target)];
  const Gaussian<N> now = compensated(t.track, s.bias);
  const Gaussian<9> track{.mean = now.mean.template head<9>(), .cov = now.cov.template topLeftCorner<9, 9>()};
  switch (arbitration_.rejected(t.life, m, rejected.verdict, track)) {
    case Remedy::None:
      break;
    case Remedy::Restart:
      restart_by(s, m);
      return {};
    case Remedy::OpenBias:
      // All targets share it: one that is refused here and used there follows something else here.
      if (s.accounts[static_cast<std::size_t>(m.source)].rejected_in_row + 1 >= settings_.arbitration.reopen_after)
        loosen_priors(s, std::uint64_t{1} << m.source, 1);
      break;
    case Remedy::Unite:
      loosen_priors(s, Arbitration::loosened_by(t.life, m), 0.25);
      t.track.estimate.cov.template topLeftCorner<6, 6>() +=
          Arbitration::union_term(arbitration_.away_from(t.life, m, track.mean));
      return is_fix(m) ? update_by_fix(s, m) : apply_plot(s, without_range_rate(m));
  }
  return rejected;
}

template <int N>
void Ts<N>::loosen_priors(State& s, std::uint64_t radars, double share) const {
  step_.variance.setZero();
  for (std::size_t radar = 0; radar < layout_.radars.size(); ++radar) {
    const RadarBlock& block = layout_.radars[radar];
    if ((radars >> radar & 1) != 0)
      step_.variance.segment(block.at, block.terms) = share * block.prior_sigma().head(block.terms).cwiseAbs2();
  }
  loosen_all(s);
}

template <int N>
Outcome Ts<N>::apply_fix(State& s, const Measurement& m) const {
  Target& t = s.targets[static_cast<std::size_t>(m.target)];
  const Gaussian<N> now = compensated(t.track, s.bias);
  const TrackVelocity velocity{.m_s = now.mean.template segment<3>(3),
                               .sigma_m_s = std::sqrt(now.cov.template block<3, 3>(3, 3).trace())};
  if (is_frozen(t.last_fix, m, velocity)) return {.verdict = Verdict::Frozen, .nis = 0, .dof = 3};
  const Outcome outcome = update_by_fix(s, m);
  if (outcome.verdict != Verdict::Gated || !Arbitration::may_be_engine_event(t.life)) return outcome;
  const Mat<N, N> before = t.track.estimate.cov;
  Mat<9, 9> opened = before.template topLeftCorner<9, 9>();
  Arbitration::add_engine_event(opened, m.epoch - t.life.receiver.accepted->epoch);
  t.track.estimate.cov.template topLeftCorner<9, 9>() = opened;
  const Outcome by_event = update_by_fix(s, m);
  if (by_event.verdict == Verdict::Accepted) return by_event;
  t.track.estimate.cov = before;
  return outcome;
}

template <int N>
Outcome Ts<N>::update_by_fix(State& s, const Measurement& m) const {
  Target& t = s.targets[static_cast<std::size_t>(m.target)];
  SourceAccount& account = s.accounts[static_cast<std::size_t>(m.source)];
  const bool learns = settings_.noise.enabled && account.noise.open(m.epoch, m.noise_held, true);
  const Fix fix = account.noise.believed(fix_of(m));
  bound_gps_error(s, t);
  const Vec<N> x = compensated_mean(t.track, s.bias);
  const auto use = [&]<int M>() {
    Vec<M> nu;
    nu.template head<3>() = fix.position.m;
    if constexpr (M == 6) nu.template tail<3>() = fix.velocity.m_s;
    nu -= x.template head<M>();
    Mat<M, N> H = Mat<M, N>::Zero();
    H.template leftCols<M>().setIdentity();
    if constexpr (N == 12) {
      nu.template head<3>() -= x.template tail<3>();
      H.template topRightCorner<3, 3>().setIdentity();
    }
    const auto u = update(s.bias, t.track, nu, H, Mat<M, 0>(), 0, fix_noise<M>(fix), gates_[M]);
    if (learns) account.noise.update_scale<M>(fix, lesson_of<M>(u));
    return outcome_of<M>(account, u);
  };
  const bool with_velocity = fix.velocity_valid && settings_.gps_use.velocity;
  return with_velocity ? use.template operator()<6>() : use.template operator()<3>();
}

template <int N>
void Ts<N>::bound_gps_error(const State& s, Target& t) const {
  if constexpr (N == 12) {
    const Vec<3> error = compensated_mean(t.track, s.bias).template tail<3>();
    if (!arbitration_.is_no_gps_error(error)) return;
    Gaussian<N>& track = t.track.estimate;
    track.cov.template topLeftCorner<3, 3>() += union_term(error);
    track.mean.template tail<3>().setZero();
    track.cov.template bottomRows<3>().setZero();
    track.cov.template rightCols<3>().setZero();
    track.cov.diagonal().template tail<3>().setConstant(std::pow(settings_.gps.error.sigma_m, 2));
    t.track.V.template bottomRows<3>().setZero();
  }
}

template <int N>
Outcome Ts<N>::apply_plot(State& s, const Measurement& m) const {
  Target& t = s.targets[static_cast<std::size_t>(m.target)];
  const auto source = static_cast<std::size_t>(m.source);
  const RadarModel& radar = settings_.radars[source];
  const RadarBlock& block = layout_.radars[source];
  const Plot plot = plot_of(m.measured);
  const Vec<N> x = compensated_mean(t.track, s.bias);
  const PredictedPlot predicted = predict_plot(radar, x.template head<9>(), block.bias(s.bias.mean()));
  const Vec<3> nu = plot_residual(plot.measured, predicted.q);
  Mat<3, N> H = Mat<3, N>::Zero();
  H.template leftCols<9>() = predicted.d_motion;
  Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, bias_term_count> C(3, block.terms);
  for (int i = 0; i < block.terms; ++i) C.col(i) = predicted.d_bias.col(index(block.term[static_cast<std::size_t>(i)]));
  SourceAccount& account = s.accounts[source];
  const bool learns =
      settings_.noise.enabled && account.noise.open(m.epoch, m.noise_held, arbitration_.has_receiver(t.life, m.epoch));
  const Outcome outcome = with_components(plot, [&]<int First, int M>() {
    const Vec<M> variance = plot_variance(radar, plot).segment<M>(First).cwiseProduct(account.noise.factors<M>(First));
    const auto u =
        update(s.bias, t.track, Vec<M>(nu.template segment<M>(First)), Mat<M, N>(H.template middleRows<M>(First)),
               C.template middleRows<M>(First), block.at, Mat<M, M>(variance.asDiagonal()), gates_[M]);
    if (learns) account.noise.update_scale<M>(First, variance, lesson_of<M>(u));
    return outcome_of<M>(account, u);
  });
  if (uses_range_rate(radar, plot)) note_part(account, update_by_range_rate(s, t, source, plot, learns));
  return outcome;
}

template <int N>
Outcome Ts<N>::update_by_range_rate(State& s, Target& t, std::size_t source, const Plot& plot, bool learns) const {
  const RadarModel& radar = settings_.radars[source];
  const RadarBlock& block = layout_.radars[source];
  const Vec<9> motion = compensated_mean(t.track, s.bias).template head<9>();
  const PredictedRangeRate predicted = predict_range_rate(radar, motion, block.bias(s.bias.mean()));
  Mat<1, N> H = Mat<1, N>::Zero();
  H.template leftCols<9>() = predicted.d_motion;
  Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, bias_term_count> C(1, block.terms);
  for (int i = 0; i < block.terms; ++i) C[i] = predicted.d_bias[index(block.term[static_cast<std::size_t>(i)])];
  const Vec<1> nu(plot.range_rate_m_s - predicted.m_s);
  SourceAccount& account = s.accounts[source];
  const Vec<1> variance(range_rate_variance(radar, plot) * account.noise.factor(NoiseScale::range_rate));
  const auto u = update(s.bias, t.track, nu, H, C, block.at, Mat<1, 1>(variance), gates_[1]);
  if (learns) account.noise.update_scale<1>(NoiseScale::range_rate, variance, lesson_of<1>(u));
  return outcome_of<1>(account, u);
}

template <int N>
std::optional<TrackEstimate> Ts<N>::fused(const State& state, int target, std::optional<Time> at) const {
  const Target& t = state.targets[static_cast<std::size_t>(target)];
  if (!t.started) return std::nullopt;
  TrackEstimate e;
  e.epoch = at.value_or(t.data_epoch);
  e.data_epoch = t.data_epoch;
  e.size = 9;
  const Gaussian<N> now = compensated(t.track, state.bias);
  const Gaussian<9> x = downrange::predict(
      motion_, {now.mean.template head<9>(), now.cov.template topLeftCorner<9, 9>()}, (e.epoch - t.epoch).seconds());
  e.mean = x.mean;
  e.cov = x.cov;
  e.sources = Arbitration::recent_sources(t.life, t.data_epoch);
  e.nis = t.nis;
  e.nis_dof = t.nis_dof;
  return e;
}

template <int N>
BiasEstimate Ts<N>::bias(const State& state, int radar) const {
  const RadarBlock& block = layout_.radars[static_cast<std::size_t>(radar)];
  const Radar& known = state.radars[static_cast<std::size_t>(radar)];
  BiasEstimate b;
  b.epoch = known.epoch;
  b.samples = known.samples;
  b.terms = block.terms;
  b.term = block.term;
  b.value.head(block.terms) = state.bias.mean().segment(block.at, block.terms);
  if (known.samples > 0) {
    for (std::size_t other = 0; other < state.radars.size(); ++other) {
      if (static_cast<int>(other) != radar && state.radars[other].samples > 0) b.reference = BiasReference::CrossRadar;
    }
  }
  if (known.referenced) b.reference = BiasReference::Gps;

  const Eigen::MatrixXd& P = state.bias.covariance();
  b.cov.topLeftCorner(block.terms, block.terms) = P.block(block.at, block.at, block.terms, block.terms);
  std::array<bool, BiasEstimate::max_terms> like_anothers{};
  for (int i = 0; i < block.terms; ++i) {
    const int at = block.at + i;
    for (int j = 0; j < layout_.size; ++j) {
      const bool own = j >= block.at && j < block.at + block.terms;
      if (!own && std::abs(P(j, at)) > alike * std::sqrt(P(j, j) * P(at, at)))
        like_anothers[static_cast<std::size_t>(i)] = true;
    }
  }
  b.state = bias_states(b, block.prior_sigma(), false);
  for (std::size_t i = 0; i < static_cast<std::size_t>(block.terms); ++i) {
    if (like_anothers[i]) b.state[i] = BiasState::NotObservable;
  }
  return b;
}

template class Ts<9>;
template class Ts<12>;

}  // namespace downrange
