/// The experiments federated, spatial and alphabeta: the same on any number of threads, their figures reached in a
/// short run already, methods that can be left out.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "../support/same_figures.hpp"
#include "experiment/experiment.hpp"
#include "experiment/report.hpp"

namespace downrange::experiment {
namespace {

class PaperExperiment : public testing::TestWithParam<const char*> {
 protected:
  static const Experiment& experiment() {
    return *std::find_if(experiments().begin(), experiments().end(),
                         [](const Experiment& e) { return e.name == GetParam(); });
  }
  static ExperimentResult run(int runs, int jobs, std::vector<std::string> methods = {}) {
    ExperimentOptions options;
    options.runs = runs;
    options.seed = 7;
    options.jobs = jobs;
    options.methods = std::move(methods);
    return experiment().run(options);
  }
};

TEST_P(PaperExperiment, DoesNotDependOnThreads) {
  const ExperimentResult one = run(9, 1);
  const ExperimentResult four = run(9, 4);
  test::expect_same_figures(one, four);
  ASSERT_EQ(one.plots.size(), four.plots.size());
  for (std::size_t p = 0; p < one.plots.size(); ++p) {
    ASSERT_EQ(one.plots[p].curves.size(), four.plots[p].curves.size());
    for (std::size_t c = 0; c < one.plots[p].curves.size(); ++c)
      EXPECT_EQ(one.plots[p].curves[c].y, four.plots[p].curves[c].y) << one.plots[p].title;
  }
  EXPECT_EQ(one.seed, 7u);
  EXPECT_EQ(one.runs, 9);
}

TEST_P(PaperExperiment, ReachesItsFiguresAndIsFinite) {
  const ExperimentResult result = run(120, 2);
  for (const Figure& figure : result.figures) {
    EXPECT_TRUE(std::isfinite(figure.measured)) << figure.what;
    EXPECT_LE(figure.what.size(), figure_name_width) << figure.what;
    // 120 runs of one seed: NEES bands are those of the stated runs, the others have their margin.
    EXPECT_TRUE(figure.reached) << figure.what << ' ' << figure.measured << ' ' << figure.reach;
  }
  EXPECT_FALSE(result.settings.empty());
  for (const Plot& plot : result.plots) {
    EXPECT_FALSE(plot.curves.empty()) << plot.title;
    for (const Curve& curve : plot.curves) {
      EXPECT_EQ(curve.x.size(), curve.y.size());
      EXPECT_TRUE(std::all_of(curve.y.begin(), curve.y.end(), [](double y) { return std::isfinite(y); }))
          << plot.title << ", " << curve.label;
    }
  }
}

TEST_P(PaperExperiment, EachMethodAloneAndNoOther) {
  for (const std::string& method : experiment().methods) {
    const ExperimentResult result = run(2, 1, {method});
    const bool drawn = std::any_of(result.plots.begin(), result.plots.end(), [&](const Plot& plot) {
      return std::any_of(plot.curves.begin(), plot.curves.end(), [&](const Curve& c) { return c.label == method; });
    });
    EXPECT_TRUE(drawn) << method;
  }
  EXPECT_THROW((void)run(2, 1, {"no such method"}), std::invalid_argument);
}

TEST_P(PaperExperiment, ReportsItsProgress) {
  double last = 0;
  ExperimentOptions options;
  options.runs = 5;
  options.progress = [&](double fraction) {
    EXPECT_GT(fraction, last);
    last = fraction;
  };
  (void)experiment().run(options);
  EXPECT_EQ(last, 1);
}

INSTANTIATE_TEST_SUITE_P(Papers, PaperExperiment, testing::Values("federated", "spatial", "alphabeta"),
                         [](const auto& param) { return std::string(param.param); });

}  // namespace
}  // namespace downrange::experiment
