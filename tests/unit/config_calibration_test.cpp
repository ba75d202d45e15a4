/// Calibrations: what is written is what is read, and what is wrong is named.
#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Cholesky>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>
#include <sstream>

#include "config/calibration.hpp"
#include "config_testing.hpp"

namespace downrange::config {
namespace {

using namespace test;

constexpr double deg = std::numbers::pi / 180;

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

/// A bias of the default terms with random values and a covariance of full correlation structure.
SensorBias drawn_bias(const char* sensor, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const BiasModel model = bias_model_of(BiasConfig{});
  SensorBias bias;
  bias.sensor = sensor;
  bias.method = "joint";
  bias.epoch = {1'772'352'479'987'654'321};
  bias.reference = BiasReference::Gps;
  bias.samples = 3700;
  bias.terms = static_cast<int>(model.terms.size());
  const Eigen::MatrixXd L = Eigen::MatrixXd::NullaryExpr(bias.terms, bias.terms, [&] { return normal(random); });
  const Eigen::MatrixXd shape = L * L.transpose() + 1e-6 * Eigen::MatrixXd::Identity(bias.terms, bias.terms);
  std::size_t k = 0;
  for (int i = 0; i < bias.terms; ++i) {
    const auto term = model.terms[static_cast<std::size_t>(i)];
    const auto prior = [&](int j) {
      const auto t = static_cast<Eigen::Index>(model.terms[static_cast<std::size_t>(j)]);
      return std::sqrt(model.prior_cov(t, t));
    };
    bias.term[static_cast<std::size_t>(i)] = term;
    bias.value[static_cast<std::size_t>(i)] = prior(i) * normal(random);
    bias.state[static_cast<std::size_t>(i)] = static_cast<BiasState>(i % 4);
    for (int j = i; j < bias.terms; ++j) bias.covariance[k++] = shape(i, j) / 10 * prior(i) * prior(j);
  }
  return bias;
}

const std::string calibrated_text =
    calibration_text({.archive = "flight.mcap", .configuration = "0123"},
                     std::vector<CalibratedSensor>{{SourceKind::Radar, drawn_bias("goheung", 1)},
                                                   {SourceKind::Radar, drawn_bias("jeju", 2)}});

/// A folder of its own per test and process with a range that names a calibration.
class CalibrationFile : public testing::Test {
 protected:
  CalibrationFile()
      : folder_(std::filesystem::temp_directory_path() /
                ("downrange-calibration-" + std::to_string(::getpid()) + "-" +
                 testing::UnitTest::GetInstance()->current_test_info()->name())) {
    std::filesystem::create_directories(folder_);
    std::filesystem::copy_file(naro.parent_path() / "dds-qos.xml", folder_ / "dds-qos.xml",
                               std::filesystem::copy_options::overwrite_existing);
    std::ofstream(folder_ / "range.toml") << replaced(read(naro), "calibration = \"\"", "calibration = \"cal.toml\"");
  }
  ~CalibrationFile() override { std::filesystem::remove_all(folder_); }

  ServiceConfig load(const std::string& calibration) {
    std::ofstream(folder_ / "cal.toml") << calibration;
    return config::load(folder_ / "range.toml");
  }

  /// What is wrong, the folder's name taken off.
  std::string complaint(const std::string& calibration) {
    try {
      static_cast<void>(load(calibration));
    } catch (const ConfigError& error) {
      std::string text = error.what();
      for (const std::string head = folder_.string() + '/'; text.find(head) != std::string::npos;)
        text.erase(text.find(head), head.size());
      return text;
    }
    return "none";
  }

