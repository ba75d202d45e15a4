#pragma once
/// When a vehicle left its pad, as far as this node knows.

#include <downrange/stage/event.hpp>
#include <downrange/stage/range_config.hpp>
#include <optional>
#include <vector>

namespace downrange {

/// By the mission's lift-off, or else by the vehicle's first motion: three fixes, a second apart or more, that move as
/// its own velocity says. Neither a receiver that warms up nor one that repeats itself does that.
class Departure {
 public:
  explicit Departure(const RangeConfig& config);

  /// Lift-off; the newest one holds, for it may be corrected. Other marks, and those of another kind of flight
  /// (simulated or not), are not heard.
  void note(const MissionEvent& event);
  /// A fix of a known target that ingest has nothing to say against but where it is.
  void note(const Observation& observation);

  [[nodiscard]] bool left_pad(const Name& target, Time epoch) const;

 private:
  struct KnownFix {
    Time epoch;
    Fix fix;
  };
  struct Target {
    std::optional<KnownFix> last;  ///< that was compared
    Eigen::Vector3d slope_m_s = Eigen::Vector3d::Zero();
    int moving = 0;  ///< steps in a row
    Time moving_since;
    std::optional<Time> motion;
  };

  std::vector<TargetConfig> targets_;
  bool simulated_;
  std::optional<Time> liftoff_;
  std::vector<Target> motions_;
};

}  // namespace downrange
