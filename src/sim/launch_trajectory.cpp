#include "sim/launch_trajectory.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <downrange/geo/earth.hpp>
#include <iterator>
#include <numbers>
#include <stdexcept>

#include "sim/runge_kutta.hpp"

namespace downrange::sim {
namespace {

constexpr double deg = std::numbers::pi / 180;

/// The burn at t; null while coasting.
const Burn* burn_at(const LaunchProfile& profile, double t_s) {
  for (const Burn& burn : profile.burns)
    if (burn.from_s <= t_s && t_s < burn.to_s) return &burn;
  return nullptr;
}

double pitch_at(const LaunchProfile& profile, double t_s) {
  const auto& table = profile.pitch;
  if (t_s <= table.front().t_s) return table.front().pitch_rad;
  if (t_s >= table.back().t_s) return table.back().pitch_rad;
  const auto later = [](double t, const PitchPoint& point) { return t < point.t_s; };
  const auto b = std::upper_bound(table.begin(), table.end(), t_s, later);
  const auto a = std::prev(b);
  return a->pitch_rad + (b->pitch_rad - a->pitch_rad) * (t_s - a->t_s) / (b->t_s - a->t_s);
}

/// What acts from one discontinuity to the next; given, not looked up, so that a step which ends at a cut-off is
/// powered to its end.
struct Segment {
  const Burn* burn = nullptr;  ///< null while coasting
  std::vector<const Push*> pushes{};
};

Segment segment_at(const LaunchProfile& profile, double t_s) {
  Segment segment{burn_at(profile, t_s), {}};
  for (const Push& push : profile.pushes)
    if (push.from_s <= t_s && t_s < push.to_s) segment.pushes.push_back(&push);
  return segment;
}

Eigen::Vector3d pushed(const Push& push, const score::TrueState& state) {
  const Eigen::Vector3d& v = state.velocity.m_s;
  if (!(v.norm() > 1)) return Eigen::Vector3d::Zero();  // no direction yet
  const Eigen::Vector3d forward = v.normalized();
  const Eigen::Vector3d vertical = state.position.m.normalized();
  const Eigen::Vector3d across = forward.cross(vertical);
  if (!(across.norm() > 1e-6)) return push.forward_m_s2 * forward;  // straight up: there is no right
  const Eigen::Vector3d right = across.normalized();
  return push.forward_m_s2 * forward + push.right_m_s2 * right + push.up_m_s2 * right.cross(forward);
}

Eigen::Vector3d drag(const LaunchProfile& profile, const score::TrueState& state) {
  constexpr double sea_level_kg_m3 = 1.225;
  constexpr double scale_height_m = 7200;
  const double height_m = geodetic_from_ecef(state.position).height_m;
  const double density = sea_level_kg_m3 * std::exp(-std::max(0.0, height_m) / scale_height_m);
  return -density / 2 / profile.ballistic_kg_m2 * state.velocity.m_s.norm() * state.velocity.m_s;
}

Eigen::Vector3d acceleration_of(const LaunchProfile& profile, const Segment& segment, double t_s,
                                const score::TrueState& state) {
  Eigen::Vector3d a = free_fall_acceleration(state.position, state.velocity);
  for (const Push* push : segment.pushes) a += pushed(*push, state);
  if (profile.ballistic_kg_m2 > 0) a += drag(profile, state);
  const Burn* burn = segment.burn;
  if (burn == nullptr) return a;
  const double thrust_m_s2 = burn->thrust_n / (burn->mass_kg - burn->flow_kg_s * (t_s - burn->from_s));
  const double pitch = pitch_at(profile, t_s);
  const Displacement<Enu> direction{{std::sin(profile.azimuth_rad) * std::cos(pitch),
                                     std::cos(profile.azimuth_rad) * std::cos(pitch), std::sin(pitch)}};
  const Rotation<Enu, Ecef> R_enu_ecef = enu_from_ecef_at(geodetic_from_ecef(state.position));
  a += thrust_m_s2 * (R_enu_ecef.inverse() * direction).m;
  return a;
}

/// Instants in (0, duration] where the acceleration or its slope jumps, and the end.
std::vector<double> segment_ends(const LaunchProfile& profile, double duration_s) {
  std::vector<double> ends{duration_s};
  for (const Burn& burn : profile.burns) ends.insert(ends.end(), {burn.from_s, burn.to_s});
  for (const Push& push : profile.pushes) ends.insert(ends.end(), {push.from_s, push.to_s});
  for (const PitchPoint& point : profile.pitch) ends.push_back(point.t_s);
  std::erase_if(ends, [duration_s](double t) { return t <= 0 || t > duration_s; });
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  return ends;
}

std::vector<score::TruthSample> hop_samples(const LaunchProfile& profile, Time liftoff, double duration_s,
                                            double step_s) {
  const Site pad(profile.pad);
  const int steps = static_cast<int>(std::ceil(duration_s / step_s - 1e-9));
  std::vector<score::TruthSample> samples;
  for (int i = 0; i <= steps; ++i) {
    const double t_s = i * duration_s / steps;
    samples.push_back({liftoff + seconds(t_s), hop_motion(*profile.hop, pad, profile.azimuth_rad, t_s).state});
  }
  return samples;
}

std::vector<score::TruthSample> integrate(const LaunchProfile& profile, Time liftoff, double duration_s,
                                          double step_s) {
  if (!profile.hop && (profile.burns.empty() || profile.pitch.empty()))
    throw std::invalid_argument("a launch profile needs a burn and a pitch table");
  if (!(duration_s > 0) || !(step_s > 0)) throw std::invalid_argument("a launch needs a positive duration and step");
  if (profile.hop) return hop_samples(profile, liftoff, duration_s, step_s);
  score::TrueState x{ecef_from_geodetic(profile.pad), {}};
  std::vector<score::TruthSample> samples{{liftoff, x}};
  double begin_s = 0;
  for (const double end_s : segment_ends(profile, duration_s)) {
    const Segment segment = segment_at(profile, (begin_s + end_s) / 2);
    const int steps = static_cast<int>(std::ceil((end_s - begin_s) / step_s - 1e-9));
    const double h = (end_s - begin_s) / steps;
    const auto acceleration = [&](double t_s, const score::TrueState& at) {
      return acceleration_of(profile, segment, t_s, at);
    };
    for (int i = 0; i < steps; ++i) {
      x = runge_kutta_step(acceleration, begin_s + i * h, h, x);
      samples.push_back({liftoff + seconds(begin_s + (i + 1) * h), x});
    }
    begin_s = end_s;
  }
  return samples;
}

}  // namespace

LaunchProfile naro_launch_profile() {
  return {.pad = {34.4319 * deg, 127.5351 * deg, 100.0},
          .azimuth_rad = 170 * deg,
          .burns = {{0, 229, 1.55e6, 140e3, 480}, {395, 453, 80e3, 2.7e3, 30}},
          .pitch = {{15, 90 * deg},
                    {40, 80 * deg},
                    {80, 63 * deg},
                    {120, 50 * deg},
                    {160, 41 * deg},
                    {200, 35 * deg},
                    {229, 32 * deg},
                    {394, 10 * deg},
                    {395, -1 * deg},
                    {453, -4 * deg}}};
}

LaunchTrajectory::LaunchTrajectory(const LaunchProfile& profile, Time liftoff, double duration_s, double step_s)
    : profile_(profile), liftoff_(liftoff), table_(integrate(profile, liftoff, duration_s, step_s)) {}

std::optional<score::TrueState> LaunchTrajectory::at(Time t) const {
  if (t < liftoff_) return table_.samples().front().state;
  return table_.at(t);
}

std::optional<Eigen::Vector3d> LaunchTrajectory::acceleration(Time t) const {
  if (t < liftoff_) return Eigen::Vector3d::Zero();
  const std::optional<score::TrueState> state = table_.at(t);
  if (!state) return std::nullopt;
  const double t_s = (t - liftoff_).seconds();
  if (profile_.hop) return hop_motion(*profile_.hop, Site(profile_.pad), profile_.azimuth_rad, t_s).acceleration;
  return acceleration_of(profile_, segment_at(profile_, t_s), t_s, *state);
}

}  // namespace downrange::sim
