/// What a configuration may say, but hardly means: keys that cancel each other, or have no effect. Sites:
/// odd_sites.cpp.

#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <downrange/est/method/method_table.hpp>
#include <downrange/stage/source_table.hpp>
#include <numbers>
#include <set>

#include "config/checker.hpp"
#include "config/odd_sites.hpp"

namespace downrange::config {
namespace {

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

/// Keys that somebody changed, to no effect. Each is told once, with the first reason.
class Idle {
 public:
  Idle(const ServiceConfig& config, const Checker& warn) : changed_(changed_keys(config)), warn_(warn) {}

  void add(const std::string& path, const std::string& because) {
    if (changed_.erase(path) > 0) warn_.say(path, "has no effect: " + because);
  }
  void add(const std::string& section, std::initializer_list<const char*> keys, const std::string& because) {
    for (const char* key : keys) add(section + '.' + key, because);
  }

 private:
  std::set<std::string> changed_;
  const Checker& warn_;
};

const std::string unused_by_methods = "no method of fuse.methods uses it";

/// By some method of fuse.methods.
bool is_used(const RangeConfig& range, bool MethodCapabilities::*part) {
  return std::ranges::any_of(range.fuse.methods,
                             [&](const Name& method) { return capabilities_of(method.view()).*part; });
}

/// "radar[0]"
std::string table_of(const char* list, std::size_t index) { return list + ('[' + std::to_string(index) + ']'); }

/// Of what the radar does not measure.
void warn_of_unmeasured(const RadarConfig& radar, std::size_t index, Idle& idle) {
  const std::string because = "the radar does not measure that";
  const std::string table = table_of("radar", index);
  if (!radar.measures.angles)
    idle.add(table,
             {"sigma_azimuth_deg", "sigma_elevation_deg", "azimuth_sigma_on_sky", "angle_inflation", "wander_deg",
              "wander_tau_s", "sigma_azimuth_at_snr_ref_deg", "sigma_elevation_at_snr_ref_deg", "elevation_min_deg",
              "elevation_max_deg"},
             because);
  if (!radar.measures.range)
    idle.add(table, {"sigma_range_m", "sigma_range_at_snr_ref_m", "range_min_m", "range_max_m"}, because);
}

/// A reference without a noise that refers to it.
void warn_of_snr(const RadarConfig& radar, std::size_t index, Idle& idle) {
  const std::string table = table_of("radar", index);
  const bool rates = radar.sigma_range_rate_m_s > 0;
  if (!rates) idle.add(table, {"sigma_range_rate_at_snr_ref_m_s"}, "sigma_range_rate_m_s is 0");
  const PolarSigma& at_ref = radar.snr.at_ref;
  const bool of_range = radar.measures.range && at_ref.range_m > 0;
  const bool of_angles = radar.measures.angles && (at_ref.azimuth_rad > 0 || at_ref.elevation_rad > 0);
  if (!of_range && !of_angles && !(rates && radar.snr.range_rate_at_ref_m_s > 0))
    idle.add(table, {"snr_ref_db"}, "no noise refers to it, sigma_range_at_snr_ref_m or another");
}

/// `sensor`: a radar that measures angles, or an angles-only tracker. `used`: by some method.
template <class S>
void warn_of_wander(const S& sensor, const std::string& table, bool used, Idle& idle, const Checker& warn) {
  if (!used) return idle.add(table, {"wander_deg", "wander_tau_s"}, unused_by_methods);
  if (sensor.wander.sigma_rad == 0) return idle.add(table, {"wander_tau_s"}, "wander_deg is 0");
  const std::string inflation = table + ".angle_inflation";
  warn.require(!warn.given(inflation) || sensor.angle_inflation == 1, inflation,
               "found " + show_number(sensor.angle_inflation) +
                   " beside wander_deg = " + show_number(sensor.wander.sigma_rad / unit_of("_deg").to_si) +
                   ": both stand for the same slow pointing error, which then counts twice; expected: one of them");
}

/// Priors and drifts of terms that the radar's bias does not have, or that a calibration knows better.
void warn_of_bias_sizes(const RadarConfig& radar, std::size_t index, Idle& idle) {
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

/// Keys for what no method of fuse.methods does.
void warn_of_unused_by_methods(const RangeConfig& range, Idle& idle) {
  const auto unused = [&](bool MethodCapabilities::*part) { return !is_used(range, part); };
  const auto add = [&](const std::string& section, std::initializer_list<const char*> keys) {
    idle.add(section, keys, unused_by_methods);
  };
  for (std::size_t i = 0; i < range.radars.size(); ++i) {
    if (unused(&MethodCapabilities::range_rate))
      add(table_of("radar", i), {"sigma_range_rate_m_s", "sigma_range_rate_at_snr_ref_m_s"});
    if (unused(&MethodCapabilities::bias_blocks)) add(table_of("radar", i), {"bias_blocks"});
  }
  if (unused(&MethodCapabilities::adaptive_noise)) add("fuse", {"adaptive_noise"});
  if (unused(&MethodCapabilities::batch)) add("fuse", {"batch_ms"});
  if (unused(&MethodCapabilities::cartesian_bias))
    add("align", {"offset_prior_m", "scale_prior", "window", "offset_drift_m_sqrt_s", "scale_drift_sqrt_s"});
  if (unused(&MethodCapabilities::cartesian_track)) {
    add("align", {"gps_q_m2_s3"});
    add("fuse", {"q_m2_s3"});
  }
  if (unused(&MethodCapabilities::quick_look)) add("fuse", {"alpha_beta_acceleration_m_s2"});
  if (unused(&MethodCapabilities::bias_blocks) && unused(&MethodCapabilities::cartesian_bias))
    add("fuse", {"reopen_after"});
  // INTEGRITY judges by these as well, whatever the methods.
  if (unused(&MethodCapabilities::gps_regimes) && !range.integrity.enabled)
    add("align", {"gps_error_tau_s", "no_gps", "no_gps_offset_prior_m", "no_gps_angle_prior_deg", "no_gps_wander_deg",
                  "no_gps_wander_tau_s"});
}

/// Keys of kinematics that fuse.kinematics does not name, or that no method runs.
void warn_of_kinematics(const RangeConfig& range, Idle& idle) {
  const bool run = std::ranges::any_of(
      range.fuse.methods, [](const Name& method) { return capabilities_of(method.view()).kinematics != 0; });
  const Kinematics moves = range.fuse.motion.kinematics;
  const bool has_acceleration = model_set(range.fuse.motion).model[0].noise == MotionModel::Noise::WhiteJerk;
  const bool has_white_jerk = is_used(range, &MethodCapabilities::white_jerk);
  const std::string because = run ? "it is not of the kinematics that fuse.kinematics names" : unused_by_methods;
  if (!run || has_acceleration) idle.add("fuse", {"q_cv_m2_s3"}, because);
  if (!(run && (moves == Kinematics::Ca || moves == Kinematics::Vdie)) && !has_white_jerk)
    idle.add("fuse", {"q_ca_m2_s5"}, because);
  if (!(run && has_acceleration) && !has_white_jerk) idle.add("fuse", {"initial_sigma_acceleration_m_s2"}, because);
  if (!run || moves != Kinematics::Launch)
    idle.add(
        "fuse",
        {"launch_q_ballistic_m2_s5", "launch_ballistic_sigma_m_s2", "launch_q_thrust_m2_s5", "launch_q_event_m2_s5",
         "launch_phase_s", "launch_event_s", "launch_initial_ballistic", "launch_initial_event"},
        because);
}

void warn_of_idle_keys(const RangeConfig& range, Idle& idle) {
  if (!range.align.gps.error.enabled)
    idle.add("align", {"gps_error_sigma_m", "gps_error_tau_s"}, "gps_error_states is false");
  if (!range.align.gps.alignment.smooth) idle.add("align", {"smooth_fixes"}, "gps_reference is \"predict\"");
  if (!range.align.gps.no_gps.enabled)
    idle.add("align", {"no_gps_offset_prior_m", "no_gps_angle_prior_deg", "no_gps_wander_deg", "no_gps_wander_tau_s"},
             "no_gps is false");
  if (!range.gps.use.velocity) idle.add("gps", {"sigma_velocity_m_s"}, "use_velocity is false");
  if (!range.integrity.enabled)
    idle.add("integrity", {"rerun_per_tick", "trust", "copy_position_m", "copy_velocity_m_s", "readmit_after_s"},
             "enabled is false");
  if (range.fuse.publish_on_data) idle.add("fuse", {"coast_ms"}, "publish_on_data is true");
  if (std::ranges::none_of(range.antennas, [](const AntennaConfig& a) { return a.beamwidth_rad > 0; }))
    idle.add("slave", {"beam_probability_min", "coast_bound_max_deg"}, "no [[antenna]] has a beamwidth_deg");
  if (std::ranges::all_of(range.targets, [](const TargetConfig& t) { return t.nominal.empty(); }))
    idle.add("slave", {"nominal_sigma_m", "nominal_sigma_share"}, "no [[target]] has a nominal trajectory");
  if (range.impact.enabled) return;
  idle.add("impact", {"height_m", "horizon_s", "data_loss_s"}, "enabled is false");
  for (std::size_t i = 0; i < range.boundaries.size(); ++i)
    idle.add(entry("boundary", i, "vertices_deg"), "impact.enabled is false");
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

/// A mount that cannot do what its axes are said to reach.
void warn_of_antennas(const RangeConfig& range, const Checker& warn) {
  for (std::size_t i = 0; i < range.antennas.size(); ++i) {
    const AntennaConfig& a = range.antennas[i];
    warn.require(
        a.elevation_max_rad <= std::numbers::pi / 2 || a.azimuth_acceleration_max_rad_s2 > 0,
        entry("antenna", i, "elevation_max_deg"),
        "found more than 90 without azimuth_acceleration_max_deg_s2: without it passes near the zenith are not "
        "planned, and the antenna goes over it only where its azimuth travel would end otherwise");
  }
}

void warn_of_sensors(const RangeConfig& range, Idle& idle, const Checker& warn) {
  const bool wander = is_used(range, &MethodCapabilities::wander);
  for (std::size_t i = 0; i < range.radars.size(); ++i) {
    const RadarConfig& radar = range.radars[i];
    warn_of_unmeasured(radar, i, idle);
    warn_of_snr(radar, i, idle);
    if (radar.measures.angles) warn_of_wander(radar, table_of("radar", i), wander, idle, warn);
    warn_of_bias_sizes(radar, i, idle);
  }
  for (std::size_t i = 0; i < range.angle_sensors.size(); ++i) {
    const AngleSensorConfig& sensor = range.angle_sensors[i];
    warn_of_wander(sensor, table_of("angle_sensor", i), wander, idle, warn);
    if (!sensor.calibration.terms.empty())
      idle.add(entry("angle_sensor", i, "bias_prior_angle_deg"), "the calibration says what it was");
  }
}

}  // namespace

void warn_about(const ServiceConfig& config, const toml::table& root, const Report& report) {
  const Checker warn(root, report);
  Idle idle(config, warn);
  warn_of_sites(root, warn);
  warn_of_sensors(config.range, idle, warn);
  warn_of_passing_over(config.range, warn);
  warn_of_idle_keys(config.range, idle);
  warn_of_kinematics(config.range, idle);
  warn_of_unused_by_methods(config.range, idle);
  warn_of_trust(config.range, warn);
  warn_of_times(config.range, warn);
  warn_of_antennas(config.range, warn);
}

}  // namespace downrange::config
