#pragma once
/// A command's azimuth is unwrapped within the travel that [[antenna]] states; a rotator has a travel of its own. Which
/// of its turns a command is.

#include <numbers>
#include <optional>

#include "rotctl/protocol.hpp"

namespace downrange::rotctl {

/// Where the rotator shall go, within its travel.
struct Placed {
  double azimuth_rad = 0;
  double elevation_rad = 0;
  double turn_rad = 0;  ///< whole turns that were added to the command's azimuth
  bool held = false;    ///< at the end of its travel: it does not reach what the command says
};

/// Chooses the turn, and keeps it: SLAVE chose the command's for the whole pass, and a target that hovers at the end of
/// the travel turns no mount.
class Turns {
 public:
  explicit Turns(const Travel& travel) : travel_(travel) {}

  /// The turn of the last command where that is within the travel, or beyond its end by no more than `hysteresis_rad`
  /// (then held there). Else the command's own azimuth where the travel has it; else the turn nearest to where the
  /// rotator is (`measured_azimuth_rad`, or the last command's place). A direction that the travel does not have is
  /// held at the nearer end. Elevation is held at its ends.
  [[nodiscard]] Placed place(double azimuth_rad, double elevation_rad, std::optional<double> measured_azimuth_rad);

  static constexpr double hysteresis_rad = std::numbers::pi / 180;

 private:
  [[nodiscard]] double turn_of(double azimuth_rad, std::optional<double> measured_azimuth_rad) const;
  /// How far outside the travel, 0 inside.
  [[nodiscard]] double beyond(double azimuth_rad) const;

  Travel travel_;
  std::optional<double> turn_;  ///< what is added to the command's azimuth
  std::optional<double> last_azimuth_rad_;
};

}  // namespace downrange::rotctl
