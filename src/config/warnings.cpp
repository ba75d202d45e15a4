/// What a configuration may say, but hardly means: sites that no one range has, keys that cancel each other.

#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <downrange/est/method/method_table.hpp>
#include <downrange/stage/source_table.hpp>
#include <numeric>
#include <optional>
#include <set>

#include "config/checker.hpp"

namespace downrange::config {
namespace {

/// Sites of one range lie within this of each other: the longest ranges relay by islands some 2 500 km downrange.
constexpr double range_width_m = 3e6;

/// Anything of the file that has a latitude and a longitude.
struct Place {
  std::string path;  ///< "radar[0]"
  std::string name;  ///< its id, else its path
  double latitude_deg = 0;
  double longitude_deg = 0;
  Position<Ecef> position{};
};

Position<Ecef> ground_at(double latitude_deg, double longitude_deg) {
  const double rad = unit_of("_deg").to_si;
  return ecef_from_geodetic({latitude_deg * rad, longitude_deg * rad, 0});
}

double distance_m(const Position<Ecef>& a, const Position<Ecef>& b) { return (a - b).m.norm(); }

std::optional<Place> place_of(const toml::node& node, const std::string& path) {
  const toml::table* table = node.as_table();
  if (table == nullptr) return std::nullopt;
  const auto latitude = table->at_path("latitude_deg").value<double>();
  const auto longitude = table->at_path("longitude_deg").value<double>();
  if (!latitude || !longitude) return std::nullopt;
  return Place{path, table->at_path("id").value_or(path), *latitude, *longitude, ground_at(*latitude, *longitude)};
}

/// Of every table, so that a table that is new to the schema needs no line here.
std::vector<Place> places_of(const toml::table& root) {
  std::vector<Place> places;
  const auto add = [&](const toml::node& node, const std::string& path) {
    if (const auto place = place_of(node, path)) places.push_back(*place);
  };
  for (const auto& [key, node] : root) {
    const std::string name(key.str());
    add(node, name);
    const toml::array* entries = node.as_array();
    for (std::size_t i = 0; entries != nullptr && i < entries->size(); ++i)
      add(*entries->get(i), name + '[' + std::to_string(i) + ']');
  }
  return places;
}

/// The place that is nearest to all others: one that is far off does not move it.
const Place& middle_of(const std::vector<Place>& places) {
  const auto far_from_all = [&](const Place& from) {
    return std::accumulate(places.begin(), places.end(), 0.0,
                           [&](double sum, const Place& to) { return sum + distance_m(from.position, to.position); });
  };
  return *std::ranges::min_element(places, {}, far_from_all);
}

std::string coordinates(double latitude_deg, double longitude_deg) {
  return show_number(latitude_deg) + ", " + show_number(longitude_deg);
}

std::string kilometres(double m) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.0f km", m / 1000);
  return text.data();
}

/// The slip that put `place` far from `middle`, if undoing one brings it near; else empty.
std::string likely_slip(const Place& place, const Place& middle) {
  struct Slip {
    const char* question;
    double latitude_deg;
    double longitude_deg;
  };
  const std::array slips{
      Slip{"latitude and longitude swapped?", place.longitude_deg, place.latitude_deg},
      Slip{"the longitude's sign?", place.latitude_deg, -place.longitude_deg},
      Slip{"the latitude's sign?", -place.latitude_deg, place.longitude_deg},
  };
  for (const Slip& slip : slips) {
    if (std::abs(slip.latitude_deg) > 90) continue;
    const double away = distance_m(ground_at(slip.latitude_deg, slip.longitude_deg), middle.position);
    if (away <= range_width_m)
      return std::string("; ") + slip.question + ' ' + coordinates(slip.latitude_deg, slip.longitude_deg) + " is " +
             kilometres(away) + " from it";
  }
  return {};
}

void warn_of_sites(const toml::table& root, const Checker& warn) {
  const std::vector<Place> places = places_of(root);
  if (places.empty()) return;
  const Place& middle = middle_of(places);
  for (const Place& place : places) {
    const double away = distance_m(place.position, middle.position);
    warn.require(away <= range_width_m, place.path + ".latitude_deg",
                 "\"" + place.name + "\" at " + coordinates(place.latitude_deg, place.longitude_deg) + " is " +
                     kilometres(away) + " from \"" + middle.name + "\" in the middle of the range, expected: at most " +
                     kilometres(range_width_m) + likely_slip(place, middle));
  }
}

/// Paths of the keys that are not at their defaults.
std::set<std::string> changed_keys(const ServiceConfig& config) {
  std::set<std::string> changed;
  for (const Section& section : schema()) {
    const auto values = section.flatten(config);
    for (std::size_t i = 0; i < values.size(); ++i)
      if (values[i].second != section.defaults[i % section.defaults.size()]) changed.insert(values[i].first);
  }
  return changed;
}

/// Keys that somebody changed, to no effect.
class Idle {
 public:
  Idle(const ServiceConfig& config, const Checker& warn) : changed_(changed_keys(config)), warn_(warn) {}

