/// The experiment noise, short: every sigma configured a third, right and three times, and what is learnt in flight
/// mends it; the same on any number of threads.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "../support/same_figures.hpp"
#include "experiment/experiment.hpp"
#include "experiment/report.hpp"

namespace downrange::experiment {
namespace {

ExperimentResult run(int jobs, std::vector<std::string> methods) {
  return run_noise({.runs = 10, .seed = 1, .jobs = jobs, .methods = std::move(methods)});
}

double measured(const ExperimentResult& result, const std::string& what) {
  const auto figure = std::ranges::find(result.figures, what, &Figure::what);
  if (figure == result.figures.end()) throw std::runtime_error("no figure " + what);
  return figure->measured;
}

TEST(NoiseExperiment, ReachesItsFiguresOnAnyNumberOfThreads) {
  const ExperimentResult one = run(1, {"joint"});
  const ExperimentResult two = run(2, {"joint"});
  test::expect_same_figures(one, two);
  for (const Figure& figure : one.figures)
    EXPECT_TRUE(figure.reached) << figure.what << ' ' << figure.measured << ' ' << figure.reach;
}

/// What it is worth: the same flights with the sigmas kept.
TEST(NoiseExperiment, WithoutLearningAThirdLosesTheTrackAndThreefoldIsNotHonest) {
  const ExperimentResult kept = run(2, {"joint-fixed"});
  EXPECT_GT(measured(kept, "joint-fixed, sigma / 3: good plots rejected, %"), 20);
  EXPECT_GT(measured(kept, "joint-fixed, sigma / 3: rms over that of right"), 3);
  EXPECT_GT(measured(kept, "joint-fixed, sigma x 3: NIS inside, jeju"), 0.99);
  EXPECT_THROW((void)run(1, {"song2015"}), std::invalid_argument);
}

}  // namespace
}  // namespace downrange::experiment
