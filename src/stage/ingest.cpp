#include "ingest.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "indices.hpp"

namespace downrange {
namespace {

constexpr Duration same_epoch = milliseconds(1);
/// Beside one of each source and target: of receivers that nobody has configured.
constexpr std::size_t more_streams = 512;
/// A vehicle is between the Dead Sea's depth below the ellipsoid and geosynchronous altitude, slower than 20 km/s.
constexpr double radius_min_m = 6.35e6;
constexpr double radius_max_m = 5e7;
/// This near to latitude and longitude 0, at any height, or to the Earth's centre, a position is none.
constexpr double no_position_m = 10;
constexpr double speed_max_m_s = 2e4;
/// A motion that began this near to the announced lift-off is the lift-off.
constexpr Duration at_liftoff = milliseconds(10'000);
/// From its pad: three times the most that a launch vehicle's velocity changes by (departure.cpp), for lift-offs that
/// are announced late and small rockets.
constexpr double most_acceleration_m_s2 = 300;
/// What an antenna says of itself counts so long, when it says no more.
constexpr Duration antenna_said_lasts = milliseconds(5000);
/// A receiver that states worse has no fix.
constexpr double sigma_max = 1e5;

bool plausible_sigma(double sigma) { return sigma > 0 && sigma <= sigma_max; }

/// What an observation shares with the message it comes from.
template <class Message>
Observation observation_of(const Message& message, const Name& sensor, Measured measured) {
  Observation o;
  o.sensor = sensor;
  o.target = message.target;
  o.sequence = message.sequence;
  o.epoch = message.epoch;
  o.received = message.received;
  o.measured = std::move(measured);
  o.simulated = message.simulated;
  return o;
}

Plot plot_of(const RadarTspi& tspi) {
  return {.measured = {tspi.measured.range_m, wrap_two_pi(tspi.measured.azimuth_rad), tspi.measured.elevation_rad},
          .range_valid = tspi.range_valid,
          .angles_valid = tspi.azimuth_valid && tspi.elevation_valid,
          .range_rate_m_s = tspi.range_rate_m_s,
          .range_rate_valid = tspi.range_rate_valid,
          .snr_db = tspi.snr_db,
          .snr_valid = tspi.snr_valid};
}

/// Whether an instrument of this mode tells something of its own.
Reason judge_mode(TrackMode mode) {
  if (mode == TrackMode::Slaved) return Reason::Slaved;
  return mode == TrackMode::Track ? Reason::Accepted : Reason::NotTracking;
}

/// The first that is not Accepted.
template <class... Judges>
Reason first_reason(Judges&&... judges) {
  Reason reason = Reason::Accepted;
  static_cast<void>(((reason = judges(), reason == Reason::Accepted) && ...));
  return reason;
}

}  // namespace

Ingest::Ingest(const RangeConfig& config)
    : config_(config),
      sources_(config),
      departure_(config),
      mission_(config),
      orders_(config),
      antennas_(config.antennas.size()),
      most_streams_(sources_.size() * config.targets.size() + more_streams) {}

void Ingest::note(const MissionEvent& event) {
  mission_.note(event);
  if (event.kind == MissionEventKind::Recycle && mission_.refusal(event).empty()) departure_.recycle();
}

void Ingest::note(const AntennaReport& report) {
  const int antenna = index_of(config_.antennas, report.antenna);
  if (antenna < 0 || report.simulated != config_.ingest.expect_simulated || !plausible(report.epoch)) return;
  AntennaSaid& said = antennas_[static_cast<std::size_t>(antenna)];
  if (report.epoch <= said.epoch && report.received - said.received <= antenna_said_lasts) return;  // an older one
  said = {.epoch = report.epoch, .received = report.received, .slaved = report.mode == AntennaMode::Slaved};
}

bool Ingest::left_pad(const Name& target, Time epoch) const {
  // The clock knows the first motion of any target: of this one only its own counts.
  const bool announced = mission_.liftoff_announced() && mission_.in_flight(epoch);
  return announced || departure_.moved(target, epoch);
}

double Ingest::reach_from_pad_m(const Name& target, Time epoch) const {
  if (!left_pad(target, epoch)) return config_.pad->radius_m;
  // Whose motion is all that is known of it may have been in flight when this node began to hear it; so may one that
  // moved long before its lift-off was announced.
  const bool from_pad = mission_.liftoff_announced() && !departure_.moved(target, *mission_.liftoff() - at_liftoff);
  if (!from_pad) return std::numeric_limits<double>::infinity();
  const double flown_s = (epoch - *mission_.liftoff()).seconds();
  return config_.pad->radius_m + most_acceleration_m_s2 / 2 * flown_s * flown_s;
}

Observation Ingest::judge(const RadarTspi& tspi) {
  const Plot plot = usable(plot_of(tspi), tspi.sensor);
  Observation o = observation_of(tspi, tspi.sensor, plot);
  o.verdict = first_reason([&] { return judge_sender(o); }, [&] { return judge_mode(tspi.mode); },
                           [&] { return judge_antenna(o); }, [&] { return judge_instrument(o, plot); },
                           [&] { return judge_time(o); });
  return o;
}

Observation Ingest::judge(const AngleTspi& tspi) {
  const Angles angles{.azimuth_rad = wrap_two_pi(tspi.azimuth_rad), .elevation_rad = tspi.elevation_rad};
  Observation o = observation_of(tspi, tspi.sensor, angles);
  const auto whole = [&] {
    return tspi.azimuth_valid && tspi.elevation_valid ? Reason::Accepted : Reason::NotTracking;
  };
  o.verdict = first_reason([&] { return judge_sender(o); }, [&] { return judge_mode(tspi.mode); },
                           [&] { return judge_antenna(o); }, whole, [&] { return judge_instrument(o, angles); },
                           [&] { return judge_time(o); });
  return o;
}

Observation Ingest::judge(const GpsFix& message) {
  const Fix fix{.position = message.position,
                .velocity = message.velocity,
                .velocity_valid = message.velocity_valid,
                .sigma_horizontal_m = std::max(config_.gps.sigma_horizontal_m, message.sigma_horizontal_m),
                .sigma_vertical_m = std::max(config_.gps.sigma_vertical_m, message.sigma_vertical_m),
                .sigma_velocity_m_s = std::max(config_.gps.sigma_velocity_m_s, message.sigma_velocity_m_s)};
  Observation o = observation_of(message, message.station, fix);
  o.receiver = message.receiver;
  const auto has_fix = [&] {
    const bool three_dimensional = message.fix == FixType::ThreeDimensional || message.fix == FixType::Differential;
    const int least = std::max(config_.gps.min_satellites, 1);  // none is no fix, whatever is configured
    const bool enough = !message.satellites_valid || message.satellites >= least;
    return three_dimensional && enough ? Reason::Accepted : Reason::NotTracking;
  };
  const auto finite_sigmas = [&] {
    const bool finite = std::isfinite(message.sigma_horizontal_m) && std::isfinite(message.sigma_vertical_m) &&
                        std::isfinite(message.sigma_velocity_m_s);
    return finite ? Reason::Accepted : Reason::NotFinite;
  };
  o.verdict =
      first_reason([&] { return judge_sender(o); }, has_fix, finite_sigmas, [&] { return judge_instrument(o, fix); },
                   [&] { return judge_time(o); }, [&] { return judge_pad(o); });
  return o;
}

Observation Ingest::judge(Observation o) {
  // With the fixes of all nodes together it is known best whether the vehicle has left the pad: that is judged anew.
  if (o.verdict != Reason::Accepted && o.verdict != Reason::AwayFromPad) return o;
  if (auto* plot = std::get_if<Plot>(&o.measured)) *plot = usable(*plot, o.sensor);
  o.verdict = first_reason(
      [&] { return judge_sender(o); }, [&] { return judge_antenna(o); },
      [&] { return std::visit([&](const auto& measured) { return judge_instrument(o, measured); }, o.measured); },
      [&] { return judge_time(o); }, [&] { return judge_pad(o); });
  return o;
}

Plot Ingest::usable(Plot plot, const Name& sensor) const {
  const int radar = index_of(config_.radars, sensor);
  const MeasuredParts measures = radar < 0 ? MeasuredParts{} : config_.radars[static_cast<std::size_t>(radar)].measures;
  plot.range_valid = plot.range_valid && measures.range;
  plot.angles_valid = plot.angles_valid && measures.angles;
  if (!plot.range_valid) plot.measured.range_m = 0;
  if (!plot.angles_valid) plot.measured.azimuth_rad = plot.measured.elevation_rad = 0;
  return plot;
}

Reason Ingest::judge_sender(const Observation& o) const {
  const SourceId source = sources_.find(kind_of(o.measured), o.sensor);
  if (source == no_source || index_of(config_.targets, o.target) < 0) return Reason::UnknownSource;
  if (o.simulated != config_.ingest.expect_simulated) return Reason::SimulatedMismatch;
  return orders_.inhibited(source) ? Reason::Inhibited : Reason::Accepted;
}

Reason Ingest::judge_antenna(const Observation& o) const {
  for (std::size_t i = 0; i < antennas_.size(); ++i) {
    const bool slaved = antennas_[i].slaved && o.received - antennas_[i].received <= antenna_said_lasts;
    if (slaved && config_.antennas[i].sensor == o.sensor) return Reason::Slaved;
  }
  return Reason::Accepted;
}

Reason Ingest::judge_instrument(const Observation& o, const Plot& plot) const {
  if (!plot.range_valid && !plot.angles_valid) return Reason::NotTracking;
  const Polar& q = plot.measured;  // 0 in what it lacks
  const bool finite = std::isfinite(q.range_m) && std::isfinite(q.azimuth_rad) && std::isfinite(q.elevation_rad) &&
                      (!plot.range_rate_valid || std::isfinite(plot.range_rate_m_s)) &&
                      (!plot.snr_valid || std::isfinite(plot.snr_db));
  if (!finite) return Reason::NotFinite;
  const RadarConfig& radar = config_.radars[static_cast<std::size_t>(index_of(config_.radars, o.sensor))];
  const bool range_inside = !plot.range_valid || (q.range_m >= radar.range_min_m && q.range_m <= radar.range_max_m);
  const bool elevation_inside =
      !plot.angles_valid || (q.elevation_rad >= radar.elevation_min_rad && q.elevation_rad <= radar.elevation_max_rad);
  const bool rate_inside = !plot.range_rate_valid || std::abs(plot.range_rate_m_s) <= speed_max_m_s;
  return range_inside && elevation_inside && rate_inside ? Reason::Accepted : Reason::OutOfLimits;
}

Reason Ingest::judge_instrument(const Observation& o, const Angles& angles) const {
  if (!std::isfinite(angles.azimuth_rad) || !std::isfinite(angles.elevation_rad)) return Reason::NotFinite;
  const auto& sensors = config_.angle_sensors;
  const AngleSensorConfig& sensor = sensors[static_cast<std::size_t>(index_of(sensors, o.sensor))];
  const bool inside =
      angles.elevation_rad >= sensor.elevation_min_rad && angles.elevation_rad <= sensor.elevation_max_rad;
  return inside ? Reason::Accepted : Reason::OutOfLimits;
}

Reason Ingest::judge_instrument(const Observation&, const Fix& fix) const {
  const bool finite = fix.position.m.allFinite() && (!fix.velocity_valid || fix.velocity.m_s.allFinite()) &&
                      std::isfinite(fix.sigma_horizontal_m) && std::isfinite(fix.sigma_vertical_m) &&
                      std::isfinite(fix.sigma_velocity_m_s);
  if (!finite) return Reason::NotFinite;
  const Eigen::Vector3d& p = fix.position.m;
  const double radius = p.norm();
  const bool null_island = p.x() > 0 && std::hypot(p.y(), p.z()) <= no_position_m;
  if (null_island || radius <= no_position_m) return Reason::NoPosition;
  const bool plausible_place = radius >= radius_min_m && radius <= radius_max_m;
  const bool plausible_speed = !fix.velocity_valid || fix.velocity.m_s.norm() <= speed_max_m_s;
  const bool plausible_sigmas = plausible_sigma(fix.sigma_horizontal_m) && plausible_sigma(fix.sigma_vertical_m) &&
                                plausible_sigma(fix.sigma_velocity_m_s);
  return plausible_place && plausible_speed && plausible_sigmas ? Reason::Accepted : Reason::OutOfLimits;
}

Reason Ingest::judge_pad(const Observation& o) {
  const auto* fix = std::get_if<Fix>(&o.measured);
  if (fix == nullptr) return Reason::Accepted;
  departure_.note(o);
  if (const std::optional<Time> motion = departure_.motion(o.target)) mission_.note_motion(*motion);
  const bool away =
      config_.pad && (fix->position.m - config_.pad->site.ecef().m).norm() > reach_from_pad_m(o.target, o.epoch);
  return away ? Reason::AwayFromPad : Reason::Accepted;
}

Ingest::Stream& Ingest::stream_of(const Observation& o) {
  const SourceKind kind = kind_of(o.measured);
  const Name& source = kind == SourceKind::Telemetry ? o.receiver : o.sensor;
  const StreamKey key{.kind = kind, .source = source, .target = o.target};
  // Whatever an outsider calls its receivers, memory stays bounded: the stream that is quiet for longest makes room.
  if (streams_.size() >= most_streams_ && !streams_.contains(key)) {
    const auto heard_before = [](const auto& a, const auto& b) { return a.second.heard < b.second.heard; };
    streams_.erase(std::ranges::min_element(streams_, heard_before));
  }
  Stream& stream = streams_[key];
  stream.heard = std::max(stream.heard, o.received);
  return stream;
}

Reason Ingest::judge_time(const Observation& o) {
  if (!plausible(o.epoch) || !plausible(o.received)) return Reason::OutOfLimits;
  const Time horizon = o.received - config_.fuse.arbitration.history;
  if (o.epoch < horizon) return Reason::TooLate;
  if (o.epoch > o.received + config_.ingest.max_future) return Reason::FromFuture;

  Stream& stream = stream_of(o);
  // Of GPS the same epoch is +- 1 ms; a radar's plots may follow each other as closely.
  const Duration tolerance = kind_of(o.measured) == SourceKind::Telemetry ? same_epoch : Duration{0};
  std::erase_if(stream.recent, [&](const Stream::Entry& e) { return e.epoch < horizon - same_epoch; });
  const auto same = [&](const Stream::Entry& e) {
    const Duration apart = o.epoch - e.epoch;
    return apart <= tolerance && -apart <= tolerance;
  };
  if (const auto copy = std::ranges::find_if(stream.recent, same); copy != stream.recent.end()) {
    // Whatever its number: networks count anew.
    if (copy->sender == o.sensor && copy->sequence != o.sequence)
      stream.numbered_twice = std::max(stream.numbered_twice, o.epoch);
    return Reason::Duplicate;
  }
  // As long as two networks count by themselves numbers tell nothing of the order of epochs.
  const bool one_numbering = stream.numbered_twice < horizon;
  const auto stepped = [&](const Stream::Entry& e) {
    return e.sender == o.sensor && o.sequence > e.sequence && o.epoch < e.epoch;
  };
  if (one_numbering && std::ranges::any_of(stream.recent, stepped)) return Reason::ClockStep;
  stream.recent.push_back({.epoch = o.epoch, .sequence = o.sequence, .sender = o.sensor});
  return Reason::Accepted;
}

}  // namespace downrange
