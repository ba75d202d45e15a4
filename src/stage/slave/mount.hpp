#pragma once
/// Where an antenna can be that follows our commands.

#include "stage/slave/look.hpp"

namespace downrange {

struct AxisLimits {
  double rate_rad_s = 0;
  double acceleration_rad_s2 = 0;  ///< 0: not known, as fast as you like
};

/// One axis that follows commands as well as its limits allow: at once where they allow it.
class FollowingAxis {
 public:
  explicit FollowingAxis(const AxisLimits& limits) : limits_(limits) {}

  /// It is there, and moves so.
  void put(const AxisMotion& command);
  /// It stands where it is.
  void stop() { rate_rad_s_ = 0; }
  /// `dt_s` later, where it is commanded to be at `command`.
  void follow(const AxisMotion& command, double dt_s);

  [[nodiscard]] double angle_rad() const { return angle_rad_; }

 private:
  AxisLimits limits_;
  double angle_rad_ = 0;
  double rate_rad_s_ = 0;
};

}  // namespace downrange
