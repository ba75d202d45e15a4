#include "stage/slave/target_path.hpp"

#include <cmath>

#include "stage/slave/nominal_aim.hpp"

namespace downrange {

void TargetPath::update(const Aim& aim, const NominalTrajectory& nominal, const SlaveConfig& config,
                        std::optional<Time> liftoff, Time tick) {
  if (made_ && tick - *made_ < planned_every && tick >= *made_) return;
  made_ = tick;
  const Time at = aim.estimate.epoch;
  timed_ = true;
  basis_ = PassBasis::FreeFall;
  const auto plan = nominal_aim(nominal, config, liftoff, tick, at);
  const PositionVelocity now{{aim.estimate.mean.head<3>()}, {aim.estimate.mean.segment<3>(3)}};
  if (!plan) return path_.fall(at, now);
  const Displacement<Ecef> off{now.position.m - plan->mean.head<3>()};
  if (!liftoff) {
    timed_ = false;
    basis_ = PassBasis::PlannedLiftoff;
    begins_t_plus_s_ = nominal.samples().front().t_s;
    return path_.follow(at, nominal, begins_t_plus_s_, {});
  }
  if (!keeps_to_plan(aim.estimate, *plan)) return path_.fall(at, now);
  path_.follow(at, nominal, planned_time_s(liftoff, at), off);
  if (path_.empty()) return path_.fall(at, now);
  basis_ = PassBasis::Plan;
}

std::optional<Time> TargetPath::begins(std::optional<Time> planned_liftoff) const {
  if (path_.empty()) return std::nullopt;
  if (timed_) return path_.from();
  if (!planned_liftoff) return std::nullopt;
  return *planned_liftoff + seconds(begins_t_plus_s_);
}

}  // namespace downrange
