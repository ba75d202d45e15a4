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

MethodSettings settings_of(const RangeConfig& config) {
  MethodSettings s;
  for (const RadarConfig& radar : config.radars) {
    const double angle = std::sqrt(radar.angle_inflation);
    s.radars.push_back({.site = radar.site,
                        .sigma = {.range_m = radar.sigma.range_m,
                                  .azimuth_rad = radar.sigma.azimuth_rad * angle,
                                  .elevation_rad = radar.sigma.elevation_rad * angle},
                        .azimuth_sigma_on_sky = radar.azimuth_sigma_on_sky,
                        .bias = bias_model_of(radar.bias),
                        .wander = radar.wander,
                        .refraction = refraction_of(radar)});
  }
  for (const AngleSensorConfig& sensor : config.angle_sensors) {
    const double angle = std::sqrt(sensor.angle_inflation);
    s.radars.push_back({.site = sensor.site,
                        .sigma = {.azimuth_rad = sensor.sigma_azimuth_rad * angle,
                                  .elevation_rad = sensor.sigma_elevation_rad * angle},
                        .azimuth_sigma_on_sky = sensor.azimuth_sigma_on_sky,
                        .bias = bias_model_of(sensor),
                        .wander = sensor.wander,
                        .refraction = refraction_of(sensor),
                        .measures_range = false});
  }
  s.stations = static_cast<int>(config.telemetry.size());
  s.targets = static_cast<int>(config.targets.size());
  s.history = config.fuse.history;
  s.gate_probability = config.fuse.gate_probability;
  s.restart_after = config.fuse.restart_after;
  s.reopen_after = config.fuse.reopen_after;
  s.kinematics = config.fuse.kinematics;
  s.q_cv_m2_s3 = config.fuse.q_cv_m2_s3;
  s.q_ca_m2_s5 = config.fuse.q_ca_m2_s5;
  s.batch = config.fuse.batch;
  s.q_m2_s3 = config.fuse.q_m2_s3;
  s.alpha_beta_acceleration_m_s2 = config.fuse.alpha_beta_acceleration_m_s2;
  s.initial_sigma_velocity_m_s = config.fuse.initial_sigma_velocity_m_s;
  s.initial_sigma_acceleration_m_s2 = config.fuse.initial_sigma_acceleration_m_s2;
  s.gps_error = config.align.gps_error;
  s.gps_alignment = config.align.gps_alignment;
  s.no_gps = config.align.no_gps;
  s.bias_offset_prior_m = config.align.offset_prior_m;
  s.bias_scale_prior = config.align.scale_prior;
  s.bias_window = config.align.window;
  s.bias_offset_drift_m_sqrt_s = config.align.offset_drift_m_sqrt_s;
  s.bias_scale_drift_sqrt_s = config.align.scale_drift_sqrt_s;
  s.gps_q_m2_s3 = config.align.gps_q_m2_s3;
  s.gps_use_velocity = config.gps.use_velocity;
  s.gps_max_age = config.align.gps_max_age;
  return s;
}

}  // namespace

Methods::Methods(const RangeConfig& config) : config_(config), newest_(config.targets.size()) {
  const MethodSettings settings = settings_of(config);
  for (const Name& name : config.fuse.methods)
    runners_.push_back({.name = name,
                        .method = make_method(name.view(), settings),
                        .published = std::vector<Published>(config.targets.size())});
}

void Methods::process(const Observation& o, bool in_flight) {
  Measurement m;
  m.epoch = o.epoch;
  m.kind = o.kind == ObservationKind::Gps ? Measurement::Kind::Gps : Measurement::Kind::Radar;
  m.source = source_of(o);
  m.target = index_of(config_.targets, o.target);
  m.sequence = o.sequence;
  m.in_flight = in_flight;
  m.plot = o.measured;
  m.position = o.position;
  m.velocity = o.velocity;
  m.velocity_valid = o.velocity_valid;
  m.sigma_horizontal_m = o.sigma_horizontal_m;
  m.sigma_vertical_m = o.sigma_vertical_m;
  m.sigma_velocity_m_s = o.sigma_velocity_m_s;
  Time& newest = newest_[static_cast<std::size_t>(m.target)];
  newest = std::max(newest, m.epoch);
  for (Runner& runner : runners_) runner.accepted = runner.method->process(m, o.received).verdict == Verdict::Accepted;
}

int Methods::source_of(const Observation& o) const {
  switch (o.kind) {
    case ObservationKind::Radar:
      return index_of(config_.radars, o.sensor);
    case ObservationKind::Gps:
      return index_of(config_.telemetry, o.sensor);
    case ObservationKind::Angles:
      return static_cast<int>(config_.radars.size()) + index_of(config_.angle_sensors, o.sensor);
  }
  return -1;
}

void Methods::emit_biases(const Observation& o, ResultSink& sink) const {
  if (o.kind == ObservationKind::Gps) return;
  for (const Runner& runner : runners_) {
    if (!runner.accepted) continue;
    const BiasEstimate estimate = runner.method->bias(source_of(o));
    const bool unused = o.kind == ObservationKind::Angles && estimate.samples == 0;  // by a method of radars alone
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
    const bool fresh = o.received - estimate->data_epoch <= config_.slave.coast;
    emit_trajectory(runner, *estimate, o.target, o.received, fresh ? TrackQuality::Good : TrackQuality::Coasting, sink);
  }
}

void Methods::emit_trajectories_at(Time tick, ResultSink& sink) const {
  for (std::size_t target = 0; target < config_.targets.size(); ++target) {
    if (tick - newest_[target] > config_.slave.coast) continue;
    for (const Runner& runner : runners_) {
      const auto estimate = runner.method->fused(static_cast<int>(target), tick);
      if (!estimate || tick - estimate->data_epoch > config_.slave.coast) continue;
      const bool fresh = tick - estimate->data_epoch <= config_.slave.stale;
      emit_trajectory(runner, *estimate, config_.targets[target].id, tick,
                      fresh ? TrackQuality::Good : TrackQuality::Coasting, sink);
    }
  }
}

void Methods::emit_trajectory(const Runner& runner, const TrackEstimate& estimate, const Name& target, Time received,
                              TrackQuality quality, ResultSink& sink) const {
  const auto state = estimate.mean.head(estimate.size);
  if (!state.allFinite()) return;
  Trajectory t;
  t.target = target;
  t.method = runner.name;
  t.primary = &runner == &runners_.front();
  t.epoch = estimate.epoch;
  t.received = received;
  t.quality = quality;
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
