#include "experiment/impact.hpp"

#include <GeographicLib/Geodesic.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <downrange/geo/free_fall.hpp>
#include <downrange/stage/engine.hpp>
#include <numbers>
#include <utility>

#include "experiment/parallel.hpp"
#include "score/impact_tally.hpp"
#include "sim/launch_trajectory.hpp"

namespace downrange::experiment {
namespace impact {
namespace {

constexpr double deg = std::numbers::pi / 180;
constexpr double from_s = 10;
constexpr double velocity_sigma_m_s = 0.1;
/// Until an estimator can know of an ignition or a cut-off: the receiver's next fix has come, or the radars' noise
/// shows it.
constexpr double settling_s = 3;

bool settled_at(double t_s) {
  static const std::vector<sim::Burn> burns = sim::naro_launch_profile().burns;
  return std::ranges::none_of(burns, [&](const sim::Burn& burn) {
    const auto just_after = [&](double event_s) { return t_s >= event_s && t_s < event_s + settling_s; };
    return just_after(burn.from_s) || just_after(burn.to_s);
  });
}

class Judge final : public ResultSink {
 public:
  explicit Judge(const honesty::Profile& profile) : profile_(profile), pad_(pad_of(profile)) {}

  void emit(const Result& result) override {
    const auto* told = std::get_if<ImpactPoint>(&result);
    if (told == nullptr || !told->chain.empty()) return;
    const double t_s = (told->epoch - profile_.liftoff).seconds();
    const auto truth = profile_.truth(told->epoch);
    if (!truth || t_s < from_s || t_s >= profile_.end_s) return;
    const FallSettings& fall = profile_.range.impact.fall;
    const auto landing = fall_to(*truth, fall.height_m, fall.horizon_s);
    if (!landing) return;
    if (!told->impact_valid) ++flown_.untold;
    if (const auto error = score::impact_error(*told, *truth, fall)) add(*told, *error, *landing, t_s);
  }

  [[nodiscard]] Flown flown() && { return std::move(flown_); }

 private:
  static Geodetic pad_of(const honesty::Profile& profile) {
    return geodetic_from_ecef(profile.truth(profile.liftoff)->position);
  }

  void add(const ImpactPoint& told, const score::ImpactError& error, const Landing& landing, double t_s) {
    const Geodetic there = geodetic_from_ecef(landing.state.position);
    double downrange_m = 0;
    double azimuth_at_pad = 0;
    double azimuth = 0;
    GeographicLib::Geodesic::WGS84().Inverse(pad_.latitude_rad / deg, pad_.longitude_rad / deg,
                                             there.latitude_rad / deg, there.longitude_rad / deg, downrange_m,
                                             azimuth_at_pad, azimuth);
    const Eigen::Vector2d on(std::sin(azimuth * deg), std::cos(azimuth * deg));
    flown_.misses.push_back({.t_s = t_s,
                             .downrange_m = downrange_m,
                             .along_m = on.dot(error.off_m),
                             .across_m = on.y() * error.off_m.x() - on.x() * error.off_m.y(),
                             .sigma_m = std::sqrt(told.covariance_m2[0] + told.covariance_m2[2]),
                             .inside_95 = score::inside_95(error.nees, 2),
                             .settled = settled_at(t_s)});
  }

