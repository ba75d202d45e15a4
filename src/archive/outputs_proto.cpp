/// What the engine makes (for antennas: antenna_proto.cpp), and the archive's own records.

#include <archive/proto_field.hpp>

namespace downrange::archive {

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
  copy_array(in.value(), out.terms, out.value, "value", defect);
  copy_array(in.covariance(), triangle_size(out.terms), out.covariance, "covariance", defect);
  return out;
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
  copy_array(in.state(), out.state_size, out.state, "state", defect);
  copy_array(in.covariance(), triangle_size(out.state_size), out.covariance, "covariance", defect);
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
    copy_array(in.deviation_m(), 3, out.deviation_m, "deviation_m", defect);
    copy_array(in.deviation_sigma_m(), 3, out.deviation_sigma_m, "deviation_sigma_m", defect);
  }
  return out;
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

void to_proto(const ImpactPoint& in, record::ImpactPoint& out) {
  out.Clear();  // keeps the memory of its fields
  put(in.target, out.mutable_target());
  put(in.chain, out.mutable_chain());
  out.set_epoch_ns(in.epoch.ns);
  out.set_received_ns(in.received.ns);
  out.set_impact_valid(in.impact_valid);
  out.set_latitude_rad(in.point.latitude_rad);
  out.set_longitude_rad(in.point.longitude_rad);
  out.set_height_m(in.point.height_m);
  out.set_time_to_impact_s(in.time_to_impact_s);
  put_first(in.covariance_m2, 3, out.mutable_covariance_m2());
  out.set_data_age_s(in.data_age_s);
  out.set_data_loss_timer_s(in.data_loss_timer_s);
  out.set_data_loss_limit_s(in.data_loss_limit_s);
  out.set_data_loss_limit_valid(in.data_loss_limit_valid);
  for (const BoundaryDistance& boundary : in.boundaries) {
    put(boundary.boundary, out.add_boundary());
    out.add_distance_m(boundary.distance_m);
    out.add_present_distance_m(boundary.present_distance_m);
    out.add_time_s(boundary.time_s);
    out.add_time_valid(boundary.time_valid);
    out.add_probability_outside(boundary.probability_outside);
  }
}

ImpactPoint from_proto(const record::ImpactPoint& in, Defect& defect) {
  ImpactPoint out;
  out.target = name(in.target(), "target", defect);
  out.chain = name(in.chain(), "chain", defect);
  out.epoch = {in.epoch_ns()};
  out.received = {in.received_ns()};
  out.impact_valid = in.impact_valid();
  out.point = {in.latitude_rad(), in.longitude_rad(), in.height_m()};
  out.time_to_impact_s = in.time_to_impact_s();
  copy_array(in.covariance_m2(), 3, out.covariance_m2, "covariance_m2", defect);
  out.data_age_s = in.data_age_s();
  out.data_loss_timer_s = in.data_loss_timer_s();
  out.data_loss_limit_s = in.data_loss_limit_s();
  out.data_loss_limit_valid = in.data_loss_limit_valid();
  const int boundaries = in.boundary_size();
  for (const int size : {in.distance_m_size(), in.present_distance_m_size(), in.time_s_size(), in.time_valid_size(),
                         in.probability_outside_size()}) {
    if (size == boundaries) continue;
    fault(defect, "boundary: " + std::to_string(boundaries) + " boundaries, of which another field has " +
                      std::to_string(size));
    return out;
  }
  for (int i = 0; i < boundaries; ++i) {
    out.boundaries.push_back({.boundary = name(in.boundary(i), "boundary", defect),
                              .distance_m = in.distance_m(i),
                              .present_distance_m = in.present_distance_m(i),
                              .time_s = in.time_s(i),
                              .time_valid = in.time_valid(i),
                              .probability_outside = in.probability_outside(i)});
  }
  return out;
}

void to_proto(const SourceHealth& in, record::SourceHealth& out) {
  put(in.sensor, out.mutable_sensor());
  put(in.target, out.mutable_target());
  out.set_time_ns(in.time.ns);
  out.set_rate_hz(in.rate_hz);
  out.set_latency_s(in.latency_s);
  out.clear_counts();
  for (std::size_t i = 0; i < reason_count; ++i) {
    if (in.count[i] == 0) continue;
    record::ReasonCount& counted = *out.add_counts();
    counted.set_reason(static_cast<record::Reason>(i));
    counted.set_count(in.count[i]);
  }
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
  put_first(in.sigma_ratio, static_cast<int>(in.sigma_ratio.size()), out.mutable_sigma_ratio());
  out.set_suspect(in.suspect);
  out.set_forced(in.forced);
  out.set_since_ns(in.since.ns);
  put(in.by, out.mutable_by());
  put(in.reason, out.mutable_reason());
  put(in.acknowledged_by, out.mutable_acknowledged_by());
}

SourceHealth from_proto(const record::SourceHealth& in, Defect& defect) {
  SourceHealth out;
  out.sensor = name(in.sensor(), "sensor", defect);
  out.target = name(in.target(), "target", defect);
  out.time = {in.time_ns()};
  out.rate_hz = in.rate_hz();
  out.latency_s = in.latency_s();
  for (const record::ReasonCount& counted : in.counts()) {
    const auto reason = static_cast<std::size_t>(counted.reason());
    if (reason < reason_count) out.count[reason] = counted.count();  // else of a newer program
  }
  // Of an older archive, with fewer counts than there are reasons now.
  copy_array(in.count(), std::min(in.count_size(), static_cast<int>(reason_count)), out.count, "count", defect);
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
  // None: an archive older than the field.
  copy_array(in.sigma_ratio(), in.sigma_ratio_size(), out.sigma_ratio, "sigma_ratio", defect);
  out.suspect = in.suspect();
  out.forced = in.forced();
  out.since = {in.since_ns()};
  out.by = name(in.by(), "by", defect);
  out.reason = name<Remark>(in.reason(), "reason", defect);
  out.acknowledged_by = name(in.acknowledged_by(), "acknowledged_by", defect);
  return out;
}

void to_proto(const LastTick& in, record::LastTick& out) { out.set_tick_ns(in.tick.ns); }

LastTick from_proto(const record::LastTick& in, Defect&) { return {{in.tick_ns()}}; }

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
