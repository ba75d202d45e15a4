/// The spatial-bias paper: bearings of two sensors on one ship, the displaced one brought to the reference by the range
/// of the target track, and the two tracks fused by four rules.

#include <algorithm>
#include <array>
#include <cmath>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/est/track/track_fusion.hpp>
#include <downrange/geo/polar.hpp>
#include <limits>
#include <numbers>
#include <string>
#include <vector>
#include "experiment/parallax.hpp"

#include "experiment/experiment.hpp"
#include "experiment/parallel.hpp"
#include "sim/random_stream.hpp"

namespace downrange::experiment {
namespace {

constexpr double no_gate = std::numeric_limits<double>::infinity();
constexpr double deg = std::numbers::pi / 180;

// The paper's: one auxiliary sensor ahead, one ten times as far astern, the reference's sigma fixed, three ratios. Its
// numbers are lost in the printed text; these are chosen here.
constexpr double d_ahead_m = 10;
constexpr double d_astern_m = -100;
constexpr double sigma_reference = 1 * deg;
constexpr std::array<double, 3> sigma_ratio{0.5, 1, 2};
constexpr int scans = 200;
constexpr int settled = 50;  ///< scans that figures leave out
constexpr double T = 1;
constexpr double sigma_w = 0.01 * deg;  ///< rad/s^2, constant over a scan
constexpr double sigma_start = 3 * deg;
constexpr double sigma_start_rate = 0.3 * deg;
constexpr double target_x_m = 3000;  ///< abeam
constexpr double target_y_m = -2000;
constexpr double target_speed_m_s = 20;
constexpr double target_sigma_m_s2 = 0.5;   ///< along x and y, constant over a scan: 0.01 deg/s^2 of bearing abeam
constexpr double sigma_track_range = 0.03;  ///< of the range, constant over a run

using State = Gaussian<2>;  ///< bearing (rad), its rate (rad/s)

enum Rule : std::size_t { Reference, Convex, Campo, Map, Information, rules };
const std::vector<std::string>& rule_names() {
  static const std::vector<std::string> names{"reference", "convex", "bar-shalom-campo", "map", "information"};
  return names;
}

/// Where the displaced sensor's bearings come from.
enum class Geometry : std::uint8_t {
  Matched,        ///< no displacement; the bearing moves as the filters believe
  Compensated,    ///< a target that passes abeam, compensated by the target track
  Uncompensated,  ///< the same, taken as if there were no displacement
};

struct Model {
  Mat<2, 2> F = (Mat<2, 2>() << 1, T, 0, 1).finished();
  Vec<2> g = Vec<2>(T * T / 2, T);
  Mat<2, 2> Q = sigma_w * sigma_w * g * g.transpose() + 1e-16 * Mat<2, 2>::Identity();
  Mat<1, 2> H = Mat<1, 2>(1, 0);
  Mat<2, 2> P0 = Vec<2>(sigma_start * sigma_start, sigma_start_rate* sigma_start_rate).asDiagonal();
};

/// Two local filters and every rule over them.
class Bank {
 public:
  Bank(const Model& model, double bearing, double sigma_other)
      : model_(model),
        R_{Mat<1, 1>(sigma_reference * sigma_reference), Mat<1, 1>(sigma_other * sigma_other)},
        local_{State{Vec<2>(bearing, 0), model.P0}, State{Vec<2>(bearing, 0), model.P0}},
        cross_(model.P0),
        map_(local_[0]),
        informed_(local_[0]) {}

  /// Bearing of the reference's own track at the next scan: what the displaced sensor is compensated with.
  [[nodiscard]] double predicted_bearing() const { return (model_.F * local_[0].mean)[0]; }

