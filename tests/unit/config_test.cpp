#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <sstream>
#include <string>
#include <tuple>

#include "config/key.hpp"
#include "config_testing.hpp"

namespace downrange::config {
namespace {

using namespace test;

constexpr double degree = std::numbers::pi / 180;

TEST(Naro, IsValid) { EXPECT_EQ(joined(check(naro)), ""); }

TEST(Naro, RadarsAreExact) {
  const RangeConfig range = load(naro).range;
  EXPECT_EQ(range.name.view(), "naro");
  ASSERT_EQ(range.radars.size(), 2u);
  const RadarConfig& goheung = range.radars[0];
  EXPECT_EQ(goheung.id.view(), "goheung");
  EXPECT_EQ(goheung.site.geodetic().latitude_rad, 34.4450 * degree);
  EXPECT_EQ(goheung.site.geodetic().longitude_rad, 127.5200 * degree);
  EXPECT_EQ(goheung.site.geodetic().height_m, 120);
  EXPECT_EQ(goheung.rate_hz, 10);
  const RadarConfig& jeju = range.radars[1];
  EXPECT_EQ(jeju.id.view(), "jeju");
  EXPECT_EQ(jeju.site.geodetic().latitude_rad, 33.2900 * degree);
  EXPECT_EQ(jeju.site.geodetic().longitude_rad, 126.4600 * degree);
  EXPECT_EQ(jeju.site.geodetic().height_m, 350);
  EXPECT_EQ(jeju.rate_hz, 20);
  for (const RadarConfig& radar : range.radars) {
    EXPECT_EQ(radar.sigma.range_m, 25);
    EXPECT_EQ(radar.sigma.azimuth_rad, 0.01 * degree);
    EXPECT_EQ(radar.sigma.elevation_rad, 0.01 * degree);
    EXPECT_EQ(radar.elevation_max_rad, 90 * degree);
  }
}

TEST(Naro, StationsAndAntennasAreExact) {
  const RangeConfig range = load(naro).range;
  ASSERT_EQ(range.targets.size(), 1u);
  EXPECT_EQ(range.targets[0].id.view(), "kslv");
  ASSERT_EQ(range.telemetry.size(), 3u);
  EXPECT_EQ(range.telemetry[2].id.view(), "ship-tgs");
  EXPECT_EQ(range.telemetry[2].site.geodetic().latitude_rad, 14 * degree);
  ASSERT_EQ(range.antennas.size(), 4u);
  const AntennaConfig& ship = range.antennas[2];
  EXPECT_EQ(ship.id.view(), "ship-tm");
  EXPECT_EQ(ship.azimuth_min_rad, -360 * degree);
  EXPECT_EQ(ship.elevation_min_rad, -2 * degree);
  EXPECT_EQ(ship.azimuth_rate_max_rad_s, 12 * degree);
  EXPECT_EQ(ship.link_delay, milliseconds(600));
  EXPECT_EQ(ship.lead, milliseconds(80));
  for (const AntennaConfig& antenna : range.antennas) {
    for (const RadarConfig& radar : range.radars) EXPECT_GT((antenna.site.ecef() - radar.site.ecef()).m.norm(), 100);
  }
}

TEST(Naro, ServiceIsExact) {
  const ServiceConfig config = load(naro);
  EXPECT_EQ(config.range.tick, milliseconds(25));
  EXPECT_EQ(config.range.gps.sigma_horizontal_m, 5);
  EXPECT_EQ(config.range.gps.sigma_vertical_m, 8);
  EXPECT_EQ(config.range.fuse.methods, (std::vector<Name>{"joint", "song2015", "uncorrected"}));
  EXPECT_EQ(config.range.fuse.arbitration.history, milliseconds(5000));
  EXPECT_FALSE(config.range.ingest.expect_simulated);
  EXPECT_EQ(config.clock.mode, ClockMode::Wall);
  EXPECT_EQ(config.dds.profiles, source_dir / "config/dds-qos.xml");
  EXPECT_EQ(config.archive.directory, source_dir / "config/archive");
  EXPECT_TRUE(config.log.file.empty());
}

// Keys marked "(default)" say what the structs say: leaving them all out changes nothing.
TEST(Naro, StatedDefaultsAreTheDefaults) {
  std::istringstream lines(read(naro));
  std::string reduced;
  for (std::string line; std::getline(lines, line);) {
    if (line.find("(default)") == std::string::npos) reduced += line + '\n';
  }
  ASSERT_LT(reduced.size(), read(naro).size() - 1000);
  const std::vector<std::string> changed = differences(load_text(reduced, naro), load(naro));
  for (const std::string& key : changed) ADD_FAILURE() << key;
}

TEST(Naro, NamesEveryKeyOfTheReference) {
  const std::string text = read(naro);
  std::istringstream lines(key_reference());
  int keys = 0;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t colon = line.find(':');
    if (!line.starts_with("  ") || line.starts_with("   ") || colon == std::string::npos) continue;
    const std::string key = line.substr(2, colon - 2);
    const bool commented =
        text.find("\n# " + key + " = ") != std::string::npos;  // of tables that stand there as examples
    EXPECT_TRUE(commented || text.find('\n' + key + " = ") != std::string::npos) << key;
    ++keys;
  }
  EXPECT_GT(keys, 60);
}

TEST(Hash, ChangesWithTheTextAndIsSha256) {
  const ServiceConfig config = load(naro);
  EXPECT_EQ(config.text, read(naro));
  EXPECT_EQ(config.hash.size(), 64u);
  EXPECT_EQ(config.hash, load(naro).hash);
  EXPECT_NE(config.hash, load_text(config.text + "# one more line\n", naro).hash);
}

TEST(Override, ReplacesTheFilesValueAndLoadsAgain) {
  const Overrides overrides{{"clock.mode", "range", "--clock"},
                            {"dds.domain", "7", "--domain"},
                            {"node.id", "42", "--node"},
                            {"node.stages", R"(["align", "fuse", "slave"])", "--stages"},
                            {"dds.ingest_nodes", R"(["site-a"])", "--set"},
                            {"log.level", "\"debug\"", "--log-level"},
                            {"ingest.expect_simulated", "true", "--set"}};
  const ServiceConfig config = load(naro, overrides);
  EXPECT_EQ(config.clock.mode, ClockMode::Range);
  EXPECT_EQ(config.dds.domain, 7);
  EXPECT_EQ(config.node.id.view(), "42");
  EXPECT_FALSE(config.node.stages.ingest);
  EXPECT_TRUE(config.node.stages.slave);
  EXPECT_EQ(config.log.level, LogLevel::Debug);
  EXPECT_TRUE(config.range.ingest.expect_simulated);
  EXPECT_NE(config.hash, load(naro).hash);

  const ServiceConfig again = load_text(config.text, naro);
  EXPECT_EQ(differences(config, again), std::vector<std::string>{});
  for (std::size_t i = 0; i < config.range.radars.size(); ++i) {
    EXPECT_EQ(config.range.radars[i].site.ecef().m, again.range.radars[i].site.ecef().m);
  }
}

TEST(Cape, OneRadarSeesThroughTheAtmosphere) {
  const RangeConfig range = load(source_dir / "config/cape.toml").range;
  ASSERT_EQ(range.radars.size(), 3u);
  EXPECT_EQ(range.radars[0].refractivity, 0);
  EXPECT_EQ(range.radars[2].id.view(), "downrange");
  EXPECT_EQ(range.radars[2].refractivity, 320);
}

/// The naro configuration with keys put into its first radar.
std::string with_radar_keys(const std::string& keys) {
  std::string text = read(naro);
  const std::string from = "bias_blocks = ";
  const std::string to = "\n\n[[radar]]";
  const std::size_t begin = text.find(from);
  return text.replace(begin, text.find(to) - begin, keys);
}

TEST(Bias, EveryKeyReachesTheModel) {
  const RangeConfig range = load_text(with_radar_keys(R"(
bias_blocks = ["time", "sez_scale", "polar", "sez_offset"]
bias_prior_range_m = 1
bias_prior_angle_deg = 2
bias_prior_range_scale = 0.3
bias_prior_angle_scale = 0.4
bias_prior_sez_offset_m = 5
bias_prior_sez_scale = 0.6
bias_prior_time_tag_ms = 7
bias_drift_range_m_sqrt_s = 10
bias_drift_angle_deg_sqrt_s = 12
bias_drift_range_scale_sqrt_s = 0.13
bias_drift_angle_scale_sqrt_s = 0.14
bias_drift_sez_offset_m_sqrt_s = 15
bias_drift_sez_scale_sqrt_s = 0.16
bias_drift_time_tag_ms_sqrt_s = 17
)"),
                                      naro)
                                .range;
  const BiasModel model = bias_model_of(range.radars[0].bias);
  ASSERT_EQ(model.terms.size(), 13u);
  using enum BiasTerm;
  const std::vector<std::tuple<BiasTerm, double, double>> expected{
      {OffsetSouth, 5, 15},
      {OffsetEast, 5, 15},
      {OffsetZenith, 5, 15},
      {ScaleSouth, 0.6, 0.16},
      {ScaleEast, 0.6, 0.16},
      {ScaleZenith, 0.6, 0.16},
      {OffsetRange, 1, 10},
      {OffsetAzimuth, 2 * degree, 12 * degree},
      {OffsetElevation, 2 * degree, 12 * degree},
      {ScaleRange, 0.3, 0.13},
      {ScaleAzimuth, 0.4, 0.14},
      {ScaleElevation, 0.4, 0.14},
      {TimeTag, 7e-3, 17e-3},
  };
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const auto& [term, prior, drift] = expected[i];
    const auto k = static_cast<Eigen::Index>(term);
    EXPECT_EQ(model.terms[i], term);
    EXPECT_DOUBLE_EQ(std::sqrt(model.prior_cov(k, k)), prior) << to_string(term);
    EXPECT_DOUBLE_EQ(model.drift[k], drift) << to_string(term);
  }
  EXPECT_TRUE(model.prior_cov.isDiagonal());
}

