#pragma once
/// Mission time: what range/mission tells of it, and the vehicle's own motion.

#include <downrange/stage/event.hpp>
#include <downrange/stage/range_config.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace downrange {

/// Planned and actual lift-off, holds, recycles and marks. A hold stops the count until a new planned lift-off; a
/// recycle begins anew: what was planned, announced or found before counts no more. A value; allocates at construction
/// only.
class MissionClock {
 public:
  /// A staging, or another mark.
  struct Mark {
    MissionEventKind kind = MissionEventKind::Mark;
    Name label;
    Time epoch;
  };
  static constexpr std::size_t max_marks = 32;

  explicit MissionClock(const RangeConfig& config);

  /// The newest event of a kind holds, for it may be a correction. One that `refusal` speaks against changes nothing.
  void note(const MissionEvent& event);
  /// A vehicle moves since then: lift-off, as long as none is announced. The first one counts.
  void note_motion(Time since);

  /// Why such an event is not taken, for whoever sent it; empty: it is.
  [[nodiscard]] std::string refusal(const MissionEvent& event) const;

  [[nodiscard]] const std::optional<Time>& planned_liftoff() const { return planned_; }
  /// Announced, or else found from motion.
  [[nodiscard]] const std::optional<Time>& liftoff() const { return announced_ ? announced_ : motion_; }
  [[nodiscard]] bool liftoff_announced() const { return announced_.has_value(); }
  /// None: the count is not on hold.
  [[nodiscard]] const std::optional<Time>& hold_since() const { return hold_; }
  [[nodiscard]] bool in_flight(Time at) const { return liftoff() && at >= *liftoff(); }
  /// Since lift-off, or (negative) until the planned one; on hold it stands still. None: nothing is known.
  [[nodiscard]] std::optional<Duration> t_plus(Time at) const;
  /// In the order in which they were heard, the newest `max_marks`.
  [[nodiscard]] std::span<const Mark> marks() const { return marks_; }

 private:
  bool simulated_;
  std::optional<Time> planned_;
  std::optional<Time> announced_;
  std::optional<Time> motion_;
  std::optional<Time> hold_;
  std::vector<Mark> marks_;
};

}  // namespace downrange
