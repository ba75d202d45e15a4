#include <algorithm>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/est/method/track_level.hpp>
#include <limits>
#include <stdexcept>
#include <string>

namespace downrange {

template <class Rule>
TrackLevel<Rule>::TrackLevel(MethodSettings settings)
    : align_(std::move(settings), true), gate3_(chi2_quantile(align_.settings().arbitration.gate_probability, 3)) {
  const std::vector<RadarModel>& radars = align_.settings().radars;
  track_of_.resize(radars.size(), -1);
  for (std::size_t i = 0; i < radars.size(); ++i) {
    if (!measures_position(radars[i].sigma)) continue;
    track_of_[i] = static_cast<int>(radar_of_.size());
    radar_of_.push_back(static_cast<int>(i));
  }
  if (radar_of_.size() > max_fused_tracks) {
    throw std::invalid_argument("track-level fusion takes at most " + std::to_string(max_fused_tracks) +
                                " radars, found " + std::to_string(radar_of_.size()));
  }
}

template <class Rule>
typename TrackLevel<Rule>::State TrackLevel<Rule>::initial() const {
  const Target idle{.epoch = {},
                    // A range without radars has nothing to fuse; a rule has room for one track all the same.
                    .rule = Rule(std::max(1, static_cast<int>(radar_of_.size()))),
                    .contributed = std::vector<Time>(radar_of_.size()),
                    .data_epoch = {},
                    .fused = {}};
  State s;
  s.align = align_.initial();
  s.targets.resize(static_cast<std::size_t>(settings().targets), idle);
  s.accounts = accounts_of(settings(), false);
  return s;
}

template <class Rule>
void TrackLevel<Rule>::start_target(Target& t, Time epoch, const Gaussian<6>& x) {
  t.started = true;
  t.epoch = t.data_epoch = epoch;
  t.rule.start(x);
  t.fused = x;
  std::ranges::fill(t.contributed, never);
}

template <class Rule>
void TrackLevel<Rule>::start(State& state, int target, Time epoch, const Gaussian<9>& estimate) const {
  start_target(state.targets[static_cast<std::size_t>(target)], epoch,
               {.mean = estimate.mean.head<6>(), .cov = estimate.cov.topLeftCorner<6, 6>()});
}

template <class Rule>
Outcome TrackLevel<Rule>::apply(State& state, const Measurement& m) const {
  if (!is_fix(m)) return apply_plot(state, m);
  SourceAccount& account = state.accounts[static_cast<std::size_t>(m.source)];
  return align_.apply_fix(state.align, account, m, fused(state, m.target, m.epoch));
}

template <class Rule>
Outcome TrackLevel<Rule>::apply_plot(State& state, const Measurement& m) const {
  const int track = track_of_[static_cast<std::size_t>(m.source)];
  if (track < 0 || !tells_position(m.measured)) return {};
  Target& t = state.targets[static_cast<std::size_t>(m.target)];
  SourceAccount& account = state.accounts[static_cast<std::size_t>(m.source)];

  const TimedPosition z = align_.compensated(state.align, m);
  const bool refused = align_.is_refused(state.align, m);
  const auto start_by_plot = [&] {
    start_target(t, m.epoch, started_from(z, settings().start.sigma_velocity_m_s));
    t.contributed[static_cast<std::size_t>(track)] = m.epoch;
  };
  Outcome outcome{.verdict = refused ? Verdict::Gated : Verdict::Accepted, .nis = 0, .dof = 0};
  if (t.started) {
    outcome = update(t, account, m, z, track, refused);
  } else if (!refused) {
    start_by_plot();
  }
  count(account, outcome);
  if (outcome.verdict == Verdict::Accepted) {
    align_.arbitration().accepted(state.align.lives[static_cast<std::size_t>(m.target)], m);
    return outcome;
  }
  const Remedy remedy = align_.rejected(state.align, m, outcome.verdict);
  if (remedy == Remedy::Restart) start_by_plot();
  if (remedy == Remedy::OpenBias) t.rule.designate(track);  // its track starts anew
  return outcome;
}

template <class Rule>
Outcome TrackLevel<Rule>::update(Target& t, SourceAccount& account, const Measurement& m, const TimedPosition& z,
                                 int track, bool refused) const {
  const auto slot = static_cast<std::size_t>(track);
  advance(t, m.epoch);
  if (refused) return {.verdict = Verdict::Gated, .nis = 0, .dof = 0};
  if (silent(t, slot)) t.rule.designate(track);
  const auto u = t.rule.update(track, z.z, z.R, gate3_);
  const Outcome outcome{.verdict = u.verdict, .nis = u.nis, .dof = 3};
  if (outcome.verdict != Verdict::Accepted) return outcome;
  note_innovation(account, u.innovation, u.S, u.nis);
  t.contributed[slot] = t.data_epoch = m.epoch;
  t.nis = outcome.nis;
  std::uint64_t live = 0;
  for (std::size_t i = 0; i < t.contributed.size(); ++i)
    if (!silent(t, i)) live |= std::uint64_t{1} << i;
  t.rule.fuse(live);
  t.fused = t.rule.fused();
  return outcome;
}

template <class Rule>
void TrackLevel<Rule>::advance(Target& t, Time to) const {
  const auto predict = [&](Time then) {
    if (then == t.epoch) return;
    t.rule.predict((then - t.epoch).seconds(), settings().cartesian_fusion.q_m2_s3);
    t.epoch = then;
  };
  if constexpr (requires { t.rule.end_batch(); }) {
    const Time batch_end = ceil_to_grid(t.epoch, settings().cartesian_fusion.batch);
    if (to > batch_end) {
      predict(batch_end);
      t.rule.end_batch();
    }
  }
  predict(to);
}

template <class Rule>
std::optional<TrackEstimate> TrackLevel<Rule>::fused(const State& state, int target, std::optional<Time> at) const {
  const Target& t = state.targets[static_cast<std::size_t>(target)];
  if (!t.started) return std::nullopt;
  TrackEstimate e = estimate_at(t.fused, t.data_epoch, at.value_or(t.data_epoch), settings().cartesian_fusion.q_m2_s3);
  e.sources = Arbitration::recent_sources(state.align.lives[static_cast<std::size_t>(target)], t.data_epoch);
  e.nis = t.nis;
  e.nis_dof = 3;
  return e;
}

template class TrackLevel<ConvexRule>;
template class TrackLevel<InformationRule>;
template class TrackLevel<CampoRule>;
template class TrackLevel<MapRule>;
template class TrackLevel<FederatedRule>;

}  // namespace downrange
