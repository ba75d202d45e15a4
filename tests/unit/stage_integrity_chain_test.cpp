/// What chains are made of: which there are, what they are called, what they hear, what they are run again on.
#include <gtest/gtest.h>

#include "../support/small_range.hpp"
#include "stage/integrity/bound.hpp"
#include "stage/integrity/chain_plan.hpp"
#include "stage/integrity/exclusions.hpp"
#include "stage/integrity/measurement_log.hpp"

namespace downrange {
namespace {

std::vector<std::string_view> names_of(const ChainPlans& plans) {
  std::vector<std::string_view> names;
  for (const ChainPlan& plan : plans.chains) names.push_back(plan.name.view());
  return names;
}

ChainPlans plans_of(const RangeConfig& range, bool takes_angles = true) {
  return plan_chains(source_units(SourceTable(range), takes_angles));
}

TEST(ChainPlan, EachLeftOutEachAloneAllRadarsAndEachSetOnce) {
  const ChainPlans plans = plans_of(test::small_range());
  // Without GPS is all radars. The stations are one receiver.
  EXPECT_EQ(names_of(plans), (std::vector<std::string_view>{"without-goheung", "without-jeju", "without-GPS",
                                                            "only-goheung", "only-jeju", "only-GPS"}));
  EXPECT_EQ(plans.chains[0].sources, SourceSet{0b1110});
  EXPECT_EQ(plans.chains[5].sources, SourceSet{0b1100});
  EXPECT_EQ(plans.without, (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(plans.alone, (std::vector<int>{3, 4, 5}));
  for (std::size_t i = 0; i < plans.chains.size(); ++i) EXPECT_EQ(plans.chains[i].alone, i >= 3);
}

TEST(ChainPlan, ATrackerAloneStartsNothing) {
  RangeConfig range = test::small_range();
  range.angle_sensors = {test::small_tracker()};
  EXPECT_EQ(names_of(plans_of(range)),
            (std::vector<std::string_view>{"without-goheung", "without-jeju", "without-optical", "without-GPS",
                                           "only-radars", "only-goheung", "only-jeju", "only-GPS"}));
  // To a method that takes no angles it is no source.
  EXPECT_EQ(plans_of(range, false).chains.size(), 6u);
  // One radar and a tracker: without the radar there is nothing to start with.
  range.radars.pop_back();
  range.telemetry.clear();
  const ChainPlans plans = plans_of(range);
  EXPECT_EQ(plans.without, (std::vector<int>{ChainPlans::none, 0}));
  EXPECT_EQ(names_of(plans), (std::vector<std::string_view>{"only-goheung"}));
}

TEST(ChainPlan, OfTwoSourcesTheOneLeftOutIsTheOtherAlone) {
  RangeConfig range = test::small_range();
  range.radars.pop_back();
  const ChainPlans plans = plans_of(range);
  EXPECT_EQ(names_of(plans), (std::vector<std::string_view>{"only-GPS", "only-goheung"}));
  EXPECT_EQ(plans.without, (std::vector<int>{0, 1}));
  EXPECT_EQ(plans.alone, (std::vector<int>{1, 0}));
}

TEST(ChainPlan, MoreThanSixSourcesAreNotEachAlone) {
  RangeConfig range = test::small_range();
  while (range.radars.size() < 6) {
    range.radars.push_back(range.radars.front());
    range.radars.back().id = Name("radar-" + std::to_string(range.radars.size()));
  }
  const ChainPlans plans = plans_of(range);
  ASSERT_EQ(plans.chains.size(), 8u);  // seven left out, without GPS being all radars, and GPS
  EXPECT_EQ(plans.chains.back().name, Name("only-GPS"));
  EXPECT_EQ(plans.alone.front(), ChainPlans::none);
}

TEST(ChainPlan, LongNamesAreCutAndStayDifferent) {
  EXPECT_EQ(joined_name("joint/", "without-goheung-radar", 0), Name("joint/without-goheung-radar"));
  EXPECT_EQ(joined_name("without-", "a-name-of-thirty-one-characters", 7), Name("without-a-name-of-thirty-one-.7"));
  EXPECT_NE(joined_name("without-", "a-name-of-thirty-one-characters", 7),
            joined_name("without-", "a-name-of-thirty-one-characterz", 8));
}

Time at(double t) { return test::liftoff + seconds(t); }

TEST(Exclusions, AreToldByEpoch) {
  Exclusions exclusions;
  exclusions.open(0, 1, at(10));
  exclusions.close(0, 1, at(20));
  exclusions.open(0, 1, at(30));
  const auto covered = [&](double t) { return exclusions.cover(0, 1, at(t)); };
  EXPECT_FALSE(covered(9.9));
  EXPECT_TRUE(covered(10));
  EXPECT_FALSE(covered(20));
  EXPECT_TRUE(covered(1000));
  EXPECT_FALSE(exclusions.cover(1, 1, at(15)));
  EXPECT_FALSE(exclusions.cover(0, 0, at(15)));
  exclusions.forget_before(at(25));
  EXPECT_FALSE(covered(15));
  EXPECT_TRUE(covered(40));
}

TEST(MeasurementLog, KeepsTheOrderOfProcessingAndItsPositions) {
  MeasurementLog log;
  const auto measurement = [](double t) {
    LoggedMeasurement logged;
    logged.m.epoch = at(t);
    return logged;
  };
  EXPECT_EQ(log.insert(measurement(1)), 0u);
  EXPECT_EQ(log.insert(measurement(3)), 1u);
  EXPECT_EQ(log.insert(measurement(2)), 1u);
  EXPECT_TRUE(log.complete());
  EXPECT_EQ(log.first_from(at(2)), 1u);
  log.forget_before(at(2), log.end());
  EXPECT_FALSE(log.complete());
  EXPECT_EQ(log.begin(), 1u);
  EXPECT_EQ(log[1].m.epoch, at(2));
  log.forget_before(at(10), 2);  // somebody is still there
  EXPECT_EQ(log.begin(), 2u);
  EXPECT_EQ(log.end(), 3u);
}

TEST(Bound, IsTheFarthestAlternativeWithItsOwnNoise) {
  const std::vector<Alternative> alternatives{
      {.from_selected_m = {3, 4, 0}, .cov = Eigen::Vector3d(1, 4, 9).asDiagonal()},
      {.from_selected_m = {10, 0, 0}, .cov = 0.01 * Eigen::Matrix3d::Identity()}};
  EXPECT_NEAR(bound_m(alternatives), 5 + 4.1 * 3, 1e-12);
  EXPECT_EQ(bound_m({}), 0);
}

TEST(Bound, AsAnAngleCountsWhatIsAcrossTheLineOfSight) {
  const Eigen::Vector3d selected(100'000, 0, 0);
  const std::vector<Alternative> nearer{
      {.from_selected_m = {-50'000, 0, 0}, .cov = Eigen::Vector3d(1e8, 100, 400).asDiagonal()}};
  EXPECT_NEAR(bound_rad(nearer, Eigen::Vector3d::UnitX(), selected), 4.1 * 20 / 50'000, 1e-8);
  // A command that is not there yet is farther from where the target may be.
  const Eigen::Vector3d commanded = Eigen::Vector3d(1, 0.1, 0).normalized();
  EXPECT_NEAR(bound_rad(nearer, commanded, selected), std::atan(0.1) + 4.1 * 20 / 50'000, 1e-8);
  // At the antenna itself, any direction.
  const std::vector<Alternative> here{{.from_selected_m = -selected, .cov = Eigen::Matrix3d::Identity()}};
  EXPECT_EQ(bound_rad(here, commanded, selected), std::numbers::pi);
}

}  // namespace
}  // namespace downrange