TEST(Bias, DefaultsAreThoseOfTheEstimators) {
  const BiasModel configured = bias_model_of(load_text(with_radar_keys(""), naro).range.radars[0].bias);
  const BiasModel model = RadarModel().bias;
  EXPECT_EQ(configured.terms, model.terms);
  EXPECT_EQ(configured.drift, model.drift);
  for (const BiasTerm term : model.terms) {
    const auto i = static_cast<Eigen::Index>(term);
    EXPECT_DOUBLE_EQ(configured.prior_cov(i, i), model.prior_cov(i, i)) << to_string(term);
  }
  const MethodSettings settings;
  const RangeConfig range = load(naro).range;
  EXPECT_EQ(range.align.gps.no_gps.angle_prior_rad, settings.gps.no_gps.angle_prior_rad);
  EXPECT_EQ(range.fuse.motion.q_ca_m2_s5, settings.motion.q_ca_m2_s5);
}

TEST(Bias, BadValuesOfARadarSayWhatIsAllowed) {
  const auto problem_of = [](const std::string& line) {
    const std::vector<Problem> problems = problems_of(with_radar_keys(line));
    if (problems.size() != 1) return std::to_string(problems.size()) + " problems: " + joined(problems);
    return problems[0].key + ": " + problems[0].message;
  };
  const std::string list =
      R"(allowed: a list out of "polar", "sez_offset", "sez_scale", "time", each once, one or more)";
  EXPECT_EQ(problem_of("bias_blocks = []"), "radar[0].bias_blocks: found [] (list), " + list);
  EXPECT_EQ(problem_of(R"(bias_blocks = ["time", "time"])"),
            R"(radar[0].bias_blocks: found [ "time", "time" ] (list), )" + list);
  EXPECT_EQ(problem_of(R"(bias_blocks = ["cartesian"])"),
            R"(radar[0].bias_blocks: found [ "cartesian" ] (list), )" + list);
  EXPECT_EQ(problem_of(R"(bias_blocks = "polar")"), R"(radar[0].bias_blocks: found "polar" (text), )" + list);
  const std::vector<std::pair<std::string, std::string>> sizes{
      {"range_m", "100000 m"},      {"angle_deg", "20 deg"}, {"range_scale", "1"},       {"angle_scale", "1"},
      {"sez_offset_m", "100000 m"}, {"sez_scale", "1"},      {"time_tag_ms", "10000 ms"}};
  for (const auto& [name, most] : sizes) {
    const std::string prior = "bias_prior_" + name;
    for (const char* value : {"-1", "0", "1e9", "nan"}) {
      const std::string problem = problem_of(prior + " = " + value);
      EXPECT_EQ(problem.find("radar[0]." + prior + ": found "), 0u) << problem;
      EXPECT_NE(problem.find("allowed: a number from 1e-09 to " + most), std::string::npos) << problem;
    }
    const std::string drift = "bias_drift_" + name + "_sqrt_s";
    for (const char* value : {"-1", "1e9", "inf"}) {
      const std::string problem = problem_of(drift + " = " + value);
      EXPECT_EQ(problem.find("radar[0]." + drift + ": found "), 0u) << problem;
      EXPECT_NE(problem.find("allowed: a number from 0 to "), std::string::npos) << problem;
      EXPECT_NE(problem.find("sqrt(s)"), std::string::npos) << problem;
    }
  }
}

