#pragma once
/// When a vehicle left its pad, as its own fixes tell.

#include <downrange/stage/event.hpp>
#include <downrange/stage/range_config.hpp>
#include <optional>
#include <vector>

namespace downrange {

/// The vehicle's first motion: three fixes, a second apart or more, that move as its own velocity says. Neither a
/// receiver that warms up nor one that repeats itself does that.
class Departure {
 public:
  explicit Departure(const RangeConfig& config);

  /// A fix of a known target that ingest has nothing to say against but where it is.
  void note(const Observation& observation);
  /// The vehicles are on the pad again: what was found counts no more.
  void recycle();

  /// None: it did not move, or the target is not configured.
  [[nodiscard]] std::optional<Time> motion(const Name& target) const;
  [[nodiscard]] bool moved(const Name& target, Time epoch) const {
    const std::optional<Time> since = motion(target);
    return since && epoch >= *since;
  }

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
  std::vector<Target> motions_;
};

}  // namespace downrange
