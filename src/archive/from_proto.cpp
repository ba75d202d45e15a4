#include <algorithm>
#include <archive/convert.hpp>
#include <limits>

namespace downrange::archive {
namespace {

void fault(Defect& defect, std::string what) {
  if (defect.what.empty()) defect.what = std::move(what);
}

template <class Text = Name>
Text name(const std::string& text, const char* field, Defect& defect) {
  const auto parsed = Text::parse(text);
  if (!parsed) {
    fault(defect,
          std::string(field) + ": longer than " + std::to_string(Text::max_size) + " characters or holding a NUL");
  }
  return parsed.value_or(Text());
}

/// `last` is the highest enumerator.
template <class Enum>
Enum enumerator(int value, Enum last, const char* field, Defect& defect) {
  if (value >= 0 && value <= static_cast<int>(last)) return static_cast<Enum>(value);
  fault(defect, std::string(field) + ": no enumerator has the number " + std::to_string(value));
  return Enum{};
}

std::uint8_t byte(std::uint32_t value, const char* field, Defect& defect) {
  if (value > std::numeric_limits<std::uint8_t>::max()) fault(defect, std::string(field) + ": above 255");
  return static_cast<std::uint8_t>(value);
}

/// Copies a repeated field of exactly `size` numbers to the front of a fixed array.
template <class Field, class Array>
void take(const Field& in, int size, Array& out, const char* field, Defect& defect) {
  if (in.size() != size || in.size() > static_cast<int>(out.size())) {
    fault(defect, std::string(field) + ": " + std::to_string(in.size()) + " entries instead of " +
                      std::to_string(size) + " (at most " + std::to_string(out.size()) + ")");
    return;
  }
  std::copy(in.begin(), in.end(), out.begin());
}

template <class Message>
Position<Ecef> position(const Message& in) {
  return {{in.position_x_m(), in.position_y_m(), in.position_z_m()}};
}

template <class Message>
Velocity<Ecef> velocity(const Message& in) {
  return {{in.velocity_x_m_s(), in.velocity_y_m_s(), in.velocity_z_m_s()}};
}

template <class Message>
Polar polar(const Message& in) {
  return {in.range_m(), in.azimuth_rad(), in.elevation_rad()};
}

}  // namespace

RadarTspi from_proto(const record::RadarTspi& in, Defect& defect) {
  RadarTspi out;
  out.sensor = name(in.sensor(), "sensor", defect);
  out.target = name(in.target(), "target", defect);
  out.sequence = in.sequence();
  out.epoch = {in.epoch_ns()};
  out.received = {in.received_ns()};
  out.measured = polar(in);
  out.range_rate_m_s = in.range_rate_m_s();
  out.range_rate_valid = in.range_rate_valid();
  out.range_valid = !in.has_range_valid() || in.range_valid();
  out.azimuth_valid = !in.has_azimuth_valid() || in.azimuth_valid();
  out.elevation_valid = !in.has_elevation_valid() || in.elevation_valid();
  out.mode = enumerator(in.mode(), TrackMode::Slaved, "mode", defect);
  out.snr_db = in.snr_db();
  out.snr_valid = in.has_snr_valid() ? in.snr_valid() : in.snr_db() != 0;
  out.simulated = in.simulated();
  return out;
}

GpsFix from_proto(const record::GpsFix& in, Defect& defect) {
  GpsFix out;
  out.target = name(in.target(), "target", defect);
  out.receiver = name(in.receiver(), "receiver", defect);
  out.station = name(in.station(), "station", defect);
  out.sequence = in.sequence();
  out.epoch = {in.epoch_ns()};
  out.received = {in.received_ns()};
  out.position = position(in);
  out.velocity = velocity(in);
  out.velocity_valid = in.velocity_valid();
  out.sigma_horizontal_m = in.sigma_horizontal_m();
  out.sigma_vertical_m = in.sigma_vertical_m();
  out.sigma_velocity_m_s = in.sigma_velocity_m_s();
  out.fix = enumerator(in.fix(), FixType::Differential, "fix", defect);
  out.satellites = byte(in.satellites(), "satellites", defect);
  out.satellites_valid = in.has_satellites_valid() ? in.satellites_valid() : out.satellites > 0;
  out.simulated = in.simulated();
  return out;
}

AngleTspi from_proto(const record::AngleTspi& in, Defect& defect) {
  AngleTspi out;
  out.sensor = name(in.sensor(), "sensor", defect);
  out.target = name(in.target(), "target", defect);
  out.sequence = in.sequence();
  out.epoch = {in.epoch_ns()};
  out.received = {in.received_ns()};
  out.azimuth_rad = in.azimuth_rad();
  out.elevation_rad = in.elevation_rad();
  out.azimuth_valid = !in.has_azimuth_valid() || in.azimuth_valid();
  out.elevation_valid = !in.has_elevation_valid() || in.elevation_valid();
  out.mode = enumerator(in.mode(), TrackMode::Slaved, "mode", defect);
  out.simulated = in.simulated();
  return out;
}

MissionEvent from_proto(const record::MissionEvent& in, Defect& defect) {
  MissionEvent out;
  out.mission = name(in.mission(), "mission", defect);
  out.label = name(in.label(), "label", defect);
  out.kind = enumerator(in.kind(), MissionEventKind::Recycle, "kind", defect);
  out.sequence = in.sequence();
  out.epoch = {in.epoch_ns()};
  out.received = {in.received_ns()};
  out.simulated = in.simulated();
  return out;
}

OperatorCommand from_proto(const record::OperatorCommand& in, Defect& defect) {
  OperatorCommand out;
  out.operator_id = name(in.operator_id(), "operator_id", defect);
  out.order = enumerator(in.order(), OperatorOrder::AcknowledgeAlarm, "order", defect);
  out.subject = name(in.subject(), "subject", defect);
  out.argument = name(in.argument(), "argument", defect);
  out.azimuth_trim_rad = in.azimuth_trim_rad();
  out.elevation_trim_rad = in.elevation_trim_rad();
  out.reason = name<Remark>(in.reason(), "reason", defect);
  out.sequence = in.sequence();
  out.epoch = {in.epoch_ns()};
  out.received = {in.received_ns()};
  out.simulated = in.simulated();
  return out;
}

AntennaReport from_proto(const record::AntennaReport& in, Defect& defect) {
  AntennaReport out;
  out.antenna = name(in.antenna(), "antenna", defect);
  out.sequence = in.sequence();
  out.epoch = {in.epoch_ns()};
  out.received = {in.received_ns()};
  out.azimuth_rad = in.azimuth_rad();
  out.elevation_rad = in.elevation_rad();
  out.azimuth_valid = in.azimuth_valid();
  out.elevation_valid = in.elevation_valid();
  out.mode = enumerator(in.mode(), AntennaMode::Autotrack, "mode", defect);
  out.command_tick = {in.command_tick_ns()};
  out.simulated = in.simulated();
  return out;
}

PlatformState from_proto(const record::PlatformState& in, Defect& defect) {
  PlatformState out;
  out.antenna = name(in.antenna(), "antenna", defect);
  out.sequence = in.sequence();
  out.epoch = {in.epoch_ns()};
  out.received = {in.received_ns()};
  out.position = position(in);
  out.velocity = velocity(in);
  out.velocity_valid = in.velocity_valid();
  out.heading_rad = in.heading_rad();
  out.sigma_position_m = in.sigma_position_m();
  out.sigma_heading_rad = in.sigma_heading_rad();
  out.simulated = in.simulated();
  return out;
}

namespace {

Measured measured(const record::Observation& in, Defect& defect) {
  switch (in.kind()) {
    case record::OBSERVATION_KIND_RADAR:
      return Plot{.measured = polar(in),
                  .range_valid = !in.has_range_valid() || in.range_valid(),
                  .angles_valid = !in.has_angles_valid() || in.angles_valid(),
                  .range_rate_m_s = in.range_rate_m_s(),
                  .range_rate_valid = in.range_rate_valid(),
                  .snr_db = in.snr_db(),
                  .snr_valid = in.snr_valid()};
    case record::OBSERVATION_KIND_ANGLES:
      return Angles{.azimuth_rad = in.azimuth_rad(), .elevation_rad = in.elevation_rad()};
    case record::OBSERVATION_KIND_GPS:
      return Fix{.position = position(in),
                 .velocity = velocity(in),
                 .velocity_valid = in.velocity_valid(),
                 .sigma_horizontal_m = in.sigma_horizontal_m(),
                 .sigma_vertical_m = in.sigma_vertical_m(),
                 .sigma_velocity_m_s = in.sigma_velocity_m_s()};
    default:
      fault(defect, "kind: no enumerator has the number " + std::to_string(static_cast<int>(in.kind())));
      return Plot{};
  }
}

}  // namespace

Observation from_proto(const record::Observation& in, Defect& defect) {
  Observation out;
  out.verdict = enumerator(in.verdict(), static_cast<Reason>(reason_count - 1), "verdict", defect);
  out.sensor = name(in.sensor(), "sensor", defect);
  out.target = name(in.target(), "target", defect);
  out.receiver = name(in.receiver(), "receiver", defect);
  out.sequence = in.sequence();
  out.step = in.step();
  out.epoch = {in.epoch_ns()};
  out.received = {in.received_ns()};
  out.measured = measured(in, defect);
  out.simulated = in.simulated();
  return out;
}

SensorBias from_proto(const record::SensorBias& in, Defect& defect) {
  SensorBias out;
  out.sensor = name(in.sensor(), "sensor", defect);
  out.method = name(in.method(), "method", defect);
  out.epoch = {in.epoch_ns()};
  out.received = {in.received_ns()};
  out.reference = enumerator(in.reference(), BiasReference::CrossRadar, "reference", defect);
  out.samples = in.samples();
  if (in.term_size() > max_bias_terms || in.state_size() != in.term_size()) {
    fault(defect, "term: " + std::to_string(in.term_size()) + " terms with " + std::to_string(in.state_size()) +
                      " states (at most " + std::to_string(max_bias_terms) + ")");
    return out;
  }
  out.terms = in.term_size();
  for (int i = 0; i < out.terms; ++i) {
    const auto at = static_cast<std::size_t>(i);
    out.term[at] = enumerator(in.term(i), BiasTerm::TimeTag, "term", defect);
    out.state[at] = enumerator(in.state(i), BiasState::Frozen, "state", defect);
  }
  take(in.value(), out.terms, out.value, "value", defect);
  take(in.covariance(), triangle_size(out.terms), out.covariance, "covariance", defect);
  return out;
}

Trajectory from_proto(const record::Trajectory& in, Defect& defect) {
  Trajectory out;
  out.target = name(in.target(), "target", defect);
  out.method = name(in.method(), "method", defect);
  out.primary = in.primary();
  out.epoch = {in.epoch_ns()};
  out.received = {in.received_ns()};
  out.quality = enumerator(in.quality(), TrackQuality::Coasting, "quality", defect);
  if (in.state_size() > max_state) {
    fault(defect, "state: " + std::to_string(in.state_size()) + " entries (at most " + std::to_string(max_state) + ")");
    return out;
  }
  out.state_size = in.state_size();
  take(in.state(), out.state_size, out.state, "state", defect);
  take(in.covariance(), triangle_size(out.state_size), out.covariance, "covariance", defect);
  out.geodetic = {in.latitude_rad(), in.longitude_rad(), in.height_m()};
  out.speed_m_s = in.speed_m_s();
  out.flight_path_rad = in.flight_path_rad();
  out.heading_rad = in.heading_rad();
  out.sources = in.sources();
  out.nis = in.nis();
  out.nis_dof = in.nis_dof();
  out.chain = name(in.chain(), "chain", defect);
  out.bound_m = in.bound_m();
  out.bound_valid = in.bound_valid();
  out.deviation_valid = in.deviation_valid();
  if (out.deviation_valid) {
    take(in.deviation_m(), 3, out.deviation_m, "deviation_m", defect);
    take(in.deviation_sigma_m(), 3, out.deviation_sigma_m, "deviation_sigma_m", defect);
  }
  return out;
}

Integrity from_proto(const record::Integrity& in, Defect& defect) {
  Integrity out;
  out.target = name(in.target(), "target", defect);
  out.time = {in.time_ns()};
  out.liftoff = {in.liftoff_ns()};
  out.liftoff_valid = in.liftoff_valid();
  out.chain = name(in.chain(), "chain", defect);
  out.held_by = name(in.held_by(), "held_by", defect);
  out.bound_m = in.bound_m();
  out.bound_valid = in.bound_valid();
  out.events = in.events();
  const int sources = in.sensor_size();
  for (const int size : {in.verdict_size(), in.why_size(), in.since_ns_size(), in.onset_ns_size(), in.test_value_size(),
                         in.against_size(), in.apart_m_size(), in.agree_m_size(), in.by_size()}) {
    if (size == sources) continue;
    fault(defect,
          "sensor: " + std::to_string(sources) + " sources, of which another field has " + std::to_string(size));
    return out;
  }
  for (int i = 0; i < sources; ++i) {
    out.sources.push_back({.sensor = name(in.sensor(i), "sensor", defect),
                           .verdict = enumerator(in.verdict(i), IntegrityVerdict::Ambiguous, "verdict", defect),
                           .why = enumerator(in.why(i), Finding::Impossible, "why", defect),
                           .since = {in.since_ns(i)},
                           .onset = {in.onset_ns(i)},
                           .test_value = in.test_value(i),
                           .against = in.against(i),
                           .apart_m = in.apart_m(i),
                           .agree_m = in.agree_m(i),
                           .by = name(in.by(i), "by", defect)});
  }
  return out;
}

SlavingCommand from_proto(const record::SlavingCommand& in, Defect& defect) {
  SlavingCommand out;
  out.antenna = name(in.antenna(), "antenna", defect);
  out.target = name(in.target(), "target", defect);
  out.tick = {in.tick_ns()};
  out.apply_at = {in.apply_at_ns()};
  out.valid_until = {in.valid_until_ns()};
  out.data_epoch = {in.data_epoch_ns()};
  out.age_s = in.age_s();
  out.azimuth_rad = in.azimuth_rad();
  out.elevation_rad = in.elevation_rad();
  out.range_m = in.range_m();
  out.azimuth_rate_rad_s = in.azimuth_rate_rad_s();
  out.elevation_rate_rad_s = in.elevation_rate_rad_s();
  out.range_rate_m_s = in.range_rate_m_s();
  out.sigma_azimuth_rad = in.sigma_azimuth_rad();
  out.sigma_elevation_rad = in.sigma_elevation_rad();
  out.source = enumerator(in.source(), SlavingSource::Nominal, "source", defect);
  out.limits = byte(in.limits(), "limits", defect);
  out.azimuth_acceleration_rad_s2 = in.azimuth_acceleration_rad_s2();
  out.elevation_acceleration_rad_s2 = in.elevation_acceleration_rad_s2();
  out.acceleration_valid = in.acceleration_valid();
  out.probability_in_beam = in.probability_in_beam();
  out.probability_valid = in.probability_valid();
  out.bound_rad = in.bound_rad();
  out.bound_valid = in.bound_valid();
  out.chain = name(in.chain(), "chain", defect);
  return out;
}

SourceHealth from_proto(const record::SourceHealth& in, Defect& defect) {
  SourceHealth out;
  out.sensor = name(in.sensor(), "sensor", defect);
  out.target = name(in.target(), "target", defect);
  out.time = {in.time_ns()};
  out.rate_hz = in.rate_hz();
  out.latency_s = in.latency_s();
  // Fewer counts: an archive older than the newest reasons.
  take(in.count(), std::min(in.count_size(), static_cast<int>(reason_count)), out.count, "count", defect);
  out.residual_mean = in.residual_mean();
  out.residual_sigma = in.residual_sigma();
  out.nis = in.nis();
  out.qualified = in.qualified();
  out.why = enumerator(in.why(), Disqualification::Excluded, "why", defect);
  out.rejected_for = enumerator(in.rejected_for(), static_cast<Reason>(reason_count - 1), "rejected_for", defect);
  out.nis_inside_95 = in.nis_inside_95();
  out.nis_count = static_cast<int>(in.nis_count());
  out.mismatch = in.mismatch();
  out.residual_m = in.residual_m();
  out.expected_m = in.expected_m();
  out.residual_rad = in.residual_rad();
  out.expected_rad = in.expected_rad();
  out.suspect = in.suspect();
  out.forced = in.forced();
  out.since = {in.since_ns()};
  out.by = name(in.by(), "by", defect);
  out.reason = name<Remark>(in.reason(), "reason", defect);
  return out;
}

ClockGap from_proto(const record::ClockGap& in, Defect&) { return {{in.epoch_ns()}, {in.received_ns()}}; }

LastTick from_proto(const record::LastTick& in, Defect&) { return {{in.tick_ns()}}; }

Truth from_proto(const record::Truth& in, Defect& defect) {
  Truth out;
  out.target = name(in.target(), "target", defect);
  out.epoch = {in.epoch_ns()};
  out.position = position(in);
  out.velocity = velocity(in);
  out.acceleration_m_s2 = {in.acceleration_x_m_s2(), in.acceleration_y_m_s2(), in.acceleration_z_m_s2()};
  out.acceleration_valid = in.acceleration_valid();
  return out;
}

}  // namespace downrange::archive
