#include "score/scorer.hpp"

#include <algorithm>
#include <deque>
#include <downrange/est/filter/consistency.hpp>
#include <iterator>
#include <optional>
#include <utility>

#include "score/errors.hpp"
#include "score/impact_tally.hpp"
#include "score/source_tally.hpp"
#include "stage/integrity_notes.hpp"

namespace downrange::score {
namespace {

/// Further behind a fix than this, a track says nothing about it.
constexpr Duration longest_prediction = milliseconds(2'000);
/// What fixes may come late by and still find the track before them.
constexpr Duration latest_fix = milliseconds(10'000);

Polar look_angles(const Site& site, const Position<Ecef>& target) { return polar_from_enu(site.enu_of(target)); }

struct PositionSample {
  Time epoch;
  double error_m;
  bool inside_95;
};
using Samples = std::vector<PositionSample>;

PositionSample sample_of(Time epoch, const Eigen::Vector3d& error, const Mat<3, 3>& P) {
  return {epoch, error.norm(), inside_95(normalised_square<3>(error, P), 3)};
}

/// Noise of a fix, ECEF.
Mat<3, 3> covariance_of_fix(const Fix& fix) {
  const Eigen::Matrix3d R_enu_ecef = enu_from_ecef_at(geodetic_from_ecef(fix.position)).R;
  const Eigen::Vector3d sigma(fix.sigma_horizontal_m, fix.sigma_horizontal_m, fix.sigma_vertical_m);
  return R_enu_ecef.transpose() * sigma.cwiseAbs2().asDiagonal() * R_enu_ecef;
}

struct PointingSamples {
  std::vector<double> error_rad;
  std::size_t commands = 0;
  std::size_t held = 0;
  std::size_t axes_inside = 0;
  double age_sum_s = 0;
  double worst_age_s = 0;
};

PositionScore position_score(const Samples& samples, Time from, Time to) {
  std::vector<double> errors;
  Share inside;
  for (const PositionSample& sample : samples) {
    if (sample.epoch < from || sample.epoch >= to) continue;
    errors.push_back(sample.error_m);
    inside.add(sample.inside_95);
  }
  if (errors.empty()) return {};
  const Spread spread = spread_of(std::move(errors));
  return {spread.count, spread.rms, spread.p95, spread.worst, inside.value()};
}

}  // namespace

/// Collects what one run says.
class Scorer::Run : public ResultSink {
 public:
  Run(const Scorer& scorer, std::string label)
      : scorer_(scorer),
        label_(std::move(label)),
        primary_(scorer.first_method()),
        impacts_(scorer.range_.impact.fall, scorer.liftoff_) {}

  void emit(const Result& result) override {
    std::visit([this](const auto& r) { add(r); }, result);
  }

  /// Its primary method's row.
  [[nodiscard]] TrajectoryScore primary_score() const { return trajectory_score(label_, primary_); }

  /// The service's own run: its primary method first, named; then the methods beside it.
  [[nodiscard]] std::vector<TrajectoryScore> scores_by_method() const {
    std::vector<TrajectoryScore> scores{trajectory_score(label_ + " (" + std::string(primary_.view()) + ")", primary_)};
    for (const auto& [method, samples] : positions_)
      if (method != primary_) scores.push_back(trajectory_score(std::string(method.view()), method));
    return scores;
  }

  [[nodiscard]] SystematicScore systematic_score(const Source& source) const {
    SystematicScore score{.sensor = source.name,
                          .kind = source.kind,
                          .has_range = source.sigma.range_m > 0,
                          .has_angles = source.sigma.azimuth_rad > 0,
                          .rejected = source_score(source.name, source.kind).rejected(),
                          .before = {},
                          .after = {}};
    const auto found = sources_.find({source.kind, source.name});
    if (found == sources_.end()) return score;
    const PlotErrors& errors = is_answered(source.name) ? found->second.of_method : found->second.of_ingest;
    score.plots = errors.plots;
    score.before = errors.before.rms_of_means();
    score.after = errors.after.rms_of_means();
    return score;
  }

  /// Those that sent something and that the range does not have.
  [[nodiscard]] std::vector<SourceScore> unknown_sources() const {
    std::vector<SourceScore> scores;
    for (const auto& [key, tally] : sources_)
      if (scorer_.sources_.find(key.first, key.second) == no_source)
        scores.push_back(source_score(key.second, key.first));
    return scores;
  }

  [[nodiscard]] SourceScore source_score(const Name& sensor, SourceKind kind) const {
    SourceScore score;
    score.sensor = sensor;
    score.kind = kind;
    const auto found = sources_.find({kind, sensor});
    if (found == sources_.end()) return score;
    const SourceTally& tally = found->second;
    score.count = tally.by_ingest;
    auto& accepted = score.count[static_cast<std::size_t>(Reason::Accepted)];
    accepted -= std::min(tally.gated + tally.frozen + tally.excluded, accepted);
    score.excluded = tally.excluded;
    score.count[static_cast<std::size_t>(Reason::Gated)] = tally.gated;
    score.count[static_cast<std::size_t>(Reason::Frozen)] = tally.frozen;
    const auto rejected = [&](const Fates& fates, bool outlier) -> std::optional<std::size_t> {
      if (!is_answered(sensor) && fates.delivered > 0) return std::nullopt;
      const bool still_open = open_ && open_->source == found->first && open_->outlier == outlier;
      return fates.rejected + (still_open ? 1 : 0);
    };
    score.outliers = tally.outliers.delivered;
    score.good = tally.good.delivered;
    score.outliers_rejected = rejected(tally.outliers, true);
    score.good_rejected = rejected(tally.good, false);
    add_consistency(tally.health, score);
    score.sigma_ratio = tally.sigma_ratio;
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
      const Spread spread = spread_of(samples.error_rad);
      PointingScore score{.antenna = antenna,
                          .source = key.second,
                          .commands = samples.commands,
                          .held = samples.held,
                          .scored = spread.count,
                          .rms_rad = spread.rms,
                          .p95_rad = spread.p95,
                          .worst_rad = spread.worst,
                          .mean_age_s = samples.age_sum_s / static_cast<double>(samples.commands),
                          .worst_age_s = samples.worst_age_s};
      if (spread.count > 0)
        score.inside_2_sigma = static_cast<double>(samples.axes_inside) / static_cast<double>(2 * spread.count);
      scores.push_back(score);
    }
    return scores;
  }

  void add_safety_to(Summary& summary) const {
    summary.integrity = integrity_;
    summary.bounded = bounded_;
    summary.bound_holds = bound_holds_;
    summary.impacts = impacts_.chains();
    summary.boundaries = impacts_.boundaries();
  }

 private:
  using SourceKey = std::pair<SourceKind, Name>;

  /// A plot that ingest accepted, until the first method's results of the same event show that it accepted it.
  struct OpenPlot {
    SourceKey source;
    Time received;
    bool outlier;
    std::optional<PlotError> error;
  };

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

  /// The first method emits a sensor's bias with each of its plots that it accepts: without any, the single plots'
  /// verdicts are unknown.
  [[nodiscard]] bool is_answered(const Name& sensor) const { return biases_.contains(sensor); }

  /// The first method accepted the open plot, or did not.
  void close(bool accepted) {
    if (!open_) return;
    SourceTally& source = sources_[open_->source];
    if (!accepted) ++(open_->outlier ? source.outliers : source.good).rejected;
    if (accepted && open_->error && !open_->outlier) open_->error->add_to(source.of_method);
    open_.reset();
  }

  /// A result of the first method, of the event received then: it accepted that event's plot.
  void answered(const Name& method, Time received) {
    if (open_ && method == scorer_.first_method() && received == open_->received) close(true);
  }

  void add(const Observation& observation) {
    close(false);
    const SourceKey key{kind_of(observation.measured), observation.sensor};
    SourceTally& source = sources_[key];
    ++source.by_ingest[static_cast<std::size_t>(observation.verdict)];
    const bool used = observation.target != scorer_.target_ || !excluded_.contains(observation.sensor);
    if (observation.verdict == Reason::Accepted && !used) {
      ++source.excluded;
      return;
    }
    if (key.first == SourceKind::Telemetry) return add_fix(observation);
    const bool outlier = scorer_.outliers_.contains({observation.sensor, observation.sequence});
    Fates& fates = outlier ? source.outliers : source.good;
    ++fates.delivered;
    if (observation.verdict != Reason::Accepted) {
      ++fates.rejected;
      return;
    }
    open_ = {key, observation.received, outlier, error_of(observation)};
    if (open_->error && !outlier) open_->error->add_to(source.of_ingest);
  }

  /// Nothing of another target, outside the phases and where the truth is not known.
  [[nodiscard]] std::optional<PlotError> error_of(const Observation& plot) {
    if (plot.target != scorer_.target_ || !scorer_.in_a_phase(plot.epoch)) return std::nullopt;
    const Site* site = scorer_.site_of(plot.sensor);
    const SensorBias& bias = biases_.contains(plot.sensor) ? biases_.at(plot.sensor) : no_bias_;
    const std::optional<TrueState> truth = scorer_.truth_at(plot.epoch);
    const std::optional<TrueState> truth_at_tag = scorer_.truth_at(plot.epoch - seconds(time_tag_of(bias)));
    if (site == nullptr || !truth || !truth_at_tag) return std::nullopt;
    const Polar exact = look_angles(*site, truth->position);
    const Polar exact_at_tag = look_angles(*site, truth_at_tag->position);
    // What a plot lacks: the truth takes its place, and leaves no error.
    const Plot seen = plot_of(plot.measured);
    const Polar measured{seen.range_valid ? seen.measured.range_m : exact.range_m,
                         seen.angles_valid ? seen.measured.azimuth_rad : exact.azimuth_rad,
                         seen.angles_valid ? seen.measured.elevation_rad : exact.elevation_rad};
    const auto air = scorer_.air_.find(plot.sensor);
    const Polar after = corrected(measured, bias, air == scorer_.air_.end() ? nullptr : &air->second);
    PlotError error{plot.epoch, plot_error(measured, exact), plot_error(after, exact_at_tag)};
    if (!seen.range_valid) error.before[0] = error.after[0] = 0;
    if (!seen.angles_valid) error.before.tail<2>() = error.after.tail<2>() = Eigen::Vector2d::Zero();
    return error;
  }

  void add(const Trajectory& trajectory) {
    answered(trajectory.method, trajectory.received);
    if (trajectory.target != scorer_.target_) return;
    if (!scorer_.truth_) {
      if (trajectory.primary) primary_ = trajectory.method;
      keep(trajectory);
      return;
    }
    const std::optional<TrueState> truth = scorer_.truth_(trajectory.epoch);
    if (!truth) return;
    if (trajectory.primary) primary_ = trajectory.method;
    const Gaussian<3> x = position_at(trajectory, trajectory.epoch);
    const Eigen::Vector3d error = x.mean - truth->position.m;
    positions_[trajectory.method].push_back(sample_of(trajectory.epoch, error, x.cov));
    if (!trajectory.primary || !trajectory.bound_valid) return;
    ++bounded_;
    if (error.norm() <= trajectory.bound_m) ++bound_holds_;
  }

  /// For fixes to come.
  void keep(const Trajectory& trajectory) {
    std::deque<Trajectory>& recent = recent_[trajectory.method];
    recent.push_back(trajectory);
    while (trajectory.epoch - recent.front().epoch > latest_fix) recent.pop_front();
  }

  /// Without truth the fixes stand in for it: each against the track as it was just before it.
  void add_fix(const Observation& fix) {
    if (scorer_.truth_ || fix.verdict != Reason::Accepted || fix.target != scorer_.target_) return;
    const Fix& measured = std::get<Fix>(fix.measured);
    for (const auto& [method, recent] : recent_) {
      const auto before = std::find_if(recent.rbegin(), recent.rend(), [&](const Trajectory& t) {
        return t.epoch < fix.epoch && fix.epoch - t.epoch <= longest_prediction;
      });
      if (before == recent.rend()) continue;
      const Gaussian<3> x = position_at(*before, fix.epoch);
      positions_[method].push_back(
          sample_of(fix.epoch, measured.position.m - x.mean, x.cov + covariance_of_fix(measured)));
    }
  }

  void add(const Integrity& integrity) {
    if (integrity.target != scorer_.target_) return;
    excluded_.clear();
    for (const SourceIntegrity& source : integrity.sources)
      if (source.verdict == IntegrityVerdict::Excluded) excluded_.insert(source.sensor);
    for (std::string& note : integrity_notes_.changes(integrity))
      integrity_.push_back({.t_s = (integrity.time - scorer_.liftoff_).seconds(), .text = std::move(note)});
  }

  void add(const ImpactPoint& point) {
    if (point.target == scorer_.target_) impacts_.add(point, scorer_.truth_at(point.epoch));
  }

  /// Of a result that nothing is measured of.
  template <class Other>
  void add(const Other&) {}
  void add(const SensorBias& bias) {
    if (open_ && open_->source.second == bias.sensor) answered(bias.method, bias.received);
    if (bias.method == scorer_.first_method()) biases_[bias.sensor] = bias;
  }

  void add(const SlavingCommand& command) {
    const auto antenna = std::ranges::find(scorer_.range_.antennas, command.antenna, &AntennaConfig::id);
    const std::optional<TrueState> truth = scorer_.truth_at(command.apply_at);
    if (antenna == scorer_.range_.antennas.end() || command.target != scorer_.target_ || (scorer_.truth_ && !truth))
      return;
    PointingSamples& samples = pointing_[{command.antenna, command.source}];
    ++samples.commands;
    samples.age_sum_s += command.age_s;
    samples.worst_age_s = std::max(samples.worst_age_s, command.age_s);
    const bool at_stop = (command.limits & (LimitElevation | LimitAzimuth)) != 0;
    if (!truth || antenna->moves) {
      if (at_stop) ++samples.held;
      return;
    }
    const auto air = scorer_.antenna_air_.find(command.antenna);
    const Polar look =
        pointing_at(antenna->site, air == scorer_.antenna_air_.end() ? nullptr : &air->second, truth->position);
    if (at_stop && !can_point_at(*antenna, look)) {
      ++samples.held;
    } else {
      samples.error_rad.push_back(pointing_error(command, look));
      samples.axes_inside += static_cast<std::size_t>(axes_within_2_sigma(command, look));
    }
  }

  void add(const SourceHealth& health) {
    const auto of = [&](Reason reason) { return health.count[static_cast<std::size_t>(reason)]; };
    for (auto& [key, source] : sources_) {
      if (key.second != health.sensor) continue;
      source.gated = of(Reason::Gated);
      source.frozen = of(Reason::Frozen);
      source.sigma_ratio = health.sigma_ratio;
      source.health.push_back({.judged = of(Reason::Accepted) + source.gated,
                               .window = health.nis_count,
                               .inside_95 = health.nis_inside_95,
                               .mismatch = health.mismatch});
    }
  }

  const Scorer& scorer_;
  std::string label_;
  IntegrityNotes integrity_notes_;
  std::vector<IntegrityNote> integrity_;
  std::set<Name> excluded_;  ///< by INTEGRITY, of the target's sources, now
  std::size_t bounded_ = 0;
  std::size_t bound_holds_ = 0;
  Name primary_;
  std::map<Name, Samples> positions_;              // by method
  std::map<Name, std::deque<Trajectory>> recent_;  // likewise; without truth
  std::map<Name, SensorBias> biases_;              // of the first method
  SensorBias no_bias_;
  std::map<SourceKey, SourceTally> sources_;
  std::optional<OpenPlot> open_;
  ImpactTally impacts_;
  std::map<std::pair<Name, SlavingSource>, PointingSamples> pointing_;
};

bool Scorer::in_a_phase(Time t) const {
  return std::ranges::any_of(phases_, [&](const Phase& phase) {
    return t >= liftoff_ + seconds(phase.from_s) && t < liftoff_ + seconds(phase.to_s);
  });
}

Name Scorer::first_method() const { return range_.fuse.methods.empty() ? Name() : range_.fuse.methods.front(); }

std::optional<TrueState> Scorer::truth_at(Time t) const { return truth_ ? truth_(t) : std::nullopt; }

const Site* Scorer::site_of(const Name& sensor) const {
  const SourceId id = sources_.find(sensor);
  return id == no_source ? nullptr : &sources_[id].site;
}

Scorer::Scorer(const RangeConfig& range, const Name& target, TruthFunction truth, Time liftoff,
               std::vector<Phase> phases)
    : range_(range),
      sources_(range),
      target_(target),
      truth_(std::move(truth)),
      liftoff_(liftoff),
      phases_(std::move(phases)),
      antenna_air_(air_of_antennas(range)) {
  for (const Source& source : sources_)
    if (source.refractivity > 0)
      air_.emplace(source.name, RefractionTable(atmosphere_over(source.site.geodetic(), source.refractivity)));
}

Scorer::~Scorer() = default;

ResultSink& Scorer::open_run(const std::string& label) { return runs_.emplace_back(*this, label); }

void Scorer::know_outliers(std::set<MessageId> outliers, OutlierOrigin origin) {
  outliers_ = std::move(outliers);
  outlier_origin_ = origin;
}

Summary Scorer::summary() const {
  Summary summary;
  summary.phases = phases_;
  summary.truth_known = static_cast<bool>(truth_);
  summary.outliers = outlier_origin_;
  summary.method = first_method();
  if (runs_.empty()) return summary;
  const Run& own = runs_.front();
  std::vector<TrajectoryScore>& rows = truth_ ? summary.trajectories : summary.against_gps;
  rows = own.scores_by_method();
  own.add_safety_to(summary);
  for (auto run = std::next(runs_.begin()); run != runs_.end(); ++run) rows.push_back(run->primary_score());
  for (const AntennaConfig& antenna : range_.antennas)
    for (const PointingScore& score : own.pointing_scores(antenna.id)) summary.pointing.push_back(score);
  for (const Source& source : sources_) {
    summary.sources.push_back(own.source_score(source.name, source.kind));
    if (source.kind == SourceKind::Telemetry) continue;
    if (truth_) summary.systematic.push_back(own.systematic_score(source));
    if (const auto bias = own.last_bias(source.name)) summary.biases.push_back(*bias);
  }
  std::ranges::copy(own.unknown_sources(), std::back_inserter(summary.sources));
  return summary;
}

}  // namespace downrange::score
