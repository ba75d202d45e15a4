#pragma once
/// Where a moving antenna is, and how it is turned.

#include <downrange/geo/site.hpp>
#include <downrange/stage/event.hpp>
#include <optional>

namespace downrange {

/// Of a ship's or an aircraft's antenna, out of range/platform. The deck is taken as level: a mount stabilises itself.
class Platform {
 public:
  /// What is older says nothing any more.
  static constexpr Duration oldest = milliseconds(5000);

  struct Place {
    Site site;                    ///< azimuths from the antenna's own zero
    Velocity<Ecef> velocity;      ///< 0 where it is not told
    double turn_rate_rad_s = 0;   ///< of the azimuth zero, clockwise
    double sigma_position_m = 0;  ///< per axis
    double sigma_heading_rad = 0;
  };

  /// One that cannot be, or is older than the last one, is passed over.
  void note(const PlatformState& state);
  /// None: not told of within `oldest`.
  [[nodiscard]] std::optional<Place> at(Time t) const;

 private:
  struct Heading {
    Time epoch;
    double rad = 0;
  };
  void note_heading(const Heading& heading);

  std::optional<PlatformState> newest_;
  std::optional<Heading> before_;  ///< a second or more before `since_`
  std::optional<Heading> since_;
  std::optional<double> turn_rate_rad_s_;
  double turned_over_s_ = 0;  ///< time between the headings that the rate is made of
};

}  // namespace downrange
