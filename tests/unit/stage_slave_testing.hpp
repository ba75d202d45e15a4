#pragma once
/// Of the tests of SLAVE: tracks that are what a test says, passes, and a mount behind the commands.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <downrange/geo/earth.hpp>
#include <downrange/geo/hermite.hpp>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "../support/small_range.hpp"
#include "stage/slave/slave.hpp"

namespace downrange::test {

/// A method whose tracks are what the test says.
struct Told : Method {
  void start(int, Time, const Gaussian<9>&) override {}
  Outcome process(const Measurement&, Time) override { return {}; }
  std::optional<TrackEstimate> fused(int, std::optional<Time> at) const override {
    ++asked;
    return moved(fused_track, at);
  }
  std::optional<TrackEstimate> gps_track(int, Time at) const override { return moved(gps, at); }
  BiasEstimate bias(int) const override { return {}; }
  const SourceAccount& account(int) const override { return none; }

  static std::optional<TrackEstimate> moved(std::optional<TrackEstimate> e, std::optional<Time> at) {
    if (e && at) {
      e->mean.head<3>() += e->mean.segment<3>(3) * (*at - e->epoch).seconds();
      e->epoch = *at;
    }
    return e;
  }
  std::optional<TrackEstimate> fused_track;
  std::optional<TrackEstimate> gps;
  SourceAccount none;
  mutable int asked = 0;
};

/// A method that knows a path: seconds after `liftoff` to a state. `sigma_m` per axis.
struct Knows final : Told {
  std::optional<TrackEstimate> fused(int, std::optional<Time> at) const override {
    if (!known) return std::nullopt;
    TrackEstimate e;
    e.epoch = at.value_or(data_epoch);
    e.data_epoch = data_epoch;
    e.size = 9;
    const double t = (e.epoch - liftoff).seconds();
    const PositionVelocity x = path(t);
    e.mean.head<3>() = x.position.m;
    e.mean.segment<3>(3) = x.velocity.m_s;
    e.mean.tail<3>() = (path(t + 0.05).velocity.m_s - path(t - 0.05).velocity.m_s) / 0.1;
    e.cov = Mat<9, 9>::Identity() * sigma_m * sigma_m;
    e.cov.block<3, 3>(3, 3) = Mat<3, 3>::Identity() * sigma_m_s * sigma_m_s;
    return e;
  }
  std::function<PositionVelocity(double)> path;
  Time data_epoch;
  bool known = true;
  double sigma_m = 1;
  double sigma_m_s = 1;
};

/// Free fall through a state, by Runge-Kutta of order 4 with steps of half a second.
class Fall {
 public:
  Fall(const PositionVelocity& at_zero, double before_s, double after_s) : before_s_(std::ceil(before_s)) {
    std::vector<PositionVelocity> back{at_zero};
    for (double t = 0; t < before_s_; t += step_s) back.push_back(step(back.back(), -step_s));
    states_.assign(back.rbegin(), back.rend());
    for (double t = 0; t < after_s; t += step_s) states_.push_back(step(states_.back(), step_s));
  }
  PositionVelocity operator()(double t) const {
    const double place = std::clamp((t + before_s_) / step_s, 0.0, static_cast<double>(states_.size()) - 1.001);
    const auto i = static_cast<std::size_t>(place);
    return hermite(states_[i], states_[i + 1], step_s, place - std::floor(place));
  }

 private:
  static constexpr double step_s = 0.5;
  static PositionVelocity step(const PositionVelocity& x, double h) {
    const auto f = [](const PositionVelocity& s) { return free_fall_acceleration(s.position, s.velocity); };
    const auto moved = [&](const Eigen::Vector3d& v, const Eigen::Vector3d& a, double dt) {
      return PositionVelocity{{x.position.m + dt * v}, {x.velocity.m_s + dt * a}};
    };
    const Eigen::Vector3d v1 = x.velocity.m_s, a1 = f(x);
    const PositionVelocity x2 = moved(v1, a1, h / 2);
    const Eigen::Vector3d v2 = x2.velocity.m_s, a2 = f(x2);
    const PositionVelocity x3 = moved(v2, a2, h / 2);
    const Eigen::Vector3d v3 = x3.velocity.m_s, a3 = f(x3);
    const PositionVelocity x4 = moved(v3, a3, h);
    return moved((v1 + 2 * v2 + 2 * v3 + x4.velocity.m_s) / 6, (a1 + 2 * a2 + 2 * a3 + f(x4)) / 6, h);
  }
  double before_s_;
  std::vector<PositionVelocity> states_;
};

/// A satellite's pass whose highest point, at 0 s, is seen from `site` at that elevation; it flies along `heading`.
inline Fall orbit_pass(const Site& site, double elevation_rad, double heading_rad, double height_m = 400e3) {
  const double slant = height_m / std::max(std::sin(elevation_rad), 0.1);
  // Seen across the flight's direction.
  const Polar highest{slant, heading_rad + std::numbers::pi / 2, elevation_rad};
  const Position<Ecef> p = site.ecef_of(enu_from_polar(highest));
  const Rotation<Enu, Ecef> R = enu_from_ecef_at(geodetic_from_ecef(p));
  const Eigen::Vector3d v_enu = 7300 * Eigen::Vector3d(std::sin(heading_rad), std::cos(heading_rad), 0);
  return Fall({p, {R.R.transpose() * v_enu}}, 400, 400);
}

/// One axis of an antenna: rate and acceleration limited, braking in time.
struct Servo {
  double rate_max = 15 * deg;
  double acceleration_max = 20 * deg;
  double angle = 0;
  double rate = 0;
  double way = 0;  ///< travelled in all

