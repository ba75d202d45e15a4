#include <algorithm>
#include <archive/convert.hpp>
#include <string_view>

namespace downrange::archive {
namespace {

/// Bytes of the well-formed UTF-8 character at the front of `text` (RFC 3629, section 4), 0 when there is none.
std::size_t utf8_size(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  const auto in = [&](std::size_t i, unsigned low, unsigned high) { return byte(i) >= low && byte(i) <= high; };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  if (in(0, 0xC2, 0xDF)) return in(1, 0x80, 0xBF) ? 2 : 0;
  if (in(0, 0xE0, 0xEF)) {
    const bool second = in(1, first == 0xE0 ? 0xA0 : 0x80, first == 0xED ? 0x9F : 0xBF);
    return second && in(2, 0x80, 0xBF) ? 3 : 0;
  }
  if (in(0, 0xF0, 0xF4)) {
    const bool second = in(1, first == 0xF0 ? 0x90 : 0x80, first == 0xF4 ? 0x8F : 0xBF);
    return second && in(2, 0x80, 0xBF) && in(3, 0x80, 0xBF) ? 4 : 0;
  }
  return 0;
}

template <std::size_t MaxSize>
void put(const FixedText<MaxSize>& name, std::string* out) {
  const std::string_view text = name.view();
  out->assign(text);
  if (std::all_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x80; })) return;
  for (std::size_t i = 0; i < out->size();) {
    const std::size_t size = utf8_size(std::string_view(*out).substr(i));
    if (size == 0) (*out)[i] = '?';
    i += std::max<std::size_t>(size, 1);
  }
}

template <class Message>
void put(const Position<Ecef>& p, Message& out) {
  out.set_position_x_m(p.m.x());
  out.set_position_y_m(p.m.y());
  out.set_position_z_m(p.m.z());
}

template <class Message>
void put(const Velocity<Ecef>& v, Message& out) {
  out.set_velocity_x_m_s(v.m_s.x());
  out.set_velocity_y_m_s(v.m_s.y());
  out.set_velocity_z_m_s(v.m_s.z());
}

template <class Message>
void put(const Polar& q, Message& out) {
  out.set_range_m(q.range_m);
  out.set_azimuth_rad(q.azimuth_rad);
  out.set_elevation_rad(q.elevation_rad);
}

/// The first `count` of a fixed array.
template <class Array, class Field>
void put_first(const Array& in, int count, Field* out) {
  out->Clear();
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
    out->Add(static_cast<typename Field::value_type>(in[i]));
}

template <class Wire, class Enum>
Wire wire(Enum value) {
  return static_cast<Wire>(static_cast<int>(value));
}

}  // namespace

void to_proto(const RadarTspi& in, record::RadarTspi& out) {
  put(in.sensor, out.mutable_sensor());
  put(in.target, out.mutable_target());
  out.set_sequence(in.sequence);
  out.set_epoch_ns(in.epoch.ns);
  out.set_received_ns(in.received.ns);
  put(in.measured, out);
  out.set_range_rate_m_s(in.range_rate_m_s);
  out.set_range_rate_valid(in.range_rate_valid);
  out.set_mode(wire<record::TrackMode>(in.mode));
  out.set_snr_db(in.snr_db);
  out.set_simulated(in.simulated);
  out.set_range_valid(in.range_valid);
  out.set_azimuth_valid(in.azimuth_valid);
  out.set_elevation_valid(in.elevation_valid);
  out.set_snr_valid(in.snr_valid);
}

void to_proto(const GpsFix& in, record::GpsFix& out) {
  put(in.target, out.mutable_target());
  put(in.receiver, out.mutable_receiver());
  put(in.station, out.mutable_station());
  out.set_sequence(in.sequence);
  out.set_epoch_ns(in.epoch.ns);
  out.set_received_ns(in.received.ns);
  put(in.position, out);
  put(in.velocity, out);
  out.set_velocity_valid(in.velocity_valid);
  out.set_sigma_horizontal_m(in.sigma_horizontal_m);
  out.set_sigma_vertical_m(in.sigma_vertical_m);
  out.set_sigma_velocity_m_s(in.sigma_velocity_m_s);
  out.set_fix(wire<record::FixType>(in.fix));
  out.set_satellites(in.satellites);
  out.set_satellites_valid(in.satellites_valid);
  out.set_simulated(in.simulated);
}

