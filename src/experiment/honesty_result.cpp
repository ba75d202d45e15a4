#include <cmath>

#include "experiment/honesty.hpp"
#include "experiment/parallel.hpp"

namespace downrange::experiment {
namespace {

using namespace honesty;

/// What is called honest: a share of 95 % and a NEES of 3 within what 200 seeds leave open.
constexpr double share_least = 0.92;
constexpr double share_most = 0.97;
constexpr double nees_least = 0.8;
constexpr double nees_most = 1.25;

struct Case {
  const Profile* profile;
  bool gps;

  [[nodiscard]] std::string name() const { return profile->name + (gps ? ", with GPS" : ", without GPS"); }
};

struct Flown {
  Case of;
  Track track;
};

template <class Value>
Curve over_time(std::string label, std::size_t bins, bool dashed, const Value& value) {
  Curve curve{.label = std::move(label), .dashed = dashed};
  for (std::size_t i = 0; i < bins; ++i) {
    curve.x.push_back((static_cast<double>(i) + 0.5) * bin_s);
    curve.y.push_back(value(i));
  }
  return curve;
}

void add_plots(const std::vector<Flown>& flown, const Profile& profile, std::vector<Plot>& plots) {
  Plot share{.title = "Position inside the 95 % region, " + profile.name,
             .x_label = "time after lift-off, s",
             .y_label = "share",
             .row = profile.name};
  Plot size{.title = "Position error and what its covariance promises, " + profile.name,
            .x_label = "time after lift-off, s",
            .y_label = "rms, m",
            .log_y = true,
            .row = profile.name + " size"};
  for (const Flown& f : flown) {
    if (f.of.profile != &profile) continue;
    const Track& t = f.track;
    const std::string label = f.of.gps ? "with GPS" : "without GPS";
    share.curves.push_back(over_time(label, t.share.size(), false, [&](std::size_t i) { return t.share[i].value(); }));
    size.curves.push_back(over_time(label, t.error.size(), false, [&](std::size_t i) { return t.error[i].rms(); }));
    size.curves.push_back(
        over_time(label + ", promised", t.error.size(), true, [&](std::size_t i) { return t.promised[i].rms(); }));
  }
  const std::size_t bins = share.curves.front().x.size();
  share.curves.push_back(over_time("honest", bins, true, [](std::size_t) { return share_least; }));
  share.curves.push_back(over_time("", bins, true, [](std::size_t) { return share_most; }));
  plots.push_back(std::move(share));
  plots.push_back(std::move(size));
}

std::vector<Figure> figures_of(const Flown& f) {
  const std::string name = f.of.name();
  std::vector<Figure> figures{
      within(name + ": inside 95 %", f.track.inside.value(), share_least, share_most),
      within(name + ": NEES/3", f.track.nees_per_dof(), nees_least, nees_most),
      shown(name + ": position rms, m", f.track.position.rms()),
      at_most(name + ": seeds with a source excluded", static_cast<double>(f.track.excluded.size()), 0)};
  if (f.track.shares.size() > 1) figures.push_back(shown(name + ": 1-sigma of the share", f.track.standard_error()));
  if (f.track.without_track > 0) figures.push_back(at_most(name + ": seeds without a track", f.track.without_track, 0));
  return figures;
}

std::vector<std::pair<std::string, std::string>> settings_of(const std::vector<Profile>& profiles) {
  std::string names;
  for (const Profile& profile : profiles) names += (names.empty() ? "" : ", ") + profile.name;
  return {
      {"profiles", names},
      {"method", honesty_methods().front() + ", as configured by default (launch, orbit_pass) or by config/cape.toml"},
      {"radars of launch, orbit_pass", "goheung 10 Hz, jeju 20 Hz, 25 m, 0.01 deg"},
      {"bias and wander", "drawn from the priors in force, with GPS or without"},
      {"noise", "white, as the filter is told it: angle_inflation included"},
      {"GPS", "1 Hz with velocity, configured noise, slow error of the filter's model"},
      {"scored", "position twice a second, predicted to the tick, from the first estimate on"}};
}

}  // namespace

const std::vector<std::string>& honesty_methods() {
  static const std::vector<std::string> methods{"joint"};
  return methods;
}

std::vector<Profile> honesty_profiles(std::span<const flights::RecordedFlight> recorded) {
  std::vector<Profile> profiles{launch_profile()};
  for (const flights::RecordedFlight& flight : recorded) profiles.push_back(profile_of(flight));
  profiles.push_back(orbit_pass_profile());
  return profiles;
}

ExperimentResult run_honesty(const ExperimentOptions& options, std::span<const flights::RecordedFlight> recorded) {
  (void)chosen_methods(options.methods, honesty_methods());
  const int runs = options.runs > 0 ? options.runs : honesty_runs;
  std::vector<Profile> profiles = honesty_profiles(recorded);
  for (Profile& profile : profiles) profile.range.fuse.methods = {Name(honesty_methods().front())};
  std::vector<Case> cases;
  for (const Profile& profile : profiles) {
    cases.push_back({&profile, true});
    cases.push_back({&profile, false});
  }
  const int count = static_cast<int>(cases.size());
  const auto tracks = parallel_runs<Track>(
      runs * count, options.jobs,
      [&](int i) {
        const Case& c = cases[static_cast<std::size_t>(i % count)];
        return honesty::fly(*c.profile, c.gps, seed_of_run(options.seed, i / count));
      },
      options.progress);

  std::vector<Flown> flown;
  for (std::size_t c = 0; c < cases.size(); ++c) {
    flown.push_back({cases[c], {}});
    for (std::size_t i = c; i < tracks.size(); i += cases.size()) flown.back().track += tracks[i];
  }
  ExperimentResult out;
  out.name = "honesty";
  out.title = "Honesty of the fused position over seeds: errors against the covariance that the service states";
  out.runs = runs;
  out.seed = options.seed;
  out.settings = settings_of(profiles);
  for (const Flown& f : flown) {
    for (Figure& figure : figures_of(f)) out.figures.push_back(std::move(figure));
  }
  for (const Profile& profile : profiles) add_plots(flown, profile, out.plots);
  for (const Flown& f : flown) {
    for (const Exclusion& e : f.track.excluded) {
      out.notes.push_back(f.of.name() + ", seed " + std::to_string(e.seed) + ": " + std::string(e.source.view()) +
                          " excluded at T+" + std::to_string(std::lround(e.at_s)) + " s, and told the truth");
    }
  }
  if (recorded.empty()) out.notes.emplace_back("Recorded flights: left out, their truths are not here (--data).");
  return out;
}

}  // namespace downrange::experiment
