#include "experiment/flights_replay.hpp"

#include <algorithm>
#include <cmath>
#include <downrange/geo/polar.hpp>
#include <downrange/geo/refraction.hpp>
#include <downrange/stage/engine.hpp>
#include <downrange/stage/source_table.hpp>
#include <optional>

#include "score/errors.hpp"
#include "score/scorer.hpp"

namespace downrange::experiment::flights {
namespace {

/// Further behind a plot than this, a track says nothing about it.
constexpr double longest_prediction_s = 0.5;

/// Passes everything on to the scorer and keeps what it does not.
class Recorder final : public ResultSink {
 public:
  Recorder(ResultSink& scorer, const RecordedFlight& flight, const score::TruthTable& truth, Flown& flown)
      : scorer_(scorer), flight_(flight), truth_(truth), flown_(flown) {
    for (const Source& source : SourceTable(flight.range)) {
      if (flown.replay.in_order && source.refractivity > 0)
        air_.emplace(source.name, RefractionTable(atmosphere_over(source.site.geodetic(), source.refractivity)));
    }
  }

  void emit(const Result& result) override {
    scorer_.emit(result);
    if (const auto* bias = std::get_if<SensorBias>(&result)) note(*bias);
    if (const auto* trajectory = std::get_if<Trajectory>(&result)) note(*trajectory);
  }

  /// Before the engine has the plot; outliers are left out of residuals and NIS.
  void before(const RadarTspi& plot, const RadarConfig& radar, bool outlier) {
    plot_ = &plot;
    accepted_ = false;
    nis_ = {};
    if (flown_.replay.in_order && !outlier) note_residuals(plot, radar);
  }
  /// After it.
  void after(bool outlier) {
    // A plot that is rejected has no trajectory, and is outside whatever its NIS.
    if (flown_.replay.in_order && !outlier && (nis_ || !accepted_))
      flown_.nis[plot_->sensor].add(nis_ && score::inside_95(nis_->first, nis_->second));
    plot_ = nullptr;
  }

 private:
  [[nodiscard]] bool is_primary(const Name& method) const { return method == flown_.replay.methods.front(); }

  /// A method tells a radar's bias with each of its plots that it takes, and only then.
  void note(const SensorBias& bias) {
    newest_bias_[{bias.method, bias.sensor}] = bias;
    if (!is_primary(bias.method)) return;
    flown_.bias[bias.sensor] = bias;
    accepted_ = accepted_ || (plot_ != nullptr && bias.sensor == plot_->sensor);
  }

  void note(const Trajectory& t) {
    if (t.target != flight_.target) return;
    if (is_primary(t.method) && plot_ != nullptr && t.epoch == plot_->epoch) nis_ = std::pair(t.nis, t.nis_dof);
    newest_track_[t.method] = t;
    const std::optional<score::TrueState> truth = truth_.at(t.epoch);
    if (!truth) return;
    const Gaussian<3> x = score::position_at(t, t.epoch);
    const auto second = static_cast<std::int64_t>(std::floor((t.epoch - flight_.liftoff).seconds()));
    Second& s = flown_.error[t.method][second];
    s.square += (x.mean - truth->position.m).squaredNorm();
    s.variance += x.cov.trace();
    ++s.count;
  }

  void note_residuals(const RadarTspi& plot, const RadarConfig& radar) {
    for (const auto& [method, track] : newest_track_) {
      if (std::abs((plot.epoch - track.epoch).seconds()) > longest_prediction_s) continue;
      const SensorBias& bias = newest_bias_[{method, plot.sensor}];
      const auto air = air_.find(plot.sensor);
      const Polar z = score::corrected(plot.measured, bias, air == air_.end() ? nullptr : &air->second);
      const Gaussian<3> x = score::position_at(track, plot.epoch - seconds(score::time_tag_of(bias)));
      const Displacement<Enu> d_enu = radar.site.enu_of({x.mean});
      const Polar q = polar_from_enu(d_enu);
      const double on_sky = std::cos(q.elevation_rad);
      Eigen::Matrix3d H = d_polar_d_enu(d_enu) * radar.site.R_enu_ecef().R;
      H.row(1) *= on_sky;
      const double inflation = std::sqrt(radar.angle_inflation);
      const Eigen::Vector3d noise(radar.sigma.range_m,
                                  inflation * radar.sigma.azimuth_rad * (radar.azimuth_sigma_on_sky ? 1 : on_sky),
                                  inflation * radar.sigma.elevation_rad);
      flown_.residuals[method][plot.sensor].push_back(
          {.t_s = (plot.epoch - flight_.liftoff).seconds(),
           .value = score::plot_error(z, q),
           .sigma = ((H * x.cov * H.transpose()).diagonal() + noise.cwiseAbs2()).cwiseSqrt()});
    }
  }

