/// What a configuration may say, but hardly means.
#include <gtest/gtest.h>

#include <algorithm>

#include "config_testing.hpp"

namespace downrange::config {
namespace {

using namespace test;

std::string warnings_of(std::string_view text) { return joined(load_text(text, "test.toml").warnings); }

TEST(Warnings, TheExamplesHaveNone) {
  for (const char* example : {"naro", "cape", "spaceport"}) {
    const auto file = source_dir / "config" / (std::string(example) + ".toml");
    EXPECT_EQ(joined(load(file).warnings), "") << example;
  }
  EXPECT_EQ(warnings_of(small), "");
}

TEST(Warnings, ASiteFartherThanARangeIsWideIsNamedWithTheSlipThatExplainsIt) {
  const std::string near = site("telemetry", "pad", 28.6, -80.6) + site("telemetry", "island", 32.3, -64.7);
  EXPECT_EQ(warnings_of(small + near), "");
  const auto expect = [&](const std::string& far, const std::string& what) {
    const std::string warnings = warnings_of(small + near + far);
    EXPECT_EQ(std::count(warnings.begin(), warnings.end(), '\n'), 1) << warnings;
    EXPECT_NE(warnings.find("test.toml:25: telemetry[2].latitude_deg: \"far\" at"), std::string::npos) << warnings;
    EXPECT_NE(warnings.find("at most 3000 km" + what), std::string::npos) << warnings;
  };
  expect(site("telemetry", "far", -80.5, 28.5), "; latitude and longitude swapped? 28.5, -80.5 is ");
  expect(site("telemetry", "far", 28.5, 80.5), "; the longitude's sign? 28.5, -80.5 is ");
  expect(site("telemetry", "far", -28.5, -80.5), "; the latitude's sign? 28.5, -80.5 is ");
  expect(site("telemetry", "far", 0, 120), "\n");
}

// Nearer than a range is wide, a slip is told by what undoing it does.
TEST(Warnings, ASiteThatASlipExplainsIsNamed) {
  const auto warning = [](double latitude_deg, double longitude_deg, const std::string& table = "telemetry") {
    const std::string base = std::string(small).replace(small.find("28.43"), 5, "45.96");
    const std::string cosmodrome = std::string(base).replace(base.find("-80.57"), 6, "63.31") +
                                   site("telemetry", "pad", 45.97, 63.3) + site("telemetry", "hill", 46.1, 63.4);
    const std::string text = cosmodrome + site(table, "odd", latitude_deg, longitude_deg);
    return warnings_of(table == "antenna" ? text + "link_delay_ms = 5\nlead_ms = 50\n" : text);
  };
  const auto expect = [&](double latitude_deg, double longitude_deg, const std::string& what) {
    const std::string said = warning(latitude_deg, longitude_deg);
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
    EXPECT_NE(said.find("in the middle of the range; " + what), std::string::npos) << said;
  };
  expect(63.31, 45.96, "latitude and longitude swapped? 45.96, 63.31 is ");
  expect(45.96, 53.31, "a digit of the longitude? 45.96, 63.31 is ");
  expect(25.96, 63.31, "a digit of the latitude? 45.96, 63.31 is ");
  EXPECT_EQ(warning(45.96, 66.9), "") << "280 km";
  EXPECT_EQ(warning(50.3, 80), "") << "a station downrange that no slip explains";
  // An antenna is not alone downrange: a source is near it, or its coordinates are wrong.
  const std::string alone = warning(50.3, 80, "antenna");
  EXPECT_NE(alone.find("and no other site within 300 km of it, expected: a source near an antenna downrange"),
            std::string::npos)
      << alone;
  EXPECT_EQ(
      warnings_of(std::string(small) + site("telemetry", "pad", 28.6, -80.6) + site("telemetry", "island", 14, -60) +
                  site("antenna", "island-dish", 14.1, -60.1) + "link_delay_ms = 5\nlead_ms = 50\n"),
      "");
}

TEST(Warnings, ASignIsASlipOnASmallRangeToo) {
  const std::string equator =
      std::string(small).replace(small.find("28.43"), 5, "-2.37") + site("telemetry", "pad", -2.3, -80.5);
  EXPECT_NE(warnings_of(equator + site("telemetry", "odd", 2.4, -80.6)).find("the latitude's sign? -2.4, -80.6 is"),
            std::string::npos);
}

TEST(Warnings, ASiteOfAnyTableIsLookedAt) {
  const std::string near = site("telemetry", "pad", 28.6, -80.6) + site("telemetry", "other", 28.7, -80.6);
  const std::string antenna = site("antenna", "dish", -80.5, 28.5) + "link_delay_ms = 5\nlead_ms = 50\n";
  EXPECT_NE(warnings_of(small + near + antenna).find("antenna[0].latitude_deg: \"dish\""), std::string::npos);
  const std::string optics =
      site("angle_sensor", "optics", -80.5, 28.5) + "sigma_azimuth_deg = 0.01\nsigma_elevation_deg = 0.01\n";
  EXPECT_NE(warnings_of(small + near + optics).find("angle_sensor[0].latitude_deg: \"optics\""), std::string::npos);
  // Two sites cannot say which of them is wrong: both are named.
  const std::string two = warnings_of(small + site("telemetry", "pad", -80.6, 28.6));
  EXPECT_NE(two.find("\"pad\" at -80.6, 28.6"), std::string::npos) << two;
  EXPECT_NE(two.find("from \"cape\""), std::string::npos) << two;
}

struct Cancelled {
  const char* text;     ///< added to the small range, whose last table is its radar
  const char* warning;  ///< what its one warning begins with, behind the file and line
};

class CancelledKeys : public testing::TestWithParam<Cancelled> {};
INSTANTIATE_TEST_SUITE_P(
    All, CancelledKeys,
    testing::Values(
        Cancelled{"angle_inflation = 4\nwander_deg = 0.01\n", "radar[0].angle_inflation: found 4 beside wander_deg"},
        Cancelled{"wander_tau_s = 10\n", "radar[0].wander_tau_s: has no effect: wander_deg is 0"},
        Cancelled{"bias_blocks = [\"polar\"]\nbias_prior_time_tag_ms = 5\n",
                  "radar[0].bias_prior_time_tag_ms: has no effect: bias_blocks is without \"time\""},
        Cancelled{"bias_drift_sez_scale_sqrt_s = 1e-6\n",
                  "radar[0].bias_drift_sez_scale_sqrt_s: has no effect: bias_blocks is without \"sez_scale\""},
        Cancelled{"[gps]\nuse_velocity = false\nsigma_velocity_m_s = 1\n",
                  "gps.sigma_velocity_m_s: has no effect: use_velocity is false"},
        Cancelled{"[align]\ngps_error_states = false\ngps_error_tau_s = 5\n",
                  "align.gps_error_tau_s: has no effect: gps_error_states is false"},
        Cancelled{"[align]\nsmooth_fixes = 3\n", "align.smooth_fixes: has no effect: gps_reference is \"predict\""},
        Cancelled{"[align]\nno_gps = false\nno_gps_wander_deg = 0.1\n",
                  "align.no_gps_wander_deg: has no effect: no_gps is false"},
        Cancelled{"[fuse]\nkinematics = \"ca\"\nq_cv_m2_s3 = 5\n", "fuse.q_cv_m2_s3: has no effect"},
        Cancelled{"[fuse]\nkinematics = \"launch\"\nq_ca_m2_s5 = 5\n", "fuse.q_ca_m2_s5: has no effect"},
        Cancelled{"[fuse]\nkinematics = \"cv\"\ninitial_sigma_acceleration_m_s2 = 5\n",
                  "fuse.initial_sigma_acceleration_m_s2: has no effect"},
        Cancelled{"[fuse]\nkinematics = \"ca\"\nlaunch_event_s = 5\n", "fuse.launch_event_s: has no effect"},
        Cancelled{"[fuse]\npublish_on_data = true\ncoast_ms = 9000\n",
                  "fuse.coast_ms: has no effect: publish_on_data is true"},
        Cancelled{"wander_deg = 0.01\n[fuse]\nmethods = [\"ts\"]\n",
                  "radar[0].wander_deg: has no effect: no method of fuse.methods uses it"},
        Cancelled{"sigma_range_rate_m_s = 1\n[fuse]\nmethods = [\"song2015\"]\n",
                  "radar[0].sigma_range_rate_m_s: has no effect: no method"},
        Cancelled{"bias_blocks = [\"polar\"]\n[fuse]\nmethods = [\"song2015\", \"alpha-beta\"]\n",
                  "radar[0].bias_blocks: has no effect: no method"},
        Cancelled{"[fuse]\nadaptive_noise = false\nmethods = [\"map\"]\n",
                  "fuse.adaptive_noise: has no effect: no method"},
        Cancelled{"snr_ref_db = 25\n", "radar[0].snr_ref_db: has no effect: no noise refers to it"},
        Cancelled{"sigma_range_rate_at_snr_ref_m_s = 2\n",
                  "radar[0].sigma_range_rate_at_snr_ref_m_s: has no effect: sigma_range_rate_m_s is 0"},
        Cancelled{"wander_deg = 0.02\nangle_inflation = 4\n[fuse]\nmethods = [\"song2015\"]\n",
                  "radar[0].wander_deg: has no effect: no method of fuse.methods uses it"},
        Cancelled{"wander_tau_s = 31\n[fuse]\nmethods = [\"ts\"]\n",
                  "radar[0].wander_tau_s: has no effect: no method of fuse.methods uses it"},
        Cancelled{"[align]\noffset_prior_m = 7\n", "align.offset_prior_m: has no effect: no method"},
        Cancelled{"[align]\nscale_prior = 1e-3\n", "align.scale_prior: has no effect: no method"},
        Cancelled{"[align]\nwindow = 33\n", "align.window: has no effect: no method"},
        Cancelled{"[align]\noffset_drift_m_sqrt_s = 1\n[fuse]\nmethods = [\"uncorrected\"]\n",
                  "align.offset_drift_m_sqrt_s: has no effect: no method"},
        Cancelled{"[align]\nscale_drift_sqrt_s = 1e-5\n", "align.scale_drift_sqrt_s: has no effect: no method"},
        Cancelled{"[align]\ngps_q_m2_s3 = 7\n", "align.gps_q_m2_s3: has no effect: no method"},
        Cancelled{"[fuse]\nq_m2_s3 = 7\nmethods = [\"ts\"]\n", "fuse.q_m2_s3: has no effect: no method"},
        Cancelled{"[fuse]\nalpha_beta_acceleration_m_s2 = 7\n",
                  "fuse.alpha_beta_acceleration_m_s2: has no effect: no method"},
        Cancelled{"[fuse]\nreopen_after = 7\nmethods = [\"alpha-beta\"]\n",
                  "fuse.reopen_after: has no effect: no method"},
        Cancelled{"[fuse]\nlaunch_phase_s = 50\nmethods = [\"ts\"]\n", "fuse.launch_phase_s: has no effect: no method"},
        Cancelled{"[fuse]\nq_ca_m2_s5 = 50\nmethods = [\"map\"]\n", "fuse.q_ca_m2_s5: has no effect: no method"},
        Cancelled{"[align]\nno_gps_wander_tau_s = 9\n[fuse]\nmethods = [\"map\"]\n[integrity]\nenabled = false\n",
                  "align.no_gps_wander_tau_s: has no effect: no method"},
        Cancelled{"[fuse]\nbatch_ms = 200\n", "fuse.batch_ms: has no effect: no method of fuse.methods uses it"},
        Cancelled{"[integrity]\nenabled = false\nreadmit_after_s = 5\n",
                  "integrity.readmit_after_s: has no effect: enabled is false"},
        Cancelled{"[integrity]\ntrust = [\"nobody\"]\n", "integrity.trust: \"nobody\" is no radar, tracker or station"},
        Cancelled{"[slave]\nvalidity_ms = 20\n", "slave.validity_ms: found 20, expected: range.tick_ms (25) or more"}));

TEST_P(CancelledKeys, AreNamed) {
  const std::string warnings = warnings_of(small + GetParam().text);
  EXPECT_EQ(std::count(warnings.begin(), warnings.end(), '\n'), 1) << warnings;
  EXPECT_NE(warnings.find(std::string(": ") + GetParam().warning), std::string::npos) << warnings;
  EXPECT_TRUE(warnings.starts_with("test.toml:1")) << warnings;  // lines 13 to 16
}

TEST(Warnings, WhatARadarDoesNotMeasureNeedsNoKeys) {
  const auto keys_of = [](const std::string& added) {
    std::string keys;
    for (const Problem& warning : load_text(small + added, "test.toml").warnings) {
      keys += warning.key + ' ';
      EXPECT_EQ(warning.message, "has no effect: the radar does not measure that");
    }
    return keys;
  };
  const std::string radar = "radar[0].";
  EXPECT_EQ(keys_of("measures = [\"range\"]\nwander_deg = 0.03\nangle_inflation = 9\nazimuth_sigma_on_sky = true\n"),
            radar + "sigma_azimuth_deg " + radar + "sigma_elevation_deg " + radar + "wander_deg " + radar +
                "angle_inflation " + radar + "azimuth_sigma_on_sky ");
  EXPECT_EQ(keys_of("measures = [\"angles\"]\nrange_max_m = 1e6\nwander_deg = 0.03\n"),
            radar + "sigma_range_m " + radar + "range_max_m ");
}

TEST(Warnings, EitherOfTwoThatCancelIsFine) {
  for (const char* used : {"kinematics = \"vdie\"\n", "methods = [\"ts\"]\n", "methods = [\"joint\", \"schmidt\"]\n"})
    EXPECT_EQ(warnings_of(small + "[fuse]\nq_ca_m2_s5 = 5\n" + used), "");
  EXPECT_EQ(warnings_of(small + "angle_inflation = 9\n"), "");
  EXPECT_EQ(warnings_of(small + "snr_ref_db = 25\nsigma_range_at_snr_ref_m = 3\n"), "");
  EXPECT_EQ(warnings_of(small + "snr_ref_db = 25\nsigma_range_rate_m_s = 1\nsigma_range_rate_at_snr_ref_m_s = 3\n"),
            "");
  for (const char* method : {"song2015", "information", "convex"})
    EXPECT_EQ(warnings_of(small + "[align]\nwindow = 3\ngps_q_m2_s3 = 5\n[fuse]\nq_m2_s3 = 5\nreopen_after = 7\n" +
                          "methods = [\"" + method + "\"]\n"),
              "");
  EXPECT_EQ(warnings_of(small + "[fuse]\nq_m2_s3 = 5\nmethods = [\"joint\", \"uncorrected\"]\n"), "");
  EXPECT_EQ(warnings_of(small + "[fuse]\nalpha_beta_acceleration_m_s2 = 5\nmethods = [\"alpha-beta\"]\n"), "");
  EXPECT_EQ(warnings_of(small + "[align]\nno_gps_wander_tau_s = 9\n[fuse]\nmethods = [\"map\"]\n"), "")
      << "INTEGRITY judges by it";
  EXPECT_EQ(warnings_of(small + "wander_deg = 0.01\nwander_tau_s = 10\n"), "");
  EXPECT_EQ(warnings_of(small + "wander_deg = 0.01\nangle_inflation = 1\n"), "");
  EXPECT_EQ(warnings_of(small + "bias_blocks = [\"time\"]\nbias_prior_time_tag_ms = 5\n"), "");
}

}  // namespace
}  // namespace downrange::config