void to_proto(const AngleTspi& in, record::AngleTspi& out) {
  put(in.sensor, out.mutable_sensor());
  put(in.target, out.mutable_target());
  out.set_sequence(in.sequence);
  out.set_epoch_ns(in.epoch.ns);
  out.set_received_ns(in.received.ns);
  out.set_azimuth_rad(in.azimuth_rad);
  out.set_elevation_rad(in.elevation_rad);
  out.set_azimuth_valid(in.azimuth_valid);
  out.set_elevation_valid(in.elevation_valid);
  out.set_mode(wire<record::TrackMode>(in.mode));
  out.set_simulated(in.simulated);
}

void to_proto(const MissionEvent& in, record::MissionEvent& out) {
  put(in.mission, out.mutable_mission());
  put(in.label, out.mutable_label());
  out.set_kind(wire<record::MissionEventKind>(in.kind));
  out.set_sequence(in.sequence);
  out.set_epoch_ns(in.epoch.ns);
  out.set_received_ns(in.received.ns);
  out.set_simulated(in.simulated);
}

void to_proto(const OperatorCommand& in, record::OperatorCommand& out) {
  put(in.operator_id, out.mutable_operator_id());
  out.set_order(wire<record::OperatorOrder>(in.order));
  put(in.subject, out.mutable_subject());
  put(in.argument, out.mutable_argument());
  out.set_azimuth_trim_rad(in.azimuth_trim_rad);
  out.set_elevation_trim_rad(in.elevation_trim_rad);
  put(in.reason, out.mutable_reason());
  out.set_sequence(in.sequence);
  out.set_epoch_ns(in.epoch.ns);
  out.set_received_ns(in.received.ns);
  out.set_simulated(in.simulated);
}

void to_proto(const AntennaReport& in, record::AntennaReport& out) {
  put(in.antenna, out.mutable_antenna());
  out.set_sequence(in.sequence);
  out.set_epoch_ns(in.epoch.ns);
  out.set_received_ns(in.received.ns);
  out.set_azimuth_rad(in.azimuth_rad);
  out.set_elevation_rad(in.elevation_rad);
  out.set_azimuth_valid(in.azimuth_valid);
  out.set_elevation_valid(in.elevation_valid);
  out.set_mode(wire<record::AntennaMode>(in.mode));
  out.set_command_tick_ns(in.command_tick.ns);
  out.set_simulated(in.simulated);
}

void to_proto(const PlatformState& in, record::PlatformState& out) {
  put(in.antenna, out.mutable_antenna());
  out.set_sequence(in.sequence);
  out.set_epoch_ns(in.epoch.ns);
  out.set_received_ns(in.received.ns);
  put(in.position, out);
  put(in.velocity, out);
  out.set_velocity_valid(in.velocity_valid);
  out.set_heading_rad(in.heading_rad);
  out.set_sigma_position_m(in.sigma_position_m);
  out.set_sigma_heading_rad(in.sigma_heading_rad);
  out.set_simulated(in.simulated);
}

namespace {

void put_measured(const Plot& plot, record::Observation& out) {
  put(plot.measured, out);
  out.set_range_valid(plot.range_valid);
  out.set_angles_valid(plot.angles_valid);
  out.set_range_rate_m_s(plot.range_rate_m_s);
  out.set_range_rate_valid(plot.range_rate_valid);
  out.set_snr_db(plot.snr_db);
  out.set_snr_valid(plot.snr_valid);
}

void put_measured(const Fix& fix, record::Observation& out) {
  put(fix.position, out);
  put(fix.velocity, out);
  out.set_velocity_valid(fix.velocity_valid);
  out.set_sigma_horizontal_m(fix.sigma_horizontal_m);
  out.set_sigma_vertical_m(fix.sigma_vertical_m);
  out.set_sigma_velocity_m_s(fix.sigma_velocity_m_s);
}

void put_measured(const Angles& angles, record::Observation& out) {
  put(Polar{0, angles.azimuth_rad, angles.elevation_rad}, out);
  out.set_range_valid(false);
  out.set_angles_valid(true);
}

}  // namespace