  ResultSink& scorer_;
  const RecordedFlight& flight_;
  const score::TruthTable& truth_;
  Flown& flown_;
  std::map<Name, RefractionTable> air_;
  std::map<std::pair<Name, Name>, SensorBias> newest_bias_;  // by method and radar
  std::map<Name, Trajectory> newest_track_;                  // by method
  const RadarTspi* plot_ = nullptr;                          // in the engine's hands
  bool accepted_ = false;
  std::optional<std::pair<double, int>> nis_;
};

Time epoch_of(const Event& event) {
  return std::visit([](const auto& e) { return e.epoch; }, event);
}

/// What arrives, in its order, from sources that are switched on.
std::vector<Event> arrivals(const RecordedFlight& flight, const Replay& replay) {
  const auto is_off = [&](const Event& event) {
    return std::ranges::find(replay.without, source_of(event)) != replay.without.end();
  };
  std::vector<Event> events;
  for (const Event& event : flight.events) {
    if (is_off(event)) continue;
    events.push_back(event);
    if (replay.in_order) set_received(events.back(), epoch_of(event));
  }
  if (replay.in_order) {
    const auto earlier = [](const Event& a, const Event& b) { return epoch_of(a) < epoch_of(b); };
    std::stable_sort(events.begin(), events.end(), earlier);
  }
  return events;
}

GateCount gate_count(const score::Summary& summary) {
  GateCount gate;
  for (const score::SourceScore& source : summary.sources) {
    if (source.kind != SourceKind::Radar) continue;
    gate.outliers += static_cast<int>(source.outliers);
    gate.outliers_rejected += static_cast<int>(source.outliers_rejected.value_or(source.outliers));
    gate.plots += static_cast<int>(source.good);
    gate.plots_rejected += static_cast<int>(source.good_rejected.value_or(source.good));
  }
  return gate;
}

}  // namespace

score::PositionScore Flown::position(const Name& method, std::size_t phase) const {
  const std::string name(method.view());
  for (const score::TrajectoryScore& t : summary.trajectories) {
    // The first method's row is "label (method)".
    if (t.label == name || t.label.ends_with("(" + name + ")")) return t.phases[phase];
  }
  return {};
}

std::set<score::MessageId> outliers_of(const RecordedFlight& flight) {
  const score::TruthTable truth(flight.truth);
  score::OutlierFinder finder(flight.range, [&truth](Time t) { return truth.at(t); });
  for (const Event& event : flight.events)
    if (const auto* plot = std::get_if<RadarTspi>(&event))
      finder.add(plot->sensor, plot->sequence, plot->epoch, {.measured = plot->measured});
  return finder.outliers();
}

Flown fly(const RecordedFlight& flight, const Replay& replay) {
  RangeConfig range = flight.range;
  range.fuse.methods = replay.methods;
  range.fuse.publish_on_data = !replay.on_ticks;
  if (!replay.points) range.antennas.clear();
  const score::TruthTable truth(flight.truth);
  score::Scorer scorer(
      range, flight.target, [&truth](Time t) { return truth.at(t); }, flight.liftoff, replay.phases);
  const std::set<score::MessageId> outliers = outliers_of(flight);
  scorer.know_outliers(outliers, score::OutlierOrigin::Truth);
  Flown flown;
  flown.replay = replay;
  Recorder recorder(scorer.open_run(replay.label), flight, truth, flown);
  Engine engine(range, {}, recorder);
  Time last;
  for (const Event& event : arrivals(flight, replay)) {
    const Event admitted = engine.admit(event);
    last = received_of(admitted);
    const auto* plot = std::get_if<RadarTspi>(&admitted);
    const auto radar = std::find_if(range.radars.begin(), range.radars.end(),
                                    [&](const RadarConfig& r) { return plot != nullptr && r.id == plot->sensor; });
    if (radar == range.radars.end()) {
      engine.handle(admitted);
      continue;
    }
    const bool outlier = outliers.contains({plot->sensor, plot->sequence});
    recorder.before(*plot, *radar, outlier);
    engine.handle(admitted);
    recorder.after(outlier);
  }
  engine.advance_to(last + seconds(2));  // commands of the last second
  flown.summary = scorer.summary();
  flown.gate = gate_count(flown.summary);
  return flown;
}

}  // namespace downrange::experiment::flights
