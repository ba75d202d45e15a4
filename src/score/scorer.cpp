#include "score/scorer.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <downrange/est/bias_terms.hpp>
#include <downrange/est/consistency.hpp>
#include <downrange/geo/polar.hpp>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <utility>

namespace downrange::score {
namespace {

constexpr Duration mean_interval = milliseconds(10'000);

double rms(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return values.empty() ? 0 : std::sqrt(sum / static_cast<double>(values.size()));
}

/// Smallest value that 95 % of the values do not exceed.
double p95(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto rank = static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(values.size()))) - 1;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(rank), values.end());
  return values[rank];
}

double largest(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

double share(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

Eigen::Matrix3d position_covariance(const Trajectory& trajectory) {
  Eigen::Matrix3d P;
  const int n = trajectory.state_size;
  for (int row = 0; row < 3; ++row)
    for (int column = row; column < 3; ++column) {
      const int index = row * n - row * (row - 1) / 2 + column - row;
      P(row, column) = P(column, row) = trajectory.covariance[static_cast<std::size_t>(index)];
    }
  return P;
}

bool inside_95_percent(const Eigen::Vector3d& error, const Eigen::Matrix3d& P) {
  static const double limit = chi2_quantile(0.95, 3);
  const Eigen::LLT<Eigen::Matrix3d> llt(P);
  return llt.info() == Eigen::Success && error.dot(llt.solve(error)) <= limit;
}

Polar look_angles(const Site& site, const Position<Ecef>& target) { return polar_from_enu(site.enu_of(target)); }

Eigen::Vector3d direction(double azimuth_rad, double elevation_rad) {
  return enu_from_polar({1.0, azimuth_rad, elevation_rad}).m;
}

/// measured - true; azimuth on the sky.
Eigen::Vector3d polar_error(const Polar& measured, const Polar& truth) {
  return {measured.range_m - truth.range_m,
          wrap_pi(measured.azimuth_rad - truth.azimuth_rad) * std::cos(truth.elevation_rad),
          measured.elevation_rad - truth.elevation_rad};
}

double time_tag_of(const SensorBias& bias) {
  for (int i = 0; i < bias.terms; ++i)
    if (bias.term[static_cast<std::size_t>(i)] == BiasTerm::TimeTag) return bias.value[static_cast<std::size_t>(i)];
  return 0;
}

struct PositionSample {
  Time epoch;
  double error_m;
  bool inside_95;
};

struct PointingSamples {
  std::vector<double> error_rad;
  std::size_t held = 0;
  std::size_t axes_inside = 0;
  double age_sum_s = 0;
  double worst_age_s = 0;
};

PositionScore position_score(const std::vector<PositionSample>& samples, Time from, Time to) {
  std::vector<double> errors;
  std::size_t inside = 0;
  for (const PositionSample& sample : samples) {
    if (sample.epoch < from || sample.epoch >= to) continue;
    errors.push_back(sample.error_m);
    if (sample.inside_95) ++inside;
  }
  return {errors.size(), rms(errors), p95(errors), largest(errors), share(inside, errors.size())};
}

class IntervalMeans {
 public:
  void add(Time t, const Eigen::Vector3d& error) {
    auto& [sum, count] = intervals_.try_emplace(t.ns / mean_interval.ns, Eigen::Vector3d::Zero(), 0).first->second;
    sum += error;
    ++count;
  }

  [[nodiscard]] SystematicError rms_of_means() const {
    Eigen::Vector3d sum_of_squares = Eigen::Vector3d::Zero();
    for (const auto& [interval, entry] : intervals_) sum_of_squares += (entry.first / entry.second).cwiseAbs2();
    const Eigen::Vector3d rms =
        (sum_of_squares / static_cast<double>(std::max<std::size_t>(intervals_.size(), 1))).cwiseSqrt();
    return {rms[0], rms[1], rms[2]};
  }

 private:
  std::map<std::int64_t, std::pair<Eigen::Vector3d, int>> intervals_;
};

struct RadarAccount {
  std::size_t plots = 0;
  std::size_t rejected = 0;
  IntervalMeans before;
  IntervalMeans after;
};

/// What health told of a source once a second.
struct HealthSample {
  std::uint64_t weighed = 0;  ///< by the method since the start
  int window = 0;             ///< the last of these that the share is over
  double inside_95 = 1;
  bool mismatch = false;
};

struct SourceTally {
  std::array<std::uint64_t, reason_count> by_ingest{};
  std::uint64_t gated = 0;
  std::uint64_t frozen = 0;
  std::size_t outliers = 0;
  std::size_t outliers_rejected = 0;
  std::vector<HealthSample> health;
};

/// Disjoint windows from the end of the flight back.
void add_consistency(const std::vector<HealthSample>& health, SourceScore& score) {
  const int full = MismatchAlarm().window();
  double inside = 0;
  std::uint64_t begin = std::numeric_limits<std::uint64_t>::max();  // of what is counted so far
  for (auto h = health.rbegin(); h != health.rend(); ++h) {
    if (h->mismatch) ++score.mismatch_s;
    if (h->window == full) score.least_nis_inside_95 = std::min(score.least_nis_inside_95.value_or(1), h->inside_95);
    const auto window = static_cast<std::uint64_t>(h->window);
    if (window == 0 || h->weighed > begin) continue;
    score.nis_count += window;
    inside += h->inside_95 * h->window;
    begin = h->weighed - std::min(window, h->weighed);
  }
  if (score.nis_count > 0) score.nis_inside_95 = inside / static_cast<double>(score.nis_count);
}

}  // namespace

/// Collects what one run says.
class Scorer::Run : public ResultSink {
 public:
  Run(const Scorer& scorer, std::string label) : scorer_(scorer), label_(std::move(label)) {}

  void emit(const Result& result) override {
    std::visit([this](const auto& r) { add(r); }, result);
  }

  [[nodiscard]] TrajectoryScore trajectory_score(const std::string& label, const Name& method) const {
    TrajectoryScore score{label, {}};
    const auto found = positions_.find(method);
    for (const Phase& phase : scorer_.phases_)
      score.phases.push_back(found == positions_.end()
                                 ? PositionScore{}
                                 : position_score(found->second, scorer_.liftoff_ + seconds(phase.from_s),
                                                  scorer_.liftoff_ + seconds(phase.to_s)));
    return score;
  }

  /// The service's own run: its primary method first, named; then the methods beside it.
  [[nodiscard]] std::vector<TrajectoryScore> scores_by_method() const {
    std::vector<TrajectoryScore> scores{trajectory_score(label_ + " (" + std::string(primary_.view()) + ")", primary_)};
    for (const auto& [method, samples] : positions_)
      if (method != primary_) scores.push_back(trajectory_score(std::string(method.view()), method));
    return scores;
  }

  [[nodiscard]] TrajectoryScore primary_score() const { return trajectory_score(label_, primary_); }

  [[nodiscard]] RadarScore radar_score(const Name& sensor) const {
    const auto found = radars_.find(sensor);
    const RadarAccount account = found == radars_.end() ? RadarAccount{} : found->second;
    return {sensor, account.plots, account.rejected, account.before.rms_of_means(), account.after.rms_of_means()};
  }

  [[nodiscard]] SourceScore source_score(const Name& sensor, ObservationKind kind) const {
    SourceScore score;
    score.sensor = sensor;
    score.kind = kind;
    const auto found = sources_.find({kind, sensor});
    if (found == sources_.end()) return score;
    const SourceTally& tally = found->second;
    score.count = tally.by_ingest;
    auto& accepted = score.count[static_cast<std::size_t>(Reason::Accepted)];
    accepted -= std::min(tally.gated + tally.frozen, accepted);
    score.count[static_cast<std::size_t>(Reason::Gated)] = tally.gated;
    score.count[static_cast<std::size_t>(Reason::Frozen)] = tally.frozen;
    score.outliers = tally.outliers;
    score.outliers_rejected = tally.outliers_rejected + (open_outlier_ && open_outlier_->sensor == sensor ? 1 : 0);
    if (biases_.empty() && !scorer_.range_.fuse.publish_on_data) score.outliers_rejected.reset();
    add_consistency(tally.health, score);
    return score;
  }

  [[nodiscard]] std::optional<SensorBias> last_bias(const Name& sensor) const {
    const auto found = biases_.find(sensor);
    return found == biases_.end() || found->second.terms == 0 ? std::nullopt : std::optional(found->second);
  }

  [[nodiscard]] std::vector<PointingScore> pointing_scores(const Name& antenna) const {
    std::vector<PointingScore> scores;
    for (const auto& [key, samples] : pointing_) {
      if (key.first != antenna) continue;
      const std::size_t scored = samples.error_rad.size();
      const std::size_t commands = scored + samples.held;
      scores.push_back({antenna, key.second, commands, samples.held, rms(samples.error_rad), p95(samples.error_rad),
                        largest(samples.error_rad), share(samples.axes_inside, 2 * scored),
                        samples.age_sum_s / static_cast<double>(commands), samples.worst_age_s});
    }
    return scores;
  }

 private:
  /// An outlier that ingest let through, until the method's results of the same event show that it took it.
  struct OpenOutlier {
    Name sensor;
    Time received;
  };

  void tally(const Observation& observation) {
    SourceTally& source = sources_[{observation.kind, observation.sensor}];
    ++source.by_ingest[static_cast<std::size_t>(observation.verdict)];
    if (open_outlier_) ++sources_[{ObservationKind::Radar, open_outlier_->sensor}].outliers_rejected;
    open_outlier_.reset();
    if (observation.kind != ObservationKind::Radar ||
        !scorer_.outliers_.contains({observation.sensor, observation.sequence}))
      return;
    ++source.outliers;
    if (observation.verdict == Reason::Accepted) {
      open_outlier_ = {observation.sensor, observation.received};
    } else {
      ++source.outliers_rejected;
    }
  }

  /// A result that the first method gave for an event received then: it took what came with it.
  void taken(const Name& method, Time received) {
    if (open_outlier_ && method == scorer_.first_method() && received == open_outlier_->received) open_outlier_.reset();
  }

  void add(const Trajectory& trajectory) {
    taken(trajectory.method, trajectory.received);
    if (trajectory.target != scorer_.target_) return;
    const std::optional<TrueState> truth = scorer_.truth_(trajectory.epoch);
    if (!truth) return;
    if (trajectory.primary) primary_ = trajectory.method;
    const Eigen::Vector3d error = Eigen::Vector3d::Map(trajectory.state.data()) - truth->position.m;
    positions_[trajectory.method].push_back(
        {trajectory.epoch, error.norm(), inside_95_percent(error, position_covariance(trajectory))});
  }

  void add(const Observation& observation) {
    tally(observation);
    if (observation.kind != ObservationKind::Radar || observation.target != scorer_.target_) return;
    const auto radar = std::find_if(scorer_.range_.radars.begin(), scorer_.range_.radars.end(),
                                    [&](const RadarConfig& r) { return r.id == observation.sensor; });
    if (radar == scorer_.range_.radars.end()) return;
    RadarAccount& account = radars_[observation.sensor];
    if (observation.verdict != Reason::Accepted) {
      ++account.rejected;
      return;
    }
    if (!scorer_.in_a_phase(observation.epoch)) return;
    if (scorer_.outliers_.contains({observation.sensor, observation.sequence})) return;
    const SensorBias& bias = biases_[observation.sensor];
    const std::optional<TrueState> truth = scorer_.truth_(observation.epoch);
    const std::optional<TrueState> truth_at_tag = scorer_.truth_(observation.epoch - seconds(time_tag_of(bias)));
    if (!truth || !truth_at_tag) return;
    const auto terms = static_cast<std::size_t>(bias.terms);
    Polar compensated =
        compensate(observation.measured, std::span(bias.term).first(terms), std::span(bias.value).first(terms));
    if (const auto air = scorer_.air_.find(observation.sensor); air != scorer_.air_.end()) {
      const Refraction bent = air->second.at_measured(compensated.range_m, compensated.elevation_rad);
      compensated.range_m -= bent.range_m;
      compensated.elevation_rad -= bent.elevation_rad;
    }
    ++account.plots;
    account.before.add(observation.epoch, polar_error(observation.measured, look_angles(radar->site, truth->position)));
    account.after.add(observation.epoch, polar_error(compensated, look_angles(radar->site, truth_at_tag->position)));
  }

  void add(const SensorBias& bias) {
    taken(bias.method, bias.received);
    if (bias.method == scorer_.first_method()) biases_[bias.sensor] = bias;
  }

  void add(const SlavingCommand& command) {
    const auto antenna = std::find_if(scorer_.range_.antennas.begin(), scorer_.range_.antennas.end(),
                                      [&](const AntennaConfig& a) { return a.id == command.antenna; });
    const std::optional<TrueState> truth = scorer_.truth_(command.apply_at);
    if (antenna == scorer_.range_.antennas.end() || command.target != scorer_.target_ || !truth) return;
    PointingSamples& samples = pointing_[{command.antenna, command.source}];
    samples.age_sum_s += command.age_s;
    samples.worst_age_s = std::max(samples.worst_age_s, command.age_s);
    if ((command.limits & (LimitElevation | LimitAzimuth)) != 0) {
      ++samples.held;
      return;
    }
    const Polar look = look_angles(antenna->site, truth->position);
    const Eigen::Vector3d commanded = direction(command.azimuth_rad, command.elevation_rad);
    const Eigen::Vector3d exact = direction(look.azimuth_rad, look.elevation_rad);
    samples.error_rad.push_back(std::atan2(commanded.cross(exact).norm(), commanded.dot(exact)));
    const double azimuth_error = std::abs(wrap_pi(command.azimuth_rad - look.azimuth_rad));
    const double elevation_error = std::abs(command.elevation_rad - look.elevation_rad);
    if (azimuth_error <= 2 * command.sigma_azimuth_rad) ++samples.axes_inside;
    if (elevation_error <= 2 * command.sigma_elevation_rad) ++samples.axes_inside;
  }

  void add(const SourceHealth& health) {
    const auto of = [&](Reason reason) { return health.count[static_cast<std::size_t>(reason)]; };
    for (auto& [key, source] : sources_) {
      if (key.second != health.sensor) continue;
      source.gated = of(Reason::Gated);
      source.frozen = of(Reason::Frozen);
      source.health.push_back({.weighed = of(Reason::Accepted) + source.gated,
                               .window = health.nis_count,
                               .inside_95 = health.nis_inside_95,
                               .mismatch = health.mismatch});
    }
  }

  const Scorer& scorer_;
  std::string label_;
  Name primary_;
  std::map<Name, std::vector<PositionSample>> positions_;  // by method
  std::map<Name, SensorBias> biases_;
  std::map<Name, RadarAccount> radars_;
  std::map<std::pair<ObservationKind, Name>, SourceTally> sources_;
  std::optional<OpenOutlier> open_outlier_;
  std::map<std::pair<Name, SlavingSource>, PointingSamples> pointing_;
};

bool Scorer::in_a_phase(Time t) const {
  return std::ranges::any_of(phases_, [&](const Phase& phase) {
    return t >= liftoff_ + seconds(phase.from_s) && t < liftoff_ + seconds(phase.to_s);
  });
}

Name Scorer::first_method() const { return range_.fuse.methods.empty() ? Name() : range_.fuse.methods.front(); }

Scorer::Scorer(const RangeConfig& range, const Name& target, TruthFunction truth, Time liftoff,
               std::vector<Phase> phases)
    : range_(range), target_(target), truth_(std::move(truth)), liftoff_(liftoff), phases_(std::move(phases)) {
  for (const RadarConfig& radar : range_.radars) {
    if (radar.refractivity > 0)
      air_.emplace(radar.id, RefractionTable(atmosphere_over(radar.site.geodetic(), radar.refractivity)));
  }
}

Scorer::~Scorer() = default;

ResultSink& Scorer::open_run(const std::string& label) { return runs_.emplace_back(*this, label); }

Summary Scorer::summary() const {
  Summary summary;
  summary.phases = phases_;
  if (runs_.empty()) return summary;
  summary.trajectories = runs_.front().scores_by_method();
  for (auto run = std::next(runs_.begin()); run != runs_.end(); ++run)
    summary.trajectories.push_back(run->primary_score());
  for (const RadarConfig& radar : range_.radars) summary.radars.push_back(runs_.front().radar_score(radar.id));
  for (const AntennaConfig& antenna : range_.antennas)
    for (const PointingScore& score : runs_.front().pointing_scores(antenna.id)) summary.pointing.push_back(score);
  summary.method = first_method();
  const auto add_sources = [&](const auto& entries, ObservationKind kind) {
    for (const auto& entry : entries) {
      summary.sources.push_back(runs_.front().source_score(entry.id, kind));
      if (kind == ObservationKind::Gps) continue;
      if (const auto bias = runs_.front().last_bias(entry.id)) summary.biases.push_back(*bias);
    }
  };
  add_sources(range_.radars, ObservationKind::Radar);
  add_sources(range_.angle_sensors, ObservationKind::Angles);
  add_sources(range_.telemetry, ObservationKind::Gps);
  return summary;
}

}  // namespace downrange::score
