#include <algorithm>
#include <array>
#include <downrange/est/method/bound.hpp>
#include <downrange/stage/engine.hpp>
#include <map>

#include "experiment/honesty.hpp"
#include "experiment/parallel.hpp"

namespace downrange::experiment {
namespace {

using namespace honesty;

constexpr std::string_view method = "joint";
constexpr std::string_view uncorrected = "uncorrected";
constexpr double over_uncorrected = 0.6;
constexpr double over_bound = 1.1;

/// Which radars of the profile are flown: the first two, or one of them.
enum class Radars : std::uint8_t { Both, First, Second };
constexpr std::array all_radars{Radars::Both, Radars::First, Radars::Second};

/// Squares of position errors, m, at the ticks where both methods have a track; with both radars the best possible
/// there.
struct Score {
  score::Squares joint;
  score::Squares uncorrected;
  score::Squares bound;

  Score& operator+=(const Score& other) {
    joint += other.joint;
    uncorrected += other.uncorrected;
    bound += other.bound;
    return *this;
  }
};

Profile with_radars(Profile profile, Radars chosen) {
  std::vector<RadarConfig>& radars = profile.range.radars;
  radars.resize(2);
  if (chosen == Radars::First) radars.pop_back();
  if (chosen == Radars::Second) radars.erase(radars.begin());
  profile.range.fuse.methods = {Name(method), Name(uncorrected)};
  return profile;
}

class Scorer final : public ResultSink {
 public:
  explicit Scorer(const Profile& profile) : profile_(profile) {}

  void emit(const Result& result) override {
    const auto* t = std::get_if<Trajectory>(&result);
    if (t == nullptr || (!t->primary && t->method != Name(uncorrected))) return;
    const auto truth = profile_.truth(t->epoch);
    if (!truth) return;
    const double square = (score::position_at(*t, t->epoch).mean - truth->position.m).squaredNorm();
    (t->primary ? joint_ : uncorrected_)[t->epoch] = square;
  }

  /// With `bound` told its plots from the first to the last tick that counts.
  [[nodiscard]] Score score(Bound* bound, const std::vector<Measurement>& plots) const {
    Score score;
    auto next = plots.begin();
    for (const auto& [epoch, square] : joint_) {
      const auto other = uncorrected_.find(epoch);
      if (other == uncorrected_.end()) continue;
      score.joint.add(square);
      score.uncorrected.add(other->second);
      if (bound == nullptr) continue;
      for (; next != plots.end() && next->epoch <= epoch; ++next) bound->apply(*next);
      score.bound.add(bound->track_covariance().topLeftCorner<3, 3>().trace());
    }
    return score;
  }

