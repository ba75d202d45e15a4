/// The experiments' framework: figures, tables, JSON, pages.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "experiment/experiment.hpp"
#include "experiment/launch_score.hpp"
#include "experiment/report.hpp"

namespace downrange::experiment {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST(Figure, IsReachedOnItsLimitAndNotByNan) {
  EXPECT_TRUE(at_most("", 1.10, 1.10).reached);
  EXPECT_FALSE(at_most("", 1.1001, 1.10).reached);
  EXPECT_FALSE(at_most("", nan, 1.10).reached);
  EXPECT_TRUE(at_least("", 1.3, 1.3).reached);
  EXPECT_FALSE(at_least("", nan, 1.3).reached);
  EXPECT_TRUE(within("", 0.94, 0.94, 0.96).reached);
  EXPECT_FALSE(within("", 0.97, 0.94, 0.96).reached);
  EXPECT_FALSE(within("", nan, 0.94, 0.96).reached);
  EXPECT_TRUE(shown("", nan).reached);
  EXPECT_EQ(at_most("", 0, 1.1).reach, "<= 1.10");
  EXPECT_EQ(within("", 0, 0.9, 1.1).reach, "0.900 .. 1.10");
}

TEST(NumberText, KeepsTheDigitsAskedFor) {
  EXPECT_EQ(number_text(1.1, 3), "1.10");
  EXPECT_EQ(number_text(1.0 / 28, 3), "0.0357");
  EXPECT_EQ(number_text(1e-9, 3), "1e-9");
  EXPECT_EQ(number_text(-2.5e-12, 3), "-2.5e-12");
  EXPECT_EQ(number_text(3e7, 3), "3e7");
  EXPECT_EQ(number_text(1000, 3), "1000");
  EXPECT_EQ(number_text(12345.6, 3), "12346");
  EXPECT_EQ(number_text(100, 3), "100");
  EXPECT_EQ(number_text(9.9999, 3), "10.0");
  EXPECT_EQ(number_text(0, 3), "0");
  EXPECT_EQ(number_text(nan, 3), "-");
}

TEST(ChosenMethods, AreThoseAskedForOrAnErrorThatNamesThem) {
  const std::vector<std::string> compared{"a", "b", "c"};
  EXPECT_EQ(chosen_methods({}, compared), compared);
  EXPECT_EQ(chosen_methods({"c", "a"}, compared), (std::vector<std::string>{"a", "c"}));
  try {
    (void)chosen_methods({"a", "x"}, compared);
    FAIL();
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(std::string(e.what()).find("'x'"), std::string::npos);
    EXPECT_NE(std::string(e.what()).find("a, b, c"), std::string::npos);
  }
}

ExperimentResult sample() {
  ExperimentResult result;
  result.name = "sample";
  result.title = "A title of <angles> & \"quotes\", long enough that it must be broken over more than one line of text";
  result.runs = 3;
  result.seed = 7;
  result.settings = {{"radars", "two"}, {"a longer key", std::string(150, 'x') + " and words behind it"}};
  result.figures = {at_most("position", 1.05, 1.08), at_most("bias left", 1.2, 1.1), shown("for information", 3),
                    at_most("one with a name so long that it does not fit beside its numbers on one line of a "
                            "hundred columns",
                            1, 2)};
  result.notes = {"a note"};
  Plot plot{"Error", "time, s", "error, m", true, {}};
  plot.curves.push_back({"method", {0, 1, 2, 3}, {1, 10, nan, 1000}});
  plot.curves.push_back({"bound", {0, 3}, {0, 500}, true});  // 0 has no logarithm
  plot.curves.push_back({"plots", {0, 1.5}, {3, 30}, false, true});
  result.plots = {plot, {"Nothing", "x", "y", false, {{"empty", {}, {}}, {"constant", {1, 2}, {5, 5}}}}};
  return result;
}

TEST(ReportText, FitsHundredColumnsAndTellsWhatFallsShort) {
  const std::string text = format_text(sample());
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const bool one_word = line.find(std::string(150, 'x')) != std::string::npos;
    EXPECT_TRUE(line.size() <= 100 || one_word) << line;
    if (line.starts_with("position")) {
      EXPECT_TRUE(line.ends_with("pass")) << line;
    }
    if (line.starts_with("bias left")) {
      EXPECT_TRUE(line.ends_with("falls short")) << line;
    }
    if (line.starts_with("for information")) {
      EXPECT_TRUE(line.find("pass") == std::string::npos) << line;
    }
  }
  EXPECT_NE(text.find("2 of 3 figures reached"), std::string::npos);
  EXPECT_FALSE(all_reached(sample()));
}

