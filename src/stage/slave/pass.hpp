#pragma once
/// Where a target will be, and how an antenna will see that.

#include <downrange/geo/hermite.hpp>
#include <downrange/geo/nominal_trajectory.hpp>
#include <downrange/geo/time.hpp>
#include <optional>
#include <span>
#include <vector>

#include "stage/slave/look.hpp"

namespace downrange {

/// A predicted path of the next quarter of an hour at most, as states 2 s apart. Keeps its memory.
class PredictedPath {
 public:
  static constexpr int most_states = 451;
  static constexpr double step_s = 2;

  PredictedPath() { states_.reserve(most_states); }

  /// Free fall over the rotating Earth, until it is deep below the ground.
  void fall(Time from, const PositionVelocity& state);
  /// The plan from `t_plus_s` after lift-off on, displaced by `offset`; to its end.
  void follow(Time from, const NominalTrajectory& nominal, double t_plus_s, const Displacement<Ecef>& offset);
  void clear() { states_.clear(); }

  [[nodiscard]] bool empty() const { return states_.empty(); }
  [[nodiscard]] Time from() const { return from_; }
  [[nodiscard]] Time end() const { return from_ + seconds(step_s * static_cast<double>(states_.size() - 1)); }
  [[nodiscard]] std::span<const PositionVelocity> states() const { return states_; }
  /// `s` after `from`, inside the path (at its ends beyond). Not of an empty one.
  [[nodiscard]] PositionVelocity at(double s) const;

 private:
  Time from_;
  std::vector<PositionVelocity> states_;
};

/// An antenna's view of a path at one instant.
struct PassPoint {
  double s = 0;              ///< after the path's begin
  double azimuth_rad = 0;    ///< continuous along the pass
  double elevation_rad = 0;  ///< refraction included
};

/// What an antenna will see of a path: from where it rises above `lowest_rad` (the begin, where it is above) to where
/// it sets. Keeps its memory.
class Pass {
 public:
  Pass() { points_.reserve(PredictedPath::most_states); }
  void see(const PredictedPath& path, const Site& site, const RefractionTable* air, double lowest_rad);

  [[nodiscard]] std::span<const PassPoint> points() const { return points_; }

 private:
  std::vector<PassPoint> points_;
};

/// Azimuth in [0, 2 pi) and elevation, refraction included, of a point of a path.
[[nodiscard]] PassPoint seen_at(const PredictedPath& path, double s, const Site& site, const RefractionTable* air);

}  // namespace downrange
