#pragma once
/// A satellite's pass over a range: the truth of the profile orbit_pass.

#include <downrange/geo/site.hpp>
#include <optional>

#include "score/truth.hpp"

namespace downrange::sim {

struct OrbitPassProfile {
  Geodetic over;              ///< from whose horizon to whose horizon it goes
  double height_m = 400e3;    ///< of the orbit, above the equator's radius
  double heading_rad = 0;     ///< over the ground at the middle of the pass, clockwise from north
  double off_centre_rad = 0;  ///< the ground track passes this far to the right of `over`, seen from the Earth's centre
};

/// 400 km above the Naro range, north-eastwards, 55 degrees high at its middle.
[[nodiscard]] OrbitPassProfile naro_orbit_pass();

/// Circular at its middle, from there integrated forwards and backwards in free fall with J2: what J2 bends is a few
/// hundred metres.
class OrbitPass {
 public:
  /// Rises at `rise`. Throws std::invalid_argument when it does not pass above the horizon.
  OrbitPass(const OrbitPassProfile& profile, Time rise);

  /// Nothing before it rises and after it sets.
  [[nodiscard]] std::optional<score::TrueState> at(Time t) const { return table_.at(t); }
  [[nodiscard]] double duration_s() const;

 private:
  score::TruthTable table_;
};

}  // namespace downrange::sim