TEST(ReportJson, ParsesAndHoldsEverything) {
  const std::vector<ExperimentResult> results{sample(), sample()};
  const nlohmann::json j = nlohmann::json::parse(format_json(results));
  ASSERT_EQ(j.at("experiments").size(), 2u);
  const nlohmann::json& first = j["experiments"][0];
  EXPECT_EQ(first["seed"], 7);
  EXPECT_EQ(first["figures"][1]["reached"], false);
  EXPECT_FALSE(first["figures"][2].contains("reached"));
  EXPECT_TRUE(first["plots"][0]["curves"][0]["y"][2].is_null());
  EXPECT_EQ(first["all_reached"], false);
}

TEST(ReportHtml, NeedsNothingButItself) {
  const std::vector<ExperimentResult> results{sample(), sample()};
  const std::string page = format_html(results);
  for (const char* outside : {"http:", "https:", "<script", "<link", "src=", "url(", "@import"})
    EXPECT_EQ(page.find(outside), std::string::npos) << outside;
  EXPECT_NE(page.find("A title of &lt;angles&gt; &amp; &quot;quotes&quot;"), std::string::npos);
  EXPECT_NE(page.find("prefers-color-scheme: dark"), std::string::npos);
  EXPECT_NE(page.find("falls short"), std::string::npos);
  EXPECT_EQ(page.find("nan"), std::string::npos);
}

TEST(ReportHtml, EveryAxisHasTicks) {
  const std::vector<std::pair<double, double>> spans{{3.1, 3.9}, {2e-9, 7e5}, {0.9, 1.2}, {5, 5}, {-4e6, 3e6}};
  for (const auto& [low, high] : spans) {
    for (const bool log : {false, true}) {
      if (log && low <= 0) continue;
      ExperimentResult result;
      result.plots = {{"", "", "", log, {{"", {0, 1}, {low, high}}}}};
      const std::string page = format_html(std::vector{result});
      std::size_t ticks = 0;
      for (std::size_t at = 0; (at = page.find("text-anchor=\"end\"", at)) != std::string::npos; ++at) ++ticks;
      EXPECT_GE(ticks, 3u) << low << " to " << high;
      EXPECT_LE(ticks, 12u) << low << " to " << high;
    }
  }
}

TEST(ReportHtml, DrawsAGapWhereACurveHasNone) {
  const std::string page = format_html(std::vector<ExperimentResult>{sample()});
  // The first curve: two points joined, the gap, then a single point that must still be seen.
  const std::size_t at = page.find("<path class=\"line series-0\"");
  ASSERT_NE(at, std::string::npos);
  const std::string path = page.substr(at, page.find("/>", at) - at);
  EXPECT_EQ(std::count(path.begin(), path.end(), 'M'), 2) << path;
  EXPECT_EQ(std::count(path.begin(), path.end(), 'L'), 1) << path;
  EXPECT_NE(path.find("h.01"), std::string::npos) << path;
}

TEST(ReportHtml, PlotsOfARowStandSideBySideWithTheSameAxes) {
  const auto plot = [](double high, const char* row) {
    return Plot{.title = "", .x_label = "", .y_label = "", .curves = {{"", {0, 1}, {0, high}}}, .row = row};
  };
  ExperimentResult result;
  result.plots = {plot(1, "a"), plot(700, "a"), plot(1, "b"), plot(1, ""), plot(1, "")};
  const std::string page = format_html(std::vector{result});
  const auto count = [&page](std::string_view what) {
    int n = 0;
    for (std::size_t at = 0; (at = page.find(what, at)) != std::string::npos; ++at) ++n;
    return n;
  };
  EXPECT_EQ(count("<div class=\"row\">"), 1);
  EXPECT_EQ(count("<figure>"), 5);
  EXPECT_EQ(count(">600</text>"), 2);  // a tick of both plots of row a
}

TEST(Launch, SceneIsTheOneOfTheReference) {
  const launch::Scene scene;
  std::array<int, 3> count{};  // fixes, plots of each radar
  std::array<double, 3> first{1e9, 1e9, 1e9};
  for (const launch::Instant& i : scene.instants()) {
    const std::size_t k = i.is_plot ? static_cast<std::size_t>(1 + i.source) : 0;
    ++count[k];
    first[k] = std::min(first[k], i.t_s);
  }
  EXPECT_EQ(count, (std::array<int, 3>{400, 3800, 7600}));
  EXPECT_NEAR(first[0], 80.4, 1e-9);
  EXPECT_NEAR(first[1], 100.013, 1e-9);
  EXPECT_NEAR(first[2], 100.031, 1e-9);
}

TEST(Launch, CasesDifferByWhatTheyAreNamedForOnly) {
  const launch::Scene scene;
  const launch::Drawn base = scene.draw(launch::Case::Base, 5, 3);
  const launch::Drawn lost = scene.draw(launch::Case::GpsLost, 5, 3);
  ASSERT_EQ(base.measurements.size(), lost.measurements.size() + 110);
  std::size_t k = 0;
  for (const Measurement& m : lost.measurements) {
    while (base.measurements[k].epoch < m.epoch) ++k;
    EXPECT_EQ(base.measurements[k].measured, m.measured);
  }
  const launch::Drawn tagged = scene.draw(launch::Case::TimeTag, 5, 3);
  EXPECT_EQ(tagged.bias[1].time_tag_s, 5e-3);
  EXPECT_EQ(tagged.bias[1].offset.range_m, base.bias[1].offset.range_m);
  EXPECT_NE(scene.draw(launch::Case::Base, 5, 4).bias[1].offset.range_m, base.bias[1].offset.range_m);
}