const std::string tracker = R"(
[[angle_sensor]]
id = "optical"
latitude_deg = 34.439
longitude_deg = 127.5105
height_m = 160
sigma_azimuth_deg = 0.003
sigma_elevation_deg = 0.002
)";

TEST(Impact, EveryKeyReachesTheRange) {
  const RangeConfig range = load_text(small + R"(
[impact]
height_m = 250
horizon_s = 5400
data_loss_s = [[0, 4], [60.5, 8]]
[[boundary]]
id = "triangle"
vertices_deg = [[28, -80], [28.0, 280.5], [29, -80]]
)",
                                      "test.toml")
                                .range;
  EXPECT_TRUE(range.impact.enabled);
  EXPECT_EQ(range.impact.fall.height_m, 250);
  EXPECT_EQ(range.impact.fall.horizon_s, 5400);
  const std::vector<DataLossLimit> table{{0, 4}, {60.5, 8}};
  EXPECT_EQ(range.impact.data_loss, table);
  ASSERT_EQ(range.boundaries.size(), 1u);
  EXPECT_EQ(range.boundaries[0].id, Name("triangle"));
  const std::vector<GroundPoint> vertices{
      {28 * degree, -80 * degree}, {28 * degree, 280.5 * degree}, {29 * degree, -80 * degree}};
  EXPECT_EQ(range.boundaries[0].vertices, vertices);
}

