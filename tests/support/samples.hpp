#pragma once
/// One of every message of the catalogue, each field set to a value of its own: what was forgotten on the way shows.

#include <downrange/stage/catalogue.hpp>

namespace downrange::test {

/// A message that is not specialised here does not link.
template <class Record>
[[nodiscard]] Record sample();

template <>
inline RadarTspi sample<RadarTspi>() {
  RadarTspi plot;
  plot.sensor = "goheung-radar";
  plot.target = "a-name-of-thirty-one-characters";
  plot.sequence = 7;
  plot.epoch = {1'700'000'000'123'456'789};
  plot.received = {1'700'000'000'200'000'000};
  plot.measured = {123456.789, 6.28, -0.01};
  plot.range_rate_m_s = -4321.5;
  plot.range_rate_valid = true;
  plot.range_valid = false;
  plot.azimuth_valid = true;
  plot.elevation_valid = false;
  plot.mode = TrackMode::Coast;
  plot.snr_db = 12.25;
  plot.snr_valid = true;
  plot.simulated = true;
  return plot;
}

template <>
inline AngleTspi sample<AngleTspi>() {
  AngleTspi angles;
  angles.sensor = "goheung-optical";
  angles.target = "a-name-of-thirty-one-characters";
  angles.sequence = 6;
  angles.epoch = {1'700'000'000'987'654'321};
  angles.received = {1'700'000'001'200'000'000};
  angles.azimuth_rad = 5.5;
  angles.elevation_rad = 1.5;
  angles.azimuth_valid = false;
  angles.mode = TrackMode::Acquire;
  angles.simulated = true;
  return angles;
}

template <>
inline GpsFix sample<GpsFix>() {
  GpsFix fix;
  fix.target = "kslv";
  fix.receiver = "rx1";
  fix.station = "jeju-tm";
  fix.sequence = 8;
  fix.epoch = {-5};
  fix.received = {6};
  fix.position.m = {-3.1e6, 4.2e6, 3.3e6};
  fix.velocity.m_s = {1, -2, 3};
  fix.velocity_valid = true;
  fix.sigma_horizontal_m = 1.5;
  fix.sigma_vertical_m = 2.5;
  fix.sigma_velocity_m_s = 0.125;
  fix.fix = FixType::Differential;
  fix.satellites = 11;
  fix.satellites_valid = true;
  fix.simulated = true;
  return fix;
}

template <>
inline MissionEvent sample<MissionEvent>() {
  MissionEvent mark;
  mark.mission = "flight-3";
  mark.label = "second stage";
  mark.kind = MissionEventKind::Staging;
  mark.sequence = 9;
  mark.epoch = {42};
  mark.received = {43};
  mark.simulated = true;
  return mark;
}

template <>
inline OperatorCommand sample<OperatorCommand>() {
  OperatorCommand command;
  command.operator_id = "kim";
  command.order = OperatorOrder::TrimAntenna;
  command.subject = "jeju-antenna";
  command.argument = "without-goheung";
  command.azimuth_trim_rad = 0.001;
  command.elevation_trim_rad = -0.002;
  command.reason = "boresight camera shows the target low and to the left, agreed with flight safety at T+120";
  command.sequence = 11;
  command.epoch = {1'700'000'000'000'000'001};
  command.received = {1'700'000'000'000'000'002};
  command.simulated = true;
  return command;
}

template <>
inline AntennaReport sample<AntennaReport>() {
  AntennaReport report;
  report.antenna = "jeju-antenna";
  report.sequence = 12;
  report.epoch = {1'700'000'000'000'000'003};
  report.received = {1'700'000'000'000'000'004};
  report.azimuth_rad = -2.5;
  report.elevation_rad = 0.25;
  report.azimuth_valid = true;
  report.elevation_valid = false;
  report.mode = AntennaMode::Autotrack;
  report.command_tick = {1'700'000'000'000'000'000};
  report.simulated = true;
  return report;
}

template <>
inline PlatformState sample<PlatformState>() {
  PlatformState state;
  state.antenna = "ship-antenna";
  state.sequence = 13;
  state.epoch = {1'700'000'000'000'000'005};
  state.received = {1'700'000'000'000'000'006};
  state.position.m = {-3.2e6, 4.1e6, 3.4e6};
  state.velocity.m_s = {4, -5, 6};
  state.velocity_valid = true;
  state.heading_rad = 4.5;
  state.sigma_position_m = 0.75;
  state.sigma_heading_rad = 0.002;
  state.simulated = true;
  return state;
}

inline Plot sample_measured_plot() {
  return {.measured = {1, 2, 0.5},
          .range_valid = true,
          .angles_valid = false,
          .range_rate_m_s = -3,
          .range_rate_valid = true,
          .snr_db = 4,
          .snr_valid = true};
}

inline Fix sample_measured_fix() {
  return {.position = {{4, 5, 6}},
          .velocity = {{7, 8, 9}},
          .velocity_valid = true,
          .sigma_horizontal_m = 10,
          .sigma_vertical_m = 11,
          .sigma_velocity_m_s = 12};
}

/// As it came of this kind of measurement.
inline Observation sample_observation_of(Measured measured) {
  Observation observation;
  observation.verdict = Reason::Frozen;
  observation.sensor = "jeju-tm";
  observation.target = "kslv";
  observation.receiver = "rx1";
  observation.sequence = 10;
  observation.epoch = {100};
  observation.received = {200};
  observation.measured = std::move(measured);
  observation.simulated = true;
  return observation;
}

template <>
inline Observation sample<Observation>() {
  return sample_observation_of(sample_measured_fix());
}

template <>
inline SensorBias sample<SensorBias>() {
  SensorBias bias;
  bias.sensor = "goheung-radar";
  bias.method = "song2015";
  bias.epoch = {1};
  bias.received = {2};
  bias.reference = BiasReference::CrossRadar;
  bias.samples = 1234;
  bias.terms = max_bias_terms;
  for (std::size_t i = 0; i < bias.term.size(); ++i) {
    bias.term[i] = static_cast<BiasTerm>(12 - i);
    bias.state[i] = static_cast<BiasState>(i % 4);
    bias.value[i] = 0.5 + static_cast<double>(i);
  }
  for (std::size_t i = 0; i < bias.covariance.size(); ++i) bias.covariance[i] = 1e-3 * static_cast<double>(i);
  return bias;
}

template <>
inline Trajectory sample<Trajectory>() {
  Trajectory trajectory;
  trajectory.target = "kslv";
  trajectory.method = "song2015";
  trajectory.primary = true;
  trajectory.epoch = {3};
  trajectory.received = {4};
  trajectory.quality = TrackQuality::Coasting;
  trajectory.state_size = 9;
  for (std::size_t i = 0; i < trajectory.state.size(); ++i) trajectory.state[i] = -1.5 * static_cast<double>(i);
  for (std::size_t i = 0; i < trajectory.covariance.size(); ++i)
    trajectory.covariance[i] = 2.0 + static_cast<double>(i);
  trajectory.geodetic = {0.6, 2.2, 123e3};
  trajectory.speed_m_s = 7800;
  trajectory.flight_path_rad = 0.3;
  trajectory.heading_rad = 3.0;
  trajectory.sources = 0x8000000000000001;
  trajectory.nis = 2.75;
  trajectory.nis_dof = 3;
  trajectory.chain = "without-jeju";
  trajectory.bound_m = 50;
  trajectory.bound_valid = true;
  trajectory.deviation_m = {1, -2, 3};
  trajectory.deviation_sigma_m = {4, 5, 6};
  trajectory.deviation_valid = true;
  return trajectory;
}

template <>
inline Integrity sample<Integrity>() {
  Integrity integrity;
  integrity.target = "kslv";
  integrity.time = {5000};
  integrity.liftoff = {4000};
  integrity.liftoff_valid = true;
  integrity.chain = "without-jeju-tm";
  integrity.held_by = "kim";
  integrity.bound_m = 75;
  integrity.bound_valid = true;
  integrity.events = 17;
  integrity.sources = {
      {.sensor = "goheung-radar", .verdict = IntegrityVerdict::Suspect, .since = {}, .onset = {}, .by = "integrity"},
      {.sensor = "jeju-tm",
       .verdict = IntegrityVerdict::Excluded,
       .why = Finding::Impossible,
       .since = {4500},
       .onset = {4400},
       .test_value = 12.5,
       .against = 0x8000000000000001,
       .apart_m = 5000,
       .agree_m = 12,
       .by = "integrity"}};
  return integrity;
}

template <>
inline SlavingCommand sample<SlavingCommand>() {
  SlavingCommand command;
  command.antenna = "jeju-antenna";
  command.target = "kslv";
  command.tick = {1000};
  command.apply_at = {2000};
  command.valid_until = {3000};
  command.data_epoch = {900};
  command.age_s = 1.1e-6;
  command.azimuth_rad = -4.5;
  command.elevation_rad = 0.7;
  command.range_m = 1e6;
  command.azimuth_rate_rad_s = 0.01;
  command.elevation_rate_rad_s = -0.02;
  command.range_rate_m_s = 1234;
  command.sigma_azimuth_rad = 1e-4;
  command.sigma_elevation_rad = 2e-4;
  command.source = SlavingSource::Nominal;
  command.limits = LimitRate | LimitUnwrapped;
  command.azimuth_acceleration_rad_s2 = 0.003;
  command.elevation_acceleration_rad_s2 = -0.004;
  command.acceleration_valid = true;
  command.probability_in_beam = 0.75;
  command.probability_valid = true;
  command.bound_rad = 0.005;
  command.bound_valid = true;
  command.off_target_rad = 0.006;
  command.chain = "only-goheung";
  command.mount_azimuth_rad = 0.007;
  command.mount_elevation_rad = -0.008;
  return command;
}

template <>
inline AntennaAccount sample<AntennaAccount>() {
  AntennaAccount account;
  account.antenna = "jeju-antenna";
  account.target = "kslv";
  account.tick = {7000};
  account.orders = "trimmed by kim (wind)";
  account.pass_valid = true;
  account.basis = PassBasis::PlannedLiftoff;
  account.in_view = true;
  account.acquisition_valid = true;
  account.acquisition = {8000};
  account.acquisition_azimuth_rad = 3.1;
  account.loss_valid = true;
  account.loss = {9000};
  account.loss_azimuth_rad = 2.4;
  account.highest_valid = true;
  account.highest_elevation_rad = 0.6;
  account.highest = {8500};
  return account;
}

template <>
inline ImpactPoint sample<ImpactPoint>() {
  ImpactPoint impact;
  impact.target = "kslv";
  impact.chain = "only-goheung";
  impact.epoch = {7000};
  impact.received = {7100};
  impact.impact_valid = true;
  impact.point = {0.5, 2.2, 12};
  impact.time_to_impact_s = 321.5;
  impact.covariance_m2 = {400, -50, 900};
  impact.data_age_s = 0.25;
  impact.data_loss_timer_s = 0.5;
  impact.data_loss_limit_s = 7.5;
  impact.data_loss_limit_valid = true;
  impact.boundaries = {{.boundary = "corridor",
                        .distance_m = 12'000,
                        .present_distance_m = 9'000,
                        .time_s = 17.5,
                        .time_valid = true,
                        .probability_outside = 1e-7},
                       {.boundary = "island", .distance_m = -3'000, .present_distance_m = -2'000}};
  return impact;
}

template <>
inline SourceHealth sample<SourceHealth>() {
  SourceHealth health;
  health.sensor = "goheung-radar";
  health.target = "kslv";
  health.time = {5};
  health.rate_hz = 19.5;
  health.latency_s = 0.04;
  for (std::size_t i = 0; i < health.count.size(); ++i) health.count[i] = 100 + i;
  health.residual_mean = 0.01;
  health.residual_sigma = 1.1;
  health.nis = 0.9;
  health.qualified = true;
  health.why = Disqualification::Rejected;
  health.rejected_for = Reason::Frozen;
  health.nis_inside_95 = 0.925;
  health.nis_count = 1000;
  health.mismatch = true;
  health.residual_m = 12.5;
  health.expected_m = 11.5;
  health.residual_rad = 0.002;
  health.expected_rad = 0.001;
  health.sigma_ratio = {1.1, 0.9, 3, 0};
  health.suspect = true;
  health.forced = true;
  health.since = {4};
  health.by = "integrity";
  health.reason = "pointing steps since the gust at T+60";
  health.acknowledged_by = "kim";
  return health;
}

}  // namespace downrange::test
