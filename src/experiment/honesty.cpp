#include "experiment/honesty.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <downrange/est/filter/hypothesis.hpp>
#include <downrange/est/model/slow_pointing.hpp>
#include <downrange/stage/engine.hpp>
#include <memory>
#include <numbers>
#include <optional>
#include <tuple>

#include "sim/orbit_pass.hpp"
#include "sim/random_stream.hpp"
#include "sim/sensor_models.hpp"
#include "sim/simulation.hpp"
#include "stage/methods.hpp"

namespace downrange::experiment::honesty {
namespace {

constexpr double deg = std::numbers::pi / 180;
constexpr Time naro_liftoff{1'772'352'000'000'000'000};
constexpr Duration tick = milliseconds(500);
constexpr double plot_latency_s = 0.05;
constexpr double fix_latency_s = 0.3;

RadarConfig naro_radar(std::string_view id, const Geodetic& site, double rate_hz) {
  RadarConfig radar;
  radar.id = id;
  radar.site = Site(site);
  radar.sigma = {25, 0.01 * deg, 0.01 * deg};
  radar.rate_hz = rate_hz;
  return radar;
}

/// Two radars and a telemetry station, all else as it is by default.
Profile naro_profile(std::string name) {
  Profile profile;
  profile.name = std::move(name);
  profile.target = "vehicle";
  profile.liftoff = naro_liftoff;
  profile.range.name = "naro";
  profile.range.targets = {{profile.target}};
  profile.range.radars = {naro_radar("goheung", {34.4450 * deg, 127.5200 * deg, 120}, 10),
                          naro_radar("jeju", {33.2900 * deg, 126.4600 * deg, 350}, 20)};
  profile.range.telemetry = {{"telemetry", profile.range.radars[0].site}};
  return profile;
}

/// Values for the terms that a radar's prior has, drawn from it; time tag and the rest in the simulator's own places.
sim::RadarBias drawn_bias(const RadarBlock& block, std::uint64_t seed, const Name& radar) {
  const int n = block.terms;
  Eigen::VectorXd mean(n);
  Eigen::MatrixXd cov(n, n);
  const auto index = [&](int i) { return static_cast<Eigen::Index>(block.term[static_cast<std::size_t>(i)]); };
  for (int i = 0; i < n; ++i) {
    mean[i] = block.model.prior_mean[index(i)];
    for (int j = 0; j < n; ++j) cov(i, j) = block.model.prior_cov(index(i), index(j));
  }
  sim::RandomStream random(seed, "prior/" + std::string(radar.view()));
  Eigen::VectorXd white(n);
  for (double& w : white) w = random.normal();
  const Eigen::VectorXd value = mean + cov.llt().matrixL() * white;
  sim::RadarBias bias;
  for (int i = 0; i < n; ++i) {
    const double v = value[i];
    switch (block.term[static_cast<std::size_t>(i)]) {
      case BiasTerm::OffsetSouth:
      case BiasTerm::OffsetEast:
      case BiasTerm::OffsetZenith:
        bias.sez_offset_m[index(i) - static_cast<Eigen::Index>(BiasTerm::OffsetSouth)] = v;
        break;
      case BiasTerm::ScaleSouth:
      case BiasTerm::ScaleEast:
      case BiasTerm::ScaleZenith:
        bias.sez_scale[index(i) - static_cast<Eigen::Index>(BiasTerm::ScaleSouth)] = v;
        break;
      case BiasTerm::OffsetRange:
        bias.offset.range_m = v;
        break;
      case BiasTerm::OffsetAzimuth:
        bias.offset.azimuth_rad = v;
        break;
      case BiasTerm::OffsetElevation:
        bias.offset.elevation_rad = v;
        break;
      case BiasTerm::ScaleRange:
      case BiasTerm::ScaleAzimuth:
      case BiasTerm::ScaleElevation:
        bias.scale[index(i) - static_cast<Eigen::Index>(BiasTerm::ScaleRange)] = v;
        break;
      case BiasTerm::TimeTag:
        bias.time_tag_s = v;
        break;
    }
  }
  return bias;
}

sim::RadarScenario radar_scenario(const RadarConfig& radar, const PolarSigma& sigma, const RadarBlock& prior,
                                  double end_s, std::uint64_t seed) {
  sim::RadarScenario s;
  s.id = radar.id;
  s.site = radar.site;
  s.sigma = sigma;
  s.azimuth_sigma_on_sky = radar.azimuth_sigma_on_sky;
  s.coloured_on_sky = true;
  s.coloured_angle_sigma_rad = prior.wander.sigma_rad;
  s.coloured_angle_tau_s = prior.wander.tau_s;
  s.rate_hz = radar.rate_hz;
  s.phase_s = 0.013;
  s.track = {0, end_s};
  s.range_max_m = radar.range_max_m;
  s.elevation_min_rad = radar.elevation_min_rad;
  s.refractivity = radar.refractivity;
  s.latency_s = plot_latency_s;
  s.bias = drawn_bias(prior, seed, radar.id);
  return s;
}

sim::Scenario scenario_of(const Profile& profile, bool gps, std::uint64_t seed) {
  const RangeConfig& range = profile.range;
  sim::Scenario s;
  s.name = profile.name.c_str();
  s.target = profile.target;
  s.liftoff = profile.liftoff;
  s.end_s = profile.end_s;
  s.simulated = range.ingest.expect_simulated;
  const std::vector<RadarModel> models = radars_in_force(range, gps);
  const std::vector<RadarBlock> priors = bias_layout(models, 0).radars;
  for (std::size_t i = 0; i < range.radars.size(); ++i)
    s.radars.push_back(radar_scenario(range.radars[i], models[i].sigma, priors[i], profile.end_s, seed));
  if (!gps || range.telemetry.empty()) return s;
  s.gps.active = {0, profile.end_s};
  s.gps.rate_hz = profile.gps_rate_hz;
  s.gps.sigma_enu_m = {range.gps.sigma_horizontal_m, range.gps.sigma_horizontal_m, range.gps.sigma_vertical_m};
  s.gps.sigma_velocity_m_s = range.gps.sigma_velocity_m_s;
  if (range.align.gps.error.enabled) {
    s.gps.coloured_sigma_enu_m.setConstant(range.align.gps.error.sigma_m);
    s.gps.coloured_tau_s = range.align.gps.error.tau_s;
  }
  s.gps.latency_s = fix_latency_s;
  sim::StationScenario station;
  station.id = range.telemetry.front().id;
  station.site = range.telemetry.front().site;
  station.elevation_min_rad = -90 * deg;
  s.stations = {station};
  return s;
}

std::vector<Event> simulated(const Profile& profile, const sim::Scenario& scenario, std::uint64_t seed) {
  MissionEvent liftoff;
  liftoff.mission = scenario.name;
  liftoff.label = "lift-off";
  liftoff.kind = MissionEventKind::Liftoff;
  liftoff.sequence = 1;
  liftoff.epoch = liftoff.received = scenario.liftoff;
  liftoff.simulated = scenario.simulated;
  std::vector<Event> events{liftoff};
  std::ignore = sim::simulate_sensors(scenario, profile.truth, seed, events);
  sim::sort_by_arrival(events);
  return events;
}

class Scorer final : public ResultSink {
 public:
  Scorer(const Profile& profile, std::uint64_t seed) : profile_(profile), seed_(seed) {
    const auto bins = static_cast<std::size_t>(std::ceil(profile.end_s / bin_s));
    track_.share.resize(bins);
    track_.error.resize(bins);
    track_.promised.resize(bins);
  }

