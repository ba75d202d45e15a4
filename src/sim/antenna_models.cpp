#include "sim/antenna_models.hpp"

#include <GeographicLib/Geodesic.hpp>
#include <algorithm>
#include <cmath>
#include <downrange/geo/polar.hpp>
#include <numbers>
#include <string>

#include "sim/random_stream.hpp"

namespace downrange::sim {
namespace {

constexpr double deg = std::numbers::pi / 180;

/// `tell(time, number)` at `rate_hz` over the flight.
template <class Tell>
void each(const Scenario& scenario, double rate_hz, const Tell& tell) {
  std::uint64_t sequence = 0;
  for (double t = scenario.start_s; t < scenario.end_s; t = scenario.start_s + static_cast<double>(sequence) / rate_hz)
    tell(t, ++sequence);
}

}  // namespace

PlatformTruth platform_at(const PlatformScenario& platform, double t_s) {
  double latitude = 0;
  double longitude = 0;
  double course = 0;
  GeographicLib::Geodesic::WGS84().Direct(platform.start.latitude_rad / deg, platform.start.longitude_rad / deg,
                                          platform.course_rad / deg, platform.speed_m_s * t_s, latitude, longitude,
                                          course);
  return {.place = {latitude * deg, longitude * deg, platform.start.height_m},
          .course_rad = course * deg,
          .heading_rad = platform.heading_rad + t_s * platform.turn_rate_rad_s};
}

std::vector<PlatformState> simulate_platform(const PlatformScenario& platform, const Scenario& scenario,
                                             std::uint64_t seed) {
  RandomStream random(seed, "platform " + std::string(platform.id.view()));
  std::vector<PlatformState> states;
  each(scenario, platform.rate_hz, [&](double t, std::uint64_t sequence) {
    const PlatformTruth truth = platform_at(platform, t);
    const Site site(truth.place);
    const Eigen::Vector3d noise(random.normal(), random.normal(), random.normal());
    const Eigen::Vector3d v_enu =
        platform.speed_m_s * Eigen::Vector3d(std::sin(truth.course_rad), std::cos(truth.course_rad), 0);
    PlatformState state;
    state.antenna = platform.id;
    state.sequence = sequence;
    state.epoch = scenario.liftoff + seconds(t);
    state.received = state.epoch + seconds(platform.latency_s);
    state.position = {site.ecef().m + platform.sigma_position_m * noise};
    state.velocity = {site.R_enu_ecef().R.transpose() * v_enu};
    state.velocity_valid = true;
    state.heading_rad = wrap_two_pi(truth.heading_rad + platform.sigma_heading_rad * random.normal());
    state.sigma_position_m = platform.sigma_position_m;
    state.sigma_heading_rad = platform.sigma_heading_rad;
    state.simulated = scenario.simulated;
    states.push_back(state);
  });
  return states;
}

std::vector<AntennaReport> simulate_antenna(const AntennaScenario& antenna, const Scenario& scenario) {
  std::vector<AntennaReport> reports;
  each(scenario, antenna.rate_hz, [&](double t, std::uint64_t sequence) {
    AntennaReport report;
    report.antenna = antenna.id;
    report.sequence = sequence;
    report.epoch = scenario.liftoff + seconds(t);
    report.received = report.epoch + seconds(antenna.latency_s);
    report.azimuth_valid = report.elevation_valid = false;
    const bool slaved =
        std::ranges::any_of(antenna.slaved, [t](const Window& w) { return t >= w.first && t < w.second; });
    report.mode = slaved ? AntennaMode::Slaved : AntennaMode::Autotrack;
    report.simulated = scenario.simulated;
    reports.push_back(report);
  });
  return reports;
}

}  // namespace downrange::sim