  void add(const std::string& path, const std::string& because) const {
    warn_.require(!changed_.contains(path), path, "has no effect: " + because);
  }
  void add(const std::string& section, std::initializer_list<const char*> keys, const std::string& because) const {
    for (const char* key : keys) add(section + '.' + key, because);
  }

 private:
  std::set<std::string> changed_;
  const Checker& warn_;
};

/// `sensors`: radars, or angles-only trackers.
template <class S>
void warn_of_wander(const std::vector<S>& sensors, const char* table, const Idle& idle, const Checker& warn) {
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const S& sensor = sensors[i];
    if (sensor.wander.sigma_rad == 0) {
      idle.add(entry(table, i, "wander_tau_s"), "wander_deg is 0");
      continue;
    }
    const std::string inflation = entry(table, i, "angle_inflation");
    warn.require(!warn.given(inflation) || sensor.angle_inflation == 1, inflation,
                 "found " + show_number(sensor.angle_inflation) +
                     " beside wander_deg = " + show_number(sensor.wander.sigma_rad / unit_of("_deg").to_si) +
                     ": both stand for the same slow pointing error, which then counts twice; expected: one of them");
  }
}

/// Priors and drifts of terms that the radar's bias does not have, or that a calibration knows better.
void warn_of_bias_sizes(const RadarConfig& radar, std::size_t index, const Idle& idle) {
  struct Size {
    std::string key;
    std::string unit;
    BiasTerm first;  ///< of the terms that it is for: the others come and go with it
    const char* block;
  };
  static const std::array sizes{
      Size{"range", "_m", BiasTerm::OffsetRange, "polar"},
      Size{"angle", "_deg", BiasTerm::OffsetAzimuth, "polar"},
      Size{"range_scale", "", BiasTerm::ScaleRange, "polar"},
      Size{"angle_scale", "", BiasTerm::ScaleAzimuth, "polar"},
      Size{"sez_offset", "_m", BiasTerm::OffsetSouth, "sez_offset"},
      Size{"sez_scale", "", BiasTerm::ScaleSouth, "sez_scale"},
      Size{"time_tag", "_ms", BiasTerm::TimeTag, "time"},
  };
  const std::vector<BiasTerm> of_blocks = bias_model(radar.bias.blocks).terms;
  const std::vector<BiasTerm> modelled = bias_model_of(radar).terms;
  for (const Size& size : sizes) {
    const std::string prior = entry("radar", index, "bias_prior_" + size.key + size.unit);
    const std::string drift = entry("radar", index, "bias_drift_" + size.key + size.unit + "_sqrt_s");
    if (std::ranges::find(modelled, size.first) == modelled.end()) {
      const bool in_blocks = std::ranges::find(of_blocks, size.first) != of_blocks.end();
      const std::string because =
          in_blocks ? "the radar does not measure that" : std::string("bias_blocks is without \"") + size.block + '"';
      idle.add(prior, because);
      idle.add(drift, because);
    } else if (std::ranges::find(radar.bias.calibration.terms, size.first) != radar.bias.calibration.terms.end()) {
      idle.add(prior, "the calibration says what it was");
    }
  }
}

/// Methods beside others that see nothing of some sources.
void warn_of_passing_over(const RangeConfig& range, const Checker& warn) {
  std::string sources;
  for (const Source& source : SourceTable(range))
    if (source.kind != SourceKind::Telemetry && !measures_position(source))
      sources += (sources.empty() ? "" : ", ") + std::string(source.name.view());
  for (const Name& method : range.fuse.methods)
    warn.require(sources.empty() || capabilities_of(method.view()).partial_plots, "fuse.methods",
                 "\"" + std::string(method.view()) + "\" passes over the plots of " + sources +
                     ", for they lack range or angles");
}

/// By some method of fuse.methods.
bool is_used(const RangeConfig& range, bool MethodCapabilities::*part) {
  return std::ranges::any_of(range.fuse.methods,
                             [&](const Name& method) { return capabilities_of(method.view()).*part; });
}

