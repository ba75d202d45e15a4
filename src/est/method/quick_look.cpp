#include <cmath>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/est/method/quick_look.hpp>
#include <downrange/est/method/source_checks.hpp>
#include <downrange/est/model/plot_model.hpp>

namespace downrange {
namespace {

/// [position, velocity] of another frame's axes.
Mat<6, 6> both(const Mat<3, 3>& R) {
  Mat<6, 6> twice = Mat<6, 6>::Zero();
  twice.topLeftCorner<3, 3>() = R;
  twice.bottomRightCorner<3, 3>() = R;
  return twice;
}

}  // namespace

void RadarTracker::start(State& state, int, Time epoch, const Gaussian<9>& estimate) const {
  const Mat<6, 6> R_enu_ecef = both(radar_->site.R_enu_ecef().R);
  Gaussian<6> x{.mean = estimate.mean.head<6>(), .cov = {}};
  x.mean.head<3>() -= radar_->site.ecef().m;
  x.mean = R_enu_ecef * x.mean;
  x.cov = R_enu_ecef * estimate.cov.topLeftCorner<6, 6>() * R_enu_ecef.transpose();
  state.tracker.emplace(tracker_, x);
  state.epoch = epoch;
}

Outcome RadarTracker::apply(State& state, const Measurement& m) const {
  const TimedPlot now{.epoch = m.epoch, .plot = plot_of(m.measured)};
  const Polar& plot = now.plot.measured;
  const Vec<3> sigma = plot_variance(*radar_, now.plot).cwiseSqrt();
  const ConvertedMeasurement z = convert_unbiased(without_refraction(*radar_, plot), {sigma[0], sigma[1], sigma[2]});
  const Mat<3, 3> axes = line_of_sight_axes<3>(z.z.m);
  const Vec<3> sigma_m = (axes.transpose() * z.R * axes).diagonal().cwiseSqrt();
  const auto start_by_plot = [&] {
    state.tracker.emplace(tracker_, z.z.m, sigma_m);
    state.epoch = m.epoch;
    state.refused = {};
  };
  if (!state.tracker) {
    start_by_plot();
    return {};
  }
  const double T = (m.epoch - state.epoch).seconds();
  if (T <= 0) return {.verdict = Verdict::Singular};
  state.scan = state.tracker->scan(z.z.m, sigma_m, T);
  const Outcome outcome{.verdict = state.scan.verdict, .nis = state.scan.nis, .dof = 3};
  if (outcome.verdict == Verdict::Accepted) {
    state.epoch = m.epoch;
    state.refused = {};
    return outcome;
  }
  state.refused.note(m.epoch);
  const bool again = of_one_vehicle(*radar_, state.refused_plot, now);
  state.refused_plot = now;
  if (again && state.refused.last(m.epoch, restart_after_)) start_by_plot();
  return outcome;
}

std::optional<TrackEstimate> RadarTracker::estimate(const State& state, std::optional<Time> at) const {
  if (!state.tracker) return std::nullopt;
  TrackEstimate e;
  e.data_epoch = state.epoch;
  e.epoch = at.value_or(state.epoch);
  const Gaussian<6> x = state.tracker->predicted((e.epoch - e.data_epoch).seconds());
  const Mat<6, 6> R_ecef_enu = both(radar_->site.R_enu_ecef().R.transpose());
  e.mean.head<6>() = R_ecef_enu * x.mean;
  e.mean.head<3>() += radar_->site.ecef().m;
  const Mat<6, 6> P = R_ecef_enu * x.cov * R_ecef_enu.transpose();
  e.cov.topLeftCorner<6, 6>() = (P + P.transpose()) / 2;
  e.nis = state.scan.nis;
  e.nis_dof = 3;
  return e;
}

QuickLook::QuickLook(MethodSettings settings) : settings_(std::move(settings)) {
  const AlphaBetaSettings tracker{.sigma_acceleration = settings_.quick_look.acceleration_m_s2,
                                  .initial_sigma_velocity = settings_.start.sigma_velocity_m_s,
                                  .gate = chi2_quantile(settings_.arbitration.gate_probability, 3)};
  tracks_.reserve(static_cast<std::size_t>(settings_.targets) * settings_.radars.size());
  for (int target = 0; target < settings_.targets; ++target) {
    for (const RadarModel& radar : settings_.radars)
      tracks_.emplace_back(RadarTracker(radar, tracker, settings_.arbitration.restart_after), RadarTracker::State{},
                           settings_.arbitration.history);
  }
  accounts_ = accounts_of(settings_, false);
}

void QuickLook::start(int target, Time epoch, const Gaussian<9>& estimate) {
  for (std::size_t radar = 0; radar < settings_.radars.size(); ++radar) {
    if (measures_position(settings_.radars[radar].sigma)) tracks_[index(radar, target)].start(target, epoch, estimate);
  }
}

Outcome QuickLook::process(const Measurement& m, Time now) {
  if (is_fix(m) || !tells_position(m.measured)) return {};
  const auto radar = static_cast<std::size_t>(m.source);
  Rewinder<RadarTracker>& track = tracks_[index(radar, m.target)];
  const Outcome outcome = track.process(m, now);
  SourceAccount& account = accounts_[radar];
  count(account, outcome);
  const RadarTracker::State& state = track.state();
  // The innovation of a late plot is not kept.
  if (outcome.verdict == Verdict::Accepted && outcome.dof > 0 && state.epoch == m.epoch) {
    const Mat<3, 3> S = state.scan.sigma.cwiseAbs2().asDiagonal();
    note_innovation<3>(account, state.scan.innovation, S, outcome.nis);
  }
  return outcome;
}

std::optional<TrackEstimate> QuickLook::fused(int target, std::optional<Time> at) const {
  const std::size_t first = index(0, target);
  std::optional<Time> newest;
  for (std::size_t radar = 0; radar < settings_.radars.size(); ++radar) {
    const RadarTracker::State& state = tracks_[first + radar].state();
    if (state.tracker && (!newest || state.epoch > *newest)) newest = state.epoch;
  }
  if (!newest) return std::nullopt;
  std::optional<TrackEstimate> best;
  for (std::size_t radar = 0; radar < settings_.radars.size(); ++radar) {
    const Rewinder<RadarTracker>& track = tracks_[first + radar];
    if (!track.state().tracker || *newest - track.state().epoch > milliseconds(1000)) continue;
    auto e = track.core().estimate(track.state(), at);
    if (best && best->cov.topLeftCorner<3, 3>().trace() <= e->cov.topLeftCorner<3, 3>().trace()) continue;
    e->sources = std::uint64_t{1} << radar;
    best = e;
  }
  return best;
}

std::unique_ptr<MethodState> QuickLook::make_state() const {
  return std::make_unique<HeldState<State>>(
      State{.tracks = std::vector<RadarTracker::State>(tracks_.size()), .accounts = accounts_});
}

void QuickLook::save(Time before, MethodState& state) const {
  State& held = dynamic_cast<HeldState<State>&>(state).value;
  for (std::size_t i = 0; i < tracks_.size(); ++i) tracks_[i].state_before(before, held.tracks[i]);
  held.accounts = accounts_;
}

void QuickLook::restore(const MethodState& state) {
  const State& held = dynamic_cast<const HeldState<State>&>(state).value;
  for (std::size_t i = 0; i < tracks_.size(); ++i) tracks_[i].restart(held.tracks[i]);
  accounts_ = held.accounts;
}

}  // namespace downrange
