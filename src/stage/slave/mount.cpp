#include "stage/slave/mount.hpp"

#include <algorithm>
#include <cmath>

namespace downrange {

void FollowingAxis::put(const AxisMotion& command) {
  angle_rad_ = command.angle_rad;
  rate_rad_s_ = std::clamp(command.rate_rad_s, -limits_.rate_rad_s, limits_.rate_rad_s);
}

void FollowingAxis::follow(const AxisMotion& command, double dt_s) {
  const double behind = command.angle_rad - angle_rad_;
  const double most = limits_.rate_rad_s;
  const double a = limits_.acceleration_rad_s2;
  // The rate that arrives at the command with this step ...
  double rate = behind / dt_s;
  if (a > 0) {
    // ... or, from farther away, one from which it can still brake to the command's own rate.
    const double brake = std::sqrt(2 * a * std::abs(behind));
    const double wanted = std::clamp(rate, command.rate_rad_s - brake, command.rate_rad_s + brake);
    rate = std::clamp(wanted, rate_rad_s_ - a * dt_s, rate_rad_s_ + a * dt_s);
  }
  rate_rad_s_ = std::clamp(rate, -most, most);
  angle_rad_ += dt_s * rate_rad_s_;
}

}  // namespace downrange