TEST(Launch, BiasLeftIsNoneWhenTheBiasIsKnown) {
  const launch::Scene scene;
  const launch::Drawn drawn = scene.draw(launch::Case::TimeTag, 1, 0);
  const BiasModel model = bias_model({BiasBlock::Polar, BiasBlock::Time});
  for (std::size_t k = 0; k < scene.instants().size(); k += 997) {
    const launch::Instant& instant = scene.instants()[k];
    if (!instant.is_plot) continue;
    const sim::RadarBias& truth = drawn.bias[static_cast<std::size_t>(instant.source)];
    std::vector<double> known;
    for (const BiasTerm term : model.terms)
      known.push_back(launch::bias_vector(truth)[static_cast<Eigen::Index>(term)]);
    const Site& site = scene.site(instant.source);
    // Compensation is evaluated at the measured point: what remains is of second order in the bias.
    const double before = launch::bias_left(instant, truth, site, {}, {}).m.norm();
    EXPECT_LT(launch::bias_left(instant, truth, site, model.terms, known).m.norm(), 2e-3 * before) << instant.t_s;
    EXPECT_GT(before, 10);
  }
}

TEST(Launch, BiasLeftOfATimeTagIsWhereTheTargetWas) {
  const launch::Scene scene;
  const launch::Instant& instant = scene.instants()[5001];
  ASSERT_TRUE(instant.is_plot);
  const Site& site = scene.site(instant.source);
  const auto true_enu = [&](double t_s) {
    return site.enu_of({scene.motion(scene.liftoff() + seconds(t_s)).head<3>()}).m;
  };
  sim::RadarBias truth;
  truth.time_tag_s = 5e-3;
  const std::vector<BiasTerm> term{BiasTerm::TimeTag};
  const std::vector<double> value{2e-3};
  // The plot shows where the target was 5 ms before its stamp and is taken for where it was 2 ms before.
  const Eigen::Vector3d expected = true_enu(instant.t_s - 5e-3) - true_enu(instant.t_s - 2e-3);
  EXPECT_LT((launch::bias_left(instant, truth, site, term, value).m - expected).norm(), 1e-3);
  EXPECT_GT(expected.norm(), 5);
}

/// The bound against the figures of est/ERRATA.md, computed by an implementation that shares no code.
TEST(Launch, BoundOfTheBiasIsThatOfTheErrata) {
  const launch::Scene scene;
  const launch::Score bound = launch::bound_of(launch::Case::Base, bias_model({BiasBlock::Polar}), scene);
  const std::array<double, 3> goheung{3.4, 5.3, 7.0};
  for (std::size_t w = 0; w < 3; ++w)
    EXPECT_NEAR(bound.window[w].errors.bias_left[0].rms(), goheung[w], 0.05) << launch::windows()[w].name;
}

TEST(Launch, FiguresAreTheSameOnAnyNumberOfThreads) {
  ExperimentOptions options;
  options.runs = 3;
  options.methods = {"joint-ca", "song2015"};
  options.jobs = 1;
  const ExperimentResult one = run_launch(options);
  options.jobs = 3;
  const ExperimentResult three = run_launch(options);
  EXPECT_EQ(format_json(std::vector{one}), format_json(std::vector{three}));
  options.seed = 2;
  EXPECT_NE(format_json(std::vector{one}), format_json(std::vector{run_launch(options)}));

  // Three runs scatter: far wider than the limits, but wide of any gross error.
  for (const Figure& figure : one.figures) {
    EXPECT_LE(figure.what.size(), figure_name_width) << figure.what;
    if (figure.what.find("position / bound") != std::string::npos) {
      EXPECT_GT(figure.measured, 0.6) << figure.what;
      EXPECT_LT(figure.measured, 1.6) << figure.what;
    }
    if (figure.what.find("joint-ca, bias left / bound") != std::string::npos) {
      EXPECT_LT(figure.measured, 2.5) << figure.what;
    }
    if (figure.what.find("NIS inside") != std::string::npos) {
      EXPECT_NEAR(figure.measured, 0.95, 0.02) << figure.what;
    }
  }
}

TEST(Launch, RefusesAMethodThatItDoesNotCompare) {
  ExperimentOptions options;
  options.methods = {"nonesuch"};
  EXPECT_THROW((void)run_launch(options), std::invalid_argument);
}

}  // namespace
}  // namespace downrange::experiment
