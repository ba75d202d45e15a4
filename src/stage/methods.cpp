#include "methods.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <downrange/geo/polar.hpp>
#include <string>

#include "deviation.hpp"
#include "indices.hpp"
#include "orders.hpp"
#include "stage/integrity/chain_plan.hpp"

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
  s.noise = config.fuse.noise;
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
                      .angle_inflation = radar.angle_inflation,
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
                      .angle_inflation = sensor.angle_inflation,
                      .bias = bias_model_of(sensor),
                      .wander = sensor.wander,
                      .refraction = refraction_of(sensor)});
  }
  return radars;
}

Methods::Methods(const RangeConfig& config, const JudgeMaker& make_judge)
    : config_(config),
      sources_(config),
      integrity_(config, settings_of(config), make_judge),
      newest_(config.targets.size()),
      bias_reset_(sources_.size() * config.targets.size()),
      residuals_(sources_.size(), radar_models(config)),
      lone_(config.targets.size()),
      followed_(config.targets.size()) {
  const MethodSettings settings = settings_of(config);
  for (const Name& name : config.fuse.methods)
    runners_.push_back({.name = name,
                        .method = runners_.empty() ? nullptr : make_method(name.view(), settings),
                        .published = std::vector<Published>(config.targets.size())});
  const std::string prefix = std::string(config.fuse.methods.front().view()) + "/";
  for (std::size_t i = 0; i < lone_.size(); ++i)
    lone_[i].sources.reserve(integrity_.others(static_cast<int>(i)).size());
  update_followed(0);
  if (config.targets.empty()) return;
  for (const Chain& chain : integrity_.others(0))
    chain_methods_.push_back(joined_name(prefix, chain.name().view(), chain_methods_.size()));
}

void Methods::process(const Observation& o, bool in_flight, bool noise_held) {
  Measurement m;
  m.epoch = o.epoch;
  const SourceId source = sources_.find(kind_of(o.measured), o.sensor);
  m.source = source;
  m.target = index_of(config_.targets, o.target);
  m.sequence = o.sequence;
  m.measured = o.measured;
  m.in_flight = in_flight;
  m.noise_held = noise_held;
  m.reset_bias = o.verdict == Reason::Accepted && is_first_after_reset(m);
  Time& newest = newest_[static_cast<std::size_t>(m.target)];
  if (o.verdict == Reason::Accepted && m.epoch >= newest) residuals_.note(source, m.target, o, primary());
  newest = std::max(newest, m.epoch);
  const bool first = o.verdict == Reason::Accepted;
  for (Runner& runner : runners_) {
    runner.accepted = runner.method ? first && runner.method->process(m, o.received).verdict == Verdict::Accepted
                                    : integrity_.process(o, m);
  }
}

void Methods::reset_bias(SourceId sensor, Time from) {
  const std::size_t targets = config_.targets.size();
  for (std::size_t target = 0; target < targets; ++target)
    bias_reset_[static_cast<std::size_t>(sensor) * targets + target] = from;
}

bool Methods::is_first_after_reset(const Measurement& m) {
  std::optional<Time>& ordered =
      bias_reset_[static_cast<std::size_t>(m.source) * config_.targets.size() + static_cast<std::size_t>(m.target)];
  if (!ordered || m.epoch < *ordered) return false;
  ordered.reset();
  return true;
}

void Methods::emit_biases(const Observation& o, ResultSink& sink) const {
  if (std::holds_alternative<Fix>(o.measured)) return;  // a receiver has none
  const SourceId source = sources_.find(kind_of(o.measured), o.sensor);
  const int target = index_of(config_.targets, o.target);
  for (const Runner& runner : runners_) {
    if (!runner.accepted) continue;
    const BiasEstimate estimate =
        runner.method ? runner.method->bias(source) : integrity_.selected(target).bias(source);
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
    const auto estimate = this->estimate(runner, target, std::nullopt);
    if (!estimate) continue;
    // A fix that the track does not use leaves it as it was: the same estimate is not news.
    if (o.epoch > estimate->data_epoch) continue;
    Published& last = runner.published[static_cast<std::size_t>(target)];
    if (last.epoch == estimate->epoch && last.mean == estimate->mean) continue;
    last = {.epoch = estimate->epoch, .mean = estimate->mean};
    emit_trajectory(author(runner, target), *estimate, target, o.received, sink);
  }
}

void Methods::emit_trajectories_at(Time tick, ResultSink& sink) const {
  for (std::size_t target = 0; target < config_.targets.size(); ++target) {
    if (tick - newest_[target] > config_.fuse.coast) continue;
    for (const Runner& runner : runners_) {
      const auto estimate = this->estimate(runner, static_cast<int>(target), tick);
      if (!estimate || tick - estimate->data_epoch > config_.fuse.coast) continue;
      emit_trajectory(author(runner, static_cast<int>(target)), *estimate, static_cast<int>(target), tick, sink);
    }
  }
}

