#include "sim/scenario.hpp"

#include <limits>
#include <numbers>
#include <tuple>

#include "sim/toml_section.hpp"
#include "text/file.hpp"
#include "text/parse_toml.hpp"

namespace downrange::sim {
namespace {

constexpr double deg = std::numbers::pi / 180;
constexpr double day_s = 86'400;
constexpr Limits from_zero{0};
constexpr Limits any{};
constexpr Limits probability{0, 1};
constexpr Limits rate{0.01, 1000};
constexpr Limits flight_time{-day_s, day_s};

/// Looks `id` up among the range's radars, stations or targets: a scenario cannot invent one.
template <class T>
const T& find_by_id(TomlSection& toml, std::string_view key, const std::vector<T>& known, const std::string& what) {
  const std::string id = toml.text(key);
  std::string allowed;
  for (const T& entry : known) {
    if (entry.id.view() == id) return entry;
    allowed += (allowed.empty() ? "" : ", ") + std::string(entry.id.view());
  }
  toml.fail(key, "\"" + id + "\" is no " + what + " of this range; allowed: " + (allowed.empty() ? "none" : allowed));
}

Name read_name(TomlSection& toml, std::string_view key) {
  const std::string text = toml.text(key);
  const auto name = Name::parse(text);
  if (!name) toml.fail(key, "must have " + std::to_string(Name::max_size) + " characters or fewer");
  return *name;
}

Window read_window(TomlSection& toml, std::string_view from, std::string_view to, Window fallback) {
  const Window window{toml.number(from, flight_time, fallback.first), toml.number(to, flight_time, fallback.second)};
  if (!(window.first < window.second)) toml.fail(to, "must be after " + std::string(from));
  return window;
}

/// A delay is uniform in mean -+ jitter and never negative.
std::pair<double, double> read_delay(TomlSection& toml, std::string_view mean, std::string_view jitter) {
  const double mean_ms = toml.number(mean, {0, 60'000}, 0);
  const double jitter_ms = toml.number(jitter, {0, mean_ms}, 0);
  return {mean_ms / 1000, jitter_ms / 1000};
}

/// Systematic errors: of all three coordinates, or (`ranging` false) of the angles alone.
RadarBias read_bias(TomlSection& radar, std::string_view key, const Limits& limits, bool ranging) {
  RadarBias bias;
  TomlSection toml = radar.section(key);
  bias.offset = {ranging ? toml.number("range_m", limits, 0) : 0, toml.number("azimuth_deg", limits, 0) * deg,
                 toml.number("elevation_deg", limits, 0) * deg};
  bias.scale = {ranging ? toml.number("range_scale", limits, 0) : 0, toml.number("azimuth_scale", limits, 0),
                toml.number("elevation_scale", limits, 0)};
  bias.sez_offset_m = {toml.number("south_m", limits, 0), toml.number("east_m", limits, 0),
                       toml.number("zenith_m", limits, 0)};
  bias.sez_scale = {toml.number("south_scale", limits, 0), toml.number("east_scale", limits, 0),
                    toml.number("zenith_scale", limits, 0)};
  bias.time_tag_s = toml.number("time_tag_ms", limits, 0) / 1000;
  toml.reject_unknown();
  return bias;
}

RadarFault read_radar_fault(TomlSection toml, const Scenario& scenario, bool ranging) {
  RadarFault fault;
  fault.when = read_window(toml, "from_s", "to_s", {scenario.start_s, scenario.end_s});
  if (ranging) {
    fault.range_factor = toml.number("range_factor", any, 1);
    fault.range_offset_m = toml.number("range_offset_m", any, 0);
  }
  fault.azimuth_factor = toml.number("azimuth_factor", any, 1);
  fault.azimuth_offset_rad = toml.number("azimuth_offset_deg", any, 0) * deg;
  fault.elevation_offset_rad = toml.number("elevation_offset_deg", any, 0) * deg;
  toml.reject_unknown();
  return fault;
}

GpsFault read_gps_fault(TomlSection toml, const Scenario& scenario) {
  GpsFault fault;
  fault.when = read_window(toml, "from_s", "to_s", {scenario.start_s, scenario.end_s});
  fault.offset_enu_m = {toml.number("east_m", any, 0), toml.number("north_m", any, 0), toml.number("up_m", any, 0)};
  fault.drift_enu_m_s = {toml.number("drift_east_m_s", any, 0), toml.number("drift_north_m_s", any, 0),
                         toml.number("drift_up_m_s", any, 0)};
  toml.reject_unknown();
  return fault;
}

/// What a tracker has of a radar.
RadarConfig radar_without_range(const AngleSensorConfig& sensor) {
  RadarConfig radar;
  radar.id = sensor.id;
  radar.site = sensor.site;
  radar.sigma = {.azimuth_rad = sensor.sigma_azimuth_rad, .elevation_rad = sensor.sigma_elevation_rad};
  radar.rate_hz = sensor.rate_hz;
  radar.range_max_m = std::numeric_limits<double>::infinity();
  radar.elevation_min_rad = sensor.elevation_min_rad;
  return radar;
}

/// `ranging`: false for an angles-only tracker, whose table has no keys of range.
RadarScenario read_sensor(TomlSection& toml, const RadarConfig& known, const Scenario& scenario, bool ranging) {
  RadarScenario radar;
  radar.id = known.id;
  radar.site = known.site;
  radar.measures = known.measures;
  radar.sigma = {ranging ? toml.number("sigma_range_m", from_zero, known.sigma.range_m) : 0,
                 toml.number("sigma_azimuth_deg", from_zero, known.sigma.azimuth_rad / deg) * deg,
                 toml.number("sigma_elevation_deg", from_zero, known.sigma.elevation_rad / deg) * deg};
  radar.sigma_range_rate_m_s = ranging ? toml.number("sigma_range_rate_m_s", from_zero, 0) : 0;
  radar.range_rate_offset_m_s = ranging ? toml.number("range_rate_offset_m_s", any, 0) : 0;
  radar.rate_hz = toml.number("rate_hz", rate, known.rate_hz);
  radar.phase_s = toml.number("phase_ms", {0, 1000 / radar.rate_hz}, 0) / 1000;
  radar.track = read_window(toml, "track_from_s", "track_to_s", {scenario.start_s, scenario.end_s});
  radar.range_max_m = ranging ? toml.number("range_max_m", from_zero, known.range_max_m) : known.range_max_m;
  radar.elevation_min_rad = toml.number("elevation_min_deg", {-90, 90}, known.elevation_min_rad / deg) * deg;
  radar.refractivity = toml.number("refractivity_n", {0, 500}, 0);
  radar.dropout_probability = toml.number("dropout_probability", probability, 0);
  radar.outages = toml.windows("outages_s");
  radar.outlier_probability = toml.number("outlier_probability", probability, 0);
  radar.outlier_range_m = ranging ? toml.number("outlier_range_m", from_zero, 1000) : 0;
  radar.outlier_angle_rad = toml.number("outlier_angle_deg", from_zero, 1) * deg;
  radar.coloured_angle_sigma_rad = toml.number("coloured_angle_sigma_deg", from_zero, 0) * deg;
  radar.coloured_angle_tau_s = toml.number("coloured_angle_tau_s", {0.001, day_s}, 10);
  std::tie(radar.latency_s, radar.latency_jitter_s) = read_delay(toml, "latency_ms", "latency_jitter_ms");
  if (toml.optional("bias")) radar.bias = read_bias(toml, "bias", any, ranging);
  if (toml.optional("bias_sigma")) radar.bias_sigma = read_bias(toml, "bias_sigma", from_zero, ranging);
  for (TomlSection& fault : toml.sections("fault")) radar.faults.push_back(read_radar_fault(fault, scenario, ranging));
  toml.reject_unknown();
  return radar;
}

RadarScenario read_radar(TomlSection toml, const RangeConfig& range, const Scenario& scenario) {
  return read_sensor(toml, find_by_id(toml, "id", range.radars, "radar"), scenario, true);
}

RadarScenario read_angle_sensor(TomlSection toml, const RangeConfig& range, const Scenario& scenario) {
  const AngleSensorConfig& known = find_by_id(toml, "id", range.angle_sensors, "angle sensor");
  return read_sensor(toml, radar_without_range(known), scenario, false);
}

GpsScenario read_gps(TomlSection toml, const Scenario& scenario) {
  GpsScenario gps;
  gps.rate_hz = toml.number("rate_hz", rate, 1);
  gps.phase_s = toml.number("phase_ms", {0, 1000 / gps.rate_hz}, 0) / 1000;
  gps.active = read_window(toml, "from_s", "to_s", {scenario.start_s, scenario.end_s});
  gps.sigma_enu_m = {toml.number("sigma_east_m", from_zero), toml.number("sigma_north_m", from_zero),
                     toml.number("sigma_up_m", from_zero)};
  gps.coloured_sigma_enu_m.setConstant(toml.number("coloured_sigma_m", from_zero, 0));
  gps.coloured_tau_s = toml.number("coloured_tau_s", {0.001, day_s}, 60);
  gps.sigma_velocity_m_s = toml.number("sigma_velocity_m_s", from_zero, 0);
  gps.outages = toml.windows("outages_s");
  gps.latency_s = toml.number("latency_ms", {0, 60'000}, 0) / 1000;
  gps.states_accuracy = toml.flag("states_accuracy", false);
  gps.satellites_stated = toml.optional("satellites");
  gps.satellites = static_cast<int>(toml.number("satellites", {0, 255}, 0));
  for (TomlSection& fault : toml.sections("fault")) gps.faults.push_back(read_gps_fault(fault, scenario));
  toml.reject_unknown();
  return gps;
}

StationScenario read_station(TomlSection toml, const RangeConfig& range) {
  const TelemetryConfig& known = find_by_id(toml, "id", range.telemetry, "telemetry station");
  StationScenario station;
  station.id = known.id;
  station.site = known.site;
  station.elevation_min_rad = toml.number("elevation_min_deg", {-90, 90}, 0) * deg;
  std::tie(station.delay_s, station.delay_jitter_s) = read_delay(toml, "delay_ms", "delay_jitter_ms");
  station.loss_probability = toml.number("loss_probability", probability, 0);
  station.outages = toml.windows("outages_s");
  toml.reject_unknown();
  return station;
}

PlatformScenario read_platform(TomlSection toml, const RangeConfig& range) {
  const AntennaConfig& antenna = find_by_id(toml, "id", range.antennas, "antenna");
  if (!antenna.moves) toml.fail("id", "this antenna stands; allowed: one with moves = true in the range");
  const Geodetic& site = antenna.site.geodetic();
  PlatformScenario platform;
  platform.id = antenna.id;
  platform.start = {toml.number("latitude_deg", {-89, 89}, site.latitude_rad / deg) * deg,
                    toml.number("longitude_deg", {-180, 360}, site.longitude_rad / deg) * deg,
                    toml.number("height_m", {-500, 20'000}, site.height_m)};
  platform.course_rad = toml.number("course_deg", {0, 360}, 0) * deg;
  platform.speed_m_s = toml.number("speed_m_s", {0, 500}, 0);
  platform.heading_rad = toml.number("heading_deg", {0, 360}, platform.course_rad / deg) * deg;
  platform.turn_rate_rad_s = toml.number("turn_rate_deg_s", {-10, 10}, 0) * deg;
  platform.rate_hz = toml.number("rate_hz", {0.1, 100}, 10);
  platform.sigma_position_m = toml.number("sigma_position_m", {0, 1e4}, 0);
  platform.sigma_heading_rad = toml.number("sigma_heading_deg", {0, 20}, 0) * deg;
  platform.latency_s = toml.number("latency_ms", {0, 60'000}, 0) / 1000;
  toml.reject_unknown();
  return platform;
}

AntennaScenario read_antenna(TomlSection toml, const RangeConfig& range) {
  AntennaScenario antenna;
  antenna.id = find_by_id(toml, "id", range.antennas, "antenna").id;
  antenna.slaved = toml.windows("slaved_s");
  antenna.rate_hz = toml.number("rate_hz", {0.1, 100}, 10);
  antenna.latency_s = toml.number("latency_ms", {0, 60'000}, 0) / 1000;
  toml.reject_unknown();
  return antenna;
}

LaunchProfile read_profile(TomlSection toml) {
  if (toml.text("kind") != "launch") toml.fail("kind", "is not a known trajectory; allowed: launch");
  LaunchProfile profile = naro_launch_profile();
  const Geodetic& pad = profile.pad;
  profile.pad = {toml.number("pad_latitude_deg", {-90, 90}, pad.latitude_rad / deg) * deg,
                 toml.number("pad_longitude_deg", {-180, 180}, pad.longitude_rad / deg) * deg,
                 toml.number("pad_height_m", {-500, 9000}, pad.height_m)};
  profile.azimuth_rad = toml.number("azimuth_deg", {0, 360}, profile.azimuth_rad / deg) * deg;
  toml.reject_unknown();
  return profile;
}

score::Phase read_phase(TomlSection toml) {
  score::Phase phase;
  phase.name = toml.text("name");
  phase.from_s = toml.number("from_s", flight_time);
  phase.to_s = toml.number("to_s", flight_time);
  if (!(phase.from_s < phase.to_s)) toml.fail("to_s", "must be after from_s");
  toml.reject_unknown();
  return phase;
}

template <class T>
void require_distinct(const TomlSection& root, const std::string& key, const std::vector<T>& entries) {
  for (std::size_t i = 1; i < entries.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (entries[i].id == entries[j].id)
        root.fail(key, "\"" + std::string(entries[i].id.view()) + "\" is there twice; one table for each");
}

toml::table parse(const std::filesystem::path& file) {
  try {
    return text::parse_toml(text::read_file(file, text::max_toml_size));
  } catch (const text::FileError& error) {
    throw ScenarioError(file.string() + ": " + error.what());
  } catch (const text::TomlError& error) {
    throw ScenarioError(file.string() + ":" + std::to_string(error.line()) + ": " + error.what());
  }
}

}  // namespace

Scenario load_scenario(const std::filesystem::path& file, const RangeConfig& range) {
  const toml::table table = parse(file);
  TomlSection root(table, file.string(), "");
  Scenario scenario;
  scenario.name = read_name(root, "name");
  scenario.target = find_by_id(root, "target", range.targets, "target").id;
  scenario.liftoff = {root.instant_ns("liftoff_utc")};
  scenario.start_s = root.number("start_s", {-3600, 0}, -10);
  scenario.end_s = root.number("end_s", {1, 900});
  scenario.seed = static_cast<std::uint64_t>(root.number("seed", {0, 9e15}, 1));
  scenario.simulated = root.flag("simulated", true);
  scenario.profile = read_profile(root.section("trajectory"));
  for (const TomlSection& toml : root.sections("phase")) scenario.phases.push_back(read_phase(toml));
  for (const TomlSection& toml : root.sections("radar")) scenario.radars.push_back(read_radar(toml, range, scenario));
  for (const TomlSection& toml : root.sections("angle_sensor"))
    scenario.angle_sensors.push_back(read_angle_sensor(toml, range, scenario));
  scenario.gps = read_gps(root.section("gps"), scenario);
  for (const TomlSection& toml : root.sections("station")) scenario.stations.push_back(read_station(toml, range));
  for (const TomlSection& toml : root.sections("platform")) scenario.platforms.push_back(read_platform(toml, range));
  for (const TomlSection& toml : root.sections("antenna")) scenario.antennas.push_back(read_antenna(toml, range));
  require_distinct(root, "radar", scenario.radars);
  require_distinct(root, "angle_sensor", scenario.angle_sensors);
  require_distinct(root, "station", scenario.stations);
  require_distinct(root, "platform", scenario.platforms);
  require_distinct(root, "antenna", scenario.antennas);
  root.reject_unknown();
  return scenario;
}

}  // namespace downrange::sim
