#include "dds/convert_field.hpp"

namespace downrange::dds {

static_assert(int(BiasTerm::TimeTag) == int(wire::BIAS_TIME_TAG));
static_assert(int(BiasState::Frozen) == int(wire::BIAS_FROZEN));
static_assert(int(BiasReference::CrossRadar) == int(wire::BIAS_REFERENCE_CROSS_RADAR));
static_assert(int(TrackQuality::Coasting) == int(wire::TRACK_COASTING));
static_assert(int(SlavingSource::Nominal) == int(wire::SLAVING_NOMINAL));
static_assert(int(IntegrityVerdict::Ambiguous) == int(wire::INTEGRITY_AMBIGUOUS));
static_assert(int(Finding::Impossible) == int(wire::FINDING_IMPOSSIBLE));
static_assert(int(Disqualification::Excluded) == int(wire::DISQUALIFICATION_EXCLUDED));
static_assert(int(ClockMode::Range) == int(wire::CLOCK_RANGE));

void to_wire(const SensorBias& from, Wire<SensorBias>& to) {
  to.sensor_id() = from.sensor.c_str();
  to.method() = from.method.c_str();
  to.epoch_ns(from.epoch.ns);
  to.received_ns(from.received.ns);
  to.reference(same_number<wire::BiasReference>(from.reference));
  to.samples(from.samples);
  to.terms(static_cast<std::uint8_t>(from.terms));
  for (std::size_t i = 0; i < from.term.size(); ++i) {
    to.term()[i] = same_number<wire::BiasTerm>(from.term[i]);
    to.state()[i] = same_number<wire::BiasState>(from.state[i]);
  }
  to.value() = from.value;
  to.covariance() = from.covariance;
}

Defect from_wire(const Wire<SensorBias>& from, SensorBias& to) {
  Check check;
  check.name("sensor_id", from.sensor_id().c_str(), to.sensor);
  check.name("method", from.method().c_str(), to.method);
  to.epoch.ns = from.epoch_ns();
  to.received.ns = from.received_ns();
  check.enumerator("reference", from.reference(), BiasReference::CrossRadar, to.reference);
  to.samples = from.samples();
  to.terms = from.terms();
  if (to.terms > max_bias_terms) check.fail("terms", "is " + std::to_string(to.terms));
  for (std::size_t i = 0; i < to.term.size(); ++i) {
    check.enumerator("term", from.term()[i], BiasTerm::TimeTag, to.term[i]);
    check.enumerator("state", from.state()[i], BiasState::Frozen, to.state[i]);
  }
  to.value = from.value();
  to.covariance = from.covariance();
  return check.defect();
}

void to_wire(const Trajectory& from, Wire<Trajectory>& to) {
  to.target_id() = from.target.c_str();
  to.method() = from.method.c_str();
  to.primary(from.primary);
  to.epoch_ns(from.epoch.ns);
  to.received_ns(from.received.ns);
  to.quality(same_number<wire::TrackQuality>(from.quality));
  to.state_size(static_cast<std::uint8_t>(from.state_size));
  to.state_ecef() = from.state;
  to.covariance() = from.covariance;
  to.latitude_rad(from.geodetic.latitude_rad);
  to.longitude_rad(from.geodetic.longitude_rad);
  to.height_m(from.geodetic.height_m);
  to.speed_m_s(from.speed_m_s);
  to.flight_path_rad(from.flight_path_rad);
  to.heading_rad(from.heading_rad);
  to.sources(from.sources);
  to.nis(from.nis);
  to.nis_dof(static_cast<std::uint8_t>(from.nis_dof));
  to.chain() = from.chain.c_str();
  to.bound_m(from.bound_m);
  to.bound_valid(from.bound_valid);
  to.deviation_m() = from.deviation_m;
  to.deviation_sigma_m() = from.deviation_sigma_m;
  to.deviation_valid(from.deviation_valid);
}

Defect from_wire(const Wire<Trajectory>& from, Trajectory& to) {
  Check check;
  check.name("target_id", from.target_id().c_str(), to.target);
  check.name("method", from.method().c_str(), to.method);
  to.primary = from.primary();
  to.epoch.ns = from.epoch_ns();
  to.received.ns = from.received_ns();
  check.enumerator("quality", from.quality(), TrackQuality::Coasting, to.quality);
  to.state_size = from.state_size();
  if (to.state_size != 6 && to.state_size != 9) check.fail("state_size", "is " + std::to_string(to.state_size));
  to.state = from.state_ecef();
  to.covariance = from.covariance();
  to.geodetic = {from.latitude_rad(), from.longitude_rad(), from.height_m()};
  to.speed_m_s = from.speed_m_s();
  to.flight_path_rad = from.flight_path_rad();
  to.heading_rad = from.heading_rad();
  to.sources = from.sources();
  to.nis = from.nis();
  to.nis_dof = from.nis_dof();
  check.text("chain", from.chain().c_str(), to.chain);
  to.bound_m = from.bound_m();
  to.bound_valid = from.bound_valid();
  to.deviation_m = from.deviation_m();
  to.deviation_sigma_m = from.deviation_sigma_m();
  to.deviation_valid = from.deviation_valid();
  return check.defect();
}

void to_wire(const Integrity& from, Wire<Integrity>& to) {
  to.target_id() = from.target.c_str();
  to.time_ns(from.time.ns);
  to.liftoff_ns(from.liftoff.ns);
  to.liftoff_valid(from.liftoff_valid);
  to.chain() = from.chain.c_str();
  to.held_by() = from.held_by.c_str();
  to.bound_m(from.bound_m);
  to.bound_valid(from.bound_valid);
  to.events(from.events);
  to.sources().resize(std::min(from.sources.size(), max_integrity_sources));
  for (std::size_t i = 0; i < to.sources().size(); ++i) {
    const SourceIntegrity& source = from.sources[i];
    wire::SourceIntegrityV3& out = to.sources()[i];
    out.sensor_id() = source.sensor.c_str();
    out.verdict(same_number<wire::IntegrityVerdict>(source.verdict));
    out.why(same_number<wire::IntegrityFinding>(source.why));
    out.since_ns(source.since.ns);
    out.onset_ns(source.onset.ns);
    out.test_value(source.test_value);
    out.against(source.against);
    out.apart_m(source.apart_m);
    out.agree_m(source.agree_m);
    out.by() = source.by.c_str();
  }
}

Defect from_wire(const Wire<Integrity>& from, Integrity& to) {
  Check check;
  check.name("target_id", from.target_id().c_str(), to.target);
  to.time.ns = from.time_ns();
  to.liftoff.ns = from.liftoff_ns();
  to.liftoff_valid = from.liftoff_valid();
  check.text("chain", from.chain().c_str(), to.chain);
  check.text("held_by", from.held_by().c_str(), to.held_by);
  to.bound_m = from.bound_m();
  to.bound_valid = from.bound_valid();
  to.events = from.events();
  to.sources.resize(from.sources().size());
  for (std::size_t i = 0; i < to.sources.size(); ++i) {
    const wire::SourceIntegrityV3& in = from.sources()[i];
    SourceIntegrity& source = to.sources[i];
    check.name("sensor_id", in.sensor_id().c_str(), source.sensor);
    check.enumerator("verdict", in.verdict(), IntegrityVerdict::Ambiguous, source.verdict);
    check.enumerator("why", in.why(), Finding::Impossible, source.why);
    source.since.ns = in.since_ns();
    source.onset.ns = in.onset_ns();
    source.test_value = in.test_value();
    source.against = in.against();
    source.apart_m = in.apart_m();
    source.agree_m = in.agree_m();
    check.text("by", in.by().c_str(), source.by);
  }
  return check.defect();
}

void to_wire(const SlavingCommand& from, Wire<SlavingCommand>& to) {
  to.antenna_id() = from.antenna.c_str();
  to.target_id() = from.target.c_str();
  to.tick_ns(from.tick.ns);
  to.apply_at_ns(from.apply_at.ns);
  to.valid_until_ns(from.valid_until.ns);
  to.data_epoch_ns(from.data_epoch.ns);
  to.age_s(from.age_s);
  to.azimuth_rad(from.azimuth_rad);
  to.elevation_rad(from.elevation_rad);
  to.range_m(from.range_m);
  to.azimuth_rate_rad_s(from.azimuth_rate_rad_s);
  to.elevation_rate_rad_s(from.elevation_rate_rad_s);
  to.range_rate_m_s(from.range_rate_m_s);
  to.sigma_azimuth_rad(from.sigma_azimuth_rad);
  to.sigma_elevation_rad(from.sigma_elevation_rad);
  to.source(same_number<wire::SlavingSource>(from.source));
  to.limits(from.limits);
  to.azimuth_acceleration_rad_s2(from.azimuth_acceleration_rad_s2);
  to.elevation_acceleration_rad_s2(from.elevation_acceleration_rad_s2);
  to.acceleration_valid(from.acceleration_valid);
  to.probability_in_beam(from.probability_in_beam);
  to.probability_valid(from.probability_valid);
  to.bound_rad(from.bound_rad);
  to.bound_valid(from.bound_valid);
  to.off_target_rad(from.off_target_rad);
  to.chain() = from.chain.c_str();
  to.mount_azimuth_rad(from.mount_azimuth_rad);
  to.mount_elevation_rad(from.mount_elevation_rad);
}

Defect from_wire(const Wire<SlavingCommand>& from, SlavingCommand& to) {
  Check check;
  check.name("antenna_id", from.antenna_id().c_str(), to.antenna);
  check.name("target_id", from.target_id().c_str(), to.target);
  to.tick.ns = from.tick_ns();
  to.apply_at.ns = from.apply_at_ns();
  to.valid_until.ns = from.valid_until_ns();
  to.data_epoch.ns = from.data_epoch_ns();
  to.age_s = from.age_s();
  to.azimuth_rad = from.azimuth_rad();
  to.elevation_rad = from.elevation_rad();
  to.range_m = from.range_m();
  to.azimuth_rate_rad_s = from.azimuth_rate_rad_s();
  to.elevation_rate_rad_s = from.elevation_rate_rad_s();
  to.range_rate_m_s = from.range_rate_m_s();
  to.sigma_azimuth_rad = from.sigma_azimuth_rad();
  to.sigma_elevation_rad = from.sigma_elevation_rad();
  check.enumerator("source", from.source(), SlavingSource::Nominal, to.source);
  to.limits = from.limits();
  to.azimuth_acceleration_rad_s2 = from.azimuth_acceleration_rad_s2();
  to.elevation_acceleration_rad_s2 = from.elevation_acceleration_rad_s2();
  to.acceleration_valid = from.acceleration_valid();
  to.probability_in_beam = from.probability_in_beam();
  to.probability_valid = from.probability_valid();
  to.bound_rad = from.bound_rad();
  to.bound_valid = from.bound_valid();
  to.off_target_rad = from.off_target_rad();
  check.text("chain", from.chain().c_str(), to.chain);
  to.mount_azimuth_rad = from.mount_azimuth_rad();
  to.mount_elevation_rad = from.mount_elevation_rad();
  return check.defect();
}

void to_wire(const AntennaAccount& from, Wire<AntennaAccount>& to) {
  to.antenna_id() = from.antenna.c_str();
  to.target_id() = from.target.c_str();
  to.tick_ns(from.tick.ns);
  to.basis(same_number<wire::PassBasis>(from.basis));
  to.in_view(from.in_view);
  to.acquisition_valid(from.acquisition_valid);
  to.acquisition_ns(from.acquisition.ns);
  to.acquisition_azimuth_rad(from.acquisition_azimuth_rad);
  to.loss_valid(from.loss_valid);
  to.loss_ns(from.loss.ns);
  to.loss_azimuth_rad(from.loss_azimuth_rad);
  to.highest_valid(from.highest_valid);
  to.highest_elevation_rad(from.highest_elevation_rad);
  to.highest_ns(from.highest.ns);
  to.orders() = from.orders.c_str();
  to.pass_valid(from.pass_valid);
}

Defect from_wire(const Wire<AntennaAccount>& from, AntennaAccount& to) {
  Check check;
  check.name("antenna_id", from.antenna_id().c_str(), to.antenna);
  check.name("target_id", from.target_id().c_str(), to.target);
  to.tick.ns = from.tick_ns();
  check.enumerator("basis", from.basis(), PassBasis::PlannedLiftoff, to.basis);
  to.in_view = from.in_view();
  to.acquisition_valid = from.acquisition_valid();
  to.acquisition.ns = from.acquisition_ns();
  to.acquisition_azimuth_rad = from.acquisition_azimuth_rad();
  to.loss_valid = from.loss_valid();
  to.loss.ns = from.loss_ns();
  to.loss_azimuth_rad = from.loss_azimuth_rad();
  to.highest_valid = from.highest_valid();
  to.highest_elevation_rad = from.highest_elevation_rad();
  to.highest.ns = from.highest_ns();
  check.text("orders", from.orders().c_str(), to.orders);
  to.pass_valid = from.pass_valid();
  return check.defect();
}

void to_wire(const ImpactPoint& from, Wire<ImpactPoint>& to) {
  to.target_id() = from.target.c_str();
  to.chain() = from.chain.c_str();
  to.epoch_ns(from.epoch.ns);
  to.received_ns(from.received.ns);
  to.impact_valid(from.impact_valid);
  to.latitude_rad(from.point.latitude_rad);
  to.longitude_rad(from.point.longitude_rad);
  to.height_m(from.point.height_m);
  to.time_to_impact_s(from.time_to_impact_s);
  to.covariance_m2() = from.covariance_m2;
  to.data_age_s(from.data_age_s);
  to.data_loss_timer_s(from.data_loss_timer_s);
  to.data_loss_limit_s(from.data_loss_limit_s);
  to.data_loss_limit_valid(from.data_loss_limit_valid);
  to.boundaries().resize(std::min(from.boundaries.size(), max_boundaries));
  for (std::size_t i = 0; i < to.boundaries().size(); ++i) {
    const BoundaryDistance& boundary = from.boundaries[i];
    wire::BoundaryV3& out = to.boundaries()[i];
    out.boundary_id() = boundary.boundary.c_str();
    out.distance_m(boundary.distance_m);
    out.present_distance_m(boundary.present_distance_m);
    out.time_s(boundary.time_s);
    out.time_valid(boundary.time_valid);
    out.probability_outside(boundary.probability_outside);
  }
}

Defect from_wire(const Wire<ImpactPoint>& from, ImpactPoint& to) {
  Check check;
  check.name("target_id", from.target_id().c_str(), to.target);
  check.text("chain", from.chain().c_str(), to.chain);
  to.epoch.ns = from.epoch_ns();
  to.received.ns = from.received_ns();
  to.impact_valid = from.impact_valid();
  to.point = {from.latitude_rad(), from.longitude_rad(), from.height_m()};
  to.time_to_impact_s = from.time_to_impact_s();
  to.covariance_m2 = from.covariance_m2();
  to.data_age_s = from.data_age_s();
  to.data_loss_timer_s = from.data_loss_timer_s();
  to.data_loss_limit_s = from.data_loss_limit_s();
  to.data_loss_limit_valid = from.data_loss_limit_valid();
  to.boundaries.resize(from.boundaries().size());
  for (std::size_t i = 0; i < to.boundaries.size(); ++i) {
    const wire::BoundaryV3& in = from.boundaries()[i];
    BoundaryDistance& boundary = to.boundaries[i];
    check.name("boundary_id", in.boundary_id().c_str(), boundary.boundary);
    boundary.distance_m = in.distance_m();
    boundary.present_distance_m = in.present_distance_m();
    boundary.time_s = in.time_s();
    boundary.time_valid = in.time_valid();
    boundary.probability_outside = in.probability_outside();
  }
  return check.defect();
}

void to_wire(const SourceHealth& from, Wire<SourceHealth>& to) {
  to.sensor_id() = from.sensor.c_str();
  to.target_id() = from.target.c_str();
  to.time_ns(from.time.ns);
  to.rate_hz(from.rate_hz);
  to.latency_s(from.latency_s);
  static_assert(reason_count <= std::tuple_size_v<std::remove_reference_t<decltype(to.counts())>>);
  to.reasons(static_cast<std::uint8_t>(reason_count));
  for (std::size_t i = 0; i < reason_count; ++i) {
    to.counts()[i].reason(static_cast<std::uint8_t>(i));
    to.counts()[i].count(from.count[i]);
  }
  to.residual_mean(from.residual_mean);
  to.residual_sigma(from.residual_sigma);
  to.residual_m(from.residual_m);
  to.expected_m(from.expected_m);
  to.residual_rad(from.residual_rad);
  to.expected_rad(from.expected_rad);
  to.sigma_ratio(from.sigma_ratio);
  to.nis(from.nis);
  to.figure_of_merit(figure_of_merit(from));
  to.qualified(from.qualified);
  to.why(same_number<wire::Disqualification>(from.why));
  to.rejected_for(static_cast<std::uint8_t>(from.rejected_for));
  to.nis_inside_95(from.nis_inside_95);
  to.nis_count(static_cast<std::uint32_t>(from.nis_count));
  to.mismatch(from.mismatch);
  to.suspect(from.suspect);
  to.forced(from.forced);
  to.since_ns(from.since.ns);
  to.by() = from.by.c_str();
  to.reason() = from.reason.c_str();
  to.acknowledged_by() = from.acknowledged_by.c_str();
}

Defect from_wire(const Wire<SourceHealth>& from, SourceHealth& to) {
  Check check;
  check.name("sensor_id", from.sensor_id().c_str(), to.sensor);
  check.text("target_id", from.target_id().c_str(), to.target);
  to.time.ns = from.time_ns();
  to.rate_hz = from.rate_hz();
  to.latency_s = from.latency_s();
  const std::size_t reasons = from.reasons();
  if (reasons > from.counts().size()) check.fail("reasons", "is " + std::to_string(reasons));
  to.count = {};
  for (std::size_t i = 0; i < std::min(reasons, from.counts().size()); ++i) {
    const std::size_t reason = from.counts()[i].reason();
    if (reason < reason_count) to.count[reason] = from.counts()[i].count();
  }
  to.residual_mean = from.residual_mean();
  to.residual_sigma = from.residual_sigma();
  to.residual_m = from.residual_m();
  to.expected_m = from.expected_m();
  to.residual_rad = from.residual_rad();
  to.expected_rad = from.expected_rad();
  to.sigma_ratio = from.sigma_ratio();
  to.nis = from.nis();
  to.qualified = from.qualified();
  check.enumerator("why", from.why(), Disqualification::Excluded, to.why);
  check.enumerator("rejected_for", from.rejected_for(), static_cast<Reason>(reason_count - 1), to.rejected_for);
  to.nis_inside_95 = from.nis_inside_95();
  to.nis_count = static_cast<int>(from.nis_count());
  to.mismatch = from.mismatch();
  to.suspect = from.suspect();
  to.forced = from.forced();
  to.since.ns = from.since_ns();
  check.text("by", from.by().c_str(), to.by);
  check.text("reason", from.reason().c_str(), to.reason);
  check.text("acknowledged_by", from.acknowledged_by().c_str(), to.acknowledged_by);
  return check.defect();
}

void to_wire(const ServiceStatus& from, wire::ServiceStatusV4& to) {
  to.node_id() = from.node.c_str();
  to.stages(static_cast<std::uint8_t>((from.stages.ingest ? 1U : 0U) | (from.stages.align ? 2U : 0U) |
                                      (from.stages.fuse ? 4U : 0U) | (from.stages.slave ? 8U : 0U)));
  to.role() = std::string(role_of(from.stages));
  to.ownership(wire::OWNERSHIP_UNKNOWN);
  to.version() = from.version;
  to.configuration_hash() = from.configuration_hash;
  to.clock(same_number<wire::ClockMode>(from.clock));
  to.time_ns(from.time.ns);
  to.last_tick_ns(from.last_tick.ns);
  to.queue_depth(from.queue_depth);
  to.consumed(from.consumed);
  to.emitted(from.emitted);
  to.consumed_per_s(from.consumed_per_s);
  to.emitted_per_s(from.emitted_per_s);
  to.dropped(from.dropped);
  to.write_failures(from.write_failures);
  to.latency_p50_us(from.latency_us[0]);
  to.latency_p95_us(from.latency_us[1]);
  to.latency_p99_us(from.latency_us[2]);
  to.latency_max_us(from.latency_us[3]);
  to.archive_state() = from.archive_state;
  to.state() = from.state;
  to.mismatch() = from.mismatch;
  to.utc_known(from.utc.known);
  to.utc_synchronised(from.utc.synchronised);
  to.utc_offset_s(from.utc.offset_s);
  to.utc_error_s(from.utc.error_s);
  const std::size_t acknowledged = std::min(from.acknowledgements.size(), to.acknowledgements().size());
  to.acknowledged(static_cast<std::uint8_t>(acknowledged));
  for (std::size_t i = 0; i < acknowledged; ++i) {
    const Acknowledgement& acknowledgement = from.acknowledgements[i];
    wire::AcknowledgementV3& out = to.acknowledgements()[i];
    out.topic(static_cast<wire::InputTopic>(acknowledgement.topic));
    out.sender_id() = acknowledgement.sender.c_str();
    out.sequence_number(acknowledgement.sequence);
    out.refusal() = acknowledgement.refusal.c_str();
  }
}

Defect from_wire(const wire::ServiceStatusV4& from, ServiceStatus& to) {
  Check check;
  check.name("node_id", from.node_id().c_str(), to.node);
  const unsigned stages = from.stages();
  to.stages = {(stages & 1U) != 0, (stages & 2U) != 0, (stages & 4U) != 0, (stages & 8U) != 0};
  to.version = from.version().to_string();
  to.configuration_hash = from.configuration_hash().to_string();
  check.enumerator("clock", from.clock(), ClockMode::Range, to.clock);
  to.time.ns = from.time_ns();
  to.last_tick.ns = from.last_tick_ns();
  to.queue_depth = from.queue_depth();
  to.consumed = from.consumed();
  to.emitted = from.emitted();
  to.consumed_per_s = from.consumed_per_s();
  to.emitted_per_s = from.emitted_per_s();
  to.dropped = from.dropped();
  to.write_failures = from.write_failures();
  to.latency_us = {from.latency_p50_us(), from.latency_p95_us(), from.latency_p99_us(), from.latency_max_us()};
  to.archive_state = from.archive_state().to_string();
  to.state = from.state().to_string();
  to.mismatch = from.mismatch().to_string();
  to.utc = {from.utc_known(), from.utc_synchronised(), from.utc_offset_s(), from.utc_error_s()};
  const std::size_t acknowledged = from.acknowledged();
  if (acknowledged > from.acknowledgements().size()) check.fail("acknowledged", "is " + std::to_string(acknowledged));
  to.acknowledgements.resize(std::min(acknowledged, from.acknowledgements().size()));
  for (std::size_t i = 0; i < to.acknowledgements.size(); ++i) {
    const wire::AcknowledgementV3& in = from.acknowledgements()[i];
    Acknowledgement& acknowledgement = to.acknowledgements[i];
    check.enumerator("topic", in.topic(), Inputs::size - 1, acknowledgement.topic);
    check.text("sender_id", in.sender_id().c_str(), acknowledgement.sender);
    acknowledgement.sequence = in.sequence_number();
    check.text("refusal", in.refusal().c_str(), acknowledgement.refusal);
  }
  return check.defect();
}

}  // namespace downrange::dds
