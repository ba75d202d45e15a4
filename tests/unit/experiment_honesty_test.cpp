/// The honesty experiment: the same on any number of threads, drawn from what is assumed, and it tells a lie from the
/// truth.
#include <gtest/gtest.h>

#include <cmath>

#include "../support/same_figures.hpp"
#include "experiment/honesty.hpp"
#include "experiment/report.hpp"

namespace downrange::experiment {
namespace {

using namespace honesty;

Profile short_launch() {
  Profile profile = launch_profile();
  profile.end_s = 100;
  return profile;
}

Track flown(const Profile& profile, bool gps, int seeds) {
  Track track;
  for (int i = 0; i < seeds; ++i) track += fly(profile, gps, 100 + static_cast<std::uint64_t>(i));
  return track;
}

TEST(Honesty, ASeedFliesTheSameTwiceAndAnotherDiffers) {
  const Track one = fly(short_launch(), true, 7);
  const Track two = fly(short_launch(), true, 7);
  EXPECT_GT(one.inside.count, 100);
  EXPECT_EQ(one.position.sum, two.position.sum);
  EXPECT_EQ(one.nees.sum, two.nees.sum);
  EXPECT_NE(one.position.sum, fly(short_launch(), true, 8).position.sum);
  EXPECT_NE(one.position.sum, fly(short_launch(), false, 7).position.sum);
}

TEST(Honesty, AMotionThatNoModelHasIsSeen) {
  // GPS alone, as the range says it is; then a vehicle that moves as no model has it.
  Profile honest = short_launch();
  honest.range.radars.resize(1);
  honest.range.radars[0].range_max_m = 1;  // no plot
  const double share = flown(honest, true, 4).inside.value();
  EXPECT_GT(share, 0.8);
  Profile told = honest;
  told.truth = [truth = honest.truth, honest_liftoff = honest.liftoff](Time t) {
    auto state = truth(t);
    if (state) state->position.m.x() += 40 * std::sin((t - honest_liftoff).seconds());
    return state;
  };
  EXPECT_LT(flown(told, true, 4).inside.value(), share - 0.2);
}

TEST(Honesty, RunsOfAllProfilesDoNotDependOnThreads) {
  ExperimentOptions options;
  options.runs = 2;
  options.seed = 3;
  options.jobs = 1;
  const ExperimentResult one = run_honesty(options, {});
  options.jobs = 3;
  const ExperimentResult three = run_honesty(options, {});
  test::expect_same_figures(one, three);
  EXPECT_EQ(one.plots.size(), 4u);
  EXPECT_EQ(one.notes.size(), 1u) << "what is left out is said";
  EXPECT_NE(format_html({&one, 1}).find("<svg"), std::string::npos);
  options.methods = {"song2015"};
  EXPECT_THROW((void)run_honesty(options, {}), std::invalid_argument);
}

TEST(WithoutGps, TwoRadarsBeatTheirUncorrectedFusionAndAreNearTheBound) {
  ExperimentOptions options;
  options.runs = 1;
  options.seed = 2;
  options.jobs = 1;
  const ExperimentResult one = run_without_gps(options, {});
  options.jobs = 2;
  test::expect_same_figures(one, run_without_gps(options, {}));
  ASSERT_EQ(one.figures.size(), 14u);
  int both = 0;
  for (const Figure& figure : one.figures) {
    const bool over_uncorrected = figure.what.ends_with("two radars: joint over uncorrected");
    const bool over_bound = figure.what.ends_with("two radars: joint over bound");
    both += over_uncorrected || over_bound;
    if (over_uncorrected) {
      EXPECT_LT(figure.measured, 1) << figure.what;
    }
    // One draw of biases that last a flight: half of what is promised, or twice, is luck; ten times is an error.
    if (over_bound) {
      EXPECT_GT(figure.measured, 0.3) << figure.what;
      EXPECT_LT(figure.measured, 3) << figure.what;
    }
  }
  EXPECT_EQ(both, 4);
}

}  // namespace
}  // namespace downrange::experiment
