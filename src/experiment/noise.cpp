/// S. Sarkka, J. Hartikainen, Non-linear noise adaptive Kalman filtering via variational Bayes, 2013 (arXiv 1302.0681),
/// as the service has it: the launch scenario with every sigma configured a third, right, and three times.

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "experiment/experiment.hpp"
#include "experiment/launch_scenario.hpp"
#include "experiment/parallel.hpp"
#include "score/errors.hpp"

namespace downrange::experiment {
namespace {

using launch::Scene;

constexpr std::array<double, 3> factors{1.0 / 3, 1, 3};
constexpr std::array<std::string_view, 3> factor_names{"sigma / 3", "sigma right", "sigma x 3"};
constexpr std::size_t right = 1;
constexpr int sources = launch::radars + 1;
/// Each radar has given 200 plots: NoiseScale::plots_before.
constexpr double from_s = launch::tracking_from_s + NoiseScale::plots_before / 10.0;
constexpr double gate_probability = 0.9999;

/// One method with one factor on what is configured.
struct Score {
  score::Squares position;                  ///< at the plots
  score::Share rejected;                    ///< plots, all of them good
  std::array<score::Share, sources> nis{};  ///< inside the 95 % region, accepted or not
  std::array<score::Squares, 3> ratio{};    ///< of the first radar in the end: sigma learnt over true

  Score& operator+=(const Score& other) {
    position += other.position;
    rejected += other.rejected;
    for (std::size_t i = 0; i < nis.size(); ++i) nis[i] += other.nis[i];
    for (std::size_t i = 0; i < ratio.size(); ++i) ratio[i] += other.ratio[i];
    return *this;
  }
};

/// By factor.
using Scores = std::array<Score, factors.size()>;

MethodSettings settings_of(const Scene& scene, std::string_view method, double factor) {
  MethodSettings s = scene.settings(Kinematics::Launch, bias_model({BiasBlock::Polar}));
  s.arbitration.gate_probability = gate_probability;
  s.noise.enabled = method != "joint-fixed";
  for (RadarModel& radar : s.radars)
    radar.sigma = {factor * radar.sigma.range_m, factor * radar.sigma.azimuth_rad, factor * radar.sigma.elevation_rad};
  return s;
}

Measurement as_configured(Measurement m, double factor) {
  if (auto* fix = std::get_if<Fix>(&m.measured)) {
    fix->sigma_horizontal_m *= factor;
    fix->sigma_vertical_m *= factor;
  }
  return m;
}

Score fly(const Scene& scene, const launch::Drawn& drawn, std::string_view name, double factor) {
  const std::unique_ptr<Method> method =
      make_method(name == "joint-fixed" ? "joint" : name, settings_of(scene, name, factor));
  const Time start = drawn.measurements.front().epoch;
  method->start(0, start, {.mean = scene.motion(start) + drawn.start_error, .cov = launch::start_covariance()});
  Score score;
  for (const Measurement& m : drawn.measurements) {
    const Outcome outcome = method->process(as_configured(m, factor), m.epoch);
    if ((m.epoch - scene.liftoff()).seconds() < from_s) continue;
    if (outcome.dof > 0) score.nis[static_cast<std::size_t>(m.source)].add(score::inside_95(outcome.nis, outcome.dof));
    if (is_fix(m)) continue;
    score.rejected.add(outcome.verdict != Verdict::Accepted);
    if (const auto track = method->fused(0, m.epoch))
      score.position.add((track->mean.head<3>() - scene.motion(m.epoch).head<3>()).squaredNorm());
  }
  for (int i = 0; i < 3; ++i) {
    const double learnt = method->account(0).noise.sigma_ratio(i);
    if (learnt > 0) score.ratio[static_cast<std::size_t>(i)].add(std::pow(learnt * factor, 2));
  }
  return score;
}

std::vector<Figure> figures_of(const std::string& method, const Scores& scores) {
  std::vector<Figure> figures;
  const bool learns = method != "joint-fixed";
  for (std::size_t i = 0; i < factors.size(); ++i) {
    const Score& s = scores[i];
    const std::string name = method + ", " + std::string(factor_names[i]) + ": ";
    figures.push_back(shown(name + "position rms, m", s.position.rms()));
    const double ratio = s.position.rms() / scores[right].position.rms();
    const double rejected = 100 * s.rejected.value();
    figures.push_back(learns ? at_most(name + "rms over that of right", ratio, 1.1)
                             : shown(name + "rms over that of right", ratio));
    figures.push_back(learns ? at_most(name + "good plots rejected, %", rejected, 0.3)
                             : shown(name + "good plots rejected, %", rejected));
    for (int source = 0; source < sources; ++source) {
      std::string what = name + "NIS inside, ";
      what += source < launch::radars ? launch::radar_names[static_cast<std::size_t>(source)] : "GPS";
      const double share = s.nis[static_cast<std::size_t>(source)].value();
      // Fixes are too few to be right for most of a flight.
      figures.push_back(learns && source < launch::radars ? within(std::move(what), share, 0.93, 0.97)
                                                          : shown(std::move(what), share));
    }
    if (learns) figures.push_back(shown(name + "range sigma learnt over true", s.ratio[0].rms()));
  }
  return figures;
}

}  // namespace

ExperimentResult run_noise(const ExperimentOptions& options) {
  const auto& self =
      *std::find_if(experiments().begin(), experiments().end(), [](const Experiment& e) { return e.name == "noise"; });
  const std::vector<std::string> methods = chosen_methods(options.methods, self.methods);
  const int runs = options.runs > 0 ? options.runs : self.runs;
  const Scene scene;
  const auto fly_run = [&](int run) {
    const launch::Drawn drawn = scene.draw(launch::Case::Base, options.seed, run);
    std::vector<Scores> flown(methods.size());
    for (std::size_t m = 0; m < methods.size(); ++m) {
      for (std::size_t i = 0; i < factors.size(); ++i) flown[m][i] = fly(scene, drawn, methods[m], factors[i]);
    }
    return flown;
  };
  std::vector<Scores> sums(methods.size());
  for (const auto& run : parallel_runs<std::vector<Scores>>(runs, options.jobs, fly_run, options.progress)) {
    for (std::size_t m = 0; m < methods.size(); ++m) {
      for (std::size_t i = 0; i < factors.size(); ++i) sums[m][i] += run[m][i];
    }
  }

  ExperimentResult out;
  out.name = self.name;
  out.title = "Noise that is configured wrongly, learnt in flight (Sarkka, Hartikainen 2013)";
  out.runs = runs;
  out.seed = options.seed;
  out.settings = {{"scenario", "that of experiment launch: two radars from 100 s, GPS at 1 Hz from 80.4 s"},
                  {"configured", "range, azimuth, elevation of both radars and GPS: a third, right, three times"},
                  {"filters", "kinematics launch, polar biases, gate 0.9999, no GPS error states; ts: white jerk"},
                  {"judged", "from 120 s on, when each radar has given 200 plots; at the plots"},
                  {"joint-fixed", "joint that keeps what is configured"}};
  for (std::size_t m = 0; m < methods.size(); ++m) {
    const std::vector<Figure> figures = figures_of(methods[m], sums[m]);
    out.figures.insert(out.figures.end(), figures.begin(), figures.end());
  }
  return out;
}

}  // namespace downrange::experiment