TEST(Impact, MoreBoundariesThanAPointIsHeldAgainst) {
  std::string text = small;
  const auto boundary = [](int i) {
    return "[[boundary]]\nid = \"b" + std::to_string(i) + "\"\nvertices_deg = [[28, -80], [28, -79], [29, -80]]\n";
  };
  for (int i = 0; i < 32; ++i) text += boundary(i);
  EXPECT_EQ(joined(problems_of(text)), "");
  EXPECT_EQ(joined(problems_of(text + boundary(32))), "test.toml:13: boundary: found 33, allowed: at most 32\n");
}

TEST(Impact, BoundariesWithoutImpactPointsAreNamed) {
  const ServiceConfig config = load_text(small + R"(
[impact]
enabled = false
height_m = 250
[[boundary]]
id = "triangle"
vertices_deg = [[28, -80], [28, -79], [29, -80]]
)",
                                         "test.toml");
  EXPECT_EQ(joined(config.warnings),
            "test.toml:16: impact.height_m: has no effect: enabled is false\n"
            "test.toml:19: boundary[0].vertices_deg: has no effect: impact.enabled is false\n");
}

TEST(AngleSensor, EveryKeyReachesTheRange) {
  const std::string text = read(naro);
  EXPECT_TRUE(load(naro).range.angle_sensors.empty());
  const RangeConfig range = load_text(text + tracker +
                                          "rate_hz = 25\nelevation_min_deg = 5\nelevation_max_deg = 85\n"
                                          "azimuth_sigma_on_sky = true\nangle_inflation = 2\nrefractivity_n = 310\n"
                                          "bias_prior_angle_deg = 0.1\nbias_drift_angle_deg_sqrt_s = 0.001\n",
                                      naro)
                                .range;
  ASSERT_EQ(range.angle_sensors.size(), 1u);
  const AngleSensorConfig& sensor = range.angle_sensors[0];
  EXPECT_EQ(sensor.id.view(), "optical");
  EXPECT_EQ(sensor.site.geodetic().height_m, 160);
  EXPECT_EQ(sensor.sigma_azimuth_rad, 0.003 * degree);
  EXPECT_EQ(sensor.sigma_elevation_rad, 0.002 * degree);
  EXPECT_EQ(sensor.rate_hz, 25);
  EXPECT_EQ(sensor.elevation_min_rad, 5 * degree);
  EXPECT_EQ(sensor.elevation_max_rad, 85 * degree);
  EXPECT_TRUE(sensor.azimuth_sigma_on_sky);
  EXPECT_EQ(sensor.angle_inflation, 2);
  EXPECT_EQ(sensor.refractivity, 310);
  const BiasModel model = bias_model_of(sensor);
  EXPECT_EQ(model.terms, (std::vector{BiasTerm::OffsetAzimuth, BiasTerm::OffsetElevation}));
  const auto azimuth = static_cast<Eigen::Index>(BiasTerm::OffsetAzimuth);
  EXPECT_DOUBLE_EQ(std::sqrt(model.prior_cov(azimuth, azimuth)), 0.1 * degree);
  EXPECT_DOUBLE_EQ(model.drift[azimuth], 0.001 * degree);
  EXPECT_EQ(load_text(text + tracker, naro, {{"node.sources", R"(["optical"])", "--sources"}}).node.sources.size(), 1u);
}