  void emit(const Result& result) override {
    if (const auto* judged = std::get_if<Integrity>(&result)) note_exclusion(*judged);
    const auto* t = std::get_if<Trajectory>(&result);
    if (t == nullptr || !t->primary) return;
    const double t_s = (t->epoch - profile_.liftoff).seconds();
    const std::optional<score::TrueState> truth = profile_.truth(t->epoch);
    if (!truth || t_s < 0 || t_s >= profile_.end_s) return;
    const Gaussian<3> x = score::position_at(*t, t->epoch);
    const Eigen::Vector3d error = x.mean - truth->position.m;
    const double nees = normalised_square<3>(error, x.cov);
    const bool inside = score::inside_95(nees, 3);
    const auto bin = static_cast<std::size_t>(t_s / bin_s);
    track_.inside.add(inside);
    track_.share[bin].add(inside);
    track_.error[bin].add(error.squaredNorm());
    track_.promised[bin].add(x.cov.trace());
    track_.nees.add(nees);
    track_.position.add(error.squaredNorm());
  }

  [[nodiscard]] Track track() && {
    if (track_.inside.count == 0) {
      track_.without_track = 1;
    } else {
      track_.shares = {track_.inside.value()};
    }
    return std::move(track_);
  }

 private:
  void note_exclusion(const Integrity& judged) {
    if (!track_.excluded.empty()) return;
    const auto excluded = std::ranges::find(judged.sources, IntegrityVerdict::Excluded, &SourceIntegrity::verdict);
    if (excluded == judged.sources.end()) return;
    track_.excluded.push_back(
        {.seed = seed_, .source = excluded->sensor, .at_s = (judged.time - profile_.liftoff).seconds()});
  }

