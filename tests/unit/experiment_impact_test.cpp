/// The impact experiment: the same on any number of threads, and its misses are those of a good track.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "../support/same_figures.hpp"
#include "experiment/impact.hpp"

namespace downrange::experiment {
namespace {

honesty::Profile short_launch() {
  honesty::Profile profile = impact::profile(10);
  profile.end_s = 110;
  return profile;
}

TEST(ImpactExperiment, ASeedFliesTheSameTwiceAndItsMissesAreThoseOfAGoodTrack) {
  const impact::Flown one = impact::fly(short_launch(), true, 7);
  const impact::Flown two = impact::fly(short_launch(), true, 7);
  ASSERT_GT(one.misses.size(), 190u);
  ASSERT_EQ(one.misses.size(), two.misses.size());
  EXPECT_EQ(one.untold, 0);
  for (std::size_t i = 0; i < one.misses.size(); ++i) {
    const impact::Miss& m = one.misses[i];
    EXPECT_EQ(m.along_m, two.misses[i].along_m);
    EXPECT_LT(std::hypot(m.along_m, m.across_m), 6 * m.sigma_m) << m.t_s;
    EXPECT_TRUE(m.settled);
  }
  EXPECT_GT(one.misses.back().downrange_m, 40e3);
  EXPECT_LT(one.misses.front().downrange_m, 1e3);
}

TEST(ImpactExperiment, FiguresDoNotDependOnThreads) {
  ExperimentOptions options;
  options.runs = 1;
  options.seed = 3;
  options.jobs = 1;
  const ExperimentResult one = run_impact(options);
  options.jobs = 3;
  const ExperimentResult three = run_impact(options);
  test::expect_same_figures(one, three);
  ASSERT_EQ(one.figures.size(), 18u);
  for (const Figure& figure : one.figures) {
    EXPECT_TRUE(std::isfinite(figure.measured)) << figure.what;
    // One seed is no share and no 3 sigma, but what falls freely is told of, and no point is wild.
    if (figure.what.ends_with("of what comes down")) {
      EXPECT_EQ(figure.measured, 0) << figure.what;
    }
    if (figure.what.ends_with("along, % of downrange")) {
      EXPECT_LT(figure.measured, figure.what.starts_with("no GPS") ? 10 : 1) << figure.what;
    }
  }
  options.methods = {"song2015"};
  EXPECT_THROW((void)run_impact(options), std::invalid_argument);
}

}  // namespace
}  // namespace downrange::experiment
