#include "score/mount_tally.hpp"

#include <algorithm>
#include <utility>

#include "score/errors.hpp"

namespace downrange::score {
namespace {

constexpr Duration soon = milliseconds(1);
constexpr AxisLimits limits{.rate_rad_s = mount_rate_rad_s, .acceleration_rad_s2 = mount_acceleration_rad_s2};

/// How an axis is told to move that shall be at `angle` now and at `later` so much later.
AxisMotion motion(double angle_rad, double later_rad) {
  const double rate = (later_rad - angle_rad) / soon.seconds();
  // One that goes around is sent to the other end, not moved there at that rate.
  const bool goes_around = std::abs(rate) > 10 * mount_rate_rad_s;
  return {.angle_rad = angle_rad, .rate_rad_s = goes_around ? 0 : rate};
}

void brake(FollowingAxis& axis) { axis.follow({.angle_rad = axis.angle_rad()}, servo_step.seconds()); }

}  // namespace

MountScore& MountScore::operator+=(const MountScore& other) {
  steps += other.steps;
  on_target += other.on_target;
  withheld += other.withheld;
  for (std::size_t i = 0; i < source_count; ++i) followed[i] += other.followed[i];
  changes += other.changes;
  worst_rad = std::max(worst_rad, other.worst_rad);
  return *this;
}

MountTally::MountTally(const AntennaConfig& antenna, TruthFunction truth, const RefractionTable* air, Time from)
    : antenna_(antenna),
      truth_(std::move(truth)),
      air_(air),
      from_(from),
      horizon_(antenna.elevation_min_rad, antenna.horizon),
      book_(antenna.link_delay + antenna.lead),
      azimuth_(limits),
      elevation_(limits) {
  const double middle = (antenna.azimuth_min_rad + antenna.azimuth_max_rad) / 2;
  azimuth_.put({.angle_rad = middle});
  elevation_.put({.angle_rad = std::max(0.0, horizon_.at(middle))});
}

void MountTally::take(const SlavingCommand& command) {
  const Time arrival = command.tick + antenna_.link_delay;
  advance_to(arrival);
  (void)book_.take(command, arrival);
}

void MountTally::advance_to(Time t) {
  if (!now_) now_ = t;
  while (*now_ + servo_step <= t) {
    now_ = *now_ + servo_step;
    step();
  }
}

void MountTally::step() {
  const Time at = *now_ + antenna_.lead;  // what the servo is told now it has reached then
  const std::optional<CommandedPointing> commanded = book_.at(at);
  if (commanded) {
    const CommandedPointing later = book_.at(at + soon).value_or(*commanded);
    azimuth_.follow(motion(commanded->azimuth_rad, later.azimuth_rad), servo_step.seconds());
    elevation_.follow(motion(commanded->elevation_rad, later.elevation_rad), servo_step.seconds());
  } else {
    brake(azimuth_);
    brake(elevation_);
  }
  const auto off = [&] {
    return separation_rad(azimuth_.angle_rad(), elevation_.angle_rad(), commanded->azimuth_rad,
                          commanded->elevation_rad);
  };
  arrived_ = commanded && (arrived_ || off() <= on_target_rad);
  if (at >= from_) judge(at, commanded);
}

void MountTally::judge(Time at, const std::optional<CommandedPointing>& commanded) {
  const std::optional<TrueState> truth = truth_(at);
  if (!truth) return;
  const Polar look = pointing_at(antenna_.site, air_, truth->position);
  if (look.elevation_rad < horizon_.at(look.azimuth_rad)) return;
  const double off_rad =
      separation_rad(azimuth_.angle_rad(), elevation_.angle_rad(), look.azimuth_rad, look.elevation_rad);
  ++score_.steps;
  score_.on_target += off_rad <= on_target_rad ? 1 : 0;
  if (!commanded) {
    ++score_.withheld;
    return;
  }
  ++score_.followed[static_cast<std::size_t>(commanded->source)];
  if (arrived_) score_.worst_rad = std::max(score_.worst_rad, off_rad);
  const std::optional<SlavingSource> last = std::exchange(source_, commanded->source);
  score_.changes += last && *last != commanded->source ? 1 : 0;
}

}  // namespace downrange::score