  /// One scan of both sensors; the fused states by rule.
  std::array<State, rules> scan(const std::array<double, 2>& z) {
    std::array<TrackReport<2>, 2> reports;
    std::array<Mat<2, 2>, 2> ImKH;
    map_.predict(model_.F, model_.Q);
    cross_ = cross_covariance_predicted<2>(cross_, model_.F, model_.Q);
    for (int i = 0; i < 2; ++i) {
      const auto s = static_cast<std::size_t>(i);
      const State prior = predicted(local_[s]);
      const Vec<1> nu(z[s] - prior.mean[0]);
      const auto u = kalman_update<2, 1>(prior, nu, model_.H, R_[s], no_gate);
      const Vec<2> K = prior.cov.col(0) / u.S(0, 0);
      ImKH[s] = Mat<2, 2>::Identity() - K * model_.H;
      map_.updated<1>(i, K, model_.H, R_[s]);
      reports[s] = {prior, u.posterior};
      local_[s] = u.posterior;
    }
    cross_ = cross_covariance_updated<2>(ImKH[0], cross_, ImKH[1]);
    informed_ = fuse_information<2>(predicted(informed_), reports).state;
    return {local_[0], fuse_convex<2>(local_).state, fuse_bar_shalom_campo<2>(local_[0], local_[1], cross_).state,
            map_.fuse(std::array<Vec<2>, 2>{local_[0].mean, local_[1].mean}).state, informed_};
  }

 private:
  [[nodiscard]] State predicted(const State& x) const {
    return {model_.F * x.mean, symmetric<2>(model_.F * x.cov * model_.F.transpose() + model_.Q)};
  }

  const Model& model_;
  std::array<Mat<1, 1>, 2> R_;
  std::array<State, 2> local_;
  Mat<2, 2> cross_;
  MapFusion<2, 2> map_;
  State informed_;
};

/// Sums over runs of one geometry and one ratio, by rule.
struct Errors {
  std::array<std::vector<double>, rules> square;  ///< of the bearing, rad^2, scan by scan
  std::array<double, rules> nees{};               ///< per degree of freedom, over the settled scans

  Errors() { square.fill(std::vector<double>(scans, 0.0)); }
  Errors& operator+=(const Errors& other) {
    for (std::size_t r = 0; r < rules; ++r) {
      for (std::size_t k = 0; k < scans; ++k) square[r][k] += other.square[r][k];
      nees[r] += other.nees[r];
    }
    return *this;
  }
  [[nodiscard]] double rms(std::size_t rule, int runs) const {
    double sum = 0;
    for (std::size_t k = settled; k < scans; ++k) sum += square[rule][k] / runs / (scans - settled);
    return std::sqrt(sum);
  }
};

/// A target that passes the ship, which heads along y; bearings from the bow, to starboard.
struct Passing {
  Vec<2> p = Vec<2>(target_x_m, target_y_m);
  Vec<2> v = Vec<2>(0, target_speed_m_s);