TEST(Antenna, WhatItsMountCan) {
  std::string text = read(naro);
  const auto say = [&](const std::string& was, const std::string& is) { text.replace(text.find(was), was.size(), is); };
  say("horizon_deg = []", "horizon_deg = [[0, 2.5], [90, 10], [359.5, -1]]");
  say("beamwidth_deg = 0", "beamwidth_deg = 1.5");
  say("elevation_acceleration_max_deg_s2 = 20", "elevation_acceleration_max_deg_s2 = 12");
  say("refractivity_n = 0             # N-units, 0 to 500, of the air", "refractivity_n = 320           # of the air");
  const RangeConfig range = load_text(text, naro,
                                      {{"slave.beam_probability_min", "0.3", "test"},
                                       {"slave.coast_bound_max_deg", "2", "test"},
                                       {"slave.nominal_sigma_m", "50", "test"},
                                       {"slave.nominal_sigma_share", "0.02", "test"}})
                                .range;
  const AntennaConfig& antenna = range.antennas[0];
  EXPECT_EQ(antenna.azimuth_acceleration_max_rad_s2, 20 * degree);
  EXPECT_EQ(antenna.elevation_acceleration_max_rad_s2, 12 * degree);
  EXPECT_EQ(antenna.beamwidth_rad, 1.5 * degree);
  EXPECT_EQ(antenna.refractivity, 320);
  ASSERT_EQ(antenna.horizon.size(), 3u);
  EXPECT_EQ(antenna.horizon[2].azimuth_rad, 359.5 * degree);
  EXPECT_EQ(antenna.horizon[2].elevation_rad, -1 * degree);
  EXPECT_EQ(range.slave.beam_probability_min, 0.3);
  EXPECT_EQ(range.slave.coast_bound_max_rad, 2 * degree);
  EXPECT_EQ(range.slave.nominal_sigma_m, 50);
  EXPECT_EQ(range.slave.nominal_sigma_share, 0.02);
  EXPECT_EQ(range.antennas[1].azimuth_acceleration_max_rad_s2, 0);
  EXPECT_TRUE(range.antennas[1].horizon.empty());
}

