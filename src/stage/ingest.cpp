#include "ingest.hpp"

#include <algorithm>
#include <cmath>

namespace downrange {
namespace {

constexpr Duration same_epoch = milliseconds(1);
constexpr std::size_t max_streams = 512;
/// A vehicle is between the Dead Sea's depth below the ellipsoid and geosynchronous altitude, slower than 20 km/s.
constexpr double radius_min_m = 6.35e6;
constexpr double radius_max_m = 5e7;
/// This near to latitude and longitude 0, at any height, or to the Earth's centre, a position is none.
constexpr double no_position_m = 10;
constexpr double speed_max_m_s = 2e4;
/// No receiver is better than this, whatever it states.
constexpr double sigma_floor_m = 0.1;
/// A receiver that states worse has no fix.
constexpr double sigma_max = 1e5;
constexpr double sigma_floor_m_s = 0.01;

bool plausible_sigmas(const Observation& o) {
  return o.sigma_horizontal_m > 0 && o.sigma_horizontal_m <= sigma_max && o.sigma_vertical_m > 0 &&
         o.sigma_vertical_m <= sigma_max && o.sigma_velocity_m_s > 0 && o.sigma_velocity_m_s <= sigma_max;
}

bool finite_angles(const Polar& q) { return std::isfinite(q.azimuth_rad) && std::isfinite(q.elevation_rad); }

/// `sensor`: a radar or an angles-only tracker.
template <class Sensor>
bool in_elevation_limits(const Polar& q, const Sensor& sensor) {
  return q.elevation_rad >= sensor.elevation_min_rad && q.elevation_rad <= sensor.elevation_max_rad;
}

/// What an observation shares with the plot it comes from.
template <class Tspi>
Observation observation_of(ObservationKind kind, const Tspi& tspi, const Polar& measured) {
  Observation o;
  o.kind = kind;
  o.sensor = tspi.sensor;
  o.target = tspi.target;
  o.sequence = tspi.sequence;
  o.epoch = tspi.epoch;
  o.received = tspi.received;
  o.measured = measured;
  o.measured.azimuth_rad = wrap_two_pi(measured.azimuth_rad);
  o.simulated = tspi.simulated;
  return o;
}

template <class Config>
bool known_source(const std::vector<Config>& configured, const Name& id) {
  return std::ranges::find(configured, id, &Config::id) != configured.end();
}

double stated_or(double stated, double configured, double floor) {
  return stated > 0 ? std::max(stated, floor) : configured;
}

}  // namespace

Ingest::Ingest(const RangeConfig& config) : config_(config), departure_(config) {}

Observation Ingest::judge(const RadarTspi& tspi) {
  Observation o = observation_of(ObservationKind::Radar, tspi, tspi.measured);
  const auto radar = std::ranges::find(config_.radars, tspi.sensor, &RadarConfig::id);
  const auto reason = [&] {
    if (radar == config_.radars.end() || !known_source(config_.targets, tspi.target)) return Reason::UnknownSource;
    if (tspi.simulated != config_.ingest.expect_simulated) return Reason::SimulatedMismatch;
    if (tspi.mode != TrackMode::Track) return Reason::NotTracking;
    if (!finite_angles(tspi.measured) || !std::isfinite(tspi.measured.range_m)) return Reason::NotFinite;
    const bool in_range = tspi.measured.range_m >= radar->range_min_m && tspi.measured.range_m <= radar->range_max_m;
    if (!in_range || !in_elevation_limits(tspi.measured, *radar)) return Reason::OutOfLimits;
    return judge_time(o, stream_of(ObservationKind::Radar, tspi.sensor, tspi.target));
  };
  o.verdict = reason();
  return o;
}

Observation Ingest::judge(const AngleTspi& tspi) {
  const Polar measured{.azimuth_rad = tspi.azimuth_rad, .elevation_rad = tspi.elevation_rad};
  Observation o = observation_of(ObservationKind::Angles, tspi, measured);
  const auto sensor = std::ranges::find(config_.angle_sensors, tspi.sensor, &AngleSensorConfig::id);
  const auto reason = [&] {
    if (sensor == config_.angle_sensors.end() || !known_source(config_.targets, tspi.target))
      return Reason::UnknownSource;
    if (tspi.simulated != config_.ingest.expect_simulated) return Reason::SimulatedMismatch;
    if (tspi.mode != TrackMode::Track) return Reason::NotTracking;
    if (!finite_angles(measured)) return Reason::NotFinite;
    if (!in_elevation_limits(measured, *sensor)) return Reason::OutOfLimits;
    return judge_time(o, stream_of(ObservationKind::Angles, tspi.sensor, tspi.target));
  };
  o.verdict = reason();
  return o;
}

Observation Ingest::judge(const GpsFix& fix) {
  Observation o;
  o.kind = ObservationKind::Gps;
  o.sensor = fix.station;
  o.target = fix.target;
  o.receiver = fix.receiver;
  o.sequence = fix.sequence;
  o.epoch = fix.epoch;
  o.received = fix.received;
  o.position = fix.position;
  o.velocity = fix.velocity;
  o.velocity_valid = fix.velocity_valid;
  o.simulated = fix.simulated;
  o.sigma_horizontal_m = stated_or(fix.sigma_horizontal_m, config_.gps.sigma_horizontal_m, sigma_floor_m);
  o.sigma_vertical_m = stated_or(fix.sigma_vertical_m, config_.gps.sigma_vertical_m, sigma_floor_m);
  o.sigma_velocity_m_s = stated_or(fix.sigma_velocity_m_s, config_.gps.sigma_velocity_m_s, sigma_floor_m_s);

  const auto reason = [&] {
    if (!known_source(config_.telemetry, fix.station) || !known_source(config_.targets, fix.target))
      return Reason::UnknownSource;
    if (fix.simulated != config_.ingest.expect_simulated) return Reason::SimulatedMismatch;
    const bool three_dimensional = fix.fix == FixType::ThreeDimensional || fix.fix == FixType::Differential;
    const bool stated = fix.satellites > 0 || fix.satellites_stated;
    const bool too_few = stated && (fix.satellites == 0 || fix.satellites < config_.gps.min_satellites);
    if (!three_dimensional || too_few) return Reason::NotTracking;
    const bool finite_velocity = !fix.velocity_valid || fix.velocity.m_s.allFinite();
    const bool finite_sigma = std::isfinite(fix.sigma_horizontal_m) && std::isfinite(fix.sigma_vertical_m) &&
                              std::isfinite(fix.sigma_velocity_m_s);
    if (!fix.position.m.allFinite() || !finite_velocity || !finite_sigma) return Reason::NotFinite;
    const bool plausible_speed = !fix.velocity_valid || fix.velocity.m_s.norm() <= speed_max_m_s;
    if (!plausible_speed || !plausible_sigmas(o)) return Reason::OutOfLimits;
    return judge_fix(o);
  };
  o.verdict = reason();
  return o;
}

Observation Ingest::judge(Observation observation) {
  if (observation.verdict != Reason::Accepted) return observation;
  const bool gps = observation.kind == ObservationKind::Gps;
  const auto known_sensor = [&] {
    switch (observation.kind) {
      case ObservationKind::Radar:
        return known_source(config_.radars, observation.sensor);
      case ObservationKind::Gps:
        return known_source(config_.telemetry, observation.sensor);
      case ObservationKind::Angles:
        return known_source(config_.angle_sensors, observation.sensor);
    }
    return false;
  };
  const auto reason = [&] {
    if (!known_sensor() || !known_source(config_.targets, observation.target)) return Reason::UnknownSource;
    if (observation.simulated != config_.ingest.expect_simulated) return Reason::SimulatedMismatch;
    const bool whole = !gps ? finite_angles(observation.measured) && std::isfinite(observation.measured.range_m)
                            : observation.position.m.allFinite() && std::isfinite(observation.sigma_horizontal_m) &&
                                  std::isfinite(observation.sigma_vertical_m) &&
                                  (!observation.velocity_valid || observation.velocity.m_s.allFinite());
    if (!whole) return Reason::NotFinite;
    if (gps && !plausible_sigmas(observation)) return Reason::OutOfLimits;
    if (gps) return judge_fix(observation);
    return judge_time(observation, stream_of(observation.kind, observation.sensor, observation.target));
  };
  observation.verdict = reason();
  return observation;
}

Reason Ingest::judge_fix(const Observation& fix) {
  if (const Reason place = judge_place(fix); place != Reason::Accepted && place != Reason::AwayFromPad) return place;
  const Reason time = judge_time(fix, stream_of(ObservationKind::Gps, fix.receiver, fix.target));
  if (time != Reason::Accepted) return time;
  departure_.note(fix);
  return judge_place(fix);
}

Reason Ingest::judge_place(const Observation& fix) const {
  const Eigen::Vector3d& p = fix.position.m;
  const bool null_island = p.x() > 0 && std::hypot(p.y(), p.z()) <= no_position_m;
  if (null_island || p.norm() <= no_position_m) return Reason::NoPosition;
  if (p.norm() < radius_min_m || p.norm() > radius_max_m) return Reason::OutOfLimits;
  const bool away = config_.pad && (p - config_.pad->site.ecef().m).norm() > config_.pad->radius_m;
  return away && !departure_.left_pad(fix.target, fix.epoch) ? Reason::AwayFromPad : Reason::Accepted;
}

Ingest::Stream& Ingest::stream_of(ObservationKind kind, const Name& source, const Name& target) {
  for (Stream& s : streams_) {
    if (s.kind == kind && s.source == source && s.target == target) return s;
  }
  // Whatever an outsider calls its receivers, memory stays bounded: streams that went quiet make room.
  if (streams_.size() >= max_streams) streams_.erase(streams_.begin());
  streams_.push_back({.source = source, .target = target, .kind = kind, .recent = {}});
  return streams_.back();
}

Reason Ingest::judge_time(const Observation& o, Stream& stream) const {
  if (!plausible(o.epoch) || !plausible(o.received)) return Reason::OutOfLimits;
  const Time horizon = o.received - config_.fuse.history;
  if (o.epoch < horizon) return Reason::TooLate;
  if (o.epoch > o.received + config_.ingest.max_future) return Reason::FromFuture;

  // Of GPS the same epoch is +- 1 ms; a radar's plots may follow each other as closely.
  const Duration tolerance = o.kind == ObservationKind::Gps ? same_epoch : Duration{0};
  std::erase_if(stream.recent, [&](const Stream::Entry& e) { return e.epoch < horizon - same_epoch; });
  for (const Stream::Entry& e : stream.recent) {
    const Duration apart = o.epoch - e.epoch;
    if (apart <= tolerance && -apart <= tolerance) return Reason::Duplicate;
    const bool sent_after = e.sender == o.sensor && o.sequence > e.sequence;
    if (sent_after && o.epoch < e.epoch) return Reason::ClockStep;
  }
  stream.recent.push_back({.epoch = o.epoch, .sequence = o.sequence, .sender = o.sensor});
  return Reason::Accepted;
}

}  // namespace downrange
