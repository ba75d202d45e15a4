#include "stage/slave/ladder.hpp"

#include <algorithm>

#include "stage/slave/beam.hpp"
#include "stage/slave/nominal_aim.hpp"

namespace downrange {
namespace {

/// What has not been measured for longer is not asked for: predicting costs the more the older the data is.
constexpr Duration longest_coast = milliseconds(60'000);

}  // namespace

std::optional<Aim> Ladder::judged(const std::optional<TrackEstimate>& estimate, Time tick, Duration oldest,
                                  const Origin& origin) const {
  if (!estimate || !estimate->mean.allFinite()) return std::nullopt;
  const Duration age = tick - estimate->data_epoch;
  if (age > oldest) return std::nullopt;
  const auto look = look_at(antenna_.site, air_, *estimate);
  if (!look) return std::nullopt;
  const bool in_beam = antenna_.beamwidth_rad > 0 && age > config_.stale;
  const bool certain = in_beam ? probability_in_disc(Eigen::Vector2d::Zero(), look->sky, antenna_.beamwidth_rad / 2) >=
                                     config_.beam_probability_min
                               : position_sigma_m(*estimate) <= config_.coast_sigma_max_m;
  if (!certain) return std::nullopt;
  return Aim{.estimate = *estimate, .look = *look, .origin = origin};
}

std::optional<Aim> Ladder::best_alone(const Followed& followed, Time tick, Time apply_at, bool receiver) {
  std::optional<Aim> best;
  for (const LoneSource& source : followed.lone) {
    if (source.receiver != receiver || tick - source.newest > config_.coast) continue;
    const Origin origin{.source = receiver ? SlavingSource::Gps : SlavingSource::SingleSensor, .chain = source.chain};
    auto estimate = source.method->fused(source.target, apply_at);
    if (!estimate && receiver) estimate = source.method->gps_track(source.target, apply_at);
    auto aim = judged(estimate, tick, config_.coast, origin);
    if (!aim) continue;
    // The one that is followed already stays: another one may be better by chance.
    if (source.chain == alone_) return aim;
    if (!best || position_sigma_m(aim->estimate) < position_sigma_m(best->estimate)) best = aim;
  }
  return best;
}

std::optional<Aim> Ladder::from_above(const Followed& followed, Time tick, Time apply_at) {
  const bool coasts_on = antenna_.beamwidth_rad > 0;
  const Duration silence = tick - followed.newest;
  const Origin selected{.chain = followed.chain, .revision = followed.revision};
  std::optional<TrackEstimate> fused;
  if (silence <= (coasts_on ? std::max(longest_coast, config_.coast) : config_.coast)) {
    fused = followed.method->fused(followed.target, apply_at);
    const bool fresh = fused && tick - fused->data_epoch <= config_.stale;
    Origin origin = selected;
    if (!fresh) origin.source = SlavingSource::Coasting;
    if (auto aim = judged(fused, tick, config_.coast, origin)) {
      aim->bounded = followed.bounded;
      return aim;
    }
  }
  if (auto aim = best_alone(followed, tick, apply_at, false)) return aim;
  if (silence <= config_.coast) {
    Origin origin = selected;
    origin.source = SlavingSource::Gps;
    if (auto aim = judged(followed.method->gps_track(followed.target, apply_at), tick, config_.coast, origin)) {
      aim->bounded = followed.bounded;
      return aim;
    }
  }
  if (auto aim = best_alone(followed, tick, apply_at, true)) return aim;
  if (!coasts_on || bound_rad_ > config_.coast_bound_max_rad) return std::nullopt;
  Origin origin = selected;
  origin.source = SlavingSource::Coasting;
  return judged(fused, tick, longest_coast, origin);
}

std::optional<Aim> Ladder::planned(const NominalTrajectory& nominal, std::optional<Time> liftoff, Time tick,
                                   Time apply_at) const {
  if (left_plan_) return std::nullopt;
  const auto estimate = nominal_aim(nominal, config_, liftoff, tick, apply_at);
  if (!estimate) return std::nullopt;
  const auto look = look_at(antenna_.site, air_, *estimate);
  if (!look) return std::nullopt;
  return Aim{.estimate = *estimate, .look = *look, .origin = {.source = SlavingSource::Nominal}};
}

void Ladder::compare_with_plan(const Aim& aim, const NominalTrajectory& nominal, std::optional<Time> liftoff,
                               Time tick) {
  // A coasting track falls freely, whatever the vehicle does.
  if (!liftoff || tick - aim.estimate.data_epoch > config_.stale) return;
  const auto plan = nominal_aim(nominal, config_, liftoff, tick, aim.estimate.epoch);
  left_plan_ = plan && !keeps_to_plan(aim.estimate, *plan);
}

void Ladder::forget() {
  alone_ = {};
  bound_rad_ = 0;
  left_plan_ = false;
}

std::optional<Aim> Ladder::choose(const Followed& followed, const NominalTrajectory& nominal,
                                  std::optional<Time> liftoff, Time tick, Time apply_at) {
  if (!liftoff) left_plan_ = false;
  auto aim = from_above(followed, tick, apply_at);
  if (aim) {
    compare_with_plan(*aim, nominal, liftoff, tick);
  } else {
    aim = planned(nominal, liftoff, tick, apply_at);
  }
  const bool alone = aim && aim->origin.source == SlavingSource::SingleSensor;
  alone_ = alone || (aim && aim->origin.source == SlavingSource::Gps) ? aim->origin.chain : Name{};
  return aim;
}

}  // namespace downrange