TEST(AngleSensor, TheExampleIsComplete) {
  // The commented example of config/naro.toml names every key, and is valid.
  std::istringstream lines(read(naro));
  std::string text;
  bool example = false;
  for (std::string line; std::getline(lines, line);) {
    example = (example || line == "# [[angle_sensor]]") && line.starts_with("# ");
    text += (example ? line.substr(2) : line) + '\n';
  }
  EXPECT_EQ(joined(problems_of(text)), "");
  EXPECT_EQ(load_text(text, naro).range.angle_sensors.size(), 1u);
  const std::string reference = key_reference();
  const std::size_t begin = reference.find("[[angle_sensor]]");
  std::istringstream keys(reference.substr(begin, reference.find("\n\n", begin) - begin));
  for (std::string line; std::getline(keys, line);) {
    const std::size_t colon = line.find(':');
    if (!line.starts_with("  ") || line.starts_with("   ") || colon == std::string::npos) continue;
    EXPECT_NE(text.find('\n' + line.substr(2, colon - 2) + " = ", text.find("[[angle_sensor]]")), std::string::npos)
        << line;
  }
}

TEST(AngleSensor, ProblemsNameTheKey) {
  const std::string text = read(naro);
  const auto problem_of = [&](const std::string& more) {
    const std::vector<Problem> problems = problems_of(text + tracker + more);
    if (problems.size() != 1) return std::to_string(problems.size()) + " problems: " + joined(problems);
    return problems[0].key + ": " + problems[0].message;
  };
  EXPECT_EQ(problem_of("sigma_range_m = 1"), "angle_sensor[0].sigma_range_m: unknown key");
  EXPECT_EQ(problem_of("refractivity_n = -1"),
            "angle_sensor[0].refractivity_n: found -1 (whole number), allowed: a number from 0 to 500 N-units");
  EXPECT_EQ(problem_of("elevation_min_deg = 90"),
            "angle_sensor[0].elevation_max_deg: found 90, allowed: more than elevation_min_deg (90)");
  EXPECT_EQ(problem_of("bias_prior_angle_deg = 0"),
            "angle_sensor[0].bias_prior_angle_deg: found 0 (whole number), allowed: a number from 1e-09 to 20 deg");
  EXPECT_EQ(problem_of("bias_blocks = [\"polar\"]").substr(0, 40), "angle_sensor[0].bias_blocks: unknown key");
  EXPECT_EQ(problem_of(tracker), "angle_sensor[1].id: found \"optical\", already used by angle_sensor[0].id");
  std::string many;
  for (int i = 0; i < 62; ++i) {
    std::string one = tracker;
    many += one.replace(one.find("optical"), 7, "o" + std::to_string(i));
  }
  EXPECT_EQ(problem_of(many), "angle_sensor: found 65 radars and angle sensors, allowed: at most 64 together");
}

