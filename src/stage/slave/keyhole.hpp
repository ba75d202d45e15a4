#pragma once
/// A pass near the zenith, where the target's azimuth turns faster than an antenna's axis can: the azimuth leads, so
/// that the worst error on the sky is as small as the axis allows.

#include <array>
#include <downrange/stage/range_config.hpp>
#include <optional>
#include <vector>

#include "stage/slave/pass.hpp"

namespace downrange {

/// Elevation of the axis that points nearest to a direction at (`off_azimuth_rad` from the azimuth axis, elevation),
/// within [.., elevation_max]; beyond 90 deg: over the zenith.
[[nodiscard]] double nearest_elevation(double off_azimuth_rad, double elevation_rad, double elevation_max_rad);

/// The azimuth for the time in which the axis cannot follow the target, planned as a whole.
///
/// For a worst error e the azimuth may be anywhere in a tube about the target's; a tube that a rate-limited axis can
/// pass is found backwards from its end, the smallest e by bisection. The axis follows the target inside the tube as
/// long as it can, leads at its full rate, and is smoothed so that it keeps its acceleration. A plan under way is kept
/// while it is as good as it was; a new one follows it as it else follows the target. Where the elevation goes beyond
/// the zenith (plunge), passing over it is tried as well.
class KeyholePlan {
 public:
  explicit KeyholePlan(const AntennaConfig& antenna);

  /// From where the command is at `now`: azimuth of the axis, unwrapped, and whether both axes are over the zenith.
  /// `pass`: what the antenna sees of `path`.
  void make(const PredictedPath& path, const Pass& pass, const Site& site, const RefractionTable* air, Time now,
            double azimuth_rad, bool over);
  void clear() { used_ = 0; }

  /// The azimuth is the plan's, not the target's.
  [[nodiscard]] bool active(Time t) const;
  /// Of the axis, unwrapped. Only while active.
  [[nodiscard]] AxisMotion azimuth(Time t) const;
  /// Counts the plans.
  [[nodiscard]] std::uint64_t made() const { return made_; }
  /// On the sky, of the plan.
  [[nodiscard]] double worst_error_rad() const { return worst_rad_; }

 private:
  static constexpr int most_points = 361;

  struct Point {
    double azimuth = 0;  ///< of the target, continuous
    double elevation = 0;
    double across = 0;  ///< cosine of the elevation
    double centre = 0;  ///< of the tube: where the axis points at the target
    double wanted = 0;  ///< by a plan under way; not a number: the centre
    double low = 0;     ///< from where the end can still be reached inside the tube
    double high = 0;
    double raw = 0;      ///< before smoothing
    double planned = 0;  ///< of the axis
  };

  /// Whether there is a keyhole ahead: fills the target's part of the points.
  [[nodiscard]] bool look_ahead(const PredictedPath& path, const Pass& pass, const Site& site,
                                const RefractionTable* air, double now_s, bool under_way);
  /// The plan for passing the zenith with `flip` (0, or half a turn to either side) at an axis rate; its worst error.
  /// Infinite where that cannot be less than `most_error`.
  double plan(double flip, double rate, double most_error);
  [[nodiscard]] bool passes(double error, double rate);
  void smooth();
  [[nodiscard]] double worst_error() const;
  /// On the sky, of the plan under way for where the target is predicted now.
  [[nodiscard]] double error_ahead(const PredictedPath& path, const Site& site, const RefractionTable* air,
                                   Time now) const;
  /// How far the azimuth may be from the target's for an error on the sky; negative: not at all.
  [[nodiscard]] double tube(const Point& point, double error, double sine) const;
  [[nodiscard]] double index_of(Time t) const;

  const AntennaConfig& antenna_;
  double half_window_s_;
  std::vector<Point> points_;  ///< being planned
  std::vector<Point> best_;
  std::vector<double> sum_;
  Time begin_;
  double dt_s_ = 0;
  int used_ = 0;      ///< points of `best_`
  int count_ = 0;     ///< of `points_`
  int crossing_ = 0;  ///< the highest point
  double first_centre_ = 0;
  std::optional<double> start_;  ///< where the axis is, when the plan begins under way
  int first_ = 0;                ///< of `best_`: where the plan leaves the target
  int last_ = 0;
  double flip_ = 0;
  double worst_rad_ = 0;
  double granted_rad_ = 0;  ///< error that a plan under way has anyway
  std::uint64_t made_ = 0;
};

}  // namespace downrange
