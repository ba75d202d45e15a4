#include "dds/convert_field.hpp"

namespace downrange::dds {

// Empty and unknown names are no defect of an input: ingest rejects them with a reason, in-process and over DDS alike.

static_assert(int(TrackMode::Coast) == int(wire::TRACK_MODE_COAST));
static_assert(int(FixType::Differential) == int(wire::FIX_TYPE_DIFFERENTIAL));
static_assert(int(MissionEventKind::Mark) == int(wire::MISSION_MARK));
static_assert(int(ObservationKind::Angles) == int(wire::OBSERVATION_ANGLES));
static_assert(int(Reason::AwayFromPad) == int(wire::REASON_AWAY_FROM_PAD) &&
              reason_count == int(wire::REASON_AWAY_FROM_PAD) + 1);

void to_wire(const RangeStamp& from, wire::RangeStamp& to) {
  to.run_id(from.run_id);
  to.sequence_number(from.sequence);
}

RangeStamp from_wire(const wire::RangeStamp& from) { return {from.run_id(), from.sequence_number()}; }

void to_wire(const RadarTspi& from, wire::RadarTspi& to) {
  to.sensor_id() = from.sensor.c_str();
  to.target_id() = from.target.c_str();
  to.sequence_number(from.sequence);
  to.epoch_ns(from.epoch.ns);
  to.range_m(from.measured.range_m);
  to.azimuth_rad(from.measured.azimuth_rad);
  to.elevation_rad(from.measured.elevation_rad);
  to.range_rate_m_s(from.range_rate_m_s);
  to.range_rate_valid(from.range_rate_valid);
  to.mode(same_number<wire::TrackMode>(from.mode));
  to.snr_db(from.snr_db);
  to.simulated(from.simulated);
}

Defect from_wire(const wire::RadarTspi& from, RadarTspi& to) {
  Check check;
  check.text("sensor_id", from.sensor_id().c_str(), to.sensor);
  check.text("target_id", from.target_id().c_str(), to.target);
  to.sequence = from.sequence_number();
  to.epoch.ns = from.epoch_ns();
  to.measured = {from.range_m(), from.azimuth_rad(), from.elevation_rad()};
  to.range_rate_m_s = from.range_rate_m_s();
  to.range_rate_valid = from.range_rate_valid();
  check.enumerator("mode", from.mode(), TrackMode::Coast, to.mode);
  to.snr_db = from.snr_db();
  to.simulated = from.simulated();
  return check.defect();
}

void to_wire(const AngleTspi& from, wire::AngleTspi& to) {
  to.sensor_id() = from.sensor.c_str();
  to.target_id() = from.target.c_str();
  to.sequence_number(from.sequence);
  to.epoch_ns(from.epoch.ns);
  to.azimuth_rad(from.azimuth_rad);
  to.elevation_rad(from.elevation_rad);
  to.mode(same_number<wire::TrackMode>(from.mode));
  to.simulated(from.simulated);
}

Defect from_wire(const wire::AngleTspi& from, AngleTspi& to) {
  Check check;
  check.text("sensor_id", from.sensor_id().c_str(), to.sensor);
  check.text("target_id", from.target_id().c_str(), to.target);
  to.sequence = from.sequence_number();
  to.epoch.ns = from.epoch_ns();
  to.azimuth_rad = from.azimuth_rad();
  to.elevation_rad = from.elevation_rad();
  check.enumerator("mode", from.mode(), TrackMode::Coast, to.mode);
  to.simulated = from.simulated();
  return check.defect();
}

void to_wire(const GpsFix& from, wire::GpsFix& to) {
  to.target_id() = from.target.c_str();
  to.station_id() = from.station.c_str();
  to.receiver_id() = from.receiver.c_str();
  to.sequence_number(from.sequence);
  to.epoch_ns(from.epoch.ns);
  copy(from.position.m, to.position_ecef_m());
  copy(from.velocity.m_s, to.velocity_ecef_m_s());
  to.velocity_valid(from.velocity_valid);
  to.sigma_horizontal_m(from.sigma_horizontal_m);
  to.sigma_vertical_m(from.sigma_vertical_m);
  to.sigma_velocity_m_s(from.sigma_velocity_m_s);
  to.fix(same_number<wire::FixType>(from.fix));
  to.satellites(from.satellites);
  to.satellites_stated(from.satellites_stated);
  to.simulated(from.simulated);
}

Defect from_wire(const wire::GpsFix& from, GpsFix& to) {
  Check check;
  check.text("target_id", from.target_id().c_str(), to.target);
  check.text("station_id", from.station_id().c_str(), to.station);
  check.text("receiver_id", from.receiver_id().c_str(), to.receiver);
  to.sequence = from.sequence_number();
  to.epoch.ns = from.epoch_ns();
  copy(from.position_ecef_m(), to.position.m);
  copy(from.velocity_ecef_m_s(), to.velocity.m_s);
  to.velocity_valid = from.velocity_valid();
  to.sigma_horizontal_m = from.sigma_horizontal_m();
  to.sigma_vertical_m = from.sigma_vertical_m();
  to.sigma_velocity_m_s = from.sigma_velocity_m_s();
  check.enumerator("fix", from.fix(), FixType::Differential, to.fix);
  to.satellites = from.satellites();
  to.satellites_stated = from.satellites_stated();
  to.simulated = from.simulated();
  return check.defect();
}

void to_wire(const MissionEvent& from, wire::MissionEvent& to) {
  to.mission_id() = from.mission.c_str();
  to.label() = from.label.c_str();
  to.kind(same_number<wire::MissionEventKind>(from.kind));
  to.sequence_number(from.sequence);
  to.epoch_ns(from.epoch.ns);
  to.simulated(from.simulated);
}

Defect from_wire(const wire::MissionEvent& from, MissionEvent& to) {
  Check check;
  check.text("mission_id", from.mission_id().c_str(), to.mission);
  check.text("label", from.label().c_str(), to.label);
  check.enumerator("kind", from.kind(), MissionEventKind::Mark, to.kind);
  to.sequence = from.sequence_number();
  to.epoch.ns = from.epoch_ns();
  to.simulated = from.simulated();
  return check.defect();
}

void to_wire(const Observation& from, wire::Observation& to) {
  to.sensor_id() = from.sensor.c_str();
  to.target_id() = from.target.c_str();
  to.receiver_id() = from.receiver.c_str();
  to.kind(same_number<wire::ObservationKind>(from.kind));
  to.verdict(same_number<wire::Reason>(from.verdict));
  to.sequence_number(from.sequence);
  to.step(from.step);
  to.epoch_ns(from.epoch.ns);
  to.received_ns(from.received.ns);
  to.range_m(from.measured.range_m);
  to.azimuth_rad(from.measured.azimuth_rad);
  to.elevation_rad(from.measured.elevation_rad);
  copy(from.position.m, to.position_ecef_m());
  copy(from.velocity.m_s, to.velocity_ecef_m_s());
  to.velocity_valid(from.velocity_valid);
  to.sigma_horizontal_m(from.sigma_horizontal_m);
  to.sigma_vertical_m(from.sigma_vertical_m);
  to.sigma_velocity_m_s(from.sigma_velocity_m_s);
  to.simulated(from.simulated);
}

Defect from_wire(const wire::Observation& from, Observation& to) {
  Check check;
  check.text("sensor_id", from.sensor_id().c_str(), to.sensor);
  check.text("target_id", from.target_id().c_str(), to.target);
  check.text("receiver_id", from.receiver_id().c_str(), to.receiver);
  check.enumerator("kind", from.kind(), ObservationKind::Angles, to.kind);
  check.enumerator("verdict", from.verdict(), Reason::AwayFromPad, to.verdict);
  to.sequence = from.sequence_number();
  to.step = from.step();
  to.epoch.ns = from.epoch_ns();
  to.received.ns = from.received_ns();
  to.measured = {from.range_m(), from.azimuth_rad(), from.elevation_rad()};
  copy(from.position_ecef_m(), to.position.m);
  copy(from.velocity_ecef_m_s(), to.velocity.m_s);
  to.velocity_valid = from.velocity_valid();
  to.sigma_horizontal_m = from.sigma_horizontal_m();
  to.sigma_vertical_m = from.sigma_vertical_m();
  to.sigma_velocity_m_s = from.sigma_velocity_m_s();
  to.simulated = from.simulated();
  return check.defect();
}

}  // namespace downrange::dds
