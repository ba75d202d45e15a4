#include "methods.hpp"

#include <algorithm>
#include <cmath>
#include <downrange/geo/polar.hpp>

#include "indices.hpp"

namespace downrange {
namespace {

/// `sensor`: a radar or an angles-only tracker.
template <class Sensor>
std::shared_ptr<const RefractionTable> refraction_of(const Sensor& sensor) {
  if (sensor.refractivity == 0) return nullptr;
  return std::make_shared<RefractionTable>(atmosphere_over(sensor.site.geodetic(), sensor.refractivity));
}

SnrNoise inflated(SnrNoise snr, double angle) {
  snr.at_ref.azimuth_rad *= angle;
  snr.at_ref.elevation_rad *= angle;
  return snr;
}

MethodSettings settings_of(const RangeConfig& config) {
  MethodSettings s;
  s.radars = radar_models(config);
  s.stations = static_cast<int>(config.telemetry.size());
  s.targets = static_cast<int>(config.targets.size());
  s.arbitration = config.fuse.arbitration;
  s.start = config.fuse.start;
  s.motion = config.fuse.motion;
  s.gps_use = config.gps.use;
  s.gps = config.align.gps;
  s.cartesian_bias = config.align.cartesian_bias;
  s.cartesian_fusion = config.fuse.cartesian_fusion;
  s.quick_look = config.fuse.quick_look;
  return s;
}

}  // namespace

std::vector<RadarModel> radar_models(const RangeConfig& config) {
  std::vector<RadarModel> radars;
  for (const RadarConfig& radar : config.radars) {
    const double angle = std::sqrt(radar.angle_inflation);
    const PolarSigma sigma = measured_sigma(radar);
    radars.push_back({.site = radar.site,
                      .sigma = {.range_m = sigma.range_m,
                                .azimuth_rad = sigma.azimuth_rad * angle,
                                .elevation_rad = sigma.elevation_rad * angle},
                      .azimuth_sigma_on_sky = radar.azimuth_sigma_on_sky,
                      .bias = bias_model_of(radar),
                      .wander = radar.wander,
                      .sigma_range_rate_m_s = radar.sigma_range_rate_m_s,
                      .snr = inflated(radar.snr, angle),
                      .refraction = refraction_of(radar)});
  }
  for (const AngleSensorConfig& sensor : config.angle_sensors) {
    const double angle = std::sqrt(sensor.angle_inflation);
    radars.push_back({.site = sensor.site,
                      .sigma = {.azimuth_rad = sensor.sigma_azimuth_rad * angle,
                                .elevation_rad = sensor.sigma_elevation_rad * angle},
                      .azimuth_sigma_on_sky = sensor.azimuth_sigma_on_sky,
                      .bias = bias_model_of(sensor),
                      .wander = sensor.wander,
                      .refraction = refraction_of(sensor)});
  }
  return radars;
}

Methods::Methods(const RangeConfig& config) : Methods(config, settings_of(config)) {}

Methods::Methods(const RangeConfig& config, const MethodSettings& settings)
    : config_(config), sources_(config), newest_(config.targets.size()), residuals_(sources_.size(), settings.radars) {
  for (const Name& name : config.fuse.methods)
    runners_.push_back({.name = name,
                        .method = make_method(name.view(), settings),
                        .published = std::vector<Published>(config.targets.size())});
}

void Methods::process(const Observation& o, bool in_flight) {
  Measurement m;
  m.epoch = o.epoch;
  const SourceId source = sources_.find(kind_of(o.measured), o.sensor);
  m.source = source;
  m.target = index_of(config_.targets, o.target);
  m.sequence = o.sequence;
  m.measured = o.measured;
  m.in_flight = in_flight;
  Time& newest = newest_[static_cast<std::size_t>(m.target)];
  if (m.epoch >= newest) residuals_.note(source, m.target, o, primary());
  newest = std::max(newest, m.epoch);
  for (Runner& runner : runners_) runner.accepted = runner.method->process(m, o.received).verdict == Verdict::Accepted;
}

void Methods::emit_biases(const Observation& o, ResultSink& sink) const {
  if (std::holds_alternative<Fix>(o.measured)) return;  // a receiver has none
  const SourceId source = sources_.find(kind_of(o.measured), o.sensor);
  for (const Runner& runner : runners_) {
    if (!runner.accepted) continue;
    const BiasEstimate estimate = runner.method->bias(source);
    const bool unused = !tells_position(o.measured) && estimate.samples == 0;  // by a method that passes over such
    if (estimate.terms == 0 || unused) continue;
    SensorBias bias;
    bias.sensor = o.sensor;
    bias.method = runner.name;
    bias.epoch = estimate.epoch;
    bias.received = o.received;
    bias.reference = estimate.reference;
    bias.samples = estimate.samples;
    bias.terms = estimate.terms;
    bias.term = estimate.term;
    bias.state = estimate.state;
    for (int i = 0; i < estimate.terms; ++i) bias.value[static_cast<std::size_t>(i)] = estimate.value[i];
    pack_upper_triangle(estimate.cov, estimate.terms, bias.covariance);
    sink.emit(bias);
  }
}

void Methods::emit_trajectories(const Observation& o, ResultSink& sink) {
  const int target = index_of(config_.targets, o.target);
  for (Runner& runner : runners_) {
    if (!runner.accepted) continue;
    const auto estimate = runner.method->fused(target);
    if (!estimate) continue;
    // A fix that the track does not use leaves it as it was: the same estimate is not news.
    if (o.epoch > estimate->data_epoch) continue;
    Published& last = runner.published[static_cast<std::size_t>(target)];
    if (last.epoch == estimate->epoch && last.mean == estimate->mean) continue;
    last = {.epoch = estimate->epoch, .mean = estimate->mean};
    emit_trajectory(runner, *estimate, o.target, o.received, sink);
  }
}

void Methods::emit_trajectories_at(Time tick, ResultSink& sink) const {
  for (std::size_t target = 0; target < config_.targets.size(); ++target) {
    if (tick - newest_[target] > config_.fuse.coast) continue;
    for (const Runner& runner : runners_) {
      const auto estimate = runner.method->fused(static_cast<int>(target), tick);
      if (!estimate || tick - estimate->data_epoch > config_.fuse.coast) continue;
      emit_trajectory(runner, *estimate, config_.targets[target].id, tick, sink);
    }
  }
}

void Methods::emit_trajectory(const Runner& runner, const TrackEstimate& estimate, const Name& target, Time received,
                              ResultSink& sink) const {
  const auto state = estimate.mean.head(estimate.size);
  if (!state.allFinite()) return;
  Trajectory t;
  t.target = target;
  t.method = runner.name;
  t.primary = &runner == &runners_.front();
  t.epoch = estimate.epoch;
  t.received = received;
  t.quality = received - estimate.data_epoch <= config_.fuse.stale ? TrackQuality::Good : TrackQuality::Coasting;
  t.state_size = estimate.size;
  for (int i = 0; i < estimate.size; ++i) t.state[static_cast<std::size_t>(i)] = estimate.mean[i];
  pack_upper_triangle(estimate.cov, estimate.size, t.covariance);
  t.geodetic = geodetic_from_ecef({estimate.mean.head<3>()});
  const Velocity<Enu> v = enu_from_ecef_at(t.geodetic) * Velocity<Ecef>{estimate.mean.segment<3>(3)};
  const double horizontal = std::hypot(v.m_s.x(), v.m_s.y());
  t.speed_m_s = v.m_s.norm();
  t.flight_path_rad = std::atan2(v.m_s.z(), horizontal);
  t.heading_rad = wrap_two_pi(std::atan2(v.m_s.x(), v.m_s.y()));
  t.sources = estimate.sources;
  t.nis = estimate.nis;
  t.nis_dof = estimate.nis_dof;
  sink.emit(t);
}

}  // namespace downrange