  const Profile& profile_;
  std::uint64_t seed_;
  Track track_;
};

template <class T>
void add(std::vector<T>& sums, const std::vector<T>& other) {
  sums.resize(std::max(sums.size(), other.size()));
  for (std::size_t i = 0; i < other.size(); ++i) sums[i] += other[i];
}

}  // namespace

Track& Track::operator+=(const Track& other) {
  inside += other.inside;
  add(share, other.share);
  add(error, other.error);
  add(promised, other.promised);
  nees += other.nees;
  position += other.position;
  shares.insert(shares.end(), other.shares.begin(), other.shares.end());
  without_track += other.without_track;
  excluded.insert(excluded.end(), other.excluded.begin(), other.excluded.end());
  return *this;
}

double Track::standard_error() const {
  const auto n = static_cast<double>(shares.size());
  double mean = 0;
  for (const double s : shares) mean += s / n;
  double square = 0;
  for (const double s : shares) square += (s - mean) * (s - mean);
  return std::sqrt(square / (n - 1) / n);
}

Profile launch_profile() {
  Profile profile = naro_profile("launch");
  profile.end_s = 480;
  const auto flown =
      std::make_shared<sim::LaunchTrajectory>(sim::naro_launch_profile(), profile.liftoff, profile.end_s);
  profile.truth = [flown](Time t) { return flown->at(t); };
  return profile;
}

Profile orbit_pass_profile() {
  Profile profile = naro_profile("orbit_pass");
  const auto flown = std::make_shared<sim::OrbitPass>(sim::naro_orbit_pass(), profile.liftoff);
  profile.end_s = flown->duration_s();
  profile.truth = [flown](Time t) { return flown->at(t); };
  return profile;
}

Profile profile_of(const flights::RecordedFlight& flight) {
  Profile profile;
  profile.name = flight.name;
  profile.range = flight.range;
  profile.target = flight.target;
  profile.liftoff = flight.liftoff;
  const auto table = std::make_shared<score::TruthTable>(flight.truth);
  profile.end_s = (table->samples().back().time - flight.liftoff).seconds();
  profile.truth = [table](Time t) { return table->at(t); };
  return profile;
}

std::vector<Event> events_of(const Profile& profile, bool gps, std::uint64_t seed) {
  return simulated(profile, scenario_of(profile, gps, seed), seed);
}

RangeConfig range_of(const Profile& profile) {
  RangeConfig range = profile.range;
  range.tick = tick;
  range.fuse.publish_on_data = false;
  range.antennas.clear();
  return range;
}

std::vector<RadarModel> radars_in_force(const RangeConfig& range, bool gps) {
  std::vector<RadarModel> models = with_wander_as_states(radar_models(range));
  if (gps || !range.align.gps.no_gps.enabled) return models;
  const std::vector<RadarBlock> priors = bias_layout_without_gps(models, range.align.gps.no_gps, 0).radars;
  for (std::size_t i = 0; i < models.size(); ++i) {
    models[i].bias = priors[i].model;
    models[i].wander = priors[i].wander;
  }
  return models;
}

std::uint64_t seed_of_run(std::uint64_t seed, int run) { return seed * 1'000'003 + static_cast<std::uint64_t>(run); }

Track fly(const Profile& profile, bool gps, std::uint64_t seed) {
  RangeConfig range = range_of(profile);
  range.fuse.methods.resize(1);
  Scorer scorer(profile, seed);
  Engine engine(range, {}, scorer);
  for (const Event& event : events_of(profile, gps, seed)) engine.handle(engine.admit(event));
  return std::move(scorer).track();
}

}  // namespace downrange::experiment::honesty
