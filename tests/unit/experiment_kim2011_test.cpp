/// The experiment of kim2011 with few runs: the same on any number of threads, and what it must show.
#include <gtest/gtest.h>

#include <cmath>
#include <downrange/est/filter/consistency.hpp>
#include <stdexcept>

#include "experiment/experiment.hpp"
#include "experiment/kim2011_methods.hpp"
#include "experiment/report.hpp"

namespace downrange::experiment {
namespace {

using namespace kim2011;

TEST(Kim2011, JacobiansOfAPlotAreItsDifferences) {
  const Draw d = draw(5, 0);
  for (const int sensor : {0, 1}) {
    for (std::size_t t = 0; t < targets; ++t) {
      const Vec<4>& x = d.truth[7][t];
      const Vec<terms> beta = 10 * true_bias();
      const PlanarPlot p = predict_plot(sensor, x, beta);
      for (int i = 0; i < 4; ++i) {
        // Steps of a metre and of a thousandth of a bias: third derivatives and rounding leave 1e-7 of a row.
        const Vec<4> step = Vec<4>::Unit(i);
        const Vec<2> by_state = (predict_plot(sensor, x + step, beta).q - predict_plot(sensor, x - step, beta).q) / 2;
        EXPECT_LT((by_state - p.d_state.col(i)).norm(), 1e-7 * p.d_state.row(0).norm());
        const Vec<terms> change = 1e-3 * beta[i] * Vec<terms>::Unit(i);
        const Vec<2> by_bias =
            (predict_plot(sensor, x, beta + change).q - predict_plot(sensor, x, beta - change).q) / (2 * change[i]);
        EXPECT_LT((by_bias - p.d_bias.col(i)).norm(), 1e-6 * (1 + p.d_bias.col(i).norm()));
      }
    }
  }
}

TEST(Kim2011, ConvertedPlotSeesTheBiasThroughItsMatrix) {
  const Draw d = draw(5, 1);
  for (std::size_t t = 0; t < targets; ++t) {
    const Vec<4>& x = d.truth[3][t];
    const Vec<2> biased = predict_plot(1, x, true_bias()).q;
    const BiasedPosition<2, terms> z = converted(1, biased);
    // Second order in 2 mrad at 48 km: 0.1 m.
    EXPECT_LT((z.z - z.BC * true_bias() - x.head<2>()).norm(), 0.2);
  }
}

TEST(Kim2011, TwoStageIsTheAugmentedStateFilter) { EXPECT_LT(ts_against_augmented(draw(2, 0)), 1e-8); }

TEST(Kim2011, TwoStageIsHonestAndPseudoMeasurementsAreNot) {
  constexpr int runs = 20;
  double ts = 0;
  double pm = 0;
  double scaled = 0;
  for (int run = 0; run < runs; ++run) {
    const Draw d = draw(3, run);
    ts += run_ts(d, Start::BiasFree).scan[scans].nees;
    pm += run_pm(d, Start::BiasFree, 1).scan[scans].nees;
    scaled += run_pm(d, Start::BiasFree, 2.4).scan[scans].nees;
  }
  // An honest covariance leaves this band once in 10 000 tests.
  const double low = chi2_quantile(0.00005, biases * runs);
  const double high = chi2_quantile(0.99995, biases * runs);
  EXPECT_GT(ts, low);
  EXPECT_LT(ts, high);
  EXPECT_GT(pm, high);
  EXPECT_LT(scaled, high);
}

TEST(Kim2011, ResultsDoNotDependOnTheThreads) {
  ExperimentOptions options;
  options.runs = 20;
  options.seed = 4;
  options.methods = {"exx", "pm"};
  const ExperimentResult one = run_kim2011(options);
  options.jobs = 3;
  const ExperimentResult three = run_kim2011(options);
  EXPECT_EQ(format_json(std::vector{one}), format_json(std::vector{three}));
}

TEST(Kim2011, EveryFigureHasItsNameOnOneLine) {
  ExperimentOptions options;
  options.runs = 1;
  for (const Figure& figure : run_kim2011(options).figures)
    EXPECT_LE(figure.what.size(), figure_name_width) << figure.what;
}

TEST(Kim2011, RefusesAMethodThatItDoesNotCompare) {
  ExperimentOptions options;
  options.methods = {"joint"};
  EXPECT_THROW((void)run_kim2011(options), std::invalid_argument);
}

}  // namespace
}  // namespace downrange::experiment