TEST(Methods, BadSettingsSayWhatIsAllowed) {
  const std::string text = read(naro);
  std::string kinematics;
  for (const Kinematics k : all_kinematics)
    kinematics += (kinematics.empty() ? "\"" : " or \"") + std::string(to_string(k)) + '"';
  const std::vector<std::tuple<std::string, std::string, std::string>> bad{
      {"align.gps_error_states", "1", "true or false"},
      {"align.gps_error_sigma_m", "0", "a number from 0.001 to 10000 m"},
      {"align.gps_error_tau_s", "0", "a number from 0.1 to 100000 s"},
      {"align.gps_reference", "guess", R"("predict" or "smooth")"},
      {"align.smooth_fixes", "0", "a whole number from 1 to 9"},
      {"align.smooth_fixes", "10", "a whole number from 1 to 9"},
      {"align.no_gps", "\"no\"", "true or false"},
      {"align.no_gps_offset_prior_m", "0", "a number from 0.001 to 100000 m"},
      {"align.no_gps_angle_prior_deg", "21", "a number from 1e-06 to 20 deg"},
      {"align.no_gps_wander_deg", "-1", "a number from 1e-06 to 20 deg"},
      {"align.no_gps_wander_tau_s", "nan", "a number from 0.1 to 100000 s"},
      {"fuse.kinematics", "imm", kinematics},
      {"fuse.q_cv_m2_s3", "0", "a number from 1e-06 to 1000000000 m^2/s^3"},
      {"fuse.q_ca_m2_s5", "-10", "a number from 1e-06 to 1000000000 m^2/s^5"},
      {"fuse.launch_q_event_m2_s5", "0", "a number from 1e-12 to 1000000000 m^2/s^5"},
      {"fuse.launch_phase_s", "0", "a number from 1 to 100000 s"},
      {"fuse.launch_initial_event", "0.5", "a number from 0.001 to 0.49"},
      {"fuse.coast_ms", "400", "fuse.stale_ms (500) or more"},
      {"fuse.initial_sigma_acceleration_m_s2", "0", "a number from 0.01 to 10000 m/s^2"},
  };
  for (const auto& [key, value, allowed] : bad) {
    const std::vector<Problem> problems = problems_of(text, {{key, value, "--set"}});
    ASSERT_EQ(problems.size(), 1u) << key << '\n' << joined(problems);
    EXPECT_NE(problems[0].message.find("allowed: " + allowed), std::string::npos) << joined(problems);
  }
  EXPECT_EQ(load(naro, {{"fuse.kinematics", "vdie", "--set"}}).range.fuse.motion.kinematics, Kinematics::Vdie);
  EXPECT_TRUE(load(naro, {{"align.gps_reference", "smooth", "--set"}}).range.align.gps.alignment.smooth);
}

TEST(Methods, EveryKeyOfALaunchReachesTheModels) {
  Overrides overrides;
  const std::vector<std::pair<std::string, double LaunchSettings::*>> keys{
      {"q_ballistic_m2_s5", &LaunchSettings::q_ballistic_m2_s5},
      {"ballistic_sigma_m_s2", &LaunchSettings::ballistic_sigma_m_s2},
      {"q_thrust_m2_s5", &LaunchSettings::q_thrust_m2_s5},
      {"q_event_m2_s5", &LaunchSettings::q_event_m2_s5},
      {"phase_s", &LaunchSettings::phase_s},
      {"event_s", &LaunchSettings::event_s},
      {"initial_ballistic", &LaunchSettings::initial_ballistic},
      {"initial_event", &LaunchSettings::initial_event}};
  const auto value = [](std::size_t i) { return i < 6 ? 2.0 + static_cast<double>(i) : 0.04 * static_cast<double>(i); };
  for (std::size_t i = 0; i < keys.size(); ++i)
    overrides.push_back({"fuse.launch_" + keys[i].first, std::to_string(value(i)), "--set"});
  const LaunchSettings launch = load(naro, overrides).range.fuse.motion.launch;
  for (std::size_t i = 0; i < keys.size(); ++i) EXPECT_DOUBLE_EQ(launch.*keys[i].second, value(i)) << keys[i].first;
}

