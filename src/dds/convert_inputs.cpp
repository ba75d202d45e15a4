#include "dds/convert_field.hpp"

namespace downrange::dds {

// Empty and unknown names are no defect of an input: ingest rejects them with a reason, in-process and over DDS alike.

static_assert(int(TrackMode::Slaved) == int(wire::TRACK_MODE_SLAVED));
static_assert(int(FixType::Differential) == int(wire::FIX_TYPE_DIFFERENTIAL));
static_assert(int(MissionEventKind::Recycle) == int(wire::MISSION_RECYCLE));
static_assert(int(AntennaMode::Autotrack) == int(wire::ANTENNA_AUTOTRACK));
static_assert(int(OperatorOrder::AcknowledgeAlarm) == int(wire::ORDER_ACKNOWLEDGE_ALARM));
static_assert(std::variant_size_v<Measured> == wire::OBSERVATION_ANGLES + 1);
static_assert(reason_count == wire::REASON_INHIBITED + 1);

void to_wire(const RangeStamp& from, wire::RangeStamp& to) {
  to.run_id(from.run_id);
  to.sequence_number(from.sequence);
}

RangeStamp from_wire(const wire::RangeStamp& from) { return {from.run_id(), from.sequence_number()}; }

void to_wire(const RadarTspi& from, Wire<RadarTspi>& to) {
  to.sensor_id() = from.sensor.c_str();
  to.target_id() = from.target.c_str();
  to.sequence_number(from.sequence);
  to.epoch_ns(from.epoch.ns);
  to.range_m(from.measured.range_m);
  to.azimuth_rad(from.measured.azimuth_rad);
  to.elevation_rad(from.measured.elevation_rad);
  to.range_valid(from.range_valid);
  to.azimuth_valid(from.azimuth_valid);
  to.elevation_valid(from.elevation_valid);
  to.range_rate_m_s(from.range_rate_m_s);
  to.range_rate_valid(from.range_rate_valid);
  to.mode(same_number<wire::TrackMode>(from.mode));
  to.snr_db(from.snr_db);
  to.snr_valid(from.snr_valid);
  to.simulated(from.simulated);
}

Defect from_wire(const Wire<RadarTspi>& from, RadarTspi& to) {
  Check check;
  check.text("sensor_id", from.sensor_id().c_str(), to.sensor);
  check.text("target_id", from.target_id().c_str(), to.target);
  to.sequence = from.sequence_number();
  to.epoch.ns = from.epoch_ns();
  to.measured = {from.range_m(), from.azimuth_rad(), from.elevation_rad()};
  to.range_valid = from.range_valid();
  to.azimuth_valid = from.azimuth_valid();
  to.elevation_valid = from.elevation_valid();
  to.range_rate_m_s = from.range_rate_m_s();
  to.range_rate_valid = from.range_rate_valid();
  check.enumerator("mode", from.mode(), TrackMode::Slaved, to.mode);
  to.snr_db = from.snr_db();
  to.snr_valid = from.snr_valid();
  to.simulated = from.simulated();
  return check.defect();
}

void to_wire(const AngleTspi& from, Wire<AngleTspi>& to) {
  to.sensor_id() = from.sensor.c_str();
  to.target_id() = from.target.c_str();
  to.sequence_number(from.sequence);
  to.epoch_ns(from.epoch.ns);
  to.azimuth_rad(from.azimuth_rad);
  to.elevation_rad(from.elevation_rad);
  to.azimuth_valid(from.azimuth_valid);
  to.elevation_valid(from.elevation_valid);
  to.mode(same_number<wire::TrackMode>(from.mode));
  to.simulated(from.simulated);
}

Defect from_wire(const Wire<AngleTspi>& from, AngleTspi& to) {
  Check check;
  check.text("sensor_id", from.sensor_id().c_str(), to.sensor);
  check.text("target_id", from.target_id().c_str(), to.target);
  to.sequence = from.sequence_number();
  to.epoch.ns = from.epoch_ns();
  to.azimuth_rad = from.azimuth_rad();
  to.elevation_rad = from.elevation_rad();
  to.azimuth_valid = from.azimuth_valid();
  to.elevation_valid = from.elevation_valid();
  check.enumerator("mode", from.mode(), TrackMode::Slaved, to.mode);
  to.simulated = from.simulated();
  return check.defect();
}

void to_wire(const GpsFix& from, Wire<GpsFix>& to) {
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
  to.satellites_valid(from.satellites_valid);
  to.simulated(from.simulated);
}

Defect from_wire(const Wire<GpsFix>& from, GpsFix& to) {
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
  to.satellites_valid = from.satellites_valid();
  to.simulated = from.simulated();
  return check.defect();
}

void to_wire(const MissionEvent& from, Wire<MissionEvent>& to) {
  to.mission_id() = from.mission.c_str();
  to.label() = from.label.c_str();
  to.kind(same_number<wire::MissionEventKind>(from.kind));
  to.sequence_number(from.sequence);
  to.epoch_ns(from.epoch.ns);
  to.simulated(from.simulated);
}

Defect from_wire(const Wire<MissionEvent>& from, MissionEvent& to) {
  Check check;
  check.text("mission_id", from.mission_id().c_str(), to.mission);
  check.text("label", from.label().c_str(), to.label);
  check.enumerator("kind", from.kind(), MissionEventKind::Recycle, to.kind);
  to.sequence = from.sequence_number();
  to.epoch.ns = from.epoch_ns();
  to.simulated = from.simulated();
  return check.defect();
}

void to_wire(const OperatorCommand& from, Wire<OperatorCommand>& to) {
  to.operator_id() = from.operator_id.c_str();
  to.order(same_number<wire::OperatorOrder>(from.order));
  to.subject_id() = from.subject.c_str();
  to.argument_id() = from.argument.c_str();
  to.azimuth_trim_rad(from.azimuth_trim_rad);
  to.elevation_trim_rad(from.elevation_trim_rad);
  to.reason() = from.reason.c_str();
  to.sequence_number(from.sequence);
  to.epoch_ns(from.epoch.ns);
  to.simulated(from.simulated);
}

Defect from_wire(const Wire<OperatorCommand>& from, OperatorCommand& to) {
  Check check;
  check.text("operator_id", from.operator_id().c_str(), to.operator_id);
  check.enumerator("order", from.order(), OperatorOrder::AcknowledgeAlarm, to.order);
  check.text("subject_id", from.subject_id().c_str(), to.subject);
  check.text("argument_id", from.argument_id().c_str(), to.argument);
  to.azimuth_trim_rad = from.azimuth_trim_rad();
  to.elevation_trim_rad = from.elevation_trim_rad();
  check.text("reason", from.reason().c_str(), to.reason);
  to.sequence = from.sequence_number();
  to.epoch.ns = from.epoch_ns();
  to.simulated = from.simulated();
  return check.defect();
}

void to_wire(const AntennaReport& from, Wire<AntennaReport>& to) {
  to.antenna_id() = from.antenna.c_str();
  to.sequence_number(from.sequence);
  to.epoch_ns(from.epoch.ns);
  to.azimuth_rad(from.azimuth_rad);
  to.elevation_rad(from.elevation_rad);
  to.azimuth_valid(from.azimuth_valid);
  to.elevation_valid(from.elevation_valid);
  to.mode(same_number<wire::AntennaMode>(from.mode));
  to.command_tick_ns(from.command_tick.ns);
  to.simulated(from.simulated);
}

Defect from_wire(const Wire<AntennaReport>& from, AntennaReport& to) {
  Check check;
  check.text("antenna_id", from.antenna_id().c_str(), to.antenna);
  to.sequence = from.sequence_number();
  to.epoch.ns = from.epoch_ns();
  to.azimuth_rad = from.azimuth_rad();
  to.elevation_rad = from.elevation_rad();
  to.azimuth_valid = from.azimuth_valid();
  to.elevation_valid = from.elevation_valid();
  check.enumerator("mode", from.mode(), AntennaMode::Autotrack, to.mode);
  to.command_tick.ns = from.command_tick_ns();
  to.simulated = from.simulated();
  return check.defect();
}

void to_wire(const PlatformState& from, Wire<PlatformState>& to) {
  to.antenna_id() = from.antenna.c_str();
  to.sequence_number(from.sequence);
  to.epoch_ns(from.epoch.ns);
  copy(from.position.m, to.position_ecef_m());
  copy(from.velocity.m_s, to.velocity_ecef_m_s());
  to.velocity_valid(from.velocity_valid);
  to.heading_rad(from.heading_rad);
  to.sigma_position_m(from.sigma_position_m);
  to.sigma_heading_rad(from.sigma_heading_rad);
  to.simulated(from.simulated);
}

Defect from_wire(const Wire<PlatformState>& from, PlatformState& to) {
  Check check;
  check.text("antenna_id", from.antenna_id().c_str(), to.antenna);
  to.sequence = from.sequence_number();
  to.epoch.ns = from.epoch_ns();
  copy(from.position_ecef_m(), to.position.m);
  copy(from.velocity_ecef_m_s(), to.velocity.m_s);
  to.velocity_valid = from.velocity_valid();
  to.heading_rad = from.heading_rad();
  to.sigma_position_m = from.sigma_position_m();
  to.sigma_heading_rad = from.sigma_heading_rad();
  to.simulated = from.simulated();
  return check.defect();
}

namespace {

void plot_to_wire(const Plot& from, Wire<Observation>& to) {
  to.range_m(from.measured.range_m);
  to.azimuth_rad(from.measured.azimuth_rad);
  to.elevation_rad(from.measured.elevation_rad);
  to.range_valid(from.range_valid);
  to.angles_valid(from.angles_valid);
  to.range_rate_m_s(from.range_rate_m_s);
  to.range_rate_valid(from.range_rate_valid);
  to.snr_db(from.snr_db);
  to.snr_valid(from.snr_valid);
}
void fix_to_wire(const Fix& from, Wire<Observation>& to) {
  copy(from.position.m, to.position_ecef_m());
  copy(from.velocity.m_s, to.velocity_ecef_m_s());
  to.velocity_valid(from.velocity_valid);
  to.sigma_horizontal_m(from.sigma_horizontal_m);
  to.sigma_vertical_m(from.sigma_vertical_m);
  to.sigma_velocity_m_s(from.sigma_velocity_m_s);
}

/// What the wire says of a plot where the measurement is none.
Plot plot_members(const Measured& measured) {
  if (const auto* plot = std::get_if<Plot>(&measured)) return *plot;
  const auto* angles = std::get_if<Angles>(&measured);
  Plot plot;
  plot.range_valid = false;
  plot.angles_valid = angles != nullptr;
  if (angles != nullptr) plot.measured = {0, angles->azimuth_rad, angles->elevation_rad};
  return plot;
}

Measured measured_from_wire(const Wire<Observation>& from) {
  switch (from.kind()) {
    case wire::OBSERVATION_RADAR:
      return Plot{.measured = {from.range_m(), from.azimuth_rad(), from.elevation_rad()},
                  .range_valid = from.range_valid(),
                  .angles_valid = from.angles_valid(),
                  .range_rate_m_s = from.range_rate_m_s(),
                  .range_rate_valid = from.range_rate_valid(),
                  .snr_db = from.snr_db(),
                  .snr_valid = from.snr_valid()};
    case wire::OBSERVATION_ANGLES:
      return Angles{.azimuth_rad = from.azimuth_rad(), .elevation_rad = from.elevation_rad()};
    case wire::OBSERVATION_GPS:
      break;
  }
  Fix fix;
  copy(from.position_ecef_m(), fix.position.m);
  copy(from.velocity_ecef_m_s(), fix.velocity.m_s);
  fix.velocity_valid = from.velocity_valid();
  fix.sigma_horizontal_m = from.sigma_horizontal_m();
  fix.sigma_vertical_m = from.sigma_vertical_m();
  fix.sigma_velocity_m_s = from.sigma_velocity_m_s();
  return fix;
}

}  // namespace

void to_wire(const Observation& from, Wire<Observation>& to) {
  to.sensor_id() = from.sensor.c_str();
  to.target_id() = from.target.c_str();
  to.receiver_id() = from.receiver.c_str();
  to.kind(same_number<wire::ObservationKind>(from.measured.index()));
  to.verdict(static_cast<std::uint8_t>(from.verdict));
  to.sequence_number(from.sequence);
  to.step(from.step);
  to.epoch_ns(from.epoch.ns);
  to.received_ns(from.received.ns);
  plot_to_wire(plot_members(from.measured), to);
  const auto* fix = std::get_if<Fix>(&from.measured);
  fix_to_wire(fix != nullptr ? *fix : Fix{}, to);
  to.simulated(from.simulated);
}

Defect from_wire(const Wire<Observation>& from, Observation& to) {
  Check check;
  check.text("sensor_id", from.sensor_id().c_str(), to.sensor);
  check.text("target_id", from.target_id().c_str(), to.target);
  check.text("receiver_id", from.receiver_id().c_str(), to.receiver);
  if (static_cast<std::uint32_t>(from.kind()) >= std::variant_size_v<Measured>)
    check.fail("kind", "holds enumerator " + std::to_string(static_cast<std::uint32_t>(from.kind())));
  check.enumerator("verdict", from.verdict(), static_cast<Reason>(reason_count - 1), to.verdict);
  to.sequence = from.sequence_number();
  to.step = from.step();
  to.epoch.ns = from.epoch_ns();
  to.received.ns = from.received_ns();
  to.measured = measured_from_wire(from);
  to.simulated = from.simulated();
  return check.defect();
}

}  // namespace downrange::dds
