#include <cassert>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/est/method/song2015.hpp>
#include <downrange/est/model/motion.hpp>
#include <limits>

namespace downrange {
namespace {

double seconds_between(Time later, Time earlier) { return (later - earlier).seconds(); }

}  // namespace

Song2015::Song2015(MethodSettings settings, bool correct)
    : align_(std::move(settings), correct),
      gate3_(correct ? chi2_quantile(align_.settings().arbitration.gate_probability, 3)
                     : std::numeric_limits<double>::infinity()) {
  assert(align_.settings().radars.size() <= BatchTrack::max_radars);
}

Song2015::State Song2015::initial() const {
  State s;
  s.align = align_.initial();
  s.fused.resize(static_cast<std::size_t>(settings().targets));
  s.accounts = accounts_of(settings(), false);
  return s;
}

void Song2015::start(State& state, int target, Time epoch, const Gaussian<9>& estimate) const {
  BatchTrack& track = state.fused[static_cast<std::size_t>(target)];
  track.started = true;
  track.base_epoch = track.epoch = epoch;
  track.base = {.mean = estimate.mean.head<6>(), .cov = estimate.cov.topLeftCorner<6, 6>()};
  track.current = track.base;
}

Outcome Song2015::apply(State& state, const Measurement& m) const {
  if (!is_fix(m)) return apply_plot(state, m);
  SourceAccount& account = state.accounts[static_cast<std::size_t>(m.source)];
  return align_.apply_fix(state.align, account, m, fused(state, m.target, m.epoch));
}

Outcome Song2015::apply_plot(State& state, const Measurement& m) const {
  if (!tells_position(m.measured)) return {};
  BatchTrack& track = state.fused[static_cast<std::size_t>(m.target)];
  SourceAccount& account = state.accounts[static_cast<std::size_t>(m.source)];

  const TimedPosition z = align_.compensated(state.align, m);
  const bool refused = align_.is_refused(state.align, m);
  const Outcome outcome = judge(track, account, m, z, refused);
  count(account, outcome);
  if (outcome.verdict != Verdict::Accepted) {
    if (align_.rejected(state.align, m, outcome.verdict) == Remedy::Restart) start_track(track, m, z);
    return outcome;
  }
  if (track.started) {
    fuse_into(track, m, z);
    track.nis = outcome.nis;
  } else {
    start_track(track, m, z);
  }
  align_.arbitration().accepted(state.align.lives[static_cast<std::size_t>(m.target)], m);
  return outcome;
}

Outcome Song2015::judge(const BatchTrack& track, SourceAccount& account, const Measurement& m, const TimedPosition& z,
                        bool refused) const {
  if (!track.started) return {.verdict = refused ? Verdict::Gated : Verdict::Accepted, .nis = 0, .dof = 0};
  const Gaussian<6> predicted =
      cv::predict(track.current, seconds_between(m.epoch, track.epoch), settings().cartesian_fusion.q_m2_s3);
  const Vec<3> nu = z.z - predicted.mean.head<3>();
  const Mat<3, 3> S = predicted.cov.topLeftCorner<3, 3>() + z.R;
  const double nis = normalised_square<3>(nu, S);
  const bool follows = nis <= gate3_ && !refused;
  if (follows) note_innovation<3>(account, nu, S, nis);
  return {.verdict = follows ? Verdict::Accepted : Verdict::Gated, .nis = nis, .dof = 3};
}

void Song2015::start_track(BatchTrack& track, const Measurement& m, const TimedPosition& z) const {
  track = BatchTrack{};
  track.started = true;
  track.base_epoch = track.epoch = m.epoch;
  track.base = started_from(z, settings().start.sigma_velocity_m_s);
  track.current = track.base;
}

void Song2015::fuse_into(BatchTrack& track, const Measurement& m, const TimedPosition& z) const {
  // A batch ends at the first grid instant at or after its first plot, or when it is full.
  if (track.pending_count > 0) {
    const Time batch_end = ceil_to_grid(track.pending_epoch[0], settings().cartesian_fusion.batch);
    if (m.epoch > batch_end || track.pending_count == max_batch) {
      track.base = track.current;
      track.base_epoch = track.epoch;
      track.pending_count = 0;
    }
  }
  const auto slot = static_cast<std::size_t>(track.pending_count++);
  track.pending[slot] = z;
  track.pending_epoch[slot] = m.epoch;
  track.epoch = m.epoch;
  for (std::size_t i = 0; i <= slot; ++i) track.pending[i].age_s = seconds_between(m.epoch, track.pending_epoch[i]);
  track.current = fuse_asynchronous(track.base, seconds_between(m.epoch, track.base_epoch),
                                    {track.pending.data(), slot + 1}, settings().cartesian_fusion.q_m2_s3);
}

std::optional<TrackEstimate> Song2015::fused(const State& state, int target, std::optional<Time> at) const {
  const BatchTrack& track = state.fused[static_cast<std::size_t>(target)];
  if (!track.started) return std::nullopt;
  TrackEstimate e =
      estimate_at(track.current, track.epoch, at.value_or(track.epoch), settings().cartesian_fusion.q_m2_s3);
  e.sources = Arbitration::recent_sources(state.align.lives[static_cast<std::size_t>(target)], track.epoch);
  e.nis = track.nis;
  e.nis_dof = 3;
  return e;
}

}  // namespace downrange