/// Passes results on; notes whom INTEGRITY excludes.
class Methods::VerdictTap final : public ResultSink {
 public:
  VerdictTap(Methods& methods, ResultSink& sink) : methods_(methods), sink_(sink) {}
  void emit(const Result& result) override {
    if (const auto* integrity = std::get_if<Integrity>(&result)) note(*integrity);
    sink_.emit(result);
  }

 private:
  void note(const Integrity& integrity) {
    SourceSet excluded = 0;
    for (const SourceIntegrity& source : integrity.sources) {
      if (source.verdict == IntegrityVerdict::Excluded) excluded |= set_of(methods_.sources_.find(source.sensor));
    }
    methods_.lone_[static_cast<std::size_t>(index_of(methods_.config_.targets, integrity.target))].excluded = excluded;
  }

  Methods& methods_;
  ResultSink& sink_;
};

void Methods::update_followed(SourceSet inhibited) {
  for (std::size_t i = 0; i < lone_.size(); ++i) {
    const int target = static_cast<int>(i);
    Lone& lone = lone_[i];
    lone.sources.clear();
    for (const Chain& chain : integrity_.others(target)) {
      if (!chain.alone() || (chain.sources() & ~(lone.excluded | inhibited)) == 0) continue;
      const SourceId first = std::countr_zero(chain.sources());
      lone.sources.push_back({.method = &chain.method(),
                              .target = chain.target_of_method(target),
                              .newest = chain.newest(target),
                              .chain = chain.name(),
                              .receiver = sources_[first].kind == SourceKind::Telemetry});
    }
    followed_[i] = integrity_.followed()[i];
    followed_[i].lone = lone.sources;
  }
}

std::optional<Followed> Methods::on_chain(int target, const Name& chain) const {
  const auto followed = [&](const Chain& c) {
    return Followed{.method = &c.method(),
                    .target = c.target_of_method(target),
                    .newest = c.newest(target),
                    .chain = c.name(),
                    .revision = c.runs()};
  };
  if (chain == Name(Orders::whole_chain)) return followed(integrity_.all());
  for (const Chain& c : integrity_.others(target)) {
    if (c.name() == chain) return followed(c);
  }
  return std::nullopt;
}

void Methods::judge(Time tick, const OperatorWill& will, ResultSink& sink) {
  liftoff_ = will.liftoff;
  VerdictTap tap(*this, sink);
  integrity_.tick(tick, will, tap);
  update_followed(will.inhibited);
  if (config_.fuse.publish_chains && integrity_.judged()) emit_chains(tick, sink);
}

void Methods::emit_chains(Time tick, ResultSink& sink) const {
  for (int target = 0; target < static_cast<int>(config_.targets.size()); ++target) {
    const auto chains = integrity_.others(target);
    const auto states = integrity_.states_of_others(target);
    for (std::size_t i = 0; i < chains.size(); ++i) {
      const auto& estimate = states[i].estimate;
      if (!estimate) continue;
      const Author author{.method = chain_methods_[i], .chain = chains[i].name()};
      emit_trajectory(author, *estimate, target, tick, sink);
    }
  }
}

std::optional<TrackEstimate> Methods::estimate(const Runner& runner, int target, std::optional<Time> at) const {
  return runner.method ? runner.method->fused(target, at) : integrity_.selected(target).fused(target, at);
}

Methods::Author Methods::author(const Runner& runner, int target) const {
  if (runner.method) return {.method = runner.name};
  return {.method = runner.name,
          .chain = integrity_.selected(target).name(),
          .primary = true,
          .bound_m = integrity_.bound(target)};
}

void Methods::emit_trajectory(const Author& author, const TrackEstimate& estimate, int target, Time received,
                              ResultSink& sink) const {
  const auto state = estimate.mean.head(estimate.size);
  if (!state.allFinite()) return;
  const TargetConfig& vehicle = config_.targets[static_cast<std::size_t>(target)];
  Trajectory t;
  t.target = vehicle.id;
  t.method = author.method;
  t.primary = author.primary;
  t.chain = author.chain;
  t.bound_m = author.bound_m.value_or(0);
  t.bound_valid = author.bound_m.has_value();
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
  if (liftoff_ && !vehicle.nominal.empty()) {
    const double t_s = (estimate.epoch - *liftoff_).seconds();
    if (const auto deviation =
            deviation_from(vehicle.nominal, t_s, estimate.mean.head<3>(), estimate.cov.topLeftCorner<3, 3>())) {
      t.deviation_m = deviation->m;
      t.deviation_sigma_m = deviation->sigma_m;
      t.deviation_valid = true;
    }
  }
  sink.emit(t);
}

}  // namespace downrange
