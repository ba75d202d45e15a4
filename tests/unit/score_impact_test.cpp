/// What the report tells of impact points: their error against the fall of the true state, data loss, boundaries.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include <downrange/geo/free_fall.hpp>
#include "score/impact_tally.hpp"
#include "score_testing.hpp"

namespace downrange::score {
namespace {

using namespace test;

/// `east_m` off from where the true state falls, claiming `sigma_m` on both axes.
ImpactPoint make_impact(double t_s, double east_m, double sigma_m, const Name& chain = {}) {
  ImpactPoint i;
  i.target = "kslv";
  i.chain = chain;
  i.epoch = i.received = at(t_s);
  i.impact_valid = true;
  const auto landing = fall_to(*truth(at(t_s)), 0, 3600);
  const Site there(geodetic_from_ecef(landing->state.position));
  i.point = geodetic_from_ecef(there.ecef_of({{east_m, 0, 0}}));
  i.covariance_m2 = {sigma_m * sigma_m, 0, sigma_m * sigma_m};
  i.data_age_s = i.data_loss_timer_s = 0.1;
  return i;
}

TEST(ImpactScore, ErrorsAreAgainstTheFallOfTheTrueState) {
  Scorer scorer = make_scorer();
  ResultSink& run = scorer.open_run("fused");
  for (int k = 0; k < 20; ++k) run.emit(make_impact(10 + k, k == 0 ? 300 : 100, 100));
  run.emit(make_impact(12, 500, 100, "only-GPS"));
  ImpactPoint none = make_impact(40, 0, 100);
  none.impact_valid = false;
  none.data_loss_timer_s = 12.5;
  none.data_loss_limit_s = 10;
  none.data_loss_limit_valid = true;
  run.emit(none);
  ImpactPoint other = make_impact(20, 1e6, 1);
  other.target = "another";
  run.emit(other);
  const Summary summary = scorer.summary();
  ASSERT_EQ(summary.impacts.size(), 2u);
  const ImpactScore& selected = summary.impacts[0];
  EXPECT_TRUE(selected.chain.empty());
  EXPECT_EQ(selected.points, 20u);
  EXPECT_EQ(selected.without_point, 1u);
  EXPECT_EQ(selected.judged, 20u);
  EXPECT_NEAR(selected.rms_m, std::sqrt((19 * 1e4 + 9e4) / 20), 0.1);
  EXPECT_NEAR(selected.p95_m, 100, 0.1);
  EXPECT_NEAR(selected.worst_m, 300, 0.1);
  EXPECT_NEAR(selected.inside_95, 0.95, 1e-9) << "300 m is 3 sigmas";
  ASSERT_TRUE(selected.longest_loss);
  EXPECT_EQ(selected.longest_loss->value, 12.5);
  EXPECT_NEAR(selected.longest_loss->t_s, 40, 1e-6);
  EXPECT_EQ(selected.over_limit, 1u);
  EXPECT_EQ(summary.impacts[1].chain, Name("only-GPS"));
  EXPECT_NEAR(summary.impacts[1].worst_m, 500, 0.1);

  const std::string text = format_text(summary);
  EXPECT_NE(text.find("selected chain              20      1"), std::string::npos) << text;
  EXPECT_NE(text.find("  without data for longer than allowed in 1 records, first at     40.0 s\n"), std::string::npos)
      << text;
  const auto json = nlohmann::json::parse(format_json(summary))["impact"];
  ASSERT_EQ(json.size(), 2u);
  EXPECT_EQ(json[0]["points"], 20);
  EXPECT_EQ(json[0]["longest_loss"]["data_loss_s"], 12.5);
  EXPECT_EQ(json[0]["first_over_limit_s"], 40.0);
  EXPECT_TRUE(json[1]["first_over_limit_s"].is_null());
}

TEST(ImpactScore, BoundariesByTheSelectedChain) {
  Scorer scorer = make_scorer();
  ResultSink& run = scorer.open_run("fused");
  const auto emit = [&](double t_s, const Name& chain, double distance_m, double present_m, double outside) {
    ImpactPoint i = make_impact(t_s, 0, 100, chain);
    i.boundaries = {{.boundary = "corridor",
                     .distance_m = distance_m,
                     .present_distance_m = present_m,
                     .probability_outside = outside}};
    run.emit(i);
  };
  emit(10, {}, 5000, 9000, 1e-6);
  emit(20, {}, -2000, 8000, 0.9);
  emit(30, {}, -1000, 7000, 0.8);
  emit(25, "only-GPS", -90'000, -90'000, 1);
  const Summary summary = scorer.summary();
  ASSERT_EQ(summary.boundaries.size(), 1u);
  const BoundaryScore& b = summary.boundaries[0];
  EXPECT_EQ(b.least_m->value, -2000);
  EXPECT_NEAR(b.least_m->t_s, 20, 1e-6);
  EXPECT_EQ(b.least_present_m->value, 7000);
  EXPECT_EQ(b.most_outside->value, 0.9);
  EXPECT_NEAR(*b.first_outside_s, 20, 1e-6);
  const std::string text = format_text(summary);
  EXPECT_NE(text.find("  the impact point was outside first at     20.0 s\n"), std::string::npos) << text;
  std::istringstream lines(text.substr(text.find("Vacuum impact point")));
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
  const auto json = nlohmann::json::parse(format_json(summary))["boundaries"];
  EXPECT_EQ(json[0]["least"]["distance_m"], -2000.0);
}

TEST(ImpactScore, WithoutImpactPointsNothingIsTold) {
  Scorer scorer = make_scorer();
  scorer.open_run("fused").emit(make_trajectory(1, {1, 0, 0}, 1));
  EXPECT_EQ(format_text(scorer.summary()).find("impact point"), std::string::npos);
  EXPECT_TRUE(nlohmann::json::parse(format_json(scorer.summary()))["impact"].empty());
}

}  // namespace
}  // namespace downrange::score
