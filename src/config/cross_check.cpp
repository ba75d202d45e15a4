#include <algorithm>
#include <cmath>
#include <downrange/est/method/method_table.hpp>
#include <downrange/stage/source_table.hpp>
#include <iterator>
#include <map>
#include <set>

#include "config/checker.hpp"

namespace downrange::config {
namespace {

/// Bits of Trajectory::sources: radars, then angles-only trackers.
constexpr std::size_t max_sensors = 64;

/// Identifiers as they were read, with the path of the first user of each.
class Unique {
 public:
  explicit Unique(const Checker& check) : check_(check) {}

  void add(const Name& name, const std::string& path) {
    if (name.empty()) return;  // missing or not allowed: already reported
    const auto [first, fresh] = first_.try_emplace(name, path);
    check_.require(fresh, path, "found \"" + std::string(name.view()) + "\", already used by " + first->second);
  }

 private:
  const Checker& check_;
  std::map<Name, std::string> first_;
};

template <class List>
void unique_ids(Unique& unique, const List& list, const char* table) {
  for (std::size_t i = 0; i < list.size(); ++i) unique.add(list[i].id, entry(table, i, "id"));
}

void check_identifiers(const RangeConfig& range, const Checker& check) {
  check.require(!range.radars.empty() || !range.angle_sensors.empty() || !range.telemetry.empty(), "radar",
                "missing, required: a source, [[radar]], [[angle_sensor]] or [[telemetry]]");
  Unique targets(check);
  Unique sensors(check);  // radars, trackers and stations share sensor_id of downrange/observation
  Unique antennas(check);
  unique_ids(targets, range.targets, "target");
  unique_ids(sensors, range.radars, "radar");
  unique_ids(sensors, range.angle_sensors, "angle_sensor");
  unique_ids(sensors, range.telemetry, "telemetry");
  unique_ids(antennas, range.antennas, "antenna");
  check.require(range.radars.size() <= max_sensors, "radar",
                "found " + std::to_string(range.radars.size()) + " radars, allowed: at most 64");
  const std::size_t sensors_in_all = range.radars.size() + range.angle_sensors.size();
  check.require(range.radars.size() > max_sensors || sensors_in_all <= max_sensors, "angle_sensor",
                "found " + std::to_string(sensors_in_all) + " radars and angle sensors, allowed: at most 64 together");
}

/// `low` < `high`, in the same unit.
void ordered(const Checker& check, double low, double high, const std::string& high_path, const char* low_key) {
  const double to_si = unit_of(high_path).to_si;
  check.require(
      low < high, high_path,
      "found " + show_number(high / to_si) + ", allowed: more than " + low_key + " (" + show_number(low / to_si) + ")");
}

void check_calibration(const BiasCalibration& calibration, const BiasModel& model, const std::string& path,
                       const std::string& allowed, const Checker& check) {
  for (const BiasTerm term : calibration.terms)
    check.require(std::ranges::find(model.terms, term) != model.terms.end(), path,
                  "found a calibration of " + std::string(to_string(term)) + ", allowed: " + allowed);
}

/// The noise of what a radar measures.
void check_noise(const RadarConfig& radar, std::size_t i, const Checker& check) {
  const auto needs = [&](const char* key, bool measured, const char* part) {
    const std::string path = entry("radar", i, key);
    check.require(
        !measured || check.given(path), path,
        "missing, required: the noise of what the radar measures (measures has \"" + std::string(part) + "\")");
  };
  needs("sigma_range_m", radar.measures.range, "range");
  needs("sigma_azimuth_deg", radar.measures.angles, "angles");
  needs("sigma_elevation_deg", radar.measures.angles, "angles");
}

/// The sensor on an antenna's mount is on that mount alone, and stands where it stands.
void check_mount(const RangeConfig& range, std::size_t i, const Checker& check) {
  constexpr double same_mount_m = 100;
  const AntennaConfig& a = range.antennas[i];
  if (a.sensor.empty()) return;
  const std::string path = entry("antenna", i, "sensor");
  const std::string found = "found \"" + std::string(a.sensor.view()) + "\", allowed: ";
  const auto tracker = std::ranges::find(range.angle_sensors, a.sensor, &AngleSensorConfig::id);
  const auto radar = std::ranges::find(range.radars, a.sensor, &RadarConfig::id);
  const bool measures = tracker != range.angle_sensors.end() || (radar != range.radars.end() && radar->measures.angles);
  check.require(measures, path, found + "the id of an [[angle_sensor]] or of a [[radar]] that measures angles");
  check.require(!a.moves, path, found + "no sensor where the antenna moves");
  if (!measures) return;
  for (std::size_t k = 0; k < i; ++k)
    check.require(range.antennas[k].sensor != a.sensor, path,
                  found + "a sensor that is not on the mount of antenna " + std::string(range.antennas[k].id.view()));
  const Site& site = tracker != range.angle_sensors.end() ? tracker->site : radar->site;
  const double apart_m = (site.ecef().m - a.site.ecef().m).norm();
  check.require(apart_m <= same_mount_m, path,
                found + "a sensor within 100 m of the antenna (it is " + show_number(std::round(apart_m)) + " m away)");
}

void check_instruments(const RangeConfig& range, const Checker& check) {
  for (std::size_t i = 0; i < range.radars.size(); ++i) {
    const RadarConfig& r = range.radars[i];
    check_noise(r, i, check);
    ordered(check, r.range_min_m, r.range_max_m, entry("radar", i, "range_max_m"), "range_min_m");
    ordered(check, r.elevation_min_rad, r.elevation_max_rad, entry("radar", i, "elevation_max_deg"),
            "elevation_min_deg");
    check_calibration(r.bias.calibration, bias_model_of(r), entry("radar", i, "calibration"),
                      "terms of the blocks in bias_blocks that belong to what it measures", check);
  }
  for (std::size_t i = 0; i < range.angle_sensors.size(); ++i) {
    const AngleSensorConfig& s = range.angle_sensors[i];
    ordered(check, s.elevation_min_rad, s.elevation_max_rad, entry("angle_sensor", i, "elevation_max_deg"),
            "elevation_min_deg");
    check_calibration(s.calibration, bias_model_of(s), entry("angle_sensor", i, "calibration"),
                      "offset_azimuth, offset_elevation", check);
  }
  for (std::size_t i = 0; i < range.antennas.size(); ++i) {
    const AntennaConfig& a = range.antennas[i];
    const bool known =
        a.target.empty() || std::ranges::find(range.targets, a.target, &TargetConfig::id) != range.targets.end();
    check.require(known, entry("antenna", i, "target"),
                  "found \"" + std::string(a.target.view()) + "\", allowed: the id of a [[target]]");
    check_mount(range, i, check);
    ordered(check, a.azimuth_min_rad, a.azimuth_max_rad, entry("antenna", i, "azimuth_max_deg"), "azimuth_min_deg");
    ordered(check, a.elevation_min_rad, a.elevation_max_rad, entry("antenna", i, "elevation_max_deg"),
            "elevation_min_deg");
  }
}

std::string milliseconds_text(Duration d) { return show_number(static_cast<double>(d.ns) * 1e-6); }

void check_times(const RangeConfig& range, const Checker& check) {
  constexpr std::int64_t second = 1'000'000'000;
  check.require(second % range.tick.ns == 0, "range.tick_ms",
                "found " + milliseconds_text(range.tick) +
                    ", allowed: a whole part of one second (1, 5, 10, 20, 25, 50, 100 ...)");
  const std::string batch = "found " + milliseconds_text(range.fuse.cartesian_fusion.batch) + ", allowed: ";
  check.require(range.fuse.cartesian_fusion.batch.ns % range.tick.ns == 0, "fuse.batch_ms",
                batch + "a multiple of range.tick_ms (" + milliseconds_text(range.tick) + ")");
  check.require(range.fuse.arbitration.history >= range.fuse.cartesian_fusion.batch, "fuse.history_s",
                "found " + show_number(range.fuse.arbitration.history.seconds()) + ", allowed: fuse.batch_ms (" +
                    milliseconds_text(range.fuse.cartesian_fusion.batch) + " ms) or more");
  const auto coasts_after_stale = [&](Duration stale, Duration coast, const std::string& table) {
    check.require(coast >= stale, table + ".coast_ms",
                  "found " + milliseconds_text(coast) + ", allowed: " + table + ".stale_ms (" +
                      milliseconds_text(stale) + ") or more");
  };
  coasts_after_stale(range.fuse.stale, range.fuse.coast, "fuse");
  coasts_after_stale(range.slave.stale, range.slave.coast, "slave");
}

void check_capabilities(const RangeConfig& range, const std::string& method, const MethodCapabilities& capabilities,
                        const Checker& check) {
  const auto most = static_cast<std::size_t>(capabilities.most_radars);
  check.require(range.radars.size() <= most || range.radars.size() > max_sensors, "fuse.methods",
                "found \"" + method + "\" with " + std::to_string(range.radars.size()) + " radars, allowed: at most " +
                    std::to_string(most) + " [[radar]] for that method");
  std::vector<std::string> allowed;
  for (const Kinematics kinematics : all_kinematics)
    if (capabilities.allows(kinematics)) allowed.emplace_back(to_string(kinematics));
  check.require(capabilities.allows(range.fuse.motion.kinematics), "fuse.kinematics",
                "found \"" + std::string(to_string(range.fuse.motion.kinematics)) + "\", which method \"" + method +
                    "\" does not support, allowed: one of " + show_texts(allowed));
}

/// Sources whose plots lack range or angles, and receivers alone, are of use to some methods only.
void check_partial_plots(const RangeConfig& range, const std::vector<std::string>& known, const Checker& check) {
  const auto uses = [](const std::string& name) { return capabilities_of(name).partial_plots; };
  const bool used = std::ranges::any_of(range.fuse.methods, [&](const Name& method) {
    const std::string name(method.view());
    return std::ranges::find(known, name) == known.end() || uses(name);
  });
  std::vector<std::string> users;
  std::ranges::copy_if(known, std::back_inserter(users), uses);
  const auto require_user = [&](bool there, const char* what) {
    check.require(
        !there || used, "fuse.methods",
        std::string("found no method that uses ") + what + ", allowed: beside others one of " + show_texts(users));
  };
  require_user(!range.angle_sensors.empty(), "[[angle_sensor]]");
  require_user(std::ranges::any_of(range.radars, [](const RadarConfig& r) { return r.measures != MeasuredParts{}; }),
               "a [[radar]] without range or angles");
  require_user(range.radars.empty() && range.angle_sensors.empty() && !range.telemetry.empty(), "[[telemetry]] alone");
}

/// What is asked for and no method takes. What holds by default is not asked for, though a file may say it.
void check_asked_for(const RangeConfig& range, const std::vector<std::string>& known, const Checker& check) {
  const auto require_taker = [&](const std::string& path, const std::string& asked, const auto& takes) {
    const auto method_takes = [&](const Name& method) { return takes(capabilities_of(method.view())); };
    std::vector<std::string> takers;
    std::ranges::copy_if(known, std::back_inserter(takers),
                         [&](const std::string& name) { return takes(capabilities_of(name)); });
    check.require(std::ranges::any_of(range.fuse.methods, method_takes), path,
                  "found \"" + asked + "\", which no method of fuse.methods takes, allowed: beside others one of " +
                      show_texts(takers));
  };
  if (range.align.gps.alignment.smooth)
    require_taker("align.gps_reference", "smooth", [](const MethodCapabilities& c) { return c.smoothed_gps; });
  const Kinematics wanted = range.fuse.motion.kinematics;
  if (wanted != KinematicsSettings{}.kinematics)
    require_taker("fuse.kinematics", std::string(to_string(wanted)),
                  [&](const MethodCapabilities& c) { return c.kinematics != 0 && c.allows(wanted); });
}

void check_methods(const RangeConfig& range, const Checker& check) {
  const FuseConfig& fuse = range.fuse;
  const std::vector<std::string> known(method_names().begin(), method_names().end());
  check.require(!fuse.methods.empty(), "fuse.methods", "found [], allowed: one or more of " + show_texts(known));
  std::set<Name> seen;
  for (const Name& method : fuse.methods) {
    const std::string name(method.view());
    const bool is_known = std::ranges::find(known, name) != known.end();
    check.require(is_known, "fuse.methods",
                  "found \"" + name + "\", allowed: one or more of " + show_texts(known) + suggestion(name, known));
    check.require(seen.insert(method).second, "fuse.methods",
                  "found \"" + name + "\" twice, allowed: each method once");
    if (is_known) check_capabilities(range, name, capabilities_of(name), check);
  }
  check_partial_plots(range, known, check);
  const auto is_known = [&](const Name& method) { return std::ranges::find(known, method.view()) != known.end(); };
  if (std::ranges::all_of(fuse.methods, is_known)) check_asked_for(range, known, check);
}

void check_boundaries(const RangeConfig& range, const Checker& check) {
  check.require(
      range.boundaries.size() <= max_boundaries, "boundary",
      "found " + std::to_string(range.boundaries.size()) + ", allowed: at most " + std::to_string(max_boundaries));
  Unique boundaries(check);
  unique_ids(boundaries, range.boundaries, "boundary");
  for (std::size_t i = 0; i < range.boundaries.size(); ++i) {
    const std::string path = entry("boundary", i, "vertices_deg");
    if (range.boundaries[i].vertices.empty()) continue;  // missing or not allowed: already reported
    const std::string defect = GroundPolygon::defect_of(range.boundaries[i].vertices);
    check.require(defect.empty(), path, "found " + defect + "; allowed: a simple polygon");
  }
}

void check_node(const ServiceConfig& config, const Checker& check) {
  const StageSet& s = config.node.stages;
  check.require(
      s.align == s.fuse && (s.fuse || !s.slave) && (s.ingest || s.fuse), "node.stages",
      R"(allowed: align and fuse together, slave only with them, e.g. ["ingest"] or ["align", "fuse", "slave"])");
  const SourceTable sources(config.range);
  std::vector<std::string> known;
  for (const Source& source : sources) known.emplace_back(source.name.view());
  for (const Name& source : config.node.sources) {
    const std::string name(source.view());
    check.require(sources.find(source) != no_source, "node.sources",
                  "found \"" + name + "\", allowed: ids of [[radar]], [[angle_sensor]] and [[telemetry]]" +
                      suggestion(name, known));
  }
  check.require(!config.archive.enabled || !config.archive.directory.empty(), "archive.directory",
                "missing, required where archive.enabled is true");
  // Where ingest runs, the list is for the nodes without it that share the file; without [dds] nothing listens.
  const bool listens = !s.ingest && !config.dds.profiles.empty();
  check.require(!listens || !config.dds.ingest_nodes.empty(), "dds.ingest_nodes",
                "found [], allowed: one node or more where node.stages is without \"ingest\"");
  std::set<Name> nodes;
  for (const Name& node : config.dds.ingest_nodes) {
    check.require(nodes.insert(node).second && !(listens && node == config.node.id), "dds.ingest_nodes",
                  "found \"" + std::string(node.view()) + "\", allowed: each node once, without this node itself");
  }
}

/// A rotator turns one antenna.
void check_rotators(const ServiceConfig& config, const Checker& check) {
  std::map<std::pair<std::string, int>, std::string> users;
  for (const RotctlConfig& rotctl : config.rotctl) {
    const auto antenna = std::ranges::find(config.range.antennas, rotctl.antenna, &AntennaConfig::id);
    const auto index = static_cast<std::size_t>(antenna - config.range.antennas.begin());
    const auto [first, fresh] = users.try_emplace({rotctl.host, rotctl.port}, entry("antenna", index, "rotctl"));
    check.require(
        fresh, entry("antenna", index, "rotctl.port"),
        "found " + std::to_string(rotctl.port) + " of \"" + rotctl.host + "\", already used by " + first->second);
  }
}

}  // namespace

void cross_check(const ServiceConfig& config, const toml::table& root, const Report& report) {
  const Checker check(root, report);
  check_identifiers(config.range, check);
  check_instruments(config.range, check);
  check_times(config.range, check);
  check_boundaries(config.range, check);
  check_methods(config.range, check);
  check_rotators(config, check);
  check_node(config, check);
}

}  // namespace downrange::config
