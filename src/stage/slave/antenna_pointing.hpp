#pragma once
/// The commands of one antenna.

#include <downrange/stage/range_config.hpp>
#include <downrange/stage/result.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "stage/slave/antenna_will.hpp"
#include "stage/slave/axis_offset.hpp"
#include "stage/slave/blend.hpp"
#include "stage/slave/keyhole.hpp"
#include "stage/slave/ladder.hpp"
#include "stage/slave/mount.hpp"
#include "stage/slave/mount_error.hpp"
#include "stage/slave/platform.hpp"
#include "stage/slave/sighting.hpp"
#include "stage/slave/target_path.hpp"
#include "stage/slave/travel.hpp"

namespace downrange {

class AntennaPointing {
 public:
  /// Both must outlive it. Traces a refraction table where the antenna has a refractivity (50 ms).
  AntennaPointing(const AntennaConfig& antenna, const RangeConfig& range);
  AntennaPointing(const AntennaPointing&) = delete;
  AntennaPointing& operator=(const AntennaPointing&) = delete;
  AntennaPointing(AntennaPointing&&) = delete;
  AntennaPointing& operator=(AntennaPointing&&) = delete;
  ~AntennaPointing() = default;

  [[nodiscard]] const AntennaConfig& antenna() const { return configured_; }
  /// Of a moving antenna.
  void note(const PlatformState& state) { platform_.note(state); }
  /// What its own sensor read of the target while it tracked by itself.
  void note_reading(Time epoch, double azimuth_rad, double elevation_rad);

  /// What operators want of it, but for the stop and the pin.
  void obey(const AntennaWill& will);
  [[nodiscard]] int target() const { return target_; }
  [[nodiscard]] Time apply_at(Time tick) const { return tick + antenna_.link_delay + antenna_.lead; }

  /// What to follow at this tick; nothing: no command.
  [[nodiscard]] std::optional<Aim> aim(const Followed& followed, std::optional<Time> liftoff, Time tick);

  /// The command for that aim, planned by where the target will be. Nothing where it would not be finite.
  [[nodiscard]] std::optional<SlavingCommand> command(const Aim& aim, const Followed& followed, const TargetPath& path,
                                                      Time tick);

  /// `path`: null, it has nothing to follow.
  [[nodiscard]] AntennaAccount account(const AntennaWill& will, const TargetPath* path,
                                       std::optional<Time> planned_liftoff, Time tick) const;

 private:
  /// A direction that the mount read.
  struct Reading {
    Time epoch;
    double azimuth_rad = 0;
    double elevation_rad = 0;
  };
  static constexpr std::size_t most_readings = 64;  ///< of one tick; more are passed over

  /// What was commanded last, without what is added to the axes.
  struct Last {
    Time tick;
    Axes axes;
  };
  /// From one way to tell the azimuth to another (the target's, a plan's, a newer plan's) without a step.
  struct Seam {
    std::uint64_t plan = 0;  ///< whose azimuth it is; 0: the target's
    double off_rad = 0;
  };

  /// Where the antenna is at that instant. False: it moves, and is not heard of.
  bool take_place(Time at);
  /// What moves with the antenna, and how well its place is known.
  void move_with_platform(Aim& aim) const;
  /// What was read since the last tick, against what is followed.
  void learn_mount_error(const Aim& aim);
  /// Brings what is added to the axes, and with it the travel that pointing has, up to `tick`.
  void offset_axes(double cos_elevation, Time tick, bool resumes);
  /// What the axes are told, inside their travel.
  [[nodiscard]] Axes with_offset(Axes axes) const;
  void plan(const Aim& aim, const TargetPath& path, Time tick, bool resumes);
  void choose_turn_of_pass();
  /// `own`: of the azimuth axis, as planned; azimuth and elevation: of the target.
  [[nodiscard]] Axes axes_of_plan(const AxisMotion& own, const AxisMotion& azimuth, const AxisMotion& elevation) const;
  [[nodiscard]] Axes axes_of_target(const AxisMotion& azimuth, const AxisMotion& elevation);
  /// No step where the azimuth is told by another plan than at the last tick. Not of the first command, nor after a
  /// pause: there is no plan then, and no seam.
  void mend_seam(AxisMotion& azimuth, std::uint64_t plan, Time tick);
  void follow(const Axes& axes, Time tick, bool resumes);

  const AntennaConfig& configured_;
  /// As pointing has it: the site is where the antenna is, the travel is less what is added to the axes.
  AntennaConfig antenna_;
  const RangeConfig& range_;
  int configured_target_;
  int target_;
  double azimuth_trim_rad_ = 0;
  double elevation_trim_rad_ = 0;
  AxisOffset offset_;
  std::unique_ptr<const RefractionTable> air_;
  Platform platform_;
  std::optional<Platform::Place> place_;  ///< of a moving antenna
  std::optional<MountError> mount_error_;
  MountOffset mount_offset_;  ///< when the command is applied
  std::vector<Reading> readings_;
  Horizon horizon_;
  Ladder ladder_;
  Blend blend_;
  Pass pass_;
  KeyholePlan keyhole_;
  FollowingAxis azimuth_axis_;
  FollowingAxis elevation_axis_;

  std::optional<Last> last_;
  std::optional<Time> planned_;
  std::optional<double> turn_rad_;  ///< an azimuth of the turn that is followed
  bool over_ = false;               ///< with both axes over the zenith
  bool turn_settled_ = false;       ///< chosen when it was known where the target flies
  Seam seam_;
};

}  // namespace downrange