 private:
  const Profile& profile_;
  std::map<Time, double> joint_;
  std::map<Time, double> uncorrected_;
};

std::vector<Measurement> plots_of(const RangeConfig& range, const std::vector<Event>& events) {
  std::vector<Measurement> plots;
  for (const Event& event : events) {
    const auto* plot = std::get_if<RadarTspi>(&event);
    if (plot == nullptr) continue;
    const auto radar = std::ranges::find(range.radars, plot->sensor, &RadarConfig::id);
    plots.push_back({.epoch = plot->epoch,
                     .source = static_cast<int>(radar - range.radars.begin()),
                     .sequence = plot->sequence,
                     .measured = downrange::Plot{.measured = plot->measured}});
  }
  std::ranges::sort(plots, processed_before);
  return plots;
}

/// Of these plots along this truth: white jerk of the thrust model, the priors in force, every bias at its prior's
/// mean.
Bound bound_of(const Profile& profile, Time first) {
  MethodSettings settings;
  settings.radars = radars_in_force(profile.range, false);
  settings.motion.kinematics = Kinematics::Ca;
  settings.motion.q_ca_m2_s5 = settings.motion.launch.q_thrust_m2_s5;
  settings.gps.error.enabled = false;
  std::vector<Vec<bias_term_count>> biases;
  for (const RadarModel& radar : settings.radars) biases.push_back(radar.bias.prior_mean);
  const auto motion = [truth = profile.truth](Time t) {
    Vec<9> x = Vec<9>::Zero();
    if (const auto state = truth(t)) x.head<6>() << state->position.m, state->velocity.m_s;
    return x;
  };
  Bound bound(settings, motion, std::move(biases));
  Mat<9, 9> open = Mat<9, 9>::Zero();
  open.diagonal() << Vec<3>::Constant(1e10), Vec<3>::Constant(1e8), Vec<3>::Constant(1e4);
  bound.start(first, open);
  return bound;
}

Score compared(const Profile& profile, bool with_bound, std::uint64_t seed) {
  const std::vector<Event> events = events_of(profile, false, seed);
  Scorer scorer(profile);
  Engine engine(range_of(profile), {}, scorer);
  for (const Event& event : events) engine.handle(engine.admit(event));
  const std::vector<Measurement> plots = plots_of(profile.range, events);
  if (!with_bound || plots.empty()) return scorer.score(nullptr, plots);
  Bound bound = bound_of(profile, plots.front().epoch);
  return scorer.score(&bound, plots);
}

void add_figures(const Profile& profile, Radars radars, const Score& score, std::vector<Figure>& figures) {
  const double joint = score.joint.rms();
  const double without = score.uncorrected.rms();
  if (radars != Radars::Both) {
    const std::string name = profile.name + ", " + std::string(profile.range.radars.front().id.view()) + " alone: ";
    figures.push_back(shown(name + "joint rms, m", joint));
    figures.push_back(at_most(name + "joint over uncorrected", joint / without, 1));
    return;
  }
  const std::string name = profile.name + ", two radars: ";
  figures.push_back(shown(name + "joint rms, m", joint));
  figures.push_back(at_most(name + "joint over uncorrected", joint / without, over_uncorrected));
  figures.push_back(at_most(name + "joint over bound", joint / score.bound.rms(), over_bound));
}

}  // namespace

ExperimentResult run_without_gps(const ExperimentOptions& options, std::span<const flights::RecordedFlight> recorded) {
  (void)chosen_methods(options.methods, honesty_methods());
  const int runs = options.runs > 0 ? options.runs : without_gps_runs;
  struct Case {
    Profile profile;
    Radars radars;
  };
  std::vector<Case> cases;
  for (const Profile& profile : honesty_profiles(recorded)) {
    for (const Radars radars : all_radars) cases.push_back({with_radars(profile, radars), radars});
  }
  const int count = static_cast<int>(cases.size());
  const auto scores = parallel_runs<Score>(
      runs * count, options.jobs,
      [&](int i) {
        const Case& c = cases[static_cast<std::size_t>(i % count)];
        return compared(c.profile, c.radars == Radars::Both, seed_of_run(options.seed, i / count));
      },
      options.progress);
  ExperimentResult out;
  out.name = "without-gps";
  out.title = "Without GPS: two radars that calibrate each other, and one alone";
  out.runs = runs;
  out.seed = options.seed;
  out.settings = {
      {"radars", "the first two of each profile's range, together and alone; bias and wander drawn from the priors"},
      {"uncorrected", "the fusion of the same plots as they are"},
      {"bound", "joint's covariance along the truth: priors in force, white jerk of the thrust model"},
      {"scored", "position twice a second where both have a track"}};
  for (std::size_t c = 0; c < cases.size(); ++c) {
    Score sum;
    for (std::size_t i = c; i < scores.size(); i += cases.size()) sum += scores[i];
    add_figures(cases[c].profile, cases[c].radars, sum, out.figures);
  }
  if (recorded.empty()) out.notes.emplace_back("Recorded flights: left out, their truths are not here (--data).");
  return out;
}

}  // namespace downrange::experiment
