#include "sim/orbit_pass.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <downrange/geo/earth.hpp>
#include <downrange/geo/polar.hpp>
#include <numbers>
#include <stdexcept>

#include "sim/runge_kutta.hpp"

namespace downrange::sim {
namespace {

constexpr double deg = std::numbers::pi / 180;
constexpr double step_s = 1;

score::TrueState middle_of(const OrbitPassProfile& profile) {
  const Site site(profile.over);
  const Displacement<Enu> heading{{std::sin(profile.heading_rad), std::cos(profile.heading_rad), 0}};
  const Eigen::Vector3d above = ecef_from_geodetic(profile.over).m.normalized();
  Eigen::Vector3d along = (site.R_enu_ecef().inverse() * heading).m;
  along = (along - above.dot(along) * above).normalized();
  const Eigen::Vector3d right = along.cross(above);
  const Eigen::Vector3d p = std::cos(profile.off_centre_rad) * above + std::sin(profile.off_centre_rad) * right;
  const double radius = wgs84::semi_major_axis_m + profile.height_m;
  const Eigen::Vector3d rotation(0, 0, wgs84::rotation_rate_rad_s);
  return {{radius * p}, {std::sqrt(wgs84::gm_m3_s2 / radius) * along - rotation.cross(radius * p)}};
}

std::vector<score::TruthSample> integrate(const OrbitPassProfile& profile, Time rise) {
  const Site site(profile.over);
  const auto visible = [&](const score::TrueState& x) {
    return polar_from_enu(site.enu_of(x.position)).elevation_rad >= 0;
  };
  const auto acceleration = [](double, const score::TrueState& x) {
    return free_fall_acceleration(x.position, x.velocity);
  };
  const score::TrueState middle = middle_of(profile);
  if (!visible(middle)) throw std::invalid_argument("an orbit pass stays below the horizon");
  std::vector<score::TrueState> states;
  for (score::TrueState x = middle; visible(x); x = runge_kutta_step(acceleration, 0, -step_s, x)) states.push_back(x);
  std::reverse(states.begin(), states.end());
  states.pop_back();
  for (score::TrueState x = middle; visible(x); x = runge_kutta_step(acceleration, 0, step_s, x)) states.push_back(x);
  std::vector<score::TruthSample> samples;
  for (std::size_t i = 0; i < states.size(); ++i) {
    samples.push_back({rise + seconds(static_cast<double>(i) * step_s), states[i]});
  }
  return samples;
}

}  // namespace

OrbitPassProfile naro_orbit_pass() {
  return {.over = {34.4319 * deg, 127.5351 * deg, 100},
          .height_m = 400e3,
          .heading_rad = 45 * deg,
          .off_centre_rad = 2.3 * deg};
}

OrbitPass::OrbitPass(const OrbitPassProfile& profile, Time rise) : table_(integrate(profile, rise)) {}

double OrbitPass::duration_s() const {
  return (table_.samples().back().time - table_.samples().front().time).seconds();
}

}  // namespace downrange::sim