  const std::filesystem::path folder_;
};

TEST_F(CalibrationFile, WhatIsWrittenIsWhatIsRead) {
  const ServiceConfig config = load(calibrated_text);
  EXPECT_TRUE(config.range.radars[1].bias.calibration.terms.empty());
  const SensorBias bias = drawn_bias("goheung", 1);
  const BiasModel model = bias_model_of(config.range.radars[0].bias);
  std::size_t k = 0;
  for (int i = 0; i < bias.terms; ++i) {
    const auto a = static_cast<Eigen::Index>(bias.term[static_cast<std::size_t>(i)]);
    const double value = bias.value[static_cast<std::size_t>(i)];
    EXPECT_NEAR(model.prior_mean[a], value, 1e-15 * std::abs(value));
    for (int j = i; j < bias.terms; ++j, ++k) {
      const auto b = static_cast<Eigen::Index>(bias.term[static_cast<std::size_t>(j)]);
      const double scale = std::sqrt(model.prior_cov(a, a) * model.prior_cov(b, b));
      EXPECT_NEAR(model.prior_cov(a, b), bias.covariance[k], 1e-14 * scale);
      EXPECT_EQ(model.prior_cov(a, b), model.prior_cov(b, a));
    }
  }
  EXPECT_EQ(model.prior_cov.llt().info(), Eigen::Success);
}

TEST_F(CalibrationFile, TheNoiseThatWasLearntIsARemark) {
  const std::string text =
      calibration_text({.archive = "flight.mcap", .configuration = "0123"},
                       std::vector<CalibratedSensor>{{SourceKind::Radar, drawn_bias("goheung", 1), {1.02, 3, 0, 0}},
                                                     {SourceKind::Radar, drawn_bias("jeju", 2)}});
  EXPECT_NE(text.find("# Its noise, over the sigma configured: range 1.02, azimuth 3.00\n"), std::string::npos) << text;
  EXPECT_EQ(complaint(text), "none");
}

TEST_F(CalibrationFile, TheConfigurationInForceIsWhole) {
  const ServiceConfig config = load(calibrated_text);
  std::filesystem::remove(folder_ / "cal.toml");
  const ServiceConfig again = load_text(config.text, folder_ / "range.toml");
  EXPECT_EQ(differences(config, again), std::vector<std::string>{});
  EXPECT_EQ(again.range.radars[0].bias.calibration.mean, config.range.radars[0].bias.calibration.mean);
  EXPECT_EQ(again.range.radars[0].bias.calibration.cov, config.range.radars[0].bias.calibration.cov);
  EXPECT_EQ(again.hash, config.hash);
  const std::vector<std::string> changed = differences(config, config::load(naro));
  EXPECT_EQ(changed.front(), "radar[0].calibration");
  const ServiceConfig other = load(replaced(calibrated_text, "sigma_m = ", "sigma_m = 1"));
  EXPECT_NE(other.hash, config.hash);
}

TEST_F(CalibrationFile, TermsThatItDoesNotHaveKeepTheConfiguredPrior) {
  const std::string one =
      "[[radar]]\nid = \"goheung\"\ncorrelation = [[1]]\n[[radar.term]]\nterm = \"offset_azimuth\"\n"
      "value_deg = -0.5\nsigma_deg = 0.01\n";
  const BiasModel model = bias_model_of(load(one).range.radars[0].bias);
  const BiasModel plain = bias_model_of(BiasConfig{});
  const auto azimuth = static_cast<Eigen::Index>(BiasTerm::OffsetAzimuth);
  for (const BiasTerm term : plain.terms) {
    const auto i = static_cast<Eigen::Index>(term);
    EXPECT_DOUBLE_EQ(model.prior_mean[i], i == azimuth ? -0.5 * deg : 0);
    EXPECT_DOUBLE_EQ(std::sqrt(model.prior_cov(i, i)), i == azimuth ? 0.01 * deg : std::sqrt(plain.prior_cov(i, i)));
  }
}

/// A tracker's bias: the offsets of both angles, correlated.
SensorBias tracker_bias() {
  SensorBias bias;
  bias.sensor = "optics";
  bias.method = "joint";
  bias.terms = 2;
  bias.term = {BiasTerm::OffsetAzimuth, BiasTerm::OffsetElevation};
  bias.value = {0.02 * deg, -0.01 * deg};
  bias.covariance = {1e-4 * deg * deg, 0.5e-4 * deg * deg, 4e-4 * deg * deg};
  return bias;
}

TEST_F(CalibrationFile, OfATrackerIsItsPrior) {
  std::ofstream(folder_ / "range.toml", std::ios::app)
      << "\n[[angle_sensor]]\nid = \"optics\"\nlatitude_deg = 34.4\nlongitude_deg = 127.5\nheight_m = 10\n"
         "sigma_azimuth_deg = 0.003\nsigma_elevation_deg = 0.003\ncalibration = \"cal.toml\"\n";
  const auto text_of = [](const SensorBias& tracker) {
    return calibration_text({.archive = "flight.mcap", .configuration = "0123"},
                            std::vector<CalibratedSensor>{{SourceKind::Radar, drawn_bias("goheung", 1)},
                                                          {SourceKind::AngleSensor, tracker}});
  };
  const ServiceConfig config = load(text_of(tracker_bias()));
  const BiasModel model = bias_model_of(config.range.angle_sensors.at(0));
  const auto azimuth = static_cast<Eigen::Index>(BiasTerm::OffsetAzimuth);
  const auto elevation = static_cast<Eigen::Index>(BiasTerm::OffsetElevation);
  EXPECT_DOUBLE_EQ(model.prior_mean[azimuth], 0.02 * deg);
  EXPECT_DOUBLE_EQ(model.prior_mean[elevation], -0.01 * deg);
  EXPECT_NEAR(model.prior_cov(azimuth, azimuth), 1e-4 * deg * deg, 1e-12 * deg * deg);
  EXPECT_NEAR(model.prior_cov(azimuth, elevation), 0.5e-4 * deg * deg, 1e-12 * deg * deg);
  EXPECT_NEAR(model.prior_cov(elevation, elevation), 4e-4 * deg * deg, 1e-12 * deg * deg);
  EXPECT_EQ(differences(config, load_text(config.text, folder_ / "range.toml")), std::vector<std::string>{});

  SensorBias other_term = tracker_bias();
  other_term.term[1] = BiasTerm::ScaleElevation;
  EXPECT_NE(complaint(text_of(other_term))
                .find("angle_sensor[0].calibration: found a calibration of scale_elevation, "
                      "allowed: offset_azimuth, offset_elevation"),
            std::string::npos)
      << complaint(text_of(other_term));
  EXPECT_NE(complaint(calibrated_text).find("it has no [[angle_sensor]] with id \"optics\""), std::string::npos);
}

TEST_F(CalibrationFile, SaysWhereItComesFrom) {
  for (const char* text : {"archive = \"flight.mcap\"", "configuration = \"0123\"", "method = \"joint\"",
                           "epoch = 2026-03-01T08:07:59.987654321Z", "samples = 3700", "reference = \"gps\"",
                           "state = \"not observable\"", "sigma_ms = ", "sigma_deg = ", "value_m = "})
    EXPECT_NE(calibrated_text.find(text), std::string::npos) << text;
}

TEST_F(CalibrationFile, ComplaintsNameFileLineKeyAndWhatIsAllowed) {
  EXPECT_EQ(complaint(calibrated_text), "none");
  EXPECT_EQ(complaint("x = ").substr(0, 27), "cal.toml:1: not valid TOML:");
  EXPECT_EQ(complaint("").substr(0, 11), "range.toml:");
  EXPECT_NE(complaint("").find("radar[0].calibration: found \"cal.toml\", it has no [[radar]] with id \"goheung\""),
            std::string::npos);
  const std::string good =
      "[[radar]]\nid = \"goheung\"\ncorrelation = [[1]]\n[[radar.term]]\nterm = \"offset_azimuth\"\n"
      "value_deg = -0.5\nsigma_deg = 0.01\n";
  EXPECT_EQ(complaint(good), "none");
  EXPECT_EQ(
      complaint(replaced(good, "sigma_deg = 0.01", "sigma_deg = 0")),
      "cal.toml:7: radar[0].term[0].sigma_deg: found 0 (whole number), allowed: a number from 1e-12 to 1000000000 "
      "deg");
  EXPECT_EQ(complaint(replaced(good, "sigma_deg", "sigma_m")),
            "cal.toml:4: radar[0].term[0].sigma_deg: missing, required: a number from 1e-12 to 1000000000 deg (its "
            "1-sigma)\ncal.toml:7: radar[0].term[0].sigma_m: unknown key, did you mean sigma_deg?");
  EXPECT_EQ(complaint(replaced(good, "offset_azimuth", "offset_azimut")).substr(0, 77),
            "cal.toml:5: radar[0].term[0].term: found \"offset_azimut\" (text), allowed: \"of");
  EXPECT_EQ(complaint(replaced(good, "[[1]]", "[[1, 0], [0, 1]]")),
            "cal.toml:3: radar[0].correlation: found [ [ 1, 0 ], [ 0, 1 ] ] (list), allowed: 1 rows of 1 numbers from "
            "-1 to 1, symmetric, positive definite, 1 on the diagonal");
  EXPECT_EQ(complaint(replaced(good, "[[1]]", "[[0.5]]")).substr(0, 34), "cal.toml:3: radar[0].correlation: ");
  const std::string twice = replaced(good, "[[1]]", "[[1, 0], [0, 1]]") +
                            "[[radar.term]]\nterm = \"offset_azimuth\"\nvalue_deg = 1\nsigma_deg = 1\n";
  EXPECT_EQ(complaint(twice), "cal.toml:8: radar[0].term[1].term: found \"offset_azimuth\" twice, allowed: once");
  const std::string not_definite = replaced(good, "[[1]]", "[[1, 1], [1, 1]]") +
                                   "[[radar.term]]\nterm = \"offset_range\"\nvalue_m = 1\nsigma_m = 1\n";
  EXPECT_EQ(complaint(not_definite).substr(0, 34), "cal.toml:3: radar[0].correlation: ");
  EXPECT_EQ(complaint(replaced(good, "correlation = [[1]]\n", "")).substr(0, 46),
            "cal.toml:1: radar[0].correlation: missing, req");
  EXPECT_EQ(complaint("[[radar]]\nid = \"goheung\"\ncorrelation = []\nterm = 3\n").substr(0, 25),
            "cal.toml:4: radar[0].term");
  EXPECT_EQ(complaint(replaced(good, "id =", "samples = \"many\"\nid =")),
            "cal.toml:2: radar[0].samples: found \"many\" (text), allowed: a whole number");
  const std::string other_block =
      "[[radar]]\nid = \"goheung\"\ncorrelation = [[1]]\n[[radar.term]]\n"
      "term = \"scale_south\"\nvalue = 0\nsigma = 1e-4\n";
  EXPECT_NE(complaint(other_block)
                .find("radar[0].calibration: found a calibration of scale_south, allowed: terms of the blocks in "
                      "bias_blocks"),
            std::string::npos);
}

TEST_F(CalibrationFile, MissingFile) {
  try {
    static_cast<void>(config::load(folder_ / "range.toml"));
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("radar[0].calibration: found \"cal.toml\", no such file"),
              std::string::npos);
  }
}

}  // namespace
}  // namespace downrange::config
