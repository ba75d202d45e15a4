/// H.-R. Song, GPS-based multiple radar bias estimation and sensor fusion for launch vehicle tracking, 2015
/// (doi 10.9723/jksiis.2015.20.6), on the launch scenario: its method, those that do better, and the bound of all.

#include <algorithm>
#include <sstream>

#include "experiment/launch_result.hpp"
#include "experiment/parallel.hpp"

namespace downrange::experiment {
namespace {

using namespace launch;

const std::initializer_list<BiasBlock> polar{BiasBlock::Polar};
const std::initializer_list<BiasBlock> polar_time{BiasBlock::Polar, BiasBlock::Time};
const std::initializer_list<BiasBlock> default_blocks{BiasBlock::Polar, BiasBlock::SezOffset, BiasBlock::Time};

/// Everyone who flies, in the order of plots and tables.
std::vector<Contestant> contestants(const std::vector<std::string>& methods) {
  const BiasModel p = bias_model(polar);
  std::vector<Contestant> all{
      {.label = "joint-ca", .method = "joint", .bias = p},
      {.label = "joint-launch", .method = "joint", .kinematics = Kinematics::Launch, .bias = p},
      {.label = "schmidt", .method = "schmidt", .bias = p},
      {.label = "song2015", .method = "song2015", .bias = p, .starts_with_plot = true},
      {.label = "uncorrected", .method = "joint", .bias = {}, .gets_fixes = false, .starts_with_plot = true},
      {.label = "joint-ca", .method = "joint", .which = Case::GpsLost, .bias = p},
      {.label = "schmidt", .method = "schmidt", .which = Case::GpsLost, .bias = p},
      {.label = "song2015", .method = "song2015", .which = Case::GpsLost, .bias = p, .starts_with_plot = true},
      {.label = "joint-ca", .method = "joint", .which = Case::WrongBlocks, .bias = bias_model(default_blocks)},
      {.label = "joint-ca", .method = "joint", .which = Case::TimeTag, .bias = bias_model(polar_time)}};
  std::erase_if(
      all, [&](const Contestant& c) { return std::find(methods.begin(), methods.end(), c.label) == methods.end(); });
  return all;
}

/// One run of everyone, on the same draws.
std::vector<Flown> fly_run(const std::vector<Contestant>& all, const Scene& scene, std::uint64_t seed, int run) {
  std::vector<Flown> flown;
  std::optional<Case> drawn_case;
  Drawn drawn;
  for (const Contestant& contestant : all) {
    if (drawn_case != contestant.which) drawn = scene.draw(contestant.which, seed, run);
    drawn_case = contestant.which;
    Flown& f = flown.emplace_back(Flown{contestant, {}, {}});
    const bool traced = run == 0 && contestant.which == Case::Base;
    f.score = fly(contestant, scene, drawn, traced ? &f.residuals : nullptr);
  }
  return flown;
}

std::string rms_note(const std::string& label, const Score& score) {
  std::ostringstream text;
  text << "Position rms in the windows boost, coast, late, m: " << label;
  for (const WindowScore& w : score.window) text << ' ' << number_text(w.errors.position.rms(), 3);
  text << "; bias left";
  for (std::size_t r = 0; r < radars; ++r) {
    text << (r == 0 ? ", " : "; ") << radar_names[r];
    for (const WindowScore& w : score.window) text << ' ' << number_text(w.errors.bias_left[r].rms(), 3);
  }
  return text.str() + ".";
}

}  // namespace

ExperimentResult run_launch(const ExperimentOptions& options) {
  const auto& self =
      *std::find_if(experiments().begin(), experiments().end(), [](const Experiment& e) { return e.name == "launch"; });
  const std::vector<Contestant> all = contestants(chosen_methods(options.methods, self.methods));
  const int runs = options.runs > 0 ? options.runs : self.runs;

  const Scene scene;
  Result result;
  result.bound = bound_of(Case::Base, bias_model(polar), scene);
  result.bound_gps_lost = bound_of(Case::GpsLost, bias_model(polar), scene);
  result.bound_default_blocks = bound_of(Case::Base, bias_model(default_blocks), scene);
  result.bound_time_tag = bound_of(Case::Base, bias_model(polar_time), scene);
  const auto runs_flown = parallel_runs<std::vector<Flown>>(
      runs, options.jobs, [&](int run) { return fly_run(all, scene, options.seed, run); }, options.progress);
  result.flown = runs_flown.front();
  for (std::size_t run = 1; run < runs_flown.size(); ++run) {
    for (std::size_t i = 0; i < all.size(); ++i) result.flown[i].score += runs_flown[run][i].score;
  }

  ExperimentResult out;
  out.name = self.name;
  out.title = "GPS-based bias estimation and asynchronous fusion of two radars on a launch (song2015)";
  out.runs = runs;
  out.seed = options.seed;
  out.settings = {
      {"truth", "naro launch profile: pad 34.4319 N 127.5351 E, azimuth 170 deg, burns to 229 s and 395-453 s"},
      {"radars", "goheung 10 Hz, first plot 100.013 s; jeju 20 Hz, 100.031 s; 1-sigma 25 m, 0.01 deg, 0.01 deg"},
      {"bias, 1-sigma per run", "30 m, 0.03 deg, 0.03 deg; scales 3e-5, 2e-4, 2e-4"},
      {"GPS", "every second from 80.4 s, white 5 m, 5 m, 8 m east, north, up; no velocity, no latency"},
      {"first estimate", "1-sigma 100 m, 100 m/s, 20 m/s^2 per axis, drawn per run"},
      {"filters",
       "R as it is, no gate, no GPS error states; ca: white jerk 10 m^2/s^5; song2015: cv, windowed Q of 20"},
      {"windows", "boost 125-160 s, coast 250-390 s, late 370-470 s"},
      {"wrong bias blocks", "truth along south, east, zenith: 50 m and 1e-4 1-sigma; filter: polar, sez_offset, time"}};
  out.figures = figures(result);
  out.plots = plots(result);
  out.notes.push_back(rms_note("bound", result.bound));
  for (const Flown& f : result.flown)
    if (f.contestant.which == Case::Base) out.notes.push_back(rms_note(f.contestant.label, f.score));
  return out;
}

}  // namespace downrange::experiment