void to_proto(const Observation& in, record::Observation& out) {
  out.Clear();  // of what another kind of measurement left
  out.set_kind(wire<record::ObservationKind>(in.measured.index()));
  out.set_verdict(wire<record::Reason>(in.verdict));
  put(in.sensor, out.mutable_sensor());
  put(in.target, out.mutable_target());
  put(in.receiver, out.mutable_receiver());
  out.set_sequence(in.sequence);
  out.set_step(in.step);
  out.set_epoch_ns(in.epoch.ns);
  out.set_received_ns(in.received.ns);
  std::visit([&out](const auto& measured) { put_measured(measured, out); }, in.measured);
  out.set_simulated(in.simulated);
}

void to_proto(const SensorBias& in, record::SensorBias& out) {
  put(in.sensor, out.mutable_sensor());
  put(in.method, out.mutable_method());
  out.set_epoch_ns(in.epoch.ns);
  out.set_received_ns(in.received.ns);
  out.set_reference(wire<record::BiasReference>(in.reference));
  out.set_samples(in.samples);
  const int terms = std::clamp(in.terms, 0, max_bias_terms);  // a wrong count must not read past the arrays
  put_first(in.term, terms, out.mutable_term());
  put_first(in.state, terms, out.mutable_state());
  put_first(in.value, terms, out.mutable_value());
  put_first(in.covariance, triangle_size(terms), out.mutable_covariance());
}

void to_proto(const Trajectory& in, record::Trajectory& out) {
  put(in.target, out.mutable_target());
  put(in.method, out.mutable_method());
  out.set_primary(in.primary);
  out.set_epoch_ns(in.epoch.ns);
  out.set_received_ns(in.received.ns);
  out.set_quality(wire<record::TrackQuality>(in.quality));
  const int size = std::clamp(in.state_size, 0, max_state);
  put_first(in.state, size, out.mutable_state());
  put_first(in.covariance, triangle_size(size), out.mutable_covariance());
  out.set_latitude_rad(in.geodetic.latitude_rad);
  out.set_longitude_rad(in.geodetic.longitude_rad);
  out.set_height_m(in.geodetic.height_m);
  out.set_speed_m_s(in.speed_m_s);
  out.set_flight_path_rad(in.flight_path_rad);
  out.set_heading_rad(in.heading_rad);
  out.set_sources(in.sources);
  out.set_nis(in.nis);
  out.set_nis_dof(in.nis_dof);
  put(in.chain, out.mutable_chain());
  out.set_bound_m(in.bound_m);
  out.set_bound_valid(in.bound_valid);
  const int deviations = in.deviation_valid ? 3 : 0;
  put_first(in.deviation_m, deviations, out.mutable_deviation_m());
  put_first(in.deviation_sigma_m, deviations, out.mutable_deviation_sigma_m());
  out.set_deviation_valid(in.deviation_valid);
}

void to_proto(const Integrity& in, record::Integrity& out) {
  out.Clear();  // keeps the memory of its fields
  put(in.target, out.mutable_target());
  out.set_time_ns(in.time.ns);
  out.set_liftoff_ns(in.liftoff.ns);
  out.set_liftoff_valid(in.liftoff_valid);
  put(in.chain, out.mutable_chain());
  put(in.held_by, out.mutable_held_by());
  out.set_bound_m(in.bound_m);
  out.set_bound_valid(in.bound_valid);
  out.set_events(in.events);
  for (const SourceIntegrity& source : in.sources) {
    put(source.sensor, out.add_sensor());
    out.add_verdict(wire<record::IntegrityVerdict>(source.verdict));
    out.add_why(wire<record::Finding>(source.why));
    out.add_since_ns(source.since.ns);
    out.add_onset_ns(source.onset.ns);
    out.add_test_value(source.test_value);
    out.add_against(source.against);
    out.add_apart_m(source.apart_m);
    out.add_agree_m(source.agree_m);
    put(source.by, out.add_by());
  }
}

