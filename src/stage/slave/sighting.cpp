#include "stage/slave/sighting.hpp"

#include <algorithm>
#include <cmath>

namespace downrange {
namespace {

/// An antenna's view along a path.
class View {
 public:
  View(const PredictedPath& path, const Site& site, const RefractionTable* air, const Horizon& horizon)
      : path_(path), site_(site), air_(air), horizon_(horizon) {}

  [[nodiscard]] PassPoint at(double s) const { return seen_at(path_, s, site_, air_); }
  [[nodiscard]] double above_horizon(double s) const {
    const PassPoint point = at(s);
    return point.elevation_rad - horizon_.at(point.azimuth_rad);
  }
  /// Between `hidden` and `seen`, in either order, by bisection.
  [[nodiscard]] double crossing(double hidden, double seen) const {
    while (std::abs(seen - hidden) > 1e-3) {
      const double middle = (hidden + seen) / 2;
      (above_horizon(middle) > 0 ? seen : hidden) = middle;
    }
    return seen;
  }
  /// The highest point within a step of `s`, where that is the highest of the path's states.
  [[nodiscard]] double summit(double s, double first, double last) const {
    double low = std::max(first, s - PredictedPath::step_s);
    double high = std::min(last, s + PredictedPath::step_s);
    while (high - low > 1e-2) {
      const double a = low + (high - low) / 3;
      const double b = high - (high - low) / 3;
      if (at(a).elevation_rad < at(b).elevation_rad) {
        low = a;
      } else {
        high = b;
      }
    }
    return (low + high) / 2;
  }

 private:
  const PredictedPath& path_;
  const Site& site_;
  const RefractionTable* air_;
  const Horizon& horizon_;
};

}  // namespace

AntennaAccount sighting(const PredictedPath& path, Time begins, const Site& site, const RefractionTable* air,
                        const Horizon& horizon, Time tick) {
  const View view(path, site, air, horizon);
  const double end = PredictedPath::step_s * static_cast<double>(path.states().size() - 1);
  const double now = std::clamp((tick - begins).seconds(), 0.0, end);
  AntennaAccount pass;
  pass.tick = tick;
  pass.pass_valid = true;
  pass.in_view = view.above_horizon(now) > 0;
  bool seen = pass.in_view;
  double first = now;  // of the pass
  double highest = now;
  double highest_rad = view.at(now).elevation_rad;
  double before = now;
  for (double s = (std::floor(now / PredictedPath::step_s) + 1) * PredictedPath::step_s; s <= end;
       before = s, s += PredictedPath::step_s) {
    const bool above = view.above_horizon(s) > 0;
    if (!seen && above) {
      first = view.crossing(before, s);
      pass.acquisition_valid = true;
      pass.acquisition = begins + seconds(first);
      pass.acquisition_azimuth_rad = view.at(first).azimuth_rad;
      highest_rad = -1;
      seen = true;
    }
    if (seen && !above) {
      const double lost = view.crossing(s, before);
      pass.loss_valid = true;
      pass.loss = begins + seconds(lost);
      pass.loss_azimuth_rad = view.at(lost).azimuth_rad;
      break;
    }
    if (const double up = view.at(s).elevation_rad; seen && up > highest_rad) {
      highest = s;
      highest_rad = up;
    }
  }
  if (!seen) return pass;
  const double last = pass.loss_valid ? (pass.loss - begins).seconds() : end;
  const double top = view.summit(std::clamp(highest, first, last), first, last);
  pass.highest_valid = true;
  pass.highest = begins + seconds(top);
  pass.highest_elevation_rad = view.at(top).elevation_rad;
  return pass;
}

}  // namespace downrange
