#include "experiment/launch_scenario.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "sim/random_stream.hpp"
#include "sim/sensor_models.hpp"

namespace downrange::experiment::launch {
namespace {

constexpr double deg = std::numbers::pi / 180;
constexpr Time liftoff{1'772'352'000'000'000'000};
const Eigen::Vector3d gps_sigma_enu_m(5, 5, 8);

/// Sees everything from anywhere: the scenario has neither horizon nor range limit.
sim::RadarScenario radar(std::string_view name, const Geodetic& site, double rate_hz, double phase_s) {
  sim::RadarScenario r;
  r.id = name;
  r.site = Site(site);
  r.sigma = {25, 0.01 * deg, 0.01 * deg};
  r.rate_hz = rate_hz;
  r.phase_s = phase_s;
  r.track = {tracking_from_s, end_s};
  r.range_max_m = 1e9;
  r.elevation_min_rad = -90 * deg;
  r.bias_sigma.offset = {30, 0.03 * deg, 0.03 * deg};
  r.bias_sigma.scale = {3e-5, 2e-4, 2e-4};
  return r;
}

sim::Scenario base_scenario() {
  sim::Scenario s;
  s.name = "launch";
  s.target = "kslv";
  s.liftoff = liftoff;
  s.end_s = end_s;
  s.profile = sim::naro_launch_profile();
  s.radars = {radar(radar_names[0], {34.4450 * deg, 127.5200 * deg, 120}, 10, 0.013),
              radar(radar_names[1], {33.2900 * deg, 126.4600 * deg, 350}, 20, 0.031)};
  s.gps.rate_hz = 1 / fix_interval_s;
  s.gps.phase_s = std::fmod(first_fix_s, fix_interval_s);
  s.gps.active = {first_fix_s, end_s};
  s.gps.sigma_enu_m = gps_sigma_enu_m;
  sim::StationScenario station;
  station.id = "telemetry";
  station.site = s.radars[0].site;
  station.elevation_min_rad = -90 * deg;
  s.stations = {station};
  return s;
}

sim::Scenario scenario_of(Case which, sim::Scenario s) {
  for (sim::RadarScenario& r : s.radars) {
    if (which == Case::WrongBlocks) {
      r.bias_sigma = {};
      r.bias_sigma.sez_offset_m.setConstant(50);
      r.bias_sigma.sez_scale.setConstant(1e-4);
    } else if (which == Case::TimeTag) {
      r.bias.time_tag_s = time_tag_s;
    }
  }
  if (which == Case::GpsLost) s.gps.outages = {{gps_lost_s, end_s}};
  return s;
}

Measurement measurement_of(const RadarTspi& plot, int source) {
  Measurement m;
  m.epoch = plot.epoch;
  m.source = source;
  m.sequence = plot.sequence;
  m.measured = downrange::Plot{.measured = plot.measured};
  return m;
}

Measurement measurement_of(const GpsFix& fix) {
  Measurement m;
  m.epoch = fix.epoch;
  m.source = radars;
  m.sequence = fix.sequence;
  m.measured =
      Fix{.position = fix.position, .sigma_horizontal_m = gps_sigma_enu_m.x(), .sigma_vertical_m = gps_sigma_enu_m.z()};
  return m;
}

/// The runs of one seed do not overlap those of the next.
std::uint64_t seed_of_run(std::uint64_t seed, int run) { return seed * 1'000'003 + static_cast<std::uint64_t>(run); }

}  // namespace

const std::array<score::Phase, 3>& windows() {
  static const std::array<score::Phase, 3> all{score::Phase{"boost", 125, 160}, score::Phase{"coast", 250, 390},
                                               score::Phase{"late", 370, 470}};
  return all;
}

Scene::Scene() : scenario_(base_scenario()), trajectory_(scenario_.profile, scenario_.liftoff, end_s) {
  for (const Measurement& m : draw(Case::Base, 0, 0).measurements) {
    Instant i{
        .t_s = (m.epoch - liftoff()).seconds(), .is_plot = !is_fix(m), .source = m.source, .motion = motion(m.epoch)};
    if (i.is_plot) i.from_radar = site(m.source).enu_of({i.motion.head<3>()});
    instants_.push_back(i);
  }
}

Drawn Scene::draw(Case which, std::uint64_t seed, int run) const {
  const sim::Scenario scenario = scenario_of(which, scenario_);
  const std::uint64_t run_seed = seed_of_run(seed, run);
  const score::TruthFunction truth = [this](Time t) { return trajectory_.at(t); };
  Drawn drawn;
  for (int i = 0; i < radars; ++i) {
    const sim::RadarRun flown =
        sim::simulate_radar(scenario.radars[static_cast<std::size_t>(i)], scenario, truth, run_seed);
    drawn.bias[static_cast<std::size_t>(i)] = flown.bias;
    for (const RadarTspi& plot : flown.plots) drawn.measurements.push_back(measurement_of(plot, i));
  }
  for (const GpsFix& fix : sim::simulate_gps(scenario, truth, run_seed))
    drawn.measurements.push_back(measurement_of(fix));
  std::sort(drawn.measurements.begin(), drawn.measurements.end(), processed_before);

  sim::RandomStream random(run_seed, "start");
  for (int i = 0; i < 9; ++i) drawn.start_error[i] = std::sqrt(start_covariance()(i, i)) * random.normal();
  return drawn;
}

Vec<9> Scene::motion(Time t) const {
  const auto state = trajectory_.at(t);
  const auto acceleration = trajectory_.acceleration(t);
  if (!state || !acceleration) throw std::logic_error("the launch experiment asks for a truth outside its flight");
  Vec<9> motion;
  motion << state->position.m, state->velocity.m_s, *acceleration;
  return motion;
}

MethodSettings Scene::settings(Kinematics kinematics, const BiasModel& bias) const {
  MethodSettings s;
  for (const sim::RadarScenario& r : scenario_.radars)
    s.radars.push_back({.site = r.site, .sigma = r.sigma, .bias = bias});
  s.stations = 1;
  s.arbitration.history = milliseconds(0);
  s.arbitration.gate_probability = 1;
  s.motion.kinematics = kinematics;
  s.gps_use.velocity = false;
  s.gps.error.enabled = false;
  s.gps.no_gps.enabled = false;
  s.noise.enabled = false;
  s.cartesian_bias.window = 20;
  s.cartesian_bias.offset_drift_m_sqrt_s = 0;
  s.cartesian_bias.scale_drift_sqrt_s = 0;
  return s;
}

Mat<9, 9> start_covariance() {
  Vec<9> sigma;
  sigma << Vec<3>::Constant(100), Vec<3>::Constant(100), Vec<3>::Constant(20);
  return sigma.cwiseAbs2().asDiagonal();
}

BiasVector bias_vector(const sim::RadarBias& bias) {
  BiasVector b;
  b << bias.sez_offset_m, bias.sez_scale, bias.offset.range_m, bias.offset.azimuth_rad, bias.offset.elevation_rad,
      bias.scale, bias.time_tag_s;
  return b;
}

Displacement<Enu> bias_left(const Instant& instant, const sim::RadarBias& truth, const Site& site,
                            std::span<const BiasTerm> term, std::span<const double> value) {
  const Displacement<Enu> put = enu_from_polar(compensate(sim::biased(instant.from_radar, truth), term, value));
  // A plot of time t - tag is taken for one of t - tag_hat.
  const auto tag = std::find(term.begin(), term.end(), BiasTerm::TimeTag);
  const double tag_hat = tag == term.end() ? 0 : value[static_cast<std::size_t>(tag - term.begin())];
  const Velocity<Enu> v = site.R_enu_ecef() * Velocity<Ecef>{instant.motion.segment<3>(3)};
  return {put.m - instant.from_radar.m + (tag_hat - truth.time_tag_s) * v.m_s};
}

}  // namespace downrange::experiment::launch
