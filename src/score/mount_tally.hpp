#pragma once
/// What an antenna makes of its commands: a simulated mount that follows them, against where the target truly is.

#include <array>
#include <downrange/geo/refraction.hpp>
#include <downrange/stage/range_config.hpp>
#include <downrange/stage/result.hpp>
#include <numbers>
#include <optional>

#include "score/truth.hpp"
#include "stage/slave/command_book.hpp"
#include "stage/slave/mount.hpp"
#include "stage/slave/travel.hpp"

namespace downrange::score {

/// Both axes of the simulated mount.
inline constexpr double mount_rate_rad_s = 15 * std::numbers::pi / 180;
inline constexpr double mount_acceleration_rad_s2 = 20 * std::numbers::pi / 180;
/// It is told where to point so often; where it points is judged as often.
inline constexpr Duration servo_step = milliseconds(10);
/// An antenna that points this near to the target is on it, on the sky.
inline constexpr double on_target_rad = 0.25 * std::numbers::pi / 180;

inline constexpr std::size_t source_count = 5;  ///< SlavingSource has

/// What became of commands at one antenna, or several; counts are servo steps with the target above the horizon.
struct MountScore {
  long steps = 0;
  long on_target = 0;
  long withheld = 0;                          ///< no command held: the mount stands
  std::array<long, source_count> followed{};  ///< by SlavingSource: what its command was made of
  int changes = 0;                            ///< of what its commands are made of, from one followed to the next
  /// Farthest from the target while it follows commands, from when it has arrived at what they command.
  double worst_rad = 0;

  MountScore& operator+=(const MountScore& other);
  [[nodiscard]] double share_of(long count) const { return static_cast<double>(count) / static_cast<double>(steps); }
  [[nodiscard]] static double seconds_of(long count) { return static_cast<double>(count) * servo_step.seconds(); }
};

/// A mount behind one antenna's command stream. It goes from command to command to second order and stands after
/// `valid_until`, as `tools/examples/antenna_client` does: it has a command `link_delay` after the tick and leads its
/// servo by `lead`, both as configured; its axes are those above, whatever the range says. It begins parked, in the
/// middle of its azimuth's travel on the horizon. Commands are taken in the order of their ticks.
class MountTally {
 public:
  /// Judged from `from` on, while `truth` knows the target. `air`: null, no refraction.
  MountTally(const AntennaConfig& antenna, TruthFunction truth, const RefractionTable* air, Time from);

  void take(const SlavingCommand& command);
  /// No command comes before `t` that was not taken.
  void advance_to(Time t);

  [[nodiscard]] const MountScore& score() const { return score_; }

 private:
  void step();
  void judge(Time at, const std::optional<CommandedPointing>& commanded);

  AntennaConfig antenna_;
  TruthFunction truth_;
  const RefractionTable* air_;
  Time from_;
  Horizon horizon_;
  CommandBook book_;
  FollowingAxis azimuth_;
  FollowingAxis elevation_;
  std::optional<Time> now_;
  bool arrived_ = false;                 ///< since commands began, or began again
  std::optional<SlavingSource> source_;  ///< of the last judged step that followed one
  MountScore score_;
};

}  // namespace downrange::score
