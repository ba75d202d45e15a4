#pragma once
/// Going over from one aim to another.

#include <optional>

#include "stage/slave/ladder.hpp"

namespace downrange {

/// After a longer pause an antenna is where it is: nothing to go over from.
inline constexpr Duration longest_blended_gap = milliseconds(1000);

/// When what is followed changes (another chain, a chain that was run again, another rung of the ladder), the command
/// starts where the last one would be now, and what is left of the difference shrinks at a rate.
class Blend {
 public:
  explicit Blend(double rate_rad_s) : rate_rad_s_(rate_rad_s) {}

  /// Moves the look of the aim by what is left of the difference, its rates by how that shrinks.
  void apply(Time tick, const Origin& origin, AxisMotion& azimuth, AxisMotion& elevation);
  /// The last command was that, whatever the target's look: what is followed next is gone over to from there.
  void was(const AxisMotion& azimuth, const AxisMotion& elevation);

 private:
  /// What was commanded last.
  struct Previous {
    Time tick;
    Origin origin;
    AxisMotion azimuth;    ///< of the command, blend included, travel left out; the target's rate
    AxisMotion elevation;  ///< likewise
  };

  double rate_rad_s_;
  std::optional<Previous> previous_;
  double azimuth_rad_ = 0;  ///< what the command is still away from the target
  double elevation_rad_ = 0;
};

}  // namespace downrange
