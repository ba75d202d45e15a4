#include <gtest/gtest.h>

#include "../support/judged_flight.hpp"

namespace downrange::test {
namespace {

constexpr SourceId first_station = 2;
constexpr SourceId second_station = 3;
constexpr SourceSet gps = set_of(first_station) | set_of(second_station);

TEST(Judge, NobodyIsAccusedInAFaultFreeFlight) {
  const RangeConfig range = judged_range();
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    const sim::Simulation flight(judged_launch(range, 480), seed);
    const JudgedFlight f = judged(range, flight.events());
    EXPECT_TRUE(f.said.empty()) << "seed " << seed << "\n" << described(f);
    EXPECT_GT(f.largest_value, 0) << "nothing was compared";
  }
}

TEST(Judge, AReceiverThatJumpsIsNamedAndBelievedAgainTenSecondsAfterItIsRight) {
  const RangeConfig range = judged_range();
  for (const double step_m : {200.0, 5000.0}) {
    sim::Scenario scenario = judged_launch(range, 190);
    scenario.gps.faults.push_back({{150, 170}, {step_m, 0, 0}, {0, 0, 0}});
    const sim::Simulation flight(scenario, 1);
    const JudgedFlight f = judged(range, flight.events(), gps);
    for (const SourceId station : {first_station, second_station}) {
      const auto excluded = f.first(station, IntegrityVerdict::Excluded);
      ASSERT_TRUE(excluded) << described(f);
      EXPECT_GE(*excluded, 150);
      EXPECT_LE(*excluded, step_m < 1000 ? 153 : 151.5);
      const auto back = f.first(station, IntegrityVerdict::Agrees, *excluded);
      ASSERT_TRUE(back) << described(f);
      EXPECT_GE(*back, 180);
      EXPECT_LE(*back, 182);
    }
    EXPECT_FALSE(f.first(goheung, IntegrityVerdict::Suspect)) << described(f);
    EXPECT_FALSE(f.first(jeju, IntegrityVerdict::Suspect)) << described(f);
  }
}

}  // namespace
}  // namespace downrange::test
