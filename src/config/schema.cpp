#include "config/schema.hpp"

#include <algorithm>
#include <cmath>
#include <downrange/est/method/method.hpp>
#include <iterator>

#include "config/calibration.hpp"
#include "config/nominal.hpp"
#include "config/section.hpp"

namespace downrange::config {
namespace {

/// Which stages run, as a list of their names.
Key<NodeConfig> stages_key() {
  static const std::vector<std::pair<std::string, bool StageSet::*>> names{{"ingest", &StageSet::ingest},
                                                                           {"align", &StageSet::align},
                                                                           {"fuse", &StageSet::fuse},
                                                                           {"slave", &StageSet::slave}};
  return {{"stages", R"(a list out of "ingest", "align", "fuse", "slave")", optional,
           "stages this node runs; without ingest it reads the observations of other nodes"},
          [](NodeConfig& node, const toml::node& value) {
            const auto texts = read_texts(value);
            if (!texts || texts->empty()) return false;
            StageSet stages{false, false, false, false};
            for (const std::string& text : *texts) {
              const auto known = std::ranges::find(names, text, &std::pair<std::string, bool StageSet::*>::first);
              if (known == names.end()) return false;
              stages.*known->second = true;
            }
            node.stages = stages;
            return true;
          },
          [](const NodeConfig& node) {
            std::vector<std::string> texts;
            for (const auto& [text, member] : names) {
              if (node.stages.*member) texts.push_back(text);
            }
            return show_texts(texts);
          }};
}

/// Blocks of a radar's bias, as a list of their names.
Key<RadarConfig> bias_blocks_key() {
  static const std::vector<std::pair<std::string, BiasBlock>> names{{"polar", BiasBlock::Polar},
                                                                    {"sez_offset", BiasBlock::SezOffset},
                                                                    {"sez_scale", BiasBlock::SezScale},
                                                                    {"time", BiasBlock::Time}};
  return {{"bias_blocks", R"(a list out of "polar", "sez_offset", "sez_scale", "time", each once, one or more)",
           optional, "what the radar's bias is made of (joint, schmidt, ts)"},
          [](RadarConfig& radar, const toml::node& value) {
            const auto texts = read_texts(value);
            if (!texts || texts->empty()) return false;
            std::vector<BiasBlock> blocks;
            for (const std::string& text : *texts) {
              const auto known = std::ranges::find(names, text, &std::pair<std::string, BiasBlock>::first);
              if (known == names.end() || std::ranges::find(blocks, known->second) != blocks.end()) return false;
              blocks.push_back(known->second);
            }
            radar.bias.blocks = std::move(blocks);
            return true;
          },
          [](const RadarConfig& radar) {
            std::vector<std::string> texts;
            for (const BiasBlock block : radar.bias.blocks)
              texts.push_back(std::ranges::find(names, block, &std::pair<std::string, BiasBlock>::second)->first);
            return show_texts(texts);
          }};
}

/// What a radar measures, as a list.
Key<RadarConfig> measures_key() {
  return {{"measures", R"(a list out of "range", "angles", each once, one or more)", optional,
           "what is used of its plots; without range it is a tracker, without angles it needs other sources to start "
           "(joint, schmidt, ts; other methods pass over plots that lack a part)"},
          [](RadarConfig& radar, const toml::node& value) {
            const auto texts = read_texts(value);
            if (!texts || texts->empty()) return false;
            const auto count = [&](const std::string& part) { return std::ranges::count(*texts, part); };
            const auto range = count("range");
            const auto angles = count("angles");
            if (range > 1 || angles > 1 || range + angles != std::ssize(*texts)) return false;
            radar.measures = {.range = range > 0, .angles = angles > 0};
            return true;
          },
          [](const RadarConfig& radar) {
            std::vector<std::string> texts;
            if (radar.measures.range) texts.emplace_back("range");
            if (radar.measures.angles) texts.emplace_back("angles");
            return show_texts(texts);
          }};
}

/// Priors or drifts of a radar's bias: `suffix` is what a drift's unit adds.
void add_bias_sizes(std::vector<Key<RadarConfig>>& keys, const std::string& head, BiasSizes BiasConfig::*sizes,
                    const std::string& suffix, double least, const std::string& help) {
  const auto add = [&](const char* name, double BiasSizes::*size, double most, const char* what) {
    keys.push_back(number(head + name + suffix, at(&RadarConfig::bias, sizes, size), {least, most}, optional,
                          std::string(what) + ": " + help));
  };
  add("range_m", &BiasSizes::range_m, 1e5, "offset of range, block polar");
  add("angle_deg", &BiasSizes::angle_rad, 20, "offsets of azimuth and elevation, block polar");
  add("range_scale", &BiasSizes::range_scale, 1, "scale of range, block polar");
  add("angle_scale", &BiasSizes::angle_scale, 1, "scales of azimuth and elevation, block polar");
  add("sez_offset_m", &BiasSizes::sez_offset_m, 1e5, "offsets south, east, zenith, block sez_offset");
  add("sez_scale", &BiasSizes::sez_scale, 1, "scales south, east, zenith, block sez_scale");
  add("time_tag_ms", &BiasSizes::time_tag_s, 1e4, "time tag, block time");
}

/// A calibration's table; load puts it where the file has the name of another file.
template <class S>
Key<S> calibration_key(Field<S, BiasCalibration> field, const std::string& methods) {
  return {{"calibration", "the path of a file as downrange report --calibration writes it, or its table of this sensor",
           optional, "prior of the bias from an earlier flight, relative to this file; \"\": none (" + methods + ')'},
          [field](S& sensor, const toml::node& value) {
            if (value.is_string()) return true;  // "", or a problem that load has reported
            const toml::table* table = value.as_table();
            if (table == nullptr) return false;
            const auto calibration = read_calibration(*table, "", [](auto&&...) {});
            if (calibration) field.set(sensor, *calibration);
            return calibration.has_value();
          },
          [field](const S& sensor) {
            const BiasCalibration calibration = field.get(sensor);
            std::string text;
            for (std::size_t i = 0; i < calibration.terms.size(); ++i) {
              const auto k = static_cast<Eigen::Index>(i);
              text += (i == 0 ? "" : ", ") + std::string(to_string(calibration.terms[i])) + ' ' +
                      show_number(calibration.mean[k]) + " +- " + show_number(std::sqrt(calibration.cov(k, k)));
            }
            return show_text(text);
          }};
}

/// Of a target: a file that load has read into rows, or these.
Key<TargetConfig> nominal_key() {
  return {{"nominal", "the path of a CSV file, or rows of t, x, y, z, vx, vy, vz in SI units", optional,
           "planned trajectory by time after lift-off, relative to this file; \"\": none; " + nominal_columns_help()},
          [](TargetConfig& target, const toml::node& value) {
            if (value.is_string()) return true;  // "", or a problem that load has reported
            const toml::array* rows = value.as_array();
            auto nominal = rows == nullptr ? std::nullopt : nominal_from(*rows);
            if (nominal) target.nominal = std::move(*nominal);
            return nominal.has_value();
          },
          [](const TargetConfig& target) { return show_text(show_nominal(target.nominal)); }};
}

/// A key that load reads itself, before the tables are read, to put a file in its place.
Key<TargetConfig> told_to_load(std::string name, std::string allowed, std::string help) {
  return {{std::move(name), std::move(allowed), optional, std::move(help)},
          [](TargetConfig&, const toml::node& value) { return read_text(value) || read_texts(value); },
          [](const TargetConfig&) { return show_text(""); }};
}

std::vector<Key<RadarConfig>> bias_keys() {
  std::vector<Key<RadarConfig>> keys{
      bias_blocks_key(), calibration_key(at(&RadarConfig::bias, &BiasConfig::calibration), "joint, schmidt, ts")};
  add_bias_sizes(keys, "bias_prior_", &BiasConfig::prior, "", 1e-9, "1-sigma before any data");
  add_bias_sizes(keys, "bias_drift_", &BiasConfig::drift, "_sqrt_s", 0, "random walk");
  return keys;
}

std::vector<std::pair<std::string_view, Kinematics>> kinematics_names() {
  std::vector<std::pair<std::string_view, Kinematics>> names;
  for (const Kinematics kinematics : all_kinematics) names.emplace_back(to_string(kinematics), kinematics);
  return names;
}

std::string methods_help() {
  return "methods that run side by side, antennas are pointed by the first; known: " +
         show_texts({method_names().begin(), method_names().end()});
}

/// What radars and angles-only trackers have in common beside their noise.
template <class S>
std::vector<Key<S>> pointing_keys() {
  return {
      flag("azimuth_sigma_on_sky", at(&S::azimuth_sigma_on_sky), optional,
           "true: sigma_azimuth_deg is on the sky, the axis's own noise is that over cos(elevation)"),
      number("angle_inflation", at(&S::angle_inflation), {1, 1000}, optional,
             "factor on the angle variances, for slow pointing errors"),
      number("wander_deg", at(&S::wander, &PointingWander::sigma_rad), {0, 20}, optional,
             "slowly varying pointing error of each axis, 1-sigma, estimated (joint, schmidt); 0: none"),
      number("wander_tau_s", at(&S::wander, &PointingWander::tau_s), {0.1, 1e5}, optional,
             "correlation time of that error"),
      number("rate_hz", at(&S::rate_hz), {0.01, 1000}, optional, "nominal plot rate"),
      number("elevation_min_deg", at(&S::elevation_min_rad), {-90, 90}, optional, "plots lower than this are rejected"),
      number("elevation_max_deg", at(&S::elevation_max_rad), {-90, 90}, optional,
             "plots higher than this are rejected"),
      number("refractivity_n", at(&S::refractivity), {0, 500}, optional,
             "refractivity of the air at the site; 0: plots are free of refraction, or corrected already"),
  };
}

template <class S>
std::vector<Key<S>> with_site(std::vector<Key<S>> first, std::vector<Key<S>> rest) {
  first.push_back(number("latitude_deg", at(&S::site, &Geodetic::latitude_rad), {-90, 90}, required,
                         "WGS-84 geodetic latitude, north positive"));
  first.push_back(number("longitude_deg", at(&S::site, &Geodetic::longitude_rad), {-180, 360}, required,
                         "WGS-84 longitude, east positive"));
  first.push_back(number("height_m", at(&S::site, &Geodetic::height_m), {-500, 10'000}, required,
                         "height above the WGS-84 ellipsoid (not above sea level)"));
  first.insert(first.end(), rest.begin(), rest.end());
  return first;
}

constexpr double huge = 1e9;

Section range_section() {
  using R = RangeConfig;
  return single<R>(
      "range", "The range as a whole.", [](ServiceConfig& c) -> R& { return c.range; },
      {
          id("name", at(&R::name), required, "name of the range, also of its archives"),
          span("tick_ms", at(&R::tick), {1, 1000}, optional, "slaving interval on the UTC grid; divides one second"),
          integer("leap_seconds", at(&R::leap_seconds), {0, 100}, optional, "GPS time minus UTC, s"),
      });
}

Section target_section() {
  using T = TargetConfig;
  return many<T>("target", 1, "A vehicle to be tracked.",
                 [](ServiceConfig& c) -> std::vector<T>& { return c.range.targets; },
                 {
                     id("id", at(&T::id), required, "target_id on the topics"),
                     nominal_key(),
                     told_to_load("nominal_object", "text",
                                  "its rows in that file, where a column object tells several apart; default: the id"),
                     told_to_load("nominal_columns", "a list of names of columns, \"-\" for what is not read",
                                  "of that file in their order, where its first line has others or none"),
                 });
}

Section radar_section() {
  using R = RadarConfig;
  std::vector<Key<R>> keys{
      measures_key(),
      number("sigma_range_m", at(&R::sigma, &PolarSigma::range_m), {1e-3, 1e5}, optional,
             "instrument noise in range, 1-sigma; required where range is measured"),
      number("sigma_azimuth_deg", at(&R::sigma, &PolarSigma::azimuth_rad), {1e-6, 20}, optional,
             "instrument noise in azimuth, 1-sigma; required where angles are measured"),
      number("sigma_elevation_deg", at(&R::sigma, &PolarSigma::elevation_rad), {1e-6, 20}, optional,
             "instrument noise in elevation, 1-sigma; likewise"),
      number(
          "sigma_range_rate_m_s", at(&R::sigma_range_rate_m_s), {0, 1e4}, optional,
          "noise of range rate, 1-sigma, what is not known of its offset included (joint, schmidt, ts); 0: not used"),
      number(
          "snr_ref_db", at(&R::snr, &SnrNoise::ref_db), {-100, 200}, optional,
          "signal-to-noise ratio of the next four: variance = sigma^2 + sigma_at_snr_ref^2 * 10^((snr_ref - snr)/10); "
          "a plot without it counts as one of this ratio"),
      number("sigma_range_at_snr_ref_m", at(&R::snr, &SnrNoise::at_ref, &PolarSigma::range_m), {0, 1e5}, optional,
             "noise of range by the signal; 0: none"),
      number("sigma_azimuth_at_snr_ref_deg", at(&R::snr, &SnrNoise::at_ref, &PolarSigma::azimuth_rad), {0, 20},
             optional, "likewise of azimuth"),
      number("sigma_elevation_at_snr_ref_deg", at(&R::snr, &SnrNoise::at_ref, &PolarSigma::elevation_rad), {0, 20},
             optional, "likewise of elevation"),
      number("sigma_range_rate_at_snr_ref_m_s", at(&R::snr, &SnrNoise::range_rate_at_ref_m_s), {0, 1e4}, optional,
             "likewise of range rate"),
      number("range_min_m", at(&R::range_min_m), {0, huge}, optional, "plots nearer than this are rejected"),
      number("range_max_m", at(&R::range_max_m), {1, huge}, optional, "plots farther than this are rejected"),
  };
  std::ranges::copy(pointing_keys<R>(), std::back_inserter(keys));
  std::ranges::copy(bias_keys(), std::back_inserter(keys));
  return many<R>(
      "radar", 0, "A tracking radar.", [](ServiceConfig& c) -> std::vector<R>& { return c.range.radars; },
      with_site<R>({id("id", at(&R::id), required, "sensor_id on the topics")}, std::move(keys)));
}

Section angle_sensor_section() {
  using A = AngleSensorConfig;
  std::vector<Key<A>> keys{
      number("sigma_azimuth_deg", at(&A::sigma_azimuth_rad), {1e-6, 20}, required,
             "instrument noise in azimuth, 1-sigma"),
      number("sigma_elevation_deg", at(&A::sigma_elevation_rad), {1e-6, 20}, required,
             "instrument noise in elevation, 1-sigma"),
  };
  std::ranges::copy(pointing_keys<A>(), std::back_inserter(keys));
  keys.push_back(number("bias_prior_angle_deg", at(&A::bias_prior_rad), {1e-9, 20}, optional,
                        "offsets of azimuth and elevation: 1-sigma before any data"));
  keys.push_back(number("bias_drift_angle_deg_sqrt_s", at(&A::bias_drift_rad_sqrt_s), {0, 20}, optional,
                        "offsets of azimuth and elevation: random walk"));
  keys.push_back(calibration_key(at(&A::calibration), "joint, schmidt, ts"));
  return many<A>(
      "angle_sensor", 0,
      "A telemetry antenna or optical tracker that reports the direction it tracks (joint, schmidt, ts).",
      [](ServiceConfig& c) -> std::vector<A>& { return c.range.angle_sensors; },
      with_site<A>({id("id", at(&A::id), required, "sensor_id on the topics")}, std::move(keys)));
}

Section telemetry_section() {
  using T = TelemetryConfig;
  return many<T>(
      "telemetry", 0, "A telemetry ground station that relays the vehicle's GPS fixes.",
      [](ServiceConfig& c) -> std::vector<T>& { return c.range.telemetry; },
      with_site<T>({id("id", at(&T::id), required, "station_id on the topics")}, {}));
}

Section antenna_section() {
  using A = AntennaConfig;
  return many<A>(
      "antenna", 0, "An antenna or optical tracker to be pointed.",
      [](ServiceConfig& c) -> std::vector<A>& { return c.range.antennas; },
      with_site<A>({id("id", at(&A::id), required, "antenna_id on the topics"),
                    id("target", at(&A::target), optional, "id of the target it follows; left out: the first")},
                   {
                       number("azimuth_min_deg", at(&A::azimuth_min_rad), {-1080, 1080}, optional,
                              "lower end of the azimuth travel, cable wrap included"),
                       number("azimuth_max_deg", at(&A::azimuth_max_rad), {-1080, 1080}, optional,
                              "upper end of the azimuth travel"),
                       number("elevation_min_deg", at(&A::elevation_min_rad), {-90, 180}, optional,
                              "lower end of the elevation travel"),
                       number("elevation_max_deg", at(&A::elevation_max_rad), {-90, 180}, optional,
                              "upper end of the elevation travel"),
                       number("azimuth_rate_max_deg_s", at(&A::azimuth_rate_max_rad_s), {1e-3, 360}, optional,
                              "fastest the azimuth axis turns"),
                       number("elevation_rate_max_deg_s", at(&A::elevation_rate_max_rad_s), {1e-3, 360}, optional,
                              "fastest the elevation axis turns"),
                       span("link_delay_ms", at(&A::link_delay), {0, 10'000}, required,
                            "from the node to the antenna's control unit"),
                       span("lead_ms", at(&A::lead), {0, 10'000}, required, "lag of the servo, to be led"),
                   }));
}

Section gps_section() {
  using G = GpsConfig;
  return single<G>("gps", "The vehicle's receiver; where a message states that it is worse, it is.",
                   [](ServiceConfig& c) -> G& { return c.range.gps; },
                   {
                       number("sigma_horizontal_m", at(&G::sigma_horizontal_m), {1e-3, 1e5}, optional,
                              "horizontal position noise, 1-sigma per axis"),
                       number("sigma_vertical_m", at(&G::sigma_vertical_m), {1e-3, 1e5}, optional,
                              "vertical position noise, 1-sigma"),
                       number("sigma_velocity_m_s", at(&G::sigma_velocity_m_s), {1e-4, 1e4}, optional,
                              "velocity noise, 1-sigma per axis"),
                       flag("use_velocity", at(&G::use, &GpsUseSettings::velocity), optional,
                            "use the velocity of fixes that have one"),
                       integer("min_satellites", at(&G::min_satellites), {0, 64}, optional,
                               "fixes that state fewer satellites, or none, are rejected"),
                   });
}

Section pad_section() {
  using P = PadConfig;
  return absent_or_single<P>(
      "pad", "Where the vehicle stands until lift-off (topic range/mission, else its first motion).",
      [](ServiceConfig& c) -> std::optional<P>& { return c.range.pad; },
      with_site<P>({}, {number("radius_m", at(&P::radius_m), {10, 1e6}, optional,
                               "before lift-off, fixes farther from the pad than this are rejected")}));
}

Section ingest_section() {
  using I = IngestConfig;
  return single<I>("ingest", "Which input is let in.", [](ServiceConfig& c) -> I& { return c.range.ingest; },
                   {
                       span("max_future_ms", at(&I::max_future), {0, 60'000}, optional,
                            "an epoch later than its reception by more than this is rejected"),
                       flag("expect_simulated", at(&I::expect_simulated), optional,
                            "the 'simulated' flag that every input must carry: false in operations"),
                   });
}

Section align_section() {
  using A = AlignConfig;
  return single<A>(
      "align", "Estimation of the radars' biases.", [](ServiceConfig& c) -> A& { return c.range.align; },
      {
          flag("gps_error_states", at(&A::gps, &GpsSettings::error, &GpsErrorModel::enabled), optional,
               "the receiver's position has a slowly varying error that is estimated (joint, schmidt, ts)"),
          number("gps_error_sigma_m", at(&A::gps, &GpsSettings::error, &GpsErrorModel::sigma_m), {1e-3, 1e4}, optional,
                 "size of that error, 1-sigma per axis; rather too large than too small"),
          number("gps_error_tau_s", at(&A::gps, &GpsSettings::error, &GpsErrorModel::tau_s), {0.1, 1e5}, optional,
                 "correlation time of that error"),
          choice<A, bool>("gps_reference", at(&A::gps, &GpsSettings::alignment, &GpsAlignment::smooth),
                          {{"predict", false}, {"smooth", true}}, optional,
                          "GPS at a plot's epoch: predicted from the fixes before it, or smoothed by later ones, which "
                          "the plot waits for (schmidt, song2015, track-level rules)"),
          integer("smooth_fixes", at(&A::gps, &GpsSettings::alignment, &GpsAlignment::fixes), {1, 9}, optional,
                  "later fixes that a smoothed plot waits for"),
          flag("no_gps", at(&A::gps, &GpsSettings::no_gps, &NoGpsRegime::enabled), optional,
               "until a target's first fix: smaller biases, wandering pointing (joint, schmidt, ts)"),
          number("no_gps_offset_prior_m", at(&A::gps, &GpsSettings::no_gps, &NoGpsRegime::offset_prior_m), {1e-3, 1e5},
                 optional, "what an offset of range may be in that regime, 1-sigma"),
          number("no_gps_angle_prior_deg", at(&A::gps, &GpsSettings::no_gps, &NoGpsRegime::angle_prior_rad), {1e-6, 20},
                 optional, "what an offset of an angle may be in that regime, 1-sigma"),
          number("no_gps_wander_deg",
                 at(&A::gps, &GpsSettings::no_gps, &NoGpsRegime::wander, &PointingWander::sigma_rad), {1e-6, 20},
                 optional, "slowly varying pointing error in that regime, 1-sigma"),
          number("no_gps_wander_tau_s", at(&A::gps, &GpsSettings::no_gps, &NoGpsRegime::wander, &PointingWander::tau_s),
                 {0.1, 1e5}, optional, "correlation time of that error"),
          number("offset_prior_m", at(&A::cartesian_bias, &CartesianBiasSettings::offset_prior_m), {0, 1e5}, optional,
                 "what an offset may be before any data, 1-sigma per axis (song2015, track-level rules)"),
          number("scale_prior", at(&A::cartesian_bias, &CartesianBiasSettings::scale_prior), {0, 1}, optional,
                 "what a scale error may be before any data, 1-sigma per axis (song2015, track-level rules)"),
          integer("window", at(&A::cartesian_bias, &CartesianBiasSettings::window), {0, 64}, optional,
                  "samples of the paper's windowed process noise; 0: none, drift only (song2015, track-level rules)"),
          number("offset_drift_m_sqrt_s", at(&A::cartesian_bias, &CartesianBiasSettings::offset_drift_m_sqrt_s),
                 {0, 1e4}, optional, "random walk of the offsets (song2015, track-level rules)"),
          number("scale_drift_sqrt_s", at(&A::cartesian_bias, &CartesianBiasSettings::scale_drift_sqrt_s), {0, 1},
                 optional, "random walk of the scales (song2015, track-level rules)"),
          number("gps_q_m2_s3", at(&A::cartesian_bias, &CartesianBiasSettings::gps_q_m2_s3), {1e-6, 1e9}, optional,
                 "white acceleration density of the GPS track (song2015, track-level rules)"),
          span("gps_max_age_ms", at(&A::gps, &GpsSettings::max_age), {1, 600'000}, optional,
               "with GPS older than this, biases are kept, not updated"),
      });
}

Section fuse_section() {
  using F = FuseConfig;
  const auto launch = [](const std::string& name, double LaunchSettings::*member, Limits limits, const char* help) {
    return number("launch_" + name, at(&F::motion, &KinematicsSettings::launch, member), limits, optional,
                  std::string(help) + " (kinematics launch)");
  };
  return single<F>(
      "fuse", "The trajectory.", [](ServiceConfig& c) -> F& { return c.range.fuse; },
      {
          ids("methods", at(&F::methods), optional, methods_help()),
          span("history_s", at(&F::arbitration, &ArbitrationSettings::history), {0, 600}, optional,
               "how late a measurement may come"),
          choice<F, Kinematics>("kinematics", at(&F::motion, &KinematicsSettings::kinematics), kinematics_names(),
                                optional, "how a vehicle moves (joint, schmidt)"),
          number("q_cv_m2_s3", at(&F::motion, &KinematicsSettings::q_cv_m2_s3), {1e-6, 1e9}, optional,
                 "white acceleration density of cv and vdie"),
          number("q_ca_m2_s5", at(&F::motion, &KinematicsSettings::q_ca_m2_s5), {1e-6, 1e9}, optional,
                 "white jerk density of ca, of vdie while a manoeuvre lasts, of the targets of ts and of schmidt's GPS "
                 "track"),
          launch("q_ballistic_m2_s5", &LaunchSettings::q_ballistic_m2_s5, {1e-12, 1e9},
                 "white jerk density of a ballistic flight"),
          launch("ballistic_sigma_m_s2", &LaunchSettings::ballistic_sigma_m_s2, {1e-6, 100},
                 "specific force of a ballistic flight, 1-sigma per axis"),
          launch("q_thrust_m2_s5", &LaunchSettings::q_thrust_m2_s5, {1e-12, 1e9}, "white jerk density under thrust"),
          launch("q_event_m2_s5", &LaunchSettings::q_event_m2_s5, {1e-12, 1e9},
                 "white jerk density during ignition, staging and cut-off"),
          launch("phase_s", &LaunchSettings::phase_s, {1, 1e5}, "mean duration of ballistic flight, and of thrust"),
          launch("event_s", &LaunchSettings::event_s, {0.1, 1000}, "mean duration of ignition, staging or cut-off"),
          launch("initial_ballistic", &LaunchSettings::initial_ballistic, {0.001, 0.49},
                 "probability that a target is ballistic when its track starts"),
          launch("initial_event", &LaunchSettings::initial_event, {0.001, 0.49},
                 "probability that a target is in such an event when its track starts; else it is under thrust"),
          span("batch_ms", at(&F::cartesian_fusion, &CartesianFusionSettings::batch), {1, 10'000}, optional,
               "fusion interval of song2015 and federated on the UTC grid; a multiple of range.tick_ms"),
          number("q_m2_s3", at(&F::cartesian_fusion, &CartesianFusionSettings::q_m2_s3), {1e-6, 1e9}, optional,
                 "white acceleration density of the track (song2015, track-level rules)"),
          number("alpha_beta_acceleration_m_s2", at(&F::quick_look, &QuickLookSettings::acceleration_m_s2), {1e-3, 1e5},
                 optional, "acceleration between two plots of a radar, 1-sigma per axis (alpha-beta)"),
          number("gate_probability", at(&F::arbitration, &ArbitrationSettings::gate_probability), {0.5, 0.999999999},
                 optional, "share of good measurements that pass the gate"),
          flag("adaptive_noise", at(&F::noise, &AdaptiveNoiseSettings::enabled), optional,
               "the noise of each source is learnt in flight, from the sigma configured to a fifth and ten times of it "
               "(joint, schmidt, ts)"),
          span("restart_after_s", at(&F::arbitration, &ArbitrationSettings::restart_after), {0.1, 600}, optional,
               "a track of which no source's measurement was accepted for so long starts anew"),
          integer("reopen_after", at(&F::arbitration, &ArbitrationSettings::reopen_after), {1, 1'000'000}, optional,
                  "rejections in a row after which a radar's bias is opened again, while other sources are accepted"),
          number("initial_sigma_velocity_m_s", at(&F::start, &StartSettings::sigma_velocity_m_s), {0.1, 1e5}, optional,
                 "velocity 1-sigma per axis of a track's first estimate"),
          number("initial_sigma_acceleration_m_s2", at(&F::start, &StartSettings::sigma_acceleration_m_s2), {0.01, 1e4},
                 optional, "acceleration 1-sigma per axis of a track's first estimate (ca, launch)"),
          flag("publish_on_data", at(&F::publish_on_data), optional,
               "true: a trajectory with each measurement; false: on the tick"),
          span("stale_ms", at(&F::stale), {1, 600'000}, optional,
               "with the newest measurement older than this, a trajectory is coasting"),
          span("coast_ms", at(&F::coast), {1, 600'000}, optional,
               "with the newest measurement older than this, there is no trajectory on the tick"),
          flag("publish_chains", at(&F::publish_chains), optional,
               "the trajectories of INTEGRITY's chains as well, ten times a second: METHOD/without-NAME, "
               "METHOD/only-NAME"),
      });
}

Section integrity_section() {
  using I = IntegrityConfig;
  return single<I>(
      "integrity", "Which sources are believed.", [](ServiceConfig& c) -> I& { return c.range.integrity; },
      {
          flag("enabled", at(&I::enabled), optional,
               "judge the sources of a target against each other, where there are two or more"),
          integer("rerun_per_tick", at(&I::rerun_per_tick), {1, 100'000}, optional,
                  "measurements with each tick by which a run without a liar catches up"),
          ids("trust", at(&I::trust), optional,
              "whom to believe where two sources contradict each other and nothing tells who lies: ids of "
              "radars, trackers, stations or receivers, the most trusted first; empty: neither is excluded"),
          number("copy_position_m", at(&I::copy_position_m), {1e-6, 1e5}, optional,
                 "copies of one fix by several stations differ by no more than what the wire rounds"),
          number("copy_velocity_m_s", at(&I::copy_velocity_m_s), {1e-6, 1e4}, optional, "likewise"),
          span("readmit_after_s", at(&I::readmit_after), {0.1, 3600}, optional,
               "an excluded source is believed again when it has agreed for so long"),
      });
}

Section slave_section() {
  using S = SlaveConfig;
  return single<S>(
      "slave", "Pointing of the antennas.", [](ServiceConfig& c) -> S& { return c.range.slave; },
      {
          span("stale_ms", at(&S::stale), {1, 600'000}, optional,
               "with the newest measurement older than this, a command is made of a coasting track"),
          span("coast_ms", at(&S::coast), {1, 600'000}, optional, "coasting longer than this ends the commands"),
          number("coast_sigma_max_m", at(&S::coast_sigma_max_m), {1, 1e7}, optional,
                 "position 1-sigma above which coasting ends as well"),
          span("validity_ms", at(&S::validity), {1, 60'000}, optional, "how long a command holds after its instant"),
          number("blend_rate_deg_s", at(&S::blend_rate_rad_s), {1e-3, 360}, optional,
                 "how fast commands go over to another chain of sources, on the sky, beside the target's own motion"),
      });
}

Section clock_section() {
  using C = ClockConfig;
  return single<C>(
      "clock", "Where time comes from.", [](ServiceConfig& c) -> C& { return c.clock; },
      {
          choice<C, ClockMode>("mode", at(&C::mode), {{"wall", ClockMode::Wall}, {"range", ClockMode::Range}}, optional,
                               "wall: this node's UTC clock; range: topic range/clock (simulation, replay over DDS)"),
          span("step_timeout_ms", at(&C::step_timeout), {10, 600'000}, optional,
               "range clock: a step whose samples are not all there by then stops the flight"),
      });
}

Section node_section() {
  using N = NodeConfig;
  return single<N>("node", "This process among others.", [](ServiceConfig& c) -> N& { return c.node; },
                   {
                       id("id", at(&N::id), optional, "node_id on the topics; each process of a range has its own"),
                       integer("strength", at(&N::strength), {0, 1'000'000}, optional,
                               "ownership strength of the outputs: consumers hear the strongest node alive"),
                       stages_key(),
                       ids("sources", at(&N::sources), optional,
                           "radars, trackers and stations that ingest accepts here; empty: all"),
                       integer("queue", at(&N::queue), {16, 100'000}, optional,
                               "inputs of one source that may wait; more push out its oldest"),
                   });
}

Section dds_section() {
  using D = DdsConfig;
  Section section = single<D>(
      "dds", "The data bus; not needed by replay, check, report and experiment.",
      [](ServiceConfig& c) -> D& { return c.dds; },
      {
          integer("domain", at(&D::domain), {0, 232}, optional, "DDS domain"),
          path("profiles", at(&D::profiles), required, "XML file of QoS profiles, relative to this file"),
          ids("ingest_nodes", at(&D::ingest_nodes), optional, "nodes whose observations a node without ingest reads"),
      });
  section.optional = true;
  return section;
}

Section archive_section() {
  using A = ArchiveConfig;
  return single<A>(
      "archive", "The flight recorder.", [](ServiceConfig& c) -> A& { return c.archive; },
      {
          flag("enabled", at(&A::enabled), optional, "record every flight"),
          path("directory", at(&A::directory), optional,
               "folder of the archives, or one file *.mcap, relative to this file"),
          choice<A, Compression>("compression", at(&A::compression),
                                 {{"none", Compression::None}, {"lz4", Compression::Lz4}, {"zstd", Compression::Zstd}},
                                 optional, "compression of the archive's chunks"),
          flag("outputs", at(&A::outputs), optional, "record results too, not just what the engine consumed"),
      });
}

Section log_section() {
  using L = LogConfig;
  return single<L>("log", "Messages for people.", [](ServiceConfig& c) -> L& { return c.log; },
                   {
                       choice<L, LogLevel>("level", at(&L::level),
                                           {{"trace", LogLevel::Trace},
                                            {"debug", LogLevel::Debug},
                                            {"info", LogLevel::Info},
                                            {"warning", LogLevel::Warning},
                                            {"error", LogLevel::Error}},
                                           optional, "least severe messages shown"),
                       choice<L, Console>(
                           "console", at(&L::console),
                           {{"auto", Console::Auto},
                            {"plain", Console::Plain},
                            {"journal", Console::Journal},
                            {"off", Console::Off}},
                           optional, "standard error: auto is coloured on a terminal, journal adds syslog priorities"),
                       path("file", at(&L::file), optional, "log file besides, relative to this file; \"\": none"),
                   });
}

}  // namespace

const std::vector<Section>& schema() {
  static const std::vector<Section> sections{
      range_section(),   target_section(),    radar_section(), angle_sensor_section(), telemetry_section(),
      antenna_section(), gps_section(),       pad_section(),   ingest_section(),       align_section(),
      fuse_section(),    integrity_section(), slave_section(), clock_section(),        node_section(),
      dds_section(),     archive_section(),   log_section()};
  return sections;
}

}  // namespace downrange::config
