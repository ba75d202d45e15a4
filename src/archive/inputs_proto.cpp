/// What the engine consumes, to and from its records.

#include <archive/proto_field.hpp>

namespace downrange::archive {

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

void to_proto(const MissionEvent& in, record::MissionEvent& out) {
  put(in.mission, out.mutable_mission());
  put(in.label, out.mutable_label());
  out.set_kind(wire<record::MissionEventKind>(in.kind));
  out.set_sequence(in.sequence);
  out.set_epoch_ns(in.epoch.ns);
  out.set_received_ns(in.received.ns);
  out.set_simulated(in.simulated);
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

void to_proto(const ClockGap& in, record::ClockGap& out) {
  out.set_epoch_ns(in.epoch.ns);
  out.set_received_ns(in.received.ns);
}

ClockGap from_proto(const record::ClockGap& in, Defect&) { return {{in.epoch_ns()}, {in.received_ns()}}; }

}  // namespace downrange::archive
