#include "stage/slave/keyhole.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <downrange/geo/polar.hpp>
#include <limits>
#include <numbers>

#include "stage/slave/look.hpp"

namespace downrange {
namespace {

constexpr double pi = std::numbers::pi;
/// The plan is remade this long before it begins.
constexpr double ahead_s = 10;
/// Rates that are tried, in those of the axis: what the full one leaves is for corrections under way.
constexpr std::array rates{0.96, 0.7, 0.45};
/// The azimuth is the plan's where that is farther from the target than this, on the sky.
constexpr double leaves_target_rad = 1e-5;
/// Below this nothing turns fast.
constexpr double least_elevation_rad = pi / 4;
/// What the axis is off a plan that is replaced fades away in this time.
constexpr double fades_in_s = 2;
/// A plan under way is kept while its error is what was planned: this share, and this, more.
constexpr double kept_share = 1.1;
constexpr double kept_rad = 0.02 * pi / 180;
/// A plan over the other side must be better by this to replace one that is under way.
constexpr double better_by = 0.8;

double error_rad(double off_azimuth_rad, double elevation_rad, double elevation_max_rad) {
  const double axis = nearest_elevation(off_azimuth_rad, elevation_rad, elevation_max_rad);
  return separation_rad(off_azimuth_rad, axis, 0, elevation_rad);
}

}  // namespace

double nearest_elevation(double off_azimuth_rad, double elevation_rad, double elevation_max_rad) {
  const double exact = std::atan2(std::sin(elevation_rad), std::cos(elevation_rad) * std::cos(off_azimuth_rad));
  return std::min(exact, elevation_max_rad);
}

KeyholePlan::KeyholePlan(const AntennaConfig& antenna)
    : antenna_(antenna),
      half_window_s_(pi / antenna.azimuth_rate_max_rad_s + 4 +
                     (antenna.azimuth_acceleration_max_rad_s2 > 0
                          ? antenna.azimuth_rate_max_rad_s / antenna.azimuth_acceleration_max_rad_s2
                          : 0)),
      points_(most_points),
      best_(most_points),
      sum_(most_points + 1) {}

double KeyholePlan::tube(const Point& point, double error, double sine) const {
  constexpr double anywhere = 1e3;
  const double top = antenna_.elevation_max_rad;
  if (sine >= point.across) {
    if (top >= pi / 2) return anywhere;  // at the zenith itself it is near enough
  } else {
    const double off = std::asin(sine / point.across);
    if (top >= pi / 2 || nearest_elevation(off, point.elevation, pi) <= top) return off;
  }
  // Held at the end of the elevation's travel.
  const double c = (std::cos(error) - std::sin(point.elevation) * std::sin(top)) / (point.across * std::cos(top));
  if (c > 1) return -1;
  return c < -1 ? anywhere : std::acos(c);
}

bool KeyholePlan::look_ahead(const PredictedPath& path, const Pass& pass, const Site& site, const RefractionTable* air,
                             double now_s, bool under_way) {
  const auto all = pass.points();
  const auto highest = std::ranges::max_element(all, {}, &PassPoint::elevation_rad);
  if (highest == all.end() || highest->elevation_rad < least_elevation_rad) return false;
  double crossing_s = highest->s;
  double most = highest->elevation_rad;
  for (double s = highest->s - PredictedPath::step_s; s <= highest->s + PredictedPath::step_s; s += 0.1) {
    const double elevation = seen_at(path, s, site, air).elevation_rad;
    if (elevation > most) std::tie(most, crossing_s) = std::pair(elevation, s);
  }
  if (now_s < crossing_s - half_window_s_ - ahead_s || now_s > crossing_s + half_window_s_) return false;
  const double begin_s = std::max({crossing_s - half_window_s_, now_s, all.front().s});
  const double end_s = std::min(crossing_s + half_window_s_, all.back().s);
  if (!(end_s - begin_s > 1)) return false;
  const double dt_s = (end_s - begin_s) / (most_points - 1);
  crossing_ = 0;
  count_ = most_points;
  double fastest = 0;
  double hardest = 0;
  for (int i = 0; i < count_; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const PassPoint seen = seen_at(path, begin_s + dt_s * i, site, air);
    Point& p = points_[k];
    p.azimuth = i == 0 ? seen.azimuth_rad : points_[k - 1].azimuth + wrap_pi(seen.azimuth_rad - points_[k - 1].azimuth);
    p.elevation = seen.elevation_rad;
    p.across = std::cos(p.elevation);
    p.wanted = under_way ? azimuth(path.from() + seconds(seen.s)).angle_rad : std::numeric_limits<double>::quiet_NaN();
    if (p.elevation > points_[static_cast<std::size_t>(crossing_)].elevation) crossing_ = i;
    if (i > 0) fastest = std::max(fastest, std::abs(p.azimuth - points_[k - 1].azimuth) / dt_s);
    if (i > 1) {
      const double bend = p.azimuth - 2 * points_[k - 1].azimuth + points_[k - 2].azimuth;
      hardest = std::max(hardest, std::abs(bend) / (dt_s * dt_s));
    }
  }
  dt_s_ = dt_s;
  begin_ = path.from() + seconds(begin_s);
  return under_way || fastest > rates[0] * antenna_.azimuth_rate_max_rad_s ||
         hardest > antenna_.azimuth_acceleration_max_rad_s2;
}

void KeyholePlan::make(const PredictedPath& path, const Pass& pass, const Site& site, const RefractionTable* air,
                       Time now, double azimuth_rad, bool over) {
  if (antenna_.azimuth_acceleration_max_rad_s2 <= 0 || path.empty() || pass.points().empty()) return clear();
  const double now_s = (now - path.from()).seconds();
  const bool under_way = active(now);
  // Where the axis would point at the target: of a plan under way its own, else where it does.
  std::optional<double> centre_now;
  if (under_way) {
    const auto i = static_cast<std::size_t>(std::lround(index_of(now)));
    centre_now = best_[i].centre;
  }
  if (under_way && error_ahead(path, site, air, now) <= kept_share * worst_rad_ + kept_rad) return;
  const bool crossed = under_way && index_of(now) > crossing_;
  const double old_flip = flip_;
  if (!look_ahead(path, pass, site, air, now_s, under_way)) return clear();
  const PassPoint seen = seen_at(path, now_s, site, air);
  // Over the zenith the axis points half a turn away from the target; a plan under way knows whether it is.
  const auto nearest_turn = [&](double reference, double half, double turn) {
    const double at = seen.azimuth_rad + half;
    return at + turn * std::round((reference - at) / turn);
  };
  const double centre =
      centre_now ? nearest_turn(*centre_now, 0, pi) : nearest_turn(azimuth_rad, over ? pi : 0, 2 * pi);
  // From now to the begin of the window the target's azimuth goes on continuously.
  const auto first = pass.points().front();
  double begin_azimuth = seen.azimuth_rad;
  for (double s = std::max(now_s, first.s); s < (begin_ - path.from()).seconds(); s += PredictedPath::step_s)
    begin_azimuth += wrap_pi(seen_at(path, s, site, air).azimuth_rad - begin_azimuth);
  begin_azimuth += wrap_pi(points_[0].azimuth - begin_azimuth);
  first_centre_ = centre + begin_azimuth - seen.azimuth_rad;
  granted_rad_ = under_way ? worst_rad_ : 0;
  start_.reset();
  if (begin_ <= now + seconds(0.01)) start_ = azimuth_rad;

  // What the axis is off the old plan fades away.
  const double off_plan = azimuth_rad - points_[0].wanted;
  for (int i = 0; under_way && i < count_; ++i)
    points_[static_cast<std::size_t>(i)].wanted += off_plan * std::max(0.0, 1 - dt_s_ * i / fades_in_s);

  struct Best {
    double error = std::numeric_limits<double>::infinity();
    double flip = 0;
  } best;
  const bool plunges = antenna_.elevation_max_rad > pi / 2;
  for (const double flip : {0.0, -pi, pi}) {
    if (flip != 0 && (!plunges || crossed)) continue;
    for (const double share : rates) {
      double error = plan(flip, share * antenna_.azimuth_rate_max_rad_s, best.error);
      if (under_way && !crossed && flip == old_flip) error *= better_by;
      if (!(error < best.error)) continue;
      best = {error, flip};
      std::swap(points_, best_);
      // The next one needs the target's part.
      for (std::size_t i = 0; i < static_cast<std::size_t>(count_); ++i) {
        points_[i].azimuth = best_[i].azimuth;
        points_[i].elevation = best_[i].elevation;
        points_[i].across = best_[i].across;
        points_[i].wanted = best_[i].wanted;
      }
    }
  }
  if (!std::isfinite(best.error)) return clear();
  used_ = count_;
  flip_ = best.flip;
  worst_rad_ = 0;
  first_ = used_;
  last_ = -1;
  for (int i = 0; i < used_; ++i) {
    const Point& p = best_[static_cast<std::size_t>(i)];
    worst_rad_ = std::max(worst_rad_, error_rad(p.planned - p.azimuth, p.elevation, antenna_.elevation_max_rad));
    if (std::abs(p.planned - p.centre) * std::cos(p.elevation) < leaves_target_rad) continue;
    first_ = std::min(first_, i);
    last_ = i;
  }
  if (under_way && last_ >= 0) first_ = 0;  // it goes on where the target's azimuth crosses it
  ++made_;
}

bool KeyholePlan::passes(double error, double rate) {
  const double most = rate * dt_s_;
  const double sine = std::sin(error);
  for (int i = count_ - 1; i >= 0; --i) {
    Point& p = points_[static_cast<std::size_t>(i)];
    const double off = tube(p, error, sine);
    p.low = std::max(p.centre - off, antenna_.azimuth_min_rad);
    p.high = std::min(p.centre + off, antenna_.azimuth_max_rad);
    if (i == count_ - 1) {
      p.low = std::max(p.low, p.centre);
      p.high = std::min(p.high, p.centre);
    } else {
      const Point& next = points_[static_cast<std::size_t>(i) + 1];
      const bool from_here = i == 0;
      if (from_here && start_) {  // where the axis is, it is
        p.low = p.high = *start_;
        return next.low - most <= *start_ && *start_ <= next.high + most;
      }
      p.low = std::max(p.low, next.low - most);
      p.high = std::min(p.high, next.high + most);
    }
    if (!(p.low <= p.high)) return false;
  }
  return points_.front().low <= first_centre_ && first_centre_ <= points_.front().high;
}

double KeyholePlan::plan(double flip, double rate, double most_error) {
  points_[0].centre = first_centre_;
  for (int i = 1; i < count_; ++i) {
    const auto k = static_cast<std::size_t>(i);
    points_[k].centre = points_[k - 1].centre + (points_[k].azimuth - points_[k - 1].azimuth);
    if (i == crossing_) points_[k].centre += flip;
  }
  double impossible = 0;
  double possible = std::min(pi / 2, most_error);
  if (!passes(possible, rate)) return std::numeric_limits<double>::infinity();
  for (int i = 0; i < 14; ++i) {
    const double middle = (impossible + possible) / 2;
    (passes(middle, rate) ? possible : impossible) = middle;
  }
  // A little room, so that the axis can stay with the target where that costs nothing; the room of a plan under way,
  // so that it is kept while it is good enough.
  (void)passes(std::max(1.02 * possible + 1e-5, granted_rad_), rate);
  const double most = rate * dt_s_;
  double before = start_.value_or(first_centre_);
  for (int i = 0; i < count_; ++i) {
    Point& p = points_[static_cast<std::size_t>(i)];
    const double reach = i == 0 ? 0 : most;
    const double wanted = std::isnan(p.wanted) ? p.centre : p.wanted;
    p.raw = std::clamp(std::clamp(wanted, p.low, p.high), before - reach, before + reach);
    before = p.raw;
  }
  smooth();
  return worst_error();
}

/// Mean over the time in which the axis changes its rate by as much as the raw path does at most.
void KeyholePlan::smooth() {
  double slowest = std::numeric_limits<double>::infinity();
  double fastest = -slowest;
  for (int i = 1; i < count_; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double slope = (points_[k].raw - points_[k - 1].raw) / dt_s_;
    slowest = std::min(slowest, slope);
    fastest = std::max(fastest, slope);
  }
  const double wide_s = (fastest - slowest) / antenna_.azimuth_acceleration_max_rad_s2;
  const int half = std::clamp(static_cast<int>(std::ceil(wide_s / dt_s_ / 2)), 0, (count_ - 1) / 2);
  sum_[0] = 0;
  for (int i = 0; i < count_; ++i) {
    const auto k = static_cast<std::size_t>(i);
    sum_[k + 1] = sum_[k] + points_[k].raw;
  }
  for (int i = 0; i < count_; ++i) {
    // Narrower towards the ends, which stay where they are.
    const int reach = std::min({half, i, count_ - 1 - i});
    const auto end = static_cast<std::size_t>(i) + static_cast<std::size_t>(reach) + 1;
    const double sum = sum_[end] - sum_[static_cast<std::size_t>(i - reach)];
    points_[static_cast<std::size_t>(i)].planned = sum / (2 * reach + 1);
  }
}

double KeyholePlan::error_ahead(const PredictedPath& path, const Site& site, const RefractionTable* air,
                                Time now) const {
  double worst = 0;
  for (int i = static_cast<int>(index_of(now)); i <= std::min(last_ + 1, used_ - 1); ++i) {
    const Time t = begin_ + seconds(dt_s_ * i);
    const PassPoint seen = seen_at(path, (t - path.from()).seconds(), site, air);
    const double off = best_[static_cast<std::size_t>(i)].planned - seen.azimuth_rad;
    worst = std::max(worst, error_rad(off, seen.elevation_rad, antenna_.elevation_max_rad));
  }
  return worst;
}

double KeyholePlan::worst_error() const {
  double worst = 0;
  for (int i = 0; i < count_; ++i) {
    const Point& p = points_[static_cast<std::size_t>(i)];
    worst = std::max(worst, error_rad(p.planned - p.azimuth, p.elevation, antenna_.elevation_max_rad));
  }
  return worst;
}

double KeyholePlan::index_of(Time t) const {
  return std::clamp((t - begin_).seconds() / dt_s_, 0.0, static_cast<double>(used_ - 1));
}

bool KeyholePlan::active(Time t) const {
  if (used_ == 0 || last_ < first_) return false;
  const double place = (t - begin_).seconds() / dt_s_;
  return place >= first_ - 1 && place <= std::min(last_ + 1, used_ - 1);
}

AxisMotion KeyholePlan::azimuth(Time t) const {
  // A parabola through the three nearest points.
  const double place = index_of(t);
  const int middle = std::clamp(static_cast<int>(std::lround(place)), 1, used_ - 2);
  const auto at = [&](int i) { return best_[static_cast<std::size_t>(i)].planned; };
  const double slope = (at(middle + 1) - at(middle - 1)) / 2;
  const double bend = at(middle + 1) - 2 * at(middle) + at(middle - 1);
  const double u = place - middle;
  return {at(middle) + u * (slope + u * bend / 2), (slope + u * bend) / dt_s_, bend / (dt_s_ * dt_s_)};
}

}  // namespace downrange