  void step(sim::RandomStream& motion) {
    const Vec<2> a(target_sigma_m_s2 * motion.normal(), target_sigma_m_s2 * motion.normal());
    p += T * v + T * T / 2 * a;
    v += T * a;
  }
  /// Bearing and its rate at the reference.
  [[nodiscard]] Vec<2> bearing() const {
    return {std::atan2(p[0], p[1]), (v[0] * p[1] - v[1] * p[0]) / p.squaredNorm()};
  }
  [[nodiscard]] double bearing_from(double d_m) const { return std::atan2(p[0], p[1] - d_m); }
};

/// One run of the passing target as the sensors and the tracks have it, deg over scans.
struct Trace {
  std::vector<double> x_m, y_m;
  std::vector<double> at_reference, at_other;  ///< true bearings
  std::vector<double> measured_reference, measured_other;
  std::vector<double> reference, fused;  ///< tracks: reference alone, map
};

/// `trace`, where given, gets the run.
Errors fly(const Model& model, Geometry geometry, double ratio, std::uint64_t seed, int run, Trace* trace = nullptr) {
  // The same draws for every geometry and ratio: what differs is what is compared.
  sim::RandomStream motion(seed, "spatial motion " + std::to_string(run));
  sim::RandomStream noise(seed, "spatial noise " + std::to_string(run));
  const bool matched = geometry == Geometry::Matched;
  Passing target;
  Vec<2> truth =
      matched ? Vec<2>(1 + sigma_start * motion.normal(), sigma_start_rate * motion.normal()) : target.bearing();
  const double range_error = sigma_track_range * motion.normal();
  Bank bank(model, matched ? 1 : truth[0] + sigma_start * motion.normal(), ratio * sigma_reference);

  Errors errors;
  for (int k = 1; k <= scans; ++k) {
    double at_other = 0;
    if (matched) {
      truth = model.F * truth + sigma_w * motion.normal() * model.g;
      at_other = truth[0];
    } else {
      target.step(motion);
      truth = target.bearing();
      at_other = target.bearing_from(d_astern_m);
    }
    std::array<double, 2> z{truth[0] + sigma_reference * noise.normal(),
                            at_other + ratio * sigma_reference * noise.normal()};
    const std::array<double, 2> measured = z;
    if (geometry == Geometry::Compensated) {
      const double track_range = target.p.norm() * (1 + range_error);
      z[1] = compensate_planar_parallax(z[1], bank.predicted_bearing(), track_range, d_astern_m);
    }
    const auto fused = bank.scan(z);
    if (trace != nullptr) {
      trace->x_m.push_back(target.p[0]);
      trace->y_m.push_back(target.p[1]);
      trace->at_reference.push_back(truth[0] / deg);
      trace->at_other.push_back(at_other / deg);
      trace->measured_reference.push_back(measured[0] / deg);
      trace->measured_other.push_back(measured[1] / deg);
      trace->reference.push_back(fused[Reference].mean[0] / deg);
      trace->fused.push_back(fused[Map].mean[0] / deg);
    }
    for (std::size_t r = 0; r < rules; ++r) {
      const Vec<2> e = fused[r].mean - truth;
      errors.square[r][static_cast<std::size_t>(k - 1)] = e[0] * e[0];
      if (k > settled) errors.nees[r] += normalised_square<2>(e, fused[r].cov) / 2 / (scans - settled);
    }
  }
  return errors;
}

/// Largest error of bearings compensated with the exact range and bearing, rad, relative to the rounding of the bearing
/// itself where the target is near.
double exactness(std::uint64_t seed) {
  sim::RandomStream random(seed, "spatial geometries");
  double worst = 0;
  for (int i = 0; i < 10000; ++i) {
    const double theta = random.uniform(-std::numbers::pi, std::numbers::pi);
    const double r = std::pow(10, random.uniform(2.3, 5));  // 200 m to 100 km
    const double d = i % 2 == 0 ? d_ahead_m : d_astern_m;
    const double at_sensor = std::atan2(r * std::sin(theta), r * std::cos(theta) - d);
    worst = std::max(worst, std::abs(wrap_pi(compensate_planar_parallax(at_sensor, theta, r, d) - theta)));
  }
  return worst;
}

Plot bias_plot(const char* title, double d_m) {
  Plot plot{.title = title, .x_label = "bearing, deg", .y_label = "spatial bias, deg", .curves = {}};
  for (const double range : {500.0, 1000.0, 2000.0, 5000.0, 10000.0}) {
    Curve& curve = plot.curves.emplace_back();
    curve.label = number_text(range / 1000, 2) + " km";
    for (int bearing = 0; bearing <= 180; bearing += 2) {
      curve.x.push_back(bearing);
      curve.y.push_back(planar_parallax(bearing * deg, range, d_m) / deg);
    }
  }
  return plot;
}

/// Of the displaced sensor; the reference's is the same throughout.
std::string sigma_text(double ratio) { return "aux. sigma " + number_text(ratio * sigma_reference / deg, 2) + " deg"; }

/// Figure 6: the ship heads along y, the reference sensor at the origin.
Plot scenario_plot(const Trace& trace) {
  Plot plot{.title = "Ship and target (paper: figure 6; first run)", .x_label = "x, m", .y_label = "y, ahead, m"};
  plot.curves = {{.label = "target", .x = trace.x_m, .y = trace.y_m},
                 {.label = "reference sensor", .x = {0}, .y = {0}, .points = true},
                 {.label = "auxiliary sensor, 100 m astern", .x = {0}, .y = {d_astern_m}, .points = true}};
  return plot;
}

/// Figure 7: bearings of both sensors, and what the tracks make of them; less the true bearing, for all of them would
/// lie on one line.
Plot bearing_plot(const Trace& trace) {
  Plot plot{.title = "Bearings at both sensors and tracks, " + sigma_text(1) + " (paper: figure 7; first run)",
            .x_label = "time, s",
            .y_label = "bearing - true at the reference, deg"};
  const auto add = [&](const char* label, const std::vector<double>& bearing, bool points, bool dashed) {
    Curve& curve = plot.curves.emplace_back(Curve{.label = label, .dashed = dashed, .points = points});
    for (std::size_t k = 0; k < bearing.size(); ++k) {
      curve.x.push_back(T * static_cast<double>(k + 1));
      curve.y.push_back(bearing[k] - trace.at_reference[k]);
    }
  };
  add("measured by the reference", trace.measured_reference, true, false);
  add("measured by the auxiliary", trace.measured_other, true, false);
  add("reference track", trace.reference, false, false);
  add("map, compensated", trace.fused, false, false);
  add("true at the auxiliary", trace.at_other, false, true);
  return plot;
}

Plot error_plot(const std::string& title, const Errors& errors, const std::vector<std::string>& methods, int runs) {
  Plot plot{.title = title, .x_label = "time, s", .y_label = "rms bearing error, deg", .log_y = false, .curves = {}};
  for (std::size_t r = 0; r < rules; ++r) {
    if (std::find(methods.begin(), methods.end(), rule_names()[r]) == methods.end()) continue;
    Curve& curve = plot.curves.emplace_back();
    curve.label = rule_names()[r];
    for (std::size_t k = 0; k < scans; ++k) {
      curve.x.push_back(T * static_cast<double>(k + 1));
      curve.y.push_back(std::sqrt(errors.square[r][k] / runs) / deg);
    }
  }
  return plot;
}

struct Flown {
  std::array<Errors, sigma_ratio.size()> matched;
  std::array<Errors, sigma_ratio.size()> compensated;
  Errors uncompensated;  ///< at equal sigma
};

}  // namespace

ExperimentResult run_spatial(const ExperimentOptions& options) {
  const auto& self = *std::find_if(experiments().begin(), experiments().end(),
                                   [](const Experiment& e) { return e.name == "spatial"; });
  const std::vector<std::string> methods = chosen_methods(options.methods, self.methods);
  const int runs = options.runs > 0 ? options.runs : self.runs;

  const Model model;
  const auto all = parallel_runs<Flown>(
      runs, options.jobs,
      [&](int run) {
        Flown flown;
        for (std::size_t i = 0; i < sigma_ratio.size(); ++i) {
          flown.matched[i] = fly(model, Geometry::Matched, sigma_ratio[i], options.seed, run);
          flown.compensated[i] = fly(model, Geometry::Compensated, sigma_ratio[i], options.seed, run);
        }
        flown.uncompensated = fly(model, Geometry::Uncompensated, 1, options.seed, run);
        return flown;
      },
      options.progress);
  Flown sum;
  for (const Flown& flown : all) {
    for (std::size_t i = 0; i < sigma_ratio.size(); ++i) {
      sum.matched[i] += flown.matched[i];
      sum.compensated[i] += flown.compensated[i];
    }
    sum.uncompensated += flown.uncompensated;
  }

  ExperimentResult out;
  out.name = self.name;
  out.title = "Spatial bias of distributed bearing sensors, sequential track fusion";
  out.runs = runs;
  out.seed = options.seed;
  out.settings = {
      {"sensors", "reference at the origin; auxiliary 10 m ahead (bias only) and 100 m astern; scans of 1 s, 200"},
      {"sigma", "reference 1 deg; auxiliary 0.5, 1 and 2 deg"},
      {"filters", "bearing and rate, acceleration 0.01 deg/s^2 constant over a scan; start 3 deg, 0.3 deg/s"},
      {"matched case", "the bearing moves as the filters believe, no displacement; scans 51-200 are scored"},
      {"passing target",
       "3 km abeam, from 2 km astern of abeam at 20 m/s along the ship's heading, 0.5 m/s^2 process noise; range of "
       "the target "
       "track wrong by 3 % 1-sigma, constant over a run; bearing predicted by the reference's track"},
      {"map", "joint covariance of fused prior and tracks, relative ridge 1e-7"}};

  const auto has = [&](std::size_t rule) {
    return std::find(methods.begin(), methods.end(), rule_names()[rule]) != methods.end();
  };
  out.figures.push_back(at_most("exact parallax with exact range, largest error, rad", exactness(options.seed), 1e-14));
  for (std::size_t i = 0; i < sigma_ratio.size(); ++i) {
    const Errors& e = sum.matched[i];
    const std::string at = ", " + sigma_text(sigma_ratio[i]);
    if (has(Map) && has(Campo))
      out.figures.push_back(at_most("map / bar-shalom-campo, rms" + at, e.rms(Map, runs) / e.rms(Campo, runs), 0.995));
    for (const std::size_t rule : {Map, Campo})
      if (has(rule)) out.figures.push_back(within("NEES " + rule_names()[rule] + at, e.nees[rule] / runs, 0.95, 1.05));
    for (const std::size_t rule : {Convex, Information})
      if (has(rule)) out.figures.push_back(shown("NEES " + rule_names()[rule] + at, e.nees[rule] / runs));
  }
  for (std::size_t rule = 0; rule < rules; ++rule) {
    if (!has(rule)) continue;
    for (std::size_t i = 0; i < sigma_ratio.size(); ++i)
      out.figures.push_back(shown("passing, " + rule_names()[rule] + ", rms, deg, " + sigma_text(sigma_ratio[i]),
                                  sum.compensated[i].rms(rule, runs) / deg));
  }

  if (has(Map))
    out.figures.push_back(
        shown("passing, uncompensated, map, rms, deg, " + sigma_text(1), sum.uncompensated.rms(Map, runs) / deg));

  Trace trace;
  (void)fly(model, Geometry::Compensated, 1, options.seed, 0, &trace);
  out.plots.push_back(bias_plot("Spatial bias of the sensor 10 m ahead (paper: figure 4)", d_ahead_m));
  out.plots.push_back(bias_plot("Spatial bias of the sensor 100 m astern (paper: figure 5)", d_astern_m));
  out.plots.push_back(scenario_plot(trace));
  out.plots.push_back(bearing_plot(trace));
  for (std::size_t i = 0; i < sigma_ratio.size(); ++i)
    out.plots.push_back(
        error_plot("Passing target, compensated, " + sigma_text(sigma_ratio[i]) + " (paper: figures 8 to 10)",
                   sum.compensated[i], methods, runs));
  out.plots.push_back(
      error_plot("Passing target, not compensated, " + sigma_text(1), sum.uncompensated, methods, runs));
  for (std::size_t i = 0; i < sigma_ratio.size(); ++i)
    out.plots.push_back(error_plot("Matched case, " + sigma_text(sigma_ratio[i]), sum.matched[i], methods, runs));
  out.notes = {
      "The paper's numbers are lost in its printed text; displacements (ratio 10), sigma and geometry are "
      "chosen here.",
      "'information' equals the centralised filter and is the bound of all rules."};
  return out;
}

}  // namespace downrange::experiment
