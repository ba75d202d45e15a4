#pragma once
/// Powered flight of a launch vehicle over the rotating Earth: the truth of the launch scenario.

#include <Eigen/Core>
#include <downrange/geo/site.hpp>
#include <optional>
#include <vector>

#include "score/truth.hpp"
#include "sim/hop.hpp"

namespace downrange::sim {

/// One engine burn, `from_s` <= t < `to_s` after lift-off; mass counts from its ignition.
struct Burn {
  double from_s = 0;
  double to_s = 0;
  double thrust_n = 0;
  double mass_kg = 0;    ///< of the vehicle at ignition
  double flow_kg_s = 0;  ///< mass lost per second
};

struct PitchPoint {
  double t_s = 0;
  double pitch_rad = 0;  ///< of the thrust, up from the local horizontal
};

/// An acceleration on top, `from_s` <= t < `to_s` after lift-off: what staging, steering or a failure does.
struct Push {
  double from_s = 0;
  double to_s = 0;
  double forward_m_s2 = 0;  ///< along the velocity over ground
  double right_m_s2 = 0;    ///< horizontal, to the right of it
  double up_m_s2 = 0;       ///< normal to both, up in level flight
};

/// Thrust acts at `azimuth_rad` (clockwise from north) and the pitch of the table, in the geodetic east-north-up axes
/// at the vehicle. Pitch is linear between points and constant outside. Drag only where there
/// is a ballistic coefficient, in an exponential atmosphere (1.225 kg/m^3 at height 0, scale height 7200 m).
struct LaunchProfile {
  Geodetic pad;
  double azimuth_rad = 0;
  std::vector<Burn> burns;        ///< in time order, not overlapping; the first lifts off: thrust > weight
  std::vector<PitchPoint> pitch;  ///< in time order
  std::vector<Push> pushes{};
  double ballistic_kg_m2 = 0;  ///< mass / (drag coefficient * area); 0: no drag
  std::optional<Hop> hop{};    ///< flown instead of burns, pitch, pushes and drag
};

/// Two stages, southwards from the Naro pad: burns to 229 s and from 395 to 453 s (est/THEORY.md section 10).
[[nodiscard]] LaunchProfile naro_launch_profile();

/// Integrated with J2 gravity, centrifugal and Coriolis acceleration by Runge-Kutta of order 4; steps meet at the ends
/// of burns and pushes and at the points of the pitch table. Position to 1 mm over 480 s at the default step, as tested
/// by halving it.
class LaunchTrajectory {
 public:
  /// Flies `duration_s` after `liftoff`. Throws std::invalid_argument when the profile has no burn or no pitch.
  LaunchTrajectory(const LaunchProfile& profile, Time liftoff, double duration_s, double step_s = 0.05);

  /// Standing on the pad before lift-off; nothing after the end of the flight.
  [[nodiscard]] std::optional<score::TrueState> at(Time t) const;

  /// Relative to the rotating Earth, m/s^2, ECEF axes; at an ignition or cut-off the value just after it.
  [[nodiscard]] std::optional<Eigen::Vector3d> acceleration(Time t) const;

  [[nodiscard]] const LaunchProfile& profile() const { return profile_; }
  [[nodiscard]] Time liftoff() const { return liftoff_; }

 private:
  LaunchProfile profile_;
  Time liftoff_;
  score::TruthTable table_;
};

}  // namespace downrange::sim
