#pragma once
/// What a simulated flight consists of: its trajectory, the errors of its sensors, the phases it is judged by.

#include <Eigen/Core>
#include <cstdint>
#include <downrange/geo/name.hpp>
#include <downrange/geo/polar.hpp>
#include <downrange/geo/time.hpp>
#include <downrange/stage/range_config.hpp>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "score/phase.hpp"
#include "sim/launch_trajectory.hpp"
#include "sim/scenario_error.hpp"

namespace downrange::sim {

/// Seconds after lift-off, `first` <= t < `second`.
using Window = std::pair<double, double>;

/// Systematic errors of one radar: measured = true + bias. The target is first displaced in the radar's
/// south-east-zenith axes, then the polar terms act, the azimuth scale about south (est/THEORY.md section 3).
struct RadarBias {
  Polar offset;
  Eigen::Vector3d scale = Eigen::Vector3d::Zero();         ///< of range, azimuth - pi, elevation
  Eigen::Vector3d sez_offset_m = Eigen::Vector3d::Zero();  ///< south, east, zenith
  Eigen::Vector3d sez_scale = Eigen::Vector3d::Zero();
  double time_tag_s = 0;  ///< positive: the radar's clock is fast, its stamps are later than the truth
};

/// What a radar says while something is wrong with it: measured * factor + offset, after noise and bias.
struct RadarFault {
  Window when;
  double range_factor = 1;  ///< 3.28: feet
  double range_offset_m = 0;
  double azimuth_factor = 1;  ///< -1: the sign of the other convention
  double azimuth_offset_rad = 0;
  double elevation_offset_rad = 0;
};

/// Where a receiver says it is while something is wrong with it.
struct GpsFault {
  Window when;
  Eigen::Vector3d offset_enu_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d drift_enu_m_s = Eigen::Vector3d::Zero();  ///< from the fault's begin on
};

struct RadarScenario {
  Name id;
  Site site;
  MeasuredParts measures{};  ///< as the range has it: what it does not measure is not valid in its plots
  PolarSigma sigma;
  double sigma_range_rate_m_s = 0;  ///< 0: plots carry no range rate
  double range_rate_offset_m_s = 0;
  double rate_hz = 10;
  double phase_s = 0;  ///< plots are stamped at lift-off + phase + k / rate
  Window track;
  double range_max_m = 0;
  double elevation_min_rad = 0;
  double refractivity = 0;  ///< N-units at the site: range and elevation are refracted (geo/refraction.hpp)
  double dropout_probability = 0;
  std::vector<Window> outages;
  double outlier_probability = 0;
  double outlier_range_m = 0;         ///< an outlier is off by 0.5 to 1.5 times this in range
  double outlier_angle_rad = 0;       ///< and by 0.5 to 1.5 times this in both angles
  bool azimuth_sigma_on_sky = false;  ///< sigma.azimuth_rad is on the sky: the axis's own is that over cos(elevation)
  bool coloured_on_sky = false;       ///< the next likewise
  double coloured_angle_sigma_rad = 0;
  double coloured_angle_tau_s = 10;
  double latency_s = 0;
  double latency_jitter_s = 0;  ///< delay is uniform in latency -+ jitter
  RadarBias bias;               ///< the same in every run
  RadarBias bias_sigma;         ///< 1-sigma of what is drawn per run and added
  std::vector<RadarFault> faults;
};

/// The vehicle's receiver.
struct GpsScenario {
  double rate_hz = 1;
  double phase_s = 0;  ///< fixes at lift-off + phase + k / rate
  Window active;
  Eigen::Vector3d sigma_enu_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d coloured_sigma_enu_m = Eigen::Vector3d::Zero();
  double coloured_tau_s = 60;
  double sigma_velocity_m_s = 0;  ///< per axis; 0: fixes carry no velocity
  std::vector<Window> outages;
  std::vector<GpsFault> faults;
  double latency_s = 0;  ///< from the fix's epoch to its transmission
  bool states_accuracy = false;
  int satellites = 0;
  bool satellites_stated = false;
};

/// A telemetry ground station that relays the receiver's fixes.
struct StationScenario {
  Name id;
  Site site;
  double elevation_min_rad = 0;
  double delay_s = 0;
  double delay_jitter_s = 0;  ///< uniform in delay -+ jitter
  double loss_probability = 0;
  std::vector<Window> outages;
};

/// What carries a moving antenna: along a geodesic at constant height, turning steadily.
struct PlatformScenario {
  Name id;                ///< of the antenna
  Geodetic start;         ///< at lift-off
  double course_rad = 0;  ///< at lift-off, clockwise from true north
  double speed_m_s = 0;
  double heading_rad = 0;  ///< of the antenna's azimuth zero at lift-off
  double turn_rate_rad_s = 0;
  double rate_hz = 10;
  double sigma_position_m = 0;  ///< noise per axis, and what is stated
  double sigma_heading_rad = 0;
  double latency_s = 0;
};

/// What an antenna tells of its mode: slaved inside the windows, else that it tracks by itself.
struct AntennaScenario {
  Name id;
  std::vector<Window> slaved;
  double rate_hz = 10;
  double latency_s = 0;
};

struct Scenario {
  Name name;
  Name target;
  Time liftoff;
  double start_s = 0;  ///< of the flight's events, after lift-off
  double end_s = 0;
  std::uint64_t seed = 1;
  bool simulated = true;  ///< the flag every message carries
  LaunchProfile profile;
  std::vector<score::Phase> phases;
  std::vector<RadarScenario> radars;
  std::vector<RadarScenario> angle_sensors;  ///< radars that tell no range: range noise and bias do not matter
  GpsScenario gps;
  std::vector<StationScenario> stations;
  std::vector<PlatformScenario> platforms;
  std::vector<AntennaScenario> antennas;
};

/// `visit(sensor)` of every radar and every angles-only tracker.
template <class Visit>
void for_each_tracking_sensor(Scenario& scenario, const Visit& visit) {
  for (RadarScenario& radar : scenario.radars) visit(radar);
  for (RadarScenario& sensor : scenario.angle_sensors) visit(sensor);
}

/// Reads a scenario file for a range: sites, and the noise, rate and limits of a radar where the file does not give
/// them, come from the range. Throws ScenarioError (file, line, key, what is allowed).
[[nodiscard]] Scenario load_scenario(const std::filesystem::path& file, const RangeConfig& range);

}  // namespace downrange::sim