  void step(double wanted, double wanted_rate, double dt) {
    const double e = wanted - angle;
    const double braking = std::sqrt(2 * 0.8 * acceleration_max * std::abs(e));
    double v = wanted_rate + std::copysign(std::min(braking, std::abs(e) / (4 * dt)), e);
    v = std::clamp(v, -rate_max, rate_max);
    v = std::clamp(v, rate - acceleration_max * dt, rate + acceleration_max * dt);
    rate = v;
    angle += v * dt;
    way += std::abs(v) * dt;
  }
};

/// An antenna that follows commands as a good one does: each to second order, from the instant of its application on.
struct Mount {
  Servo azimuth;
  Servo elevation;
  std::optional<SlavingCommand> newest;

  static double along(double angle, double rate, double acceleration, double dt) {
    return angle + dt * (rate + dt / 2 * acceleration);
  }
  void take(const SlavingCommand& c) {
    if (!newest) {
      azimuth.angle = c.azimuth_rad;
      elevation.angle = c.elevation_rad;
    }
    newest = c;
  }
  /// To `t`, by `dt`.
  void step(Time t, double dt) {
    if (!newest || t > newest->valid_until) return;
    const double since = (t - newest->apply_at).seconds();
    const SlavingCommand& c = *newest;
    azimuth.step(along(c.azimuth_rad, c.azimuth_rate_rad_s, c.azimuth_acceleration_rad_s2, since),
                 c.azimuth_rate_rad_s + since * c.azimuth_acceleration_rad_s2, dt);
    elevation.step(along(c.elevation_rad, c.elevation_rate_rad_s, c.elevation_acceleration_rad_s2, since),
                   c.elevation_rate_rad_s + since * c.elevation_acceleration_rad_s2, dt);
  }
  [[nodiscard]] double off(const Polar& target) const {
    const Eigen::Vector3d a = enu_from_polar({1, azimuth.angle, elevation.angle}).m;
    const Eigen::Vector3d b = enu_from_polar({1, target.azimuth_rad, target.elevation_rad}).m;
    return std::atan2(a.cross(b).norm(), a.dot(b));
  }
};

/// What became of a flight behind the commands of one antenna.
struct Flown {
  std::vector<SlavingCommand> commands;
  double worst_rad = 0;  ///< of the mount, from `settled_s` after the first command on, above 1 deg of elevation
  int went_around = 0;
  double azimuth_way_rad = 0;
  double low_rad = 1e9;  ///< of the mount's azimuth
  double high_rad = -1e9;
};

/// Flies a path from `from_s` to `to_s` past the first antenna of `range`, whose mount does 15 deg/s and 20 deg/s^2.
/// `follow`: what is followed at a tick, changed by the test.
inline Flown fly(const RangeConfig& range, Knows& method, double from_s, double to_s,
                 const std::function<void(double, Followed&)>& follow = {}, double settled_s = 2,
                 Time lifted_off = liftoff) {
  Slave slave(range);
  Collector out;
  Mount mount;
  Flown result;
  const AntennaConfig& antenna = range.antennas[0];
  constexpr int servo_steps = 5;
  const double dt = range.tick.seconds() / servo_steps;
  for (Time tick = ceil_to_grid(liftoff + seconds(from_s), range.tick); tick < liftoff + seconds(to_s);
       tick = tick + range.tick) {
    method.data_epoch = tick;
    std::vector<Followed> followed{{.method = &method, .newest = tick}};
    if (follow) follow((tick - liftoff).seconds(), followed[0]);
    out.results.clear();
    slave.tick(tick, followed, lifted_off, out);
    for (const SlavingCommand& c : out.of<SlavingCommand>()) {
      if (c.antenna != antenna.id) continue;
      mount.take(c);
      result.commands.push_back(c);
      if (c.limits & LimitUnwrapped) ++result.went_around;
    }
    for (int i = 1; i <= servo_steps; ++i) {
      // The command holds from its instant on: link and servo are led.
      const Time t = tick + antenna.link_delay + antenna.lead + seconds(i * dt);
      mount.step(t, dt);
      if (!mount.newest || (tick - liftoff).seconds() < from_s + settled_s) continue;
      const Polar q = polar_from_enu(antenna.site.enu_of(method.path((t - liftoff).seconds()).position));
      if (q.elevation_rad > 1 * deg) result.worst_rad = std::max(result.worst_rad, mount.off(q));
      result.low_rad = std::min(result.low_rad, mount.azimuth.angle);
      result.high_rad = std::max(result.high_rad, mount.azimuth.angle);
    }
  }
  result.azimuth_way_rad = mount.azimuth.way;
  return result;
}

/// small_range with one antenna that does 15 deg/s and 20 deg/s^2.
inline RangeConfig mount_range() {
  RangeConfig range = small_range();
  range.antennas.resize(1);
  AntennaConfig& a = range.antennas[0];
  a.azimuth_rate_max_rad_s = a.elevation_rate_max_rad_s = 15 * deg;
  a.azimuth_acceleration_max_rad_s2 = a.elevation_acceleration_max_rad_s2 = 20 * deg;
  return range;
}

}  // namespace downrange::test