void to_proto(const SlavingCommand& in, record::SlavingCommand& out) {
  put(in.antenna, out.mutable_antenna());
  put(in.target, out.mutable_target());
  out.set_tick_ns(in.tick.ns);
  out.set_apply_at_ns(in.apply_at.ns);
  out.set_valid_until_ns(in.valid_until.ns);
  out.set_data_epoch_ns(in.data_epoch.ns);
  out.set_age_s(in.age_s);
  out.set_azimuth_rad(in.azimuth_rad);
  out.set_elevation_rad(in.elevation_rad);
  out.set_range_m(in.range_m);
  out.set_azimuth_rate_rad_s(in.azimuth_rate_rad_s);
  out.set_elevation_rate_rad_s(in.elevation_rate_rad_s);
  out.set_range_rate_m_s(in.range_rate_m_s);
  out.set_sigma_azimuth_rad(in.sigma_azimuth_rad);
  out.set_sigma_elevation_rad(in.sigma_elevation_rad);
  out.set_source(wire<record::SlavingSource>(in.source));
  out.set_limits(in.limits);
  out.set_azimuth_acceleration_rad_s2(in.azimuth_acceleration_rad_s2);
  out.set_elevation_acceleration_rad_s2(in.elevation_acceleration_rad_s2);
  out.set_acceleration_valid(in.acceleration_valid);
  out.set_probability_in_beam(in.probability_in_beam);
  out.set_probability_valid(in.probability_valid);
  out.set_bound_rad(in.bound_rad);
  out.set_bound_valid(in.bound_valid);
  put(in.chain, out.mutable_chain());
}

void to_proto(const SourceHealth& in, record::SourceHealth& out) {
  put(in.sensor, out.mutable_sensor());
  put(in.target, out.mutable_target());
  out.set_time_ns(in.time.ns);
  out.set_rate_hz(in.rate_hz);
  out.set_latency_s(in.latency_s);
  put_first(in.count, static_cast<int>(reason_count), out.mutable_count());
  out.set_residual_mean(in.residual_mean);
  out.set_residual_sigma(in.residual_sigma);
  out.set_nis(in.nis);
  out.set_qualified(in.qualified);
  out.set_why(wire<record::Disqualification>(in.why));
  out.set_rejected_for(wire<record::Reason>(in.rejected_for));
  out.set_nis_inside_95(in.nis_inside_95);
  out.set_nis_count(static_cast<std::uint32_t>(in.nis_count));
  out.set_mismatch(in.mismatch);
  out.set_residual_m(in.residual_m);
  out.set_expected_m(in.expected_m);
  out.set_residual_rad(in.residual_rad);
  out.set_expected_rad(in.expected_rad);
  out.set_suspect(in.suspect);
  out.set_forced(in.forced);
  out.set_since_ns(in.since.ns);
  put(in.by, out.mutable_by());
  put(in.reason, out.mutable_reason());
}

void to_proto(const ClockGap& in, record::ClockGap& out) {
  out.set_epoch_ns(in.epoch.ns);
  out.set_received_ns(in.received.ns);
}

void to_proto(const LastTick& in, record::LastTick& out) { out.set_tick_ns(in.tick.ns); }

void to_proto(const Truth& in, record::Truth& out) {
  put(in.target, out.mutable_target());
  out.set_epoch_ns(in.epoch.ns);
  put(in.position, out);
  put(in.velocity, out);
  out.set_acceleration_x_m_s2(in.acceleration_m_s2.x());
  out.set_acceleration_y_m_s2(in.acceleration_m_s2.y());
  out.set_acceleration_z_m_s2(in.acceleration_m_s2.z());
  out.set_acceleration_valid(in.acceleration_valid);
}

}  // namespace downrange::archive
