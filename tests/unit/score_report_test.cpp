/// The score as text and JSON.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "score_testing.hpp"

namespace downrange::score {
namespace {

using namespace test;

TEST(BiasReport, IsTheLastOfTheFirstMethodInTheUnitsOfAnEngineer) {
  Scorer scorer = make_scorer();
  ResultSink& run = scorer.open_run("fused");
  run.emit(make_bias({{BiasTerm::OffsetRange, 1}}));
  SensorBias last = make_bias({{BiasTerm::OffsetRange, 35.5},
                               {BiasTerm::OffsetAzimuth, -0.012 * deg},
                               {BiasTerm::ScaleElevation, 2.5e-4},
                               {BiasTerm::TimeTag, 0.0031}});
  last.samples = 77;
  last.state = {BiasState::Converged, BiasState::Estimating, BiasState::NotObservable, BiasState::Frozen};
  // Variances of a 4 x 4 triangle: rows begin at 0, 4, 7, 9.
  last.covariance[0] = 4;
  last.covariance[4] = std::pow(0.001 * deg, 2);
  last.covariance[7] = 1e-8;
  last.covariance[9] = 1e-6;
  run.emit(last);
  SensorBias other = make_bias({{BiasTerm::OffsetRange, 1e5}});
  other.method = "joint";
  run.emit(other);
  const std::string text = format_text(scorer.summary());
  EXPECT_NE(text.find("Biases at the end by song2015"), std::string::npos);
  const auto has = [&](const std::string& term, const std::string& figures) {
    const auto line = text.find(term);
    return line != std::string::npos &&
           text.substr(line, text.find('\n', line) - line).find(figures) != std::string::npos;
  };
  EXPECT_TRUE(has("offset_range", "35.50        2.00 m     converged")) << text;
  EXPECT_TRUE(has("offset_azimuth", "-12.00        1.00 mdeg  estimating")) << text;
  EXPECT_TRUE(has("scale_elevation", "250.00      100.00 ppm   not observable")) << text;
  EXPECT_TRUE(has("time_tag", "3.10        1.00 ms    frozen")) << text;
  const auto json = nlohmann::json::parse(format_json(scorer.summary()));
  EXPECT_EQ(json["method"], "song2015");
  ASSERT_EQ(json["biases"].size(), 1u);
  EXPECT_EQ(json["biases"][0]["source"], "goheung");
  EXPECT_EQ(json["biases"][0]["plots"], 77);
  EXPECT_EQ(json["biases"][0]["terms"][2]["state"], "not observable");
  EXPECT_NEAR(json["biases"][0]["terms"][3]["sigma"].get<double>(), 1e-3, 1e-15);
}

TEST(Report, TellsTheNoiseThatWasLearnt) {
  Scorer scorer = make_scorer();
  ResultSink& run = scorer.open_run("fused");
  run.emit(make_plot(1, 1, {1e6, 2, 1}));
  SourceHealth health = make_health(3, 12345, 0, 1000, 0.95);
  health.sigma_ratio = {0.98, 3.01, 2.97, 0};
  run.emit(health);
  const std::string text = format_text(scorer.summary());
  EXPECT_NE(text.find("noise over configured: range 0.98, azimuth 3.01, elevation 2.97\n"), std::string::npos) << text;
  const auto ratio = nlohmann::json::parse(format_json(scorer.summary()))["sources"][0]["sigma_ratio"];
  EXPECT_EQ(ratio[1], 3.01);
  EXPECT_TRUE(ratio[3].is_null());
}

TEST(Report, FitsAHundredColumnsAndSaysTheNumbers) {
  Scorer scorer(make_range(), "kslv", truth, liftoff,
                {{"boost", 125, 160}, {"coast", 250, 390}, {"late", 370, 470}, {"all", 0, 480}});
  ResultSink& run = scorer.open_run("fused");
  run.emit(make_trajectory(1, Eigen::Vector3d(1234.5, 0, 0), 20));
  run.emit(make_trajectory(2, Eigen::Vector3d(12345678, 0, 0), 20));
  run.emit(make_plot(1, 1, {1e6, 2, 1}));
  run.emit(make_bias({{BiasTerm::ScaleElevation, 12345.6}}));
  run.emit(make_command(1, 3, 0.1, 1e-3));
  Observation refused = make_plot(2, 2, {});
  for (std::size_t reason = 1; reason < reason_count; ++reason) {
    refused.verdict = static_cast<Reason>(reason);
    run.emit(refused);
  }
  run.emit(make_health(3, 12345, 0, 1000, 0.9153));
  ResultSink& alone = scorer.open_run("a radar with a very long name alone");
  alone.emit(make_trajectory(1, Eigen::Vector3d(3, 4, 0), 20));
  const std::string text = format_text(scorer.summary());
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
  EXPECT_NE(text.find("fused (song2015)"), std::string::npos);
  EXPECT_NE(text.find("all 0-480 s"), std::string::npos);
  EXPECT_NE(text.find("    5.0    5.0    5.0  100"), std::string::npos) << text;
  EXPECT_NE(text.find("goheung"), std::string::npos);
  EXPECT_NE(text.find("dish"), std::string::npos);
  EXPECT_NE(text.find("91.5 %    0-100   91.5 %        1 s"), std::string::npos) << text;
  EXPECT_NE(text.find("rejected: unknown_source 1, simulated_mismatch 1"), std::string::npos) << text;

  const auto json = nlohmann::json::parse(format_json(scorer.summary()));
  EXPECT_EQ(json["trajectories"][0]["label"], "fused (song2015)");
  EXPECT_EQ(json["trajectories"][1]["phases"][3]["phase"], "all");
  EXPECT_NEAR(json["trajectories"][1]["phases"][3]["rms_m"].get<double>(), 5, 1e-6);
  EXPECT_EQ(json["trajectories"][1]["phases"][0]["samples"], 0);
  EXPECT_EQ(json["radars"][0]["plots"], 1);
  EXPECT_EQ(json["pointing"][0]["source"], "fused");
  EXPECT_EQ(json["sources"][0]["kind"], "radar");
  EXPECT_EQ(json["sources"][0]["accepted"], 1);
  EXPECT_EQ(json["sources"][0]["rejected"]["clock_step"], 1);
  EXPECT_EQ(json["sources"][0]["mismatch_s"], 1);
}

/// Neither text nor JSON says "nan" or "inf", and no line is longer than a screen.
void expect_plain(const Summary& summary) {
  const std::string text = format_text(summary);
  const std::string json = format_json(summary);
  for (const char* no_number : {"nan", "inf"}) {
    EXPECT_EQ(text.find(no_number), std::string::npos) << text;
    EXPECT_EQ(json.find(no_number), std::string::npos) << json;
  }
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
}

TEST(Report, OfNothingIsStillATable) {
  Scorer scorer = make_scorer();
  EXPECT_NE(format_text(scorer.summary()).find("Position error"), std::string::npos);
  EXPECT_TRUE(nlohmann::json::parse(format_json(scorer.summary()))["trajectories"].empty());
  expect_plain(scorer.summary());
  Scorer of_no_results = make_scorer();
  static_cast<void>(of_no_results.open_run("fused"));
  expect_plain(of_no_results.summary());
  EXPECT_NE(format_text(of_no_results.summary()).find("Nothing to judge in first 0-50 s"), std::string::npos);
  EXPECT_NE(format_text(of_no_results.summary()).find("Slaving: no command"), std::string::npos);
}

TEST(Report, OfASingleSampleSaysSo) {
  Scorer scorer = make_scorer();
  ResultSink& run = scorer.open_run("fused");
  run.emit(make_plot(1, 1, {}));
  run.emit(make_trajectory(1, Eigen::Vector3d(3, 4, 0), 20));
  const std::string text = format_text(scorer.summary());
  EXPECT_NE(text.find("A single sample in first 0-50 s"), std::string::npos) << text;
  EXPECT_NE(text.find("Nothing to judge in second 50-60 s"), std::string::npos) << text;
  expect_plain(scorer.summary());
}

TEST(Report, WhatIsNotKnownIsADashAndNull) {
  Scorer scorer = make_scorer(make_range_out_of_sight());
  ResultSink& run = scorer.open_run("fused");
  SlavingCommand held = make_command(1, 0, 0.3, 1e-3);
  held.limits = LimitElevation;
  run.emit(held);
  SensorBias bias = make_bias({{BiasTerm::OffsetRange, 1}});
  bias.covariance[0] = -1;  // none
  run.emit(bias);
  expect_plain(scorer.summary());
  const auto json = nlohmann::json::parse(format_json(scorer.summary()));
  EXPECT_TRUE(json["pointing"][0]["rms_rad"].is_null());
  EXPECT_TRUE(json["radars"][0]["before"]["range_m"].is_null());
  EXPECT_TRUE(json["trajectories"][0]["phases"][0]["rms_m"].is_null());
  EXPECT_TRUE(json["biases"][0]["terms"][0]["sigma"].is_null());
  EXPECT_TRUE(json["sources"][0]["outliers"].is_null());
}

TEST(Report, TellsWhoWasExcludedWhenAndWhetherTheBoundHeld) {
  Scorer scorer = make_scorer();
  ResultSink& run = scorer.open_run("fused");
  EXPECT_EQ(format_text(scorer.summary()).find("downrange/integrity"), std::string::npos);
  Integrity record;
  record.target = "kslv";
  record.time = liftoff + seconds(1);
  record.bound_valid = true;
  record.bound_m = 60;
  record.sources = {{.sensor = "goheung"}, {.sensor = "jeju"}, {.sensor = "a-telemetry-station"}};
  run.emit(record);
  record.time = liftoff + seconds(242.5);
  record.chain = "without-GPS";
  record.sources[2].verdict = IntegrityVerdict::Excluded;
  record.sources[2].by = "integrity";
  record.sources[2].against = 3;
  record.sources[2].apart_m = 5000;
  record.sources[2].agree_m = 12;
  run.emit(record);
  record.target = "another";
  record.sources[0].verdict = IntegrityVerdict::Excluded;
  run.emit(record);
  for (const double error_m : {10.0, 70.0}) {
    Trajectory t = make_trajectory(2, Eigen::Vector3d(error_m, 0, 0), 20);
    t.method = "song2015";
    t.primary = true;
    t.bound_valid = true;
    t.bound_m = 60;
    run.emit(t);
  }
  const Summary summary = scorer.summary();
  ASSERT_EQ(summary.integrity.size(), 3u);
  const std::string text = format_text(summary);
  EXPECT_NE(text.find("    1.0 s  kslv follows all sources, bound 60 m\n"), std::string::npos) << text;
  EXPECT_NE(
      text.find("  242.5 s  kslv: a-telemetry-station disagrees with goheung and jeju by 5.0 km; these agree within\n"
                "           12 m; excluded by integrity\n"),
      std::string::npos)
      << text;
  EXPECT_NE(text.find("The bound covers the true error of  50.00 % of 2 positions"), std::string::npos) << text;
  const auto json = nlohmann::json::parse(format_json(summary));
  EXPECT_NEAR(json["integrity"][2]["t_s"].get<double>(), 242.5, 1e-9);
  EXPECT_EQ(json["bound"]["covered"], 1);
}

TEST(Report, SaysPlantedOnlyWhereSomebodyPlanted) {
  const auto text = [](OutlierOrigin origin) {
    Scorer scorer = make_scorer();
    scorer.know_outliers({{"goheung", 1}}, origin);
    scorer.open_run("fused").emit(make_plot(1, 1, {}));
    return format_text(scorer.summary());
  };
  EXPECT_NE(text(OutlierOrigin::Planted).find("planted"), std::string::npos);
  for (const OutlierOrigin origin : {OutlierOrigin::None, OutlierOrigin::Truth})
    EXPECT_EQ(text(origin).find("planted"), std::string::npos);
}

/// A flight of which nothing is known but what its sources say: GPS at 1 Hz, a track of each fix and one in between.
TEST(Report, WithoutTruthHoldsTheFixesAgainstTheTrackBeforeEach) {
  RangeConfig range = make_range();
  range.telemetry = {{"tgs", {}}};
  Scorer scorer(range, "kslv", {}, liftoff, {{"flight", 0, 50}});
  ResultSink& run = scorer.open_run("fused");
  for (int t = 1; t <= 20; ++t) {
    Observation fix;
    fix.sensor = "tgs";
    fix.target = "kslv";
    fix.epoch = at(t);
    Fix measured;
    measured.position = truth(at(t))->position;
    measured.sigma_horizontal_m = measured.sigma_vertical_m = 3;
    fix.measured = measured;
    run.emit(fix);
    for (const double later : {0.0, 0.5}) {
      Trajectory track = make_trajectory(t + later, Eigen::Vector3d(0, 0, later > 0 ? 6 : 0), 4);
      Eigen::Vector3d::Map(track.state.data() + 3) = truth(at(t))->velocity.m_s;
      run.emit(track);
    }
    run.emit(make_command(t, 0, 0, 1e-3));
  }
  const Summary summary = scorer.summary();
  EXPECT_FALSE(summary.truth_known);
  EXPECT_TRUE(summary.trajectories.empty());
  EXPECT_TRUE(summary.systematic.empty());
  const PositionScore& score = summary.against_gps.at(0).phases.at(0);
  EXPECT_EQ(score.samples, 19u);  // nothing was known before the first
  EXPECT_NEAR(score.rms_m, 6, 1e-6);
  EXPECT_EQ(score.inside_95, 1);  // 6 m against sqrt(4^2 + 3^2)
  ASSERT_EQ(summary.pointing.size(), 1u);
  EXPECT_EQ(summary.pointing[0].commands, 20u);
  EXPECT_EQ(summary.pointing[0].scored, 0u);
  EXPECT_EQ(summary.sources.back().accepted(), 20u);
  expect_plain(summary);
  const std::string text = format_text(summary);
  EXPECT_NE(text.find("No true trajectory is known"), std::string::npos);
  EXPECT_NE(text.find("    6.0    6.0    6.0  100"), std::string::npos) << text;
  const auto json = nlohmann::json::parse(format_json(summary));
  EXPECT_EQ(json["truth"], false);
  EXPECT_FALSE(json.contains("trajectories"));
  EXPECT_NEAR(json["against_gps"][0]["phases"][0]["rms_m"].get<double>(), 6, 1e-6);
}

}  // namespace
}  // namespace downrange::score
