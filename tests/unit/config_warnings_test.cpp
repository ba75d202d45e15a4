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

TEST(Warnings, EitherOfTwoThatCancelIsFine) {
  for (const char* used : {"kinematics = \"vdie\"\n", "methods = [\"ts\"]\n", "methods = [\"joint\", \"schmidt\"]\n"})
    EXPECT_EQ(warnings_of(small + "[fuse]\nq_ca_m2_s5 = 5\n" + used), "");
  EXPECT_EQ(warnings_of(small + "angle_inflation = 9\n"), "");
  EXPECT_EQ(warnings_of(small + "wander_deg = 0.01\nwander_tau_s = 10\n"), "");
  EXPECT_EQ(warnings_of(small + "wander_deg = 0.01\nangle_inflation = 1\n"), "");
  EXPECT_EQ(warnings_of(small + "bias_blocks = [\"time\"]\nbias_prior_time_tag_ms = 5\n"), "");
}

}  // namespace
}  // namespace downrange::config
