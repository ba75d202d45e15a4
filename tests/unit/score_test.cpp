/// The score of results whose errors are known by construction.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "score/errors.hpp"
#include "score_testing.hpp"

namespace downrange::score {
namespace {

using namespace test;

TEST(PositionScore, IsPerPhaseAndMethod) {
  Scorer scorer = make_scorer();
  ResultSink& run = scorer.open_run("fused");
  // 100 errors of 1 to 100 m in the first phase, one of 7 m in the second, one without truth.
  for (int i = 1; i <= 100; ++i) run.emit(make_trajectory(i * 0.4, Eigen::Vector3d(0, i, 0), 20));
  run.emit(make_trajectory(50, Eigen::Vector3d(2, 3, 6), 1));
  run.emit(make_trajectory(101, Eigen::Vector3d(1e6, 0, 0), 1));
  Trajectory other_target = make_trajectory(51, Eigen::Vector3d(1e6, 0, 0), 1);
  other_target.target = "other";
  run.emit(other_target);
  run.emit(make_trajectory(55, Eigen::Vector3d(0, 0, 9), 1, "joint"));
  ResultSink& alone = scorer.open_run("goheung alone");
  alone.emit(make_trajectory(51, Eigen::Vector3d(60, 0, 80), 50));
  alone.emit(make_trajectory(52, Eigen::Vector3d(1e6, 0, 0), 50, "joint"));

  const Summary summary = scorer.summary();
  ASSERT_EQ(summary.trajectories.size(), 3u);
  EXPECT_EQ(summary.trajectories[0].label, "fused (song2015)");
  EXPECT_EQ(summary.trajectories[1].label, "joint");
  EXPECT_EQ(summary.trajectories[2].label, "goheung alone");
  const PositionScore& first = summary.trajectories[0].phases[0];
  EXPECT_EQ(first.samples, 100u);
  EXPECT_NEAR(first.rms_m, std::sqrt(101 * 201 / 6.0), 1e-6);  // sum of squares: n (n + 1) (2 n + 1) / 6
  EXPECT_NEAR(first.p95_m, 95, 1e-6);
  EXPECT_NEAR(first.worst_m, 100, 1e-6);
  EXPECT_NEAR(first.inside_95, 0.55, 1e-12);  // up to 20 sqrt(7.8147) = 55.9 m
  const PositionScore& second = summary.trajectories[0].phases[1];
  EXPECT_EQ(second.samples, 1u);
  EXPECT_NEAR(second.rms_m, 7, 1e-6);
  EXPECT_EQ(second.inside_95, 0);
  EXPECT_EQ(summary.trajectories[0].phases[2].samples, 0u);
  EXPECT_NEAR(summary.trajectories[1].phases[1].rms_m, 9, 1e-6);
  EXPECT_NEAR(summary.trajectories[2].phases[1].rms_m, 100, 1e-6);
  EXPECT_EQ(summary.trajectories[2].phases[1].inside_95, 1);
}

TEST(PositionScore, EllipsoidTakesTheWholeCovarianceOfEitherStateSize) {
  // Variance 100 along (1, 1, 0)/sqrt 2 and 1 across: an error of 20 along is inside, across it is not.
  for (const int size : {6, 9}) {
    Scorer scorer = make_scorer();
    ResultSink& run = scorer.open_run("fused");
    for (const double side : {1.0, -1.0}) {
      Trajectory trajectory = make_trajectory(1, Eigen::Vector3d(1, side, 0).normalized() * 20, 0);
      trajectory.state_size = size;
      trajectory.covariance = {};
      trajectory.covariance[0] = 50.5;                                    // xx
      trajectory.covariance[1] = 49.5;                                    // xy
      trajectory.covariance[static_cast<std::size_t>(size)] = 50.5;       // yy
      trajectory.covariance[static_cast<std::size_t>(2 * size - 1)] = 1;  // zz
      run.emit(trajectory);
    }
    EXPECT_EQ(scorer.summary().trajectories[0].phases[0].inside_95, 0.5) << size;
  }
}

TEST(PositionScore, ACovarianceThatIsNoneCountsAsOutside) {
  Scorer scorer = make_scorer();
  ResultSink& run = scorer.open_run("fused");
  run.emit(make_trajectory(1, Eigen::Vector3d::Zero(), 0));
  run.emit(make_trajectory(2, Eigen::Vector3d::Zero(), std::nan("")));
  EXPECT_EQ(scorer.summary().trajectories[0].phases[0].inside_95, 0);
}

TEST(SystematicScore, IsRmsOfTenSecondMeansBeforeAndAfter) {
  Scorer scorer = make_scorer();
  ResultSink& run = scorer.open_run("fused");
  const Polar bias{30, 0.05 * deg, -0.02 * deg};
  std::uint64_t sequence = 0;
  double cos_squares = 0;
  const SensorBias unknown = make_bias({{BiasTerm::OffsetRange, 0}});
  const SensorBias found = make_bias(
      {{BiasTerm::OffsetRange, 30}, {BiasTerm::OffsetAzimuth, 0.05 * deg}, {BiasTerm::OffsetElevation, -0.02 * deg}});
  // Noise that alternates vanishes in each mean. The bias becomes known at 50 s.
  for (int i = 0; i < 1000; ++i) {
    const double noise = i % 2 == 0 ? 25 : -25;
    run.emit(make_plot(++sequence, i * 0.1, {bias.range_m + noise, bias.azimuth_rad, bias.elevation_rad}));
    run.emit(i < 499 ? unknown : found);
    const double c = std::cos(plot_of(make_plot(0, i * 0.1, {}).measured).measured.elevation_rad);
    if (i < 600) cos_squares += c * c / 600;
  }
  const SystematicScore score = scorer.summary().systematic.at(0);
  EXPECT_EQ(score.plots, 600u);  // what comes after the phases is not scored
  EXPECT_NEAR(score.before.range_m, 30, 1e-6);
  EXPECT_NEAR(score.before.azimuth_rad, 0.05 * deg * std::sqrt(cos_squares), 1e-4 * deg);
  EXPECT_NEAR(score.before.elevation_rad, 0.02 * deg, 1e-12);
  EXPECT_NEAR(score.after.range_m, 30 * std::sqrt(5.0 / 6), 1e-6);  // five of six intervals
  EXPECT_NEAR(score.after.elevation_rad, 0.02 * deg * std::sqrt(5.0 / 6), 1e-12);
}

TEST(SystematicScore, TakesOutCartesianAndTimeTerms) {
  Scorer scorer = make_scorer();
  ResultSink& run = scorer.open_run("fused");
  const SensorBias late = make_bias({{BiasTerm::TimeTag, 0.02}});
  run.emit(late);
  for (std::uint64_t i = 1; i <= 90; ++i) {
    run.emit(make_plot(i, static_cast<double>(i), {}, 0.02));
    run.emit(late);
  }
  const SystematicScore late_stamps = scorer.summary().systematic.at(0);
  EXPECT_GT(late_stamps.before.range_m, 1);
  EXPECT_LT(late_stamps.after.range_m, 1e-6);

  Scorer cartesian_scorer = make_scorer();
  ResultSink& cartesian = cartesian_scorer.open_run("fused");
  const SensorBias moved_site =
      make_bias({{BiasTerm::OffsetSouth, 40}, {BiasTerm::OffsetEast, -30}, {BiasTerm::OffsetZenith, 20}});
  cartesian.emit(moved_site);
  for (std::uint64_t i = 1; i <= 90; ++i) {
    Observation plot = make_plot(i, static_cast<double>(i), {});
    const Eigen::Vector3d moved =
        enu_from_polar(plot_of(plot.measured).measured).m + Eigen::Vector3d(-30, -40, 20);  // north = -south
    plot.measured = Plot{.measured = polar_from_enu({moved})};
    cartesian.emit(plot);
    cartesian.emit(moved_site);
  }
  const SystematicScore moved = cartesian_scorer.summary().systematic.at(0);
  EXPECT_GT(moved.before.range_m, 10);
  EXPECT_LT(moved.after.range_m, 1e-6);
  EXPECT_LT(moved.after.azimuth_rad, 1e-12);
  EXPECT_LT(moved.after.elevation_rad, 1e-12);
}

TEST(SystematicScore, LeavesOutRejectedPlotsOutliersAndOtherMethodsBiases) {
  Scorer scorer = make_scorer();
  scorer.know_outliers({{"goheung", 2}}, OutlierOrigin::Truth);
  ResultSink& run = scorer.open_run("fused");
  SensorBias other = make_bias({{BiasTerm::OffsetRange, 1e5}});
  other.method = "joint";
  run.emit(other);
  run.emit(make_plot(1, 1, {10, 0, 0}));
  run.emit(make_plot(2, 2, {5000, 0, 0}));
  Observation doubled = make_plot(1, 1, {10, 0, 0});
  doubled.verdict = Reason::Duplicate;
  run.emit(doubled);
  Observation refused = make_plot(3, 3, {7000, 0, 0});
  refused.verdict = Reason::OutOfLimits;
  run.emit(refused);
  const SystematicScore score = scorer.summary().systematic.at(0);
  EXPECT_EQ(score.plots, 1u);
  EXPECT_EQ(score.rejected, 2u);
  EXPECT_NEAR(score.before.range_m, 10, 1e-6);
  EXPECT_NEAR(score.after.range_m, 10, 1e-6);
}

TEST(SystematicScore, LeavesOutWhatTheMethodRejected) {
  Scorer scorer = make_scorer();
  ResultSink& run = scorer.open_run("fused");
  const SensorBias taken = make_bias({{BiasTerm::OffsetRange, 0}});
  run.emit(make_plot(1, 1, {10, 0, 0}));
  run.emit(taken);
  run.emit(make_plot(2, 2, {5000, 0, 0}));  // gated: no answer
  run.emit(make_plot(3, 3, {10, 0, 0}));
  run.emit(taken);
  run.emit(make_plot(4, 4, {7000, 0, 0}));  // gated, and the last of the flight
  SourceHealth health = make_health(5, 2, 2, 4, 1);
  run.emit(health);
  const Summary summary = scorer.summary();
  EXPECT_EQ(summary.systematic.at(0).plots, 2u);
  EXPECT_NEAR(summary.systematic.at(0).before.range_m, 10, 1e-6);
  EXPECT_EQ(summary.systematic.at(0).rejected, 2u);
  EXPECT_EQ(summary.sources.at(0).rejected(), 2u);
  EXPECT_EQ(summary.sources.at(0).good, 4u);
  EXPECT_EQ(summary.sources.at(0).good_rejected, 2u);
}

TEST(SystematicScore, OfATrackerIsOfItsAngles) {
  RangeConfig range = make_range();
  AngleSensorConfig tracker;
  tracker.id = "optics";
  tracker.site = range.radars[0].site;
  range.angle_sensors = {tracker};
  Scorer scorer(range, "kslv", truth, liftoff, {{"first", 0, 50}});
  ResultSink& run = scorer.open_run("fused");
  SensorBias bias = make_bias({{BiasTerm::OffsetAzimuth, 0}, {BiasTerm::OffsetElevation, -0.02 * deg}});
  bias.sensor = "optics";
  for (std::uint64_t i = 1; i <= 20; ++i) {
    Observation direction = make_plot(i, static_cast<double>(i), {0, 0, -0.02 * deg});
    const Polar seen = plot_of(direction.measured).measured;
    direction.measured = Angles{seen.azimuth_rad, seen.elevation_rad};
    direction.sensor = "optics";
    run.emit(direction);
    run.emit(bias);
  }
  const Summary summary = scorer.summary();
  ASSERT_EQ(summary.systematic.size(), 2u);
  const SystematicScore& score = summary.systematic[1];
  EXPECT_EQ(score.sensor, Name("optics"));
  EXPECT_EQ(score.plots, 20u);
  EXPECT_EQ(score.before.range_m, 0);
  EXPECT_NEAR(score.before.elevation_rad, 0.02 * deg, 1e-12);
  // The bias is known from the second on: of three intervals, the first with nine, one has a ninth left.
  EXPECT_NEAR(score.after.elevation_rad, 0.02 * deg / 9 / std::sqrt(3), 1e-12);
}

TEST(PointingScore, ACommandAtAStopIsScoredUnlessItsTargetIsOutside) {
  SlavingCommand held = make_command(31, 0, 0.3, 1e-3);
  held.limits = LimitElevation;
  for (const bool outside : {false, true}) {
    Scorer scorer = make_scorer(outside ? make_range_out_of_sight() : make_range());
    scorer.open_run("fused").emit(held);
    const auto pointing = scorer.summary().pointing;
    ASSERT_EQ(pointing.size(), 1u);
    EXPECT_EQ(pointing[0].commands, 1u);
    EXPECT_EQ(pointing[0].held, outside ? 1u : 0u);
    EXPECT_EQ(pointing[0].scored, outside ? 0u : 1u);
  }
}

TEST(PointingScore, TravelAndHorizonSayWhereAnAntennaCanPoint) {
  AntennaConfig antenna;
  antenna.azimuth_min_rad = -10 * deg;
  antenna.azimuth_max_rad = 190 * deg;
  antenna.horizon = {{0, 5 * deg}, {90 * deg, 20 * deg}, {180 * deg, 5 * deg}};
  const auto can = [&](double azimuth_deg, double elevation_deg) {
    return can_point_at(antenna, {1e5, azimuth_deg * deg, elevation_deg * deg});
  };
  EXPECT_TRUE(can(355, 30));
  EXPECT_FALSE(can(340, 30));
  EXPECT_TRUE(can(185, 30));
  EXPECT_FALSE(can(200, 30));
  EXPECT_FALSE(can(90, 19));
  EXPECT_TRUE(can(90, 21));
  antenna.elevation_max_rad = std::numbers::pi;
  EXPECT_TRUE(can(270, 30)) << "over the zenith";
}

TEST(PointingScore, IsTheGreatCircleAngleAtApplication) {
  Scorer scorer = make_scorer();
  ResultSink& run = scorer.open_run("fused");
  for (int i = 0; i < 20; ++i) run.emit(make_command(i, 0, (i + 1) * 1e-3, 1e-3));  // elevation: 1 to 20 mrad
  SlavingCommand coasting = make_command(30, 1e-3, 0, 1e-3);
  coasting.source = SlavingSource::Coasting;
  coasting.azimuth_rad += 2 * std::numbers::pi;  // unwrapped: a full turn is no error
  coasting.age_s = 0.5;
  run.emit(coasting);
  const auto pointing = scorer.summary().pointing;
  ASSERT_EQ(pointing.size(), 2u);
  EXPECT_EQ(pointing[0].source, SlavingSource::Fused);
  EXPECT_EQ(pointing[0].commands, 20u);
  EXPECT_EQ(pointing[0].held, 0u);
  EXPECT_NEAR(pointing[0].rms_rad, 1e-3 * std::sqrt(21 * 41 / 6.0), 1e-12);
  EXPECT_NEAR(pointing[0].p95_rad, 19e-3, 1e-12);
  EXPECT_NEAR(pointing[0].worst_rad, 20e-3, 1e-12);
  // All 20 azimuths and the elevations of 1 and 2 mrad; the limit itself is left to rounding.
  EXPECT_NEAR(pointing[0].inside_2_sigma, 21.5 / 40, 0.6 / 40);
  EXPECT_NEAR(pointing[0].mean_age_s, 0.1, 1e-12);
  EXPECT_EQ(pointing[1].source, SlavingSource::Coasting);
  EXPECT_NEAR(pointing[1].rms_rad, 1e-3 * std::cos(look(30).elevation_rad), 1e-9);
  EXPECT_NEAR(pointing[1].worst_age_s, 0.5, 1e-12);
}

TEST(SourceScore, CountsWhatIngestAndTheMethodRejected) {
  Scorer scorer = make_scorer();
  ResultSink& run = scorer.open_run("fused");
  for (std::uint64_t i = 1; i <= 8; ++i) run.emit(make_plot(i, static_cast<double>(i), {}));
  Observation late = make_plot(9, 9, {});
  late.verdict = Reason::TooLate;
  run.emit(late);
  Observation other = make_plot(10, 10, {});
  other.target = "other";
  run.emit(other);
  SourceHealth health = make_health(10, 6, 2, 8, 1);
  health.count[static_cast<std::size_t>(Reason::Frozen)] = 1;
  run.emit(health);
  const SourceScore score = scorer.summary().sources.at(0);
  EXPECT_EQ(score.sensor, Name("goheung"));
  EXPECT_EQ(score.count[static_cast<std::size_t>(Reason::TooLate)], 1u);
  EXPECT_EQ(score.count[static_cast<std::size_t>(Reason::Gated)], 2u);
  EXPECT_EQ(score.count[static_cast<std::size_t>(Reason::Frozen)], 1u);
  EXPECT_EQ(score.count[static_cast<std::size_t>(Reason::Accepted)],
            6u);  // 9 that ingest let through, the rest of these
}

TEST(SourceScore, WhatIntegrityExcludedIsNeitherAcceptedNorRejected) {
  Scorer scorer = make_scorer();
  ResultSink& run = scorer.open_run("fused");
  run.emit(make_plot(1, 1, {}));
  Integrity record;
  record.target = "kslv";
  record.sources = {{.sensor = "goheung", .verdict = IntegrityVerdict::Excluded}};
  run.emit(record);
  run.emit(make_plot(2, 2, {}));
  Observation late = make_plot(3, 3, {});
  late.verdict = Reason::TooLate;
  run.emit(late);
  record.sources[0].verdict = IntegrityVerdict::Agrees;
  run.emit(record);
  run.emit(make_plot(4, 4, {}));
  const SourceScore score = scorer.summary().sources.at(0);
  EXPECT_EQ(score.accepted(), 2U);
  EXPECT_EQ(score.excluded, 1U);
  EXPECT_EQ(score.rejected(), 1U);
  const std::string text = format_text(scorer.summary());
  EXPECT_NE(text.find("not used: 1 while excluded by integrity\n"), std::string::npos) << text;
}

TEST(SourceScore, WhoeverTheRangeDoesNotHaveIsListedLast) {
  Scorer scorer = make_scorer();
  ResultSink& run = scorer.open_run("fused");
  Observation stranger = make_plot(1, 1, {});
  stranger.sensor = "stranger";
  stranger.verdict = Reason::UnknownSource;
  run.emit(stranger);
  const SourceScore score = scorer.summary().sources.back();
  EXPECT_EQ(score.sensor, Name("stranger"));
  EXPECT_EQ(score.count[static_cast<std::size_t>(Reason::UnknownSource)], 1U);
  EXPECT_EQ(score.rejected(), 1U);
}

TEST(SourceScore, AnOutlierIsRejectedUnlessTheMethodAnswersItsEvent) {
  Scorer scorer = make_scorer();
  ResultSink& run = scorer.open_run("fused");
  scorer.know_outliers({{"goheung", 1}, {"goheung", 2}, {"goheung", 3}, {"goheung", 4}, {"goheung", 6}, {"goheung", 7}},
                       OutlierOrigin::Planted);
  std::uint64_t sequence = 0;
  const auto send = [&](Reason verdict = Reason::Accepted) {
    ++sequence;
    Observation plot = make_plot(sequence, static_cast<double>(sequence), {});
    plot.verdict = verdict;
    plot.received = plot.epoch + milliseconds(40);
    run.emit(plot);
    return plot.received;
  };
  const auto answer = [&](Time received, const Name& method) {
    SensorBias bias = make_bias({{BiasTerm::OffsetRange, 1}});
    bias.method = method;
    bias.received = received;
    run.emit(bias);
  };
  answer(send(), "song2015");               // taken
  answer(send(), "joint");                  // by another method: rejected by the first
  send(Reason::OutOfLimits);                // by ingest
  answer(send() - seconds(1), "song2015");  // an answer to something else
  const Time good = send();
  answer(good, "song2015");
  Trajectory of_outlier = make_trajectory(6, Eigen::Vector3d::Zero(), 1);
  of_outlier.received = send();
  run.emit(of_outlier);  // a method without biases answers with its track
  send();                // the last one: nothing came after it
  const SourceScore score = scorer.summary().sources.at(0);
  EXPECT_EQ(score.outliers, 6u);
  EXPECT_EQ(score.outliers_rejected, 4u);
  EXPECT_EQ(score.good, 1u);
  EXPECT_EQ(score.good_rejected, 0u);
}

TEST(SourceScore, TakesDisjointWindowsFromTheEnd) {
  Scorer scorer = make_scorer();
  ResultSink& run = scorer.open_run("fused");
  run.emit(make_plot(1, 1, {}));
  run.emit(make_health(1, 300, 0, 300, 0.5));      // counted: nothing of it is in the window that begins at 500
  run.emit(make_health(2, 900, 0, 900, 0));        // inside the next
  run.emit(make_health(3, 1400, 100, 1000, 0.9));  // counted: 500 to 1500
  run.emit(make_health(4, 1900, 100, 1000, 0.92));
  run.emit(make_health(5, 2400, 100, 1000, 0.96));  // counted: 1500 to 2500
  const SourceScore score = scorer.summary().sources.at(0);
  EXPECT_EQ(score.nis_count, 2300u);
  EXPECT_NEAR(score.nis_inside_95, (960 + 900 + 150) / 2300.0, 1e-12);
  EXPECT_EQ(score.least_nis_inside_95, 0.9);
  EXPECT_EQ(score.mismatch_s, 2);
}

// Clopper, Pearson 1934, at whole counts as published; between them in between.
TEST(HonestBand, IsClopperPearsonsAndWidensForAShortFlight) {
  const Band ten = honest_band(0.9, 10);
  EXPECT_NEAR(ten.low, clopper_pearson(9, 10, 0.05).low, 1e-12);
  EXPECT_NEAR(ten.high, clopper_pearson(9, 10, 0.05).high, 1e-12);
  EXPECT_LT(honest_band(0.9, 9.5).low, ten.low);
  EXPECT_GT(honest_band(0.9, 9.5).high, ten.high);
  EXPECT_EQ(honest_band(1, 8).high, 1);
  EXPECT_EQ(honest_band(0, 8).low, 0);
  EXPECT_EQ(honest_band(0.2, 0.9).low, 0) << "less than one value says nothing";
  EXPECT_EQ(honest_band(0.2, 0.9).high, 1);
  EXPECT_TRUE(honest_band(0.8, 5).contains(0.95)) << "five minutes do not refute a right model";
  EXPECT_FALSE(honest_band(0.8, 60).contains(0.95)) << "an hour does";
}

TEST(SourceScore, AFlightOfTenMinutesHasTenIndependentValues) {
  Scorer scorer = make_scorer();
  ResultSink& run = scorer.open_run("fused");
  run.emit(make_plot(1, 1, {}));
  for (int t = 1; t <= 600; ++t)
    run.emit(make_health(t, static_cast<std::uint64_t>(10 * t), 0, std::min(10 * t, 1000), 0.9));
  for (int t = 601; t <= 700; ++t) run.emit(make_health(t, 6000, 0, 1000, 0.9));  // silent: nothing more is known
  const SourceScore score = scorer.summary().sources.at(0);
  EXPECT_EQ(score.nis_independent, 10);
  EXPECT_NEAR(score.nis_band.low, clopper_pearson(9, 10, 0.05).low, 1e-9);
  EXPECT_NE(format_text(scorer.summary()).find(" 55-100 "), std::string::npos);
}

TEST(SourceScore, WithoutAFullWindowThereIsNoWorstAndOfNothingNoShare) {
  Scorer scorer = make_scorer();
  ResultSink& run = scorer.open_run("fused");
  run.emit(make_plot(1, 1, {}));
  run.emit(make_health(1, 0, 0, 0, 1));
  EXPECT_EQ(scorer.summary().sources.at(0).nis_count, 0u);
  EXPECT_TRUE(nlohmann::json::parse(format_json(scorer.summary()))["sources"][0]["nis_inside_95"].is_null());
  run.emit(make_health(2, 10, 0, 10, 0.8));
  const SourceScore score = scorer.summary().sources.at(0);
  EXPECT_EQ(score.nis_inside_95, 0.8);
  EXPECT_FALSE(score.least_nis_inside_95);
}

}  // namespace
}  // namespace downrange::score