/// Keys for what no method of fuse.methods does.
void warn_of_unused_by_methods(const RangeConfig& range, const Idle& idle) {
  const auto unused = [&](bool MethodCapabilities::*part) { return !is_used(range, part); };
  const std::string because = "no method of fuse.methods uses it";
  const auto sensors_add = [&](const char* table, std::size_t count, const char* key) {
    for (std::size_t i = 0; i < count; ++i) idle.add(entry(table, i, key), because);
  };
  if (unused(&MethodCapabilities::wander)) {
    sensors_add("radar", range.radars.size(), "wander_deg");
    sensors_add("angle_sensor", range.angle_sensors.size(), "wander_deg");
  }
  if (unused(&MethodCapabilities::range_rate)) sensors_add("radar", range.radars.size(), "sigma_range_rate_m_s");
  if (unused(&MethodCapabilities::bias_blocks)) sensors_add("radar", range.radars.size(), "bias_blocks");
  if (unused(&MethodCapabilities::adaptive_noise)) idle.add("fuse", {"adaptive_noise"}, because);
  if (unused(&MethodCapabilities::batch)) idle.add("fuse", {"batch_ms"}, because);
}

void warn_of_idle_keys(const RangeConfig& range, const Idle& idle) {
  if (!range.align.gps.error.enabled)
    idle.add("align", {"gps_error_sigma_m", "gps_error_tau_s"}, "gps_error_states is false");
  if (!range.align.gps.alignment.smooth) idle.add("align", {"smooth_fixes"}, "gps_reference is \"predict\"");
  if (!range.align.gps.no_gps.enabled)
    idle.add("align", {"no_gps_offset_prior_m", "no_gps_angle_prior_deg", "no_gps_wander_deg", "no_gps_wander_tau_s"},
             "no_gps is false");
  if (!range.gps.use.velocity) idle.add("gps", {"sigma_velocity_m_s"}, "use_velocity is false");
  const Kinematics moves = range.fuse.motion.kinematics;
  const bool has_acceleration = model_set(range.fuse.motion).model[0].noise == MotionModel::Noise::WhiteJerk;
  const bool has_white_jerk = is_used(range, &MethodCapabilities::white_jerk);
  const std::string because = "it is not of the kinematics that fuse.kinematics names";
  if (has_acceleration) idle.add("fuse", {"q_cv_m2_s3"}, because);
  if (moves != Kinematics::Ca && moves != Kinematics::Vdie && !has_white_jerk)
    idle.add("fuse", {"q_ca_m2_s5"}, because);
  if (!has_acceleration && !has_white_jerk) idle.add("fuse", {"initial_sigma_acceleration_m_s2"}, because);
  if (moves != Kinematics::Launch)
    idle.add(
        "fuse",
        {"launch_q_ballistic_m2_s5", "launch_ballistic_sigma_m_s2", "launch_q_thrust_m2_s5", "launch_q_event_m2_s5",
         "launch_phase_s", "launch_event_s", "launch_initial_ballistic", "launch_initial_event"},
        because);
  if (!range.integrity.enabled)
    idle.add("integrity", {"rerun_per_tick", "trust", "copy_position_m", "copy_velocity_m_s", "readmit_after_s"},
             "enabled is false");
  if (range.fuse.publish_on_data) idle.add("fuse", {"coast_ms"}, "publish_on_data is true");
}

void warn_of_trust(const RangeConfig& range, const Checker& warn) {
  const SourceTable sources(range);
  std::vector<std::string> known;
  for (const Source& source : sources) known.emplace_back(source.name.view());
  for (const Name& trusted : range.integrity.trust) {
    const std::string name(trusted.view());
    warn.require(sources.find(trusted) != no_source, "integrity.trust",
                 "\"" + name + "\" is no radar, tracker or station of this range, so it is taken as a receiver's name" +
                     suggestion(name, known));
  }
}

void warn_of_times(const RangeConfig& range, const Checker& warn) {
  const auto ms = [](Duration d) { return show_number(1e3 * d.seconds()); };
  warn.require(range.slave.validity >= range.tick, "slave.validity_ms",
               "found " + ms(range.slave.validity) + ", expected: range.tick_ms (" + ms(range.tick) +
                   ") or more, for a command ends before the next one renews it");
}

}  // namespace

void warn_about(const ServiceConfig& config, const toml::table& root, const Report& report) {
  const Checker warn(root, report);
  const Idle idle(config, warn);
  warn_of_sites(root, warn);
  warn_of_wander(config.range.radars, "radar", idle, warn);
  warn_of_wander(config.range.angle_sensors, "angle_sensor", idle, warn);
  for (std::size_t i = 0; i < config.range.radars.size(); ++i) warn_of_bias_sizes(config.range.radars[i], i, idle);
  for (std::size_t i = 0; i < config.range.angle_sensors.size(); ++i)
    if (!config.range.angle_sensors[i].calibration.terms.empty())
      idle.add(entry("angle_sensor", i, "bias_prior_angle_deg"), "the calibration says what it was");
  warn_of_passing_over(config.range, warn);
  warn_of_idle_keys(config.range, idle);
  warn_of_unused_by_methods(config.range, idle);
  warn_of_trust(config.range, warn);
  warn_of_times(config.range, warn);
}

}  // namespace downrange::config