  const honesty::Profile& profile_;
  Geodetic pad_;
  Flown flown_;
};

}  // namespace

honesty::Profile profile(double gps_rate_hz) {
  honesty::Profile profile = honesty::launch_profile();
  profile.gps_rate_hz = gps_rate_hz;
  profile.range.gps.sigma_velocity_m_s = velocity_sigma_m_s;
  profile.range.fuse.methods = {Name(honesty_methods().front())};
  return profile;
}

Flown fly(const honesty::Profile& profile, bool gps, std::uint64_t seed) {
  Judge judge(profile);
  Engine engine(honesty::range_of(profile), {}, judge);
  for (const Event& event : honesty::events_of(profile, gps, seed)) engine.handle(engine.admit(event));
  return std::move(judge).flown();
}

}  // namespace impact

namespace {

using impact::Flown;
using impact::Miss;

constexpr double near_pad_m = 20e3;
constexpr double three_sigmas = 0.9973;
constexpr double share_least = 0.92;
constexpr double share_most = 0.97;

/// What is flown, and the error that is promised: across and along, of the downrange distance.
struct Case {
  const char* name;
  bool gps;
  double gps_rate_hz;
  double across;
  double along;
};
constexpr std::array cases{Case{"GPS 10 Hz", true, 10, 1e-3, 5e-3}, Case{"GPS 1 Hz", true, 1, 1e-3, 5e-3},
                           Case{"no GPS", false, 1, 5e-3, 5e-2}};

/// That 99.73 % of them do not exceed; NaN of none.
double three_sigma_of(std::vector<double> values) {
  if (values.empty()) return std::nan("");
  const auto rank = static_cast<std::size_t>(std::ceil(three_sigmas * static_cast<double>(values.size())));
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::min(rank, values.size()) - 1);
  std::ranges::nth_element(values, at);
  return *at;
}

template <class Wanted, class Value>
std::vector<double> values_of(const std::vector<Miss>& misses, const Wanted& wanted, const Value& value) {
  std::vector<double> values;
  for (const Miss& m : misses)
    if (wanted(m)) values.push_back(value(m));
  return values;
}

void add_figures(const Case& c, const Flown& flown, std::vector<Figure>& figures) {
  const std::string name = c.name;
  const std::vector<Miss>& misses = flown.misses;
  const auto near_pad = [](const Miss& m) { return m.downrange_m <= near_pad_m; };
  const auto far_settled = [](const Miss& m) { return m.downrange_m > near_pad_m && m.settled; };
  const auto unsettled = [](const Miss& m) { return m.downrange_m > near_pad_m && !m.settled; };
  const auto size = [](const Miss& m) { return std::hypot(m.along_m, m.across_m); };
  const auto across = [](const Miss& m) { return std::abs(m.across_m) / m.downrange_m; };
  const auto along = [](const Miss& m) { return std::abs(m.along_m) / m.downrange_m; };
  const double near_3s = three_sigma_of(values_of(misses, near_pad, size));
  const std::string near_name = name + ": 3 sigma within 20 km of the pad, m";
  figures.push_back(c.gps ? at_most(near_name, near_3s, 30) : shown(near_name, near_3s));
  figures.push_back(at_most(name + ": 3 sigma across, % of downrange",
                            100 * three_sigma_of(values_of(misses, far_settled, across)), 100 * c.across));
  figures.push_back(at_most(name + ": 3 sigma along, % of downrange",
                            100 * three_sigma_of(values_of(misses, far_settled, along)), 100 * c.along));
  std::vector<double> jumps = values_of(misses, unsettled, along);
  figures.push_back(shown(name + ": worst along after an ignition or cut-off, %",
                          jumps.empty() ? std::nan("") : 100 * *std::ranges::max_element(jumps)));
  const auto inside = static_cast<double>(std::ranges::count_if(misses, &Miss::inside_95));
  figures.push_back(
      within(name + ": inside 95 % ellipse", inside / static_cast<double>(misses.size()), share_least, share_most));
  figures.push_back(at_most(name + ": no impact told of what comes down", static_cast<double>(flown.untold), 0));
}

/// Rms of the misses, and what the covariances promise, by time.
void add_plots(const std::string& name, const Flown& flown, std::vector<Plot>& plots) {
  constexpr double bin_s = 10;
  std::vector<score::Squares> miss;
  std::vector<score::Squares> promised;
  std::vector<score::Share> share;
  for (const Miss& m : flown.misses) {
    const auto bin = static_cast<std::size_t>(m.t_s / bin_s);
    miss.resize(std::max(miss.size(), bin + 1));
    promised.resize(miss.size());
    share.resize(miss.size());
    miss[bin].add(m.along_m * m.along_m + m.across_m * m.across_m);
    promised[bin].add(m.sigma_m * m.sigma_m);
    share[bin].add(m.inside_95);
  }
  Curve found{.label = "rms"};
  Curve told{.label = "promised", .dashed = true};
  Curve inside{.label = "inside 95 %"};
  for (std::size_t i = 0; i < miss.size(); ++i) {
    for (Curve* curve : {&found, &told, &inside}) curve->x.push_back((static_cast<double>(i) + 0.5) * bin_s);
    found.y.push_back(miss[i].rms());
    told.y.push_back(promised[i].rms());
    inside.y.push_back(share[i].value());
  }
  plots.push_back({.title = "Impact point against the fall of the true state, " + name,
                   .x_label = "time after lift-off, s",
                   .y_label = "m",
                   .log_y = true,
                   .curves = {found, told},
                   .row = "size"});
  plots.push_back({.title = "Impact point inside its 95 % ellipse, " + name,
                   .x_label = "time after lift-off, s",
                   .y_label = "share",
                   .curves = {inside},
                   .row = "share"});
}

}  // namespace

ExperimentResult run_impact(const ExperimentOptions& options) {
  (void)chosen_methods(options.methods, honesty_methods());
  const int runs = options.runs > 0 ? options.runs : impact_runs;
  std::vector<honesty::Profile> profiles;
  profiles.reserve(cases.size());
  for (const Case& c : cases) profiles.push_back(impact::profile(c.gps_rate_hz));
  const int count = static_cast<int>(cases.size());
  const auto flights = parallel_runs<Flown>(
      count * runs, options.jobs,
      [&](int i) {
        const auto k = static_cast<std::size_t>(i % count);
        return impact::fly(profiles[k], cases[k].gps, honesty::seed_of_run(options.seed, i / count));
      },
      options.progress);
  ExperimentResult out;
  out.name = "impact";
  out.title = "Vacuum impact point: error against the fall of the true state, and its ellipse";
  out.runs = runs;
  out.seed = options.seed;
  out.settings = {{"flight", "launch of experiment honesty: two radars at Naro, everything drawn from what is assumed"},
                  {"GPS", "velocity to 0.1 m/s, 0.3 s late"},
                  {"scored", "the selected chain twice a second, predicted to the tick, from T+10 s on"},
                  {"3 sigma", "what 99.73 % of all points of all seeds do not exceed"},
                  {"across, along", "beyond 20 km, without the 3 s after an ignition or a cut-off"}};
  for (std::size_t k = 0; k < cases.size(); ++k) {
    Flown all;
    for (std::size_t i = k; i < flights.size(); i += cases.size()) {
      all.misses.insert(all.misses.end(), flights[i].misses.begin(), flights[i].misses.end());
      all.untold += flights[i].untold;
    }
    add_figures(cases[k], all, out.figures);
    add_plots(cases[k].name, all, out.plots);
  }
  return out;
}

}  // namespace downrange::experiment