TEST(Key, AnyTextIsShownAsToml) {
  EXPECT_EQ(show_text("dish-1"), "\"dish-1\"");
  EXPECT_EQ(show_text("a\"]\n[x\\y\x1b"), R"("a\"]\u000A[x\\y\u001B")");
}

TEST(Override, ProblemsNameTheOption) {
  const std::string text = read(naro);
  EXPECT_EQ(joined(problems_of(text, {{"dds.domain", "300", "--domain"}})),
            "--domain: dds.domain: found 300 (whole number), allowed: a whole number from 0 to 232\n");
  EXPECT_EQ(joined(problems_of(text, {{"dds.domain", "4]", "--domain"}})),
            "--domain: dds.domain: found 4], allowed: a whole number from 0 to 232\n");
  EXPECT_EQ(joined(problems_of(text, {{"clock.mod", "range", "--set"}})),
            "--set: clock.mod: unknown key, did you mean clock.mode?\n");
  EXPECT_EQ(joined(problems_of(text, {{"dds.domain", "4\ndomain2 = 5", "--set"}})),
            "--set: dds.domain: found 4\\x0adomain2 = 5, allowed: a whole number from 0 to 232\n");
}

TEST(Differences, NameTheKeys) {
  const ServiceConfig a = load(naro);
  ServiceConfig b = a;
  b.log.level = LogLevel::Debug;
  b.range.radars[1].sigma.range_m = 24;
  EXPECT_EQ(differences(a, b), (std::vector<std::string>{"radar[1].sigma_range_m", "log.level"}));
  b.range.antennas.pop_back();
  EXPECT_EQ(differences(a, b), (std::vector<std::string>{"radar[1].sigma_range_m", "antenna", "log.level"}));
}

TEST(Dds, IsOptionalUntilSomethingTalks) {
  const ServiceConfig without = load_text(small, "cape.toml");
  EXPECT_TRUE(without.dds.profiles.empty());
  try {
    require_dds(without);
    FAIL() << "a service without [dds]";
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("cape.toml: dds: missing"), std::string::npos) << error.what();
  }
  EXPECT_NO_THROW(require_dds(load(naro)));
  // Profiles that are not there are a problem of whoever talks, too.
  const ServiceConfig absent = load_text(small + "[dds]\nprofiles = \"/absent.xml\"\n", "cape.toml");
  try {
    require_dds(absent);
    FAIL() << "a service without profiles";
  } catch (const ConfigError& error) {
    EXPECT_STREQ(error.what(), "cape.toml:14: dds.profiles: found \"/absent.xml\", no such file");
  }
  // A centre's configuration too: its ingest nodes belong to the bus.
  EXPECT_EQ(joined(problems_of(small + "[node]\nstages = [\"align\", \"fuse\", \"slave\"]\n")), "");
}

TEST(Sources, ARangeMayHaveNoRadar) {
  const std::string gps_only =
      "[range]\nname = \"pad\"\n[[target]]\nid = \"juno3\"\n" + site("telemetry", "tgs", 33, -106);
  EXPECT_EQ(joined(problems_of(gps_only)), "");
}

TEST(Peers, AreAddressesAndNetworks) {
  const auto with = [](const std::string& peers) {
    return load(naro, {{"dds.peers", "[" + peers + "]", "--set"}}).dds.peers;
  };
  EXPECT_TRUE(load(naro).dds.peers.empty());
  EXPECT_EQ(with(R"("192.0.2.7", "192.0.2.0/24", "2001:db8::1", "2001:db8::/128")").size(), 4u);
  for (const char* wrong : {"192.0.2", "192.0.2.256", "192.0.2.0/", "192.0.2.0/0", "192.0.2.0/33", "192.0.2.0/24 ",
                            "192.0.2.0/+8", "192.0.2.0/8/8", "2001:db8::/129", "radar.example", "", "any"}) {
    EXPECT_THROW(static_cast<void>(with('"' + std::string(wrong) + '"')), ConfigError) << wrong;
  }
}

}  // namespace
}  // namespace downrange::config
