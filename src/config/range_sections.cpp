#include "config/sections.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "config/calibration.hpp"
#include "config/nominal.hpp"
#include "config/section.hpp"

namespace downrange::config {
namespace {

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

/// What an antenna's horizon hides, as a list of pairs.
Key<AntennaConfig> horizon_key() {
  constexpr double degree = std::numbers::pi / 180;
  return {
      {"horizon_deg",
       "pairs [azimuth, elevation] in deg, azimuths ascending from 0 to less than 360, elevations from -90 to 90",
       optional,
       "the antenna is not pointed lower than this at these azimuths, between two the line, around by north; empty: "
       "elevation_min_deg all around"},
      [](AntennaConfig& antenna, const toml::node& value) {
        const toml::array* pairs = value.as_array();
        if (pairs == nullptr) return false;
        std::vector<HorizonPoint> horizon;
        for (const toml::node& node : *pairs) {
          const toml::array* pair = node.as_array();
          if (pair == nullptr || pair->size() != 2) return false;
          const auto azimuth = read_number(*pair->get(0), {0, 360});
          const auto elevation = read_number(*pair->get(1), {-90, 90});
          if (!azimuth || !elevation || *azimuth >= 360) return false;
          const HorizonPoint point{.azimuth_rad = *azimuth * degree, .elevation_rad = *elevation * degree};
          if (!horizon.empty() && point.azimuth_rad <= horizon.back().azimuth_rad) return false;
          horizon.push_back(point);
        }
        antenna.horizon = std::move(horizon);
        return true;
      },
      [](const AntennaConfig& antenna) {
        std::string text;
        for (const HorizonPoint& point : antenna.horizon)
          text += (text.empty() ? "[" : ", [") + show_number(point.azimuth_rad / degree) + ", " +
                  show_number(point.elevation_rad / degree) + ']';
        return '[' + text + ']';
      }};
}

std::vector<Key<RadarConfig>> bias_keys() {
  std::vector<Key<RadarConfig>> keys{
      bias_blocks_key(), calibration_key(at(&RadarConfig::bias, &BiasConfig::calibration), "joint, schmidt, ts")};
  add_bias_sizes(keys, "bias_prior_", &BiasConfig::prior, "", 1e-9, "1-sigma before any data");
  add_bias_sizes(keys, "bias_drift_", &BiasConfig::drift, "_sqrt_s", 0, "random walk");
  return keys;
}

/// What radars and angles-only trackers have in common beside their noise.
template <class S>
std::vector<Key<S>> pointing_keys() {
  return {
      flag("azimuth_sigma_on_sky", at(&S::azimuth_sigma_on_sky), optional,
           "true: sigma_azimuth_deg is on the sky, the axis's own noise is that over cos(elevation)"),
      number("angle_inflation", at(&S::angle_inflation), {1, 1000}, optional,
             "factor on the angle variances, for pointing errors that are not white; 1: they are"),
      number("wander_deg", at(&S::wander, &PointingWander::sigma_rad), {0, 20}, optional,
             "slowly varying pointing error of each axis, 1-sigma, estimated (joint, schmidt); 0: half the sigma of "
             "angles over "
             "100 s, none where angle_inflation is 1"),
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

}  // namespace

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
      with_site<A>(
          {id("id", at(&A::id), required, "antenna_id on the topics"),
           id("target", at(&A::target), optional, "id of the target it follows; left out: the first"),
           id("sensor", at(&A::sensor), optional,
              "id of the tracker or radar on the same mount: what it reads while it tracks tells the mount's own "
              "pointing error, which is taken out of the commands; what it reads while the antenna is slaved "
              "(range/antenna) is no measurement; left out: none"),
           flag("moves", at(&A::moves), optional,
                "it is on a ship or an aircraft: range/platform tells where it is and where its azimuth zero points")},
          {
              number("azimuth_min_deg", at(&A::azimuth_min_rad), {-1080, 1080}, optional,
                     "lower end of the azimuth travel, cable wrap included"),
              number("azimuth_max_deg", at(&A::azimuth_max_rad), {-1080, 1080}, optional,
                     "upper end of the azimuth travel"),
              number("elevation_min_deg", at(&A::elevation_min_rad), {-90, 180}, optional,
                     "lower end of the elevation travel"),
              number("elevation_max_deg", at(&A::elevation_max_rad), {-90, 180}, optional,
                     "upper end of the elevation travel; beyond 90 it may go over the zenith"),
              number("azimuth_rate_max_deg_s", at(&A::azimuth_rate_max_rad_s), {1e-3, 360}, optional,
                     "fastest the azimuth axis turns"),
              number("elevation_rate_max_deg_s", at(&A::elevation_rate_max_rad_s), {1e-3, 360}, optional,
                     "fastest the elevation axis turns"),
              number("azimuth_acceleration_max_deg_s2", at(&A::azimuth_acceleration_max_rad_s2), {0, 3600}, optional,
                     "largest acceleration of the azimuth axis: passes near the zenith are planned by it; 0: "
                     "not known, they are not planned"),
              number("elevation_acceleration_max_deg_s2", at(&A::elevation_acceleration_max_rad_s2), {0, 3600},
                     optional, "likewise of the elevation axis, to tell when it lags; 0: not known"),
              horizon_key(),
              number("beamwidth_deg", at(&A::beamwidth_rad), {0, 180}, optional,
                     "full width of the beam: commands tell how probably the target is in it, and end by that "
                     "(slave.beam_probability_min) while coasting; 0: not known"),
              number("refractivity_n", at(&A::refractivity), {0, 500}, optional,
                     "refractivity of the air at the site, added to the elevation; 0: none is"),
              number("mount_error_max_deg", at(&A::mount_error_max_rad), {0, 20}, optional,
                     "largest pointing error of an axis that is taken out of the commands (sensor); what reads "
                     "farther away tracks something else"),
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
      with_site<P>(
          {}, {number("radius_m", at(&P::radius_m), {10, 1e6}, optional,
                      "before lift-off, fixes farther from the pad than this are rejected; after an announced one, "
                      "farther than a vehicle can have come by then")}));
}

}  // namespace downrange::config
