#pragma once
/// Events and results with every field set to its own value, and their comparison over all fields.

#include <gtest/gtest.h>

#include <downrange/stage/event.hpp>
#include <downrange/stage/result.hpp>
#include <source_dir.hpp>
#include <string>

#include "dds/participant.hpp"

namespace downrange::dds {

inline ParticipantOptions test_participant(int domain, const char* node, ClockMode clock) {
  return {domain, std::string(DOWNRANGE_SOURCE_DIR) + "/config/dds-qos.xml", node, clock};
}

inline RadarTspi sample_plot(std::uint64_t sequence = 7) {
  RadarTspi plot;
  plot.sensor = "goheung-radar";
  plot.target = "a-name-of-thirty-one-characters";
  plot.sequence = sequence;
  plot.epoch = {1'700'000'000'123'456'789};
  plot.measured = {123456.789, 6.28, -0.01};
  plot.range_rate_m_s = -4321.5;
  plot.range_rate_valid = true;
  plot.mode = TrackMode::Coast;
  plot.snr_db = 12.25;
  plot.simulated = true;
  return plot;
}

inline AngleTspi sample_angles(std::uint64_t sequence = 6) {
  AngleTspi angles;
  angles.sensor = "goheung-optical";
  angles.target = "a-name-of-thirty-one-characters";
  angles.sequence = sequence;
  angles.epoch = {1'700'000'000'987'654'321};
  angles.azimuth_rad = 5.5;
  angles.elevation_rad = 1.5;
  angles.mode = TrackMode::Acquire;
  angles.simulated = true;
  return angles;
}

inline GpsFix sample_fix(std::uint64_t sequence = 8) {
  GpsFix fix;
  fix.target = "kslv";
  fix.receiver = "rx1";
  fix.station = "jeju-tm";
  fix.sequence = sequence;
  fix.epoch = {-5};
  fix.position.m = {-3.1e6, 4.2e6, 3.3e6};
  fix.velocity.m_s = {1, -2, 3};
  fix.velocity_valid = true;
  fix.sigma_horizontal_m = 1.5;
  fix.sigma_vertical_m = 2.5;
  fix.sigma_velocity_m_s = 0.125;
  fix.fix = FixType::Differential;
  fix.satellites = 11;
  fix.satellites_stated = true;
  fix.simulated = true;
  return fix;
}

inline MissionEvent sample_mark(std::uint64_t sequence = 9) {
  MissionEvent mark;
  mark.mission = "flight-3";
  mark.label = "second stage";
  mark.kind = MissionEventKind::Staging;
  mark.sequence = sequence;
  mark.epoch = {42};
  mark.simulated = true;
  return mark;
}

inline Observation sample_observation(std::uint64_t sequence = 10) {
  Observation observation;
  observation.kind = ObservationKind::Gps;
  observation.verdict = Reason::Frozen;
  observation.sensor = "jeju-tm";
  observation.target = "kslv";
  observation.receiver = "rx1";
  observation.sequence = sequence;
  observation.step = 0;
  observation.epoch = {100};
  observation.received = {200};
  observation.measured = {1, 2, 3};
  observation.position.m = {4, 5, 6};
  observation.velocity.m_s = {7, 8, 9};
  observation.velocity_valid = true;
  observation.sigma_horizontal_m = 10;
  observation.sigma_vertical_m = 11;
  observation.sigma_velocity_m_s = 12;
  observation.simulated = true;
  return observation;
}

inline SensorBias sample_bias() {
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

inline Trajectory sample_trajectory() {
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
  return trajectory;
}

inline SlavingCommand sample_command(const Name& antenna = "jeju-antenna") {
  SlavingCommand command;
  command.antenna = antenna;
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
  return command;
}

inline SourceHealth sample_health() {
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
  return health;
}

inline void expect_equal(const RadarTspi& a, const RadarTspi& b) {
  EXPECT_EQ(a.sensor, b.sensor);
  EXPECT_EQ(a.target, b.target);
  EXPECT_EQ(a.sequence, b.sequence);
  EXPECT_EQ(a.epoch, b.epoch);
  EXPECT_EQ(a.measured.range_m, b.measured.range_m);
  EXPECT_EQ(a.measured.azimuth_rad, b.measured.azimuth_rad);
  EXPECT_EQ(a.measured.elevation_rad, b.measured.elevation_rad);
  EXPECT_EQ(a.range_rate_m_s, b.range_rate_m_s);
  EXPECT_EQ(a.range_rate_valid, b.range_rate_valid);
  EXPECT_EQ(a.mode, b.mode);
  EXPECT_EQ(a.snr_db, b.snr_db);
  EXPECT_EQ(a.simulated, b.simulated);
}

inline void expect_equal(const AngleTspi& a, const AngleTspi& b) {
  EXPECT_EQ(a.sensor, b.sensor);
  EXPECT_EQ(a.target, b.target);
  EXPECT_EQ(a.sequence, b.sequence);
  EXPECT_EQ(a.epoch, b.epoch);
  EXPECT_EQ(a.azimuth_rad, b.azimuth_rad);
  EXPECT_EQ(a.elevation_rad, b.elevation_rad);
  EXPECT_EQ(a.mode, b.mode);
  EXPECT_EQ(a.simulated, b.simulated);
}

inline void expect_equal(const GpsFix& a, const GpsFix& b) {
  EXPECT_EQ(a.target, b.target);
  EXPECT_EQ(a.receiver, b.receiver);
  EXPECT_EQ(a.station, b.station);
  EXPECT_EQ(a.sequence, b.sequence);
  EXPECT_EQ(a.epoch, b.epoch);
  EXPECT_EQ(a.position.m, b.position.m);
  EXPECT_EQ(a.velocity.m_s, b.velocity.m_s);
  EXPECT_EQ(a.velocity_valid, b.velocity_valid);
  EXPECT_EQ(a.sigma_horizontal_m, b.sigma_horizontal_m);
  EXPECT_EQ(a.sigma_vertical_m, b.sigma_vertical_m);
  EXPECT_EQ(a.sigma_velocity_m_s, b.sigma_velocity_m_s);
  EXPECT_EQ(a.fix, b.fix);
  EXPECT_EQ(a.satellites, b.satellites);
  EXPECT_EQ(a.satellites_stated, b.satellites_stated);
  EXPECT_EQ(a.simulated, b.simulated);
}

inline void expect_equal(const ClockGap&, const ClockGap&) { ADD_FAILURE() << "no topic carries it"; }
inline void expect_equal(const MissionEvent& a, const MissionEvent& b) {
  EXPECT_EQ(a.mission, b.mission);
  EXPECT_EQ(a.label, b.label);
  EXPECT_EQ(a.kind, b.kind);
  EXPECT_EQ(a.sequence, b.sequence);
  EXPECT_EQ(a.epoch, b.epoch);
  EXPECT_EQ(a.simulated, b.simulated);
}

inline void expect_equal(const Observation& a, const Observation& b) {
  EXPECT_EQ(a.kind, b.kind);
  EXPECT_EQ(a.verdict, b.verdict);
  EXPECT_EQ(a.sensor, b.sensor);
  EXPECT_EQ(a.target, b.target);
  EXPECT_EQ(a.receiver, b.receiver);
  EXPECT_EQ(a.sequence, b.sequence);
  EXPECT_EQ(a.step, b.step);
  EXPECT_EQ(a.epoch, b.epoch);
  EXPECT_EQ(a.received, b.received);
  EXPECT_EQ(a.measured.range_m, b.measured.range_m);
  EXPECT_EQ(a.measured.azimuth_rad, b.measured.azimuth_rad);
  EXPECT_EQ(a.measured.elevation_rad, b.measured.elevation_rad);
  EXPECT_EQ(a.position.m, b.position.m);
  EXPECT_EQ(a.velocity.m_s, b.velocity.m_s);
  EXPECT_EQ(a.velocity_valid, b.velocity_valid);
  EXPECT_EQ(a.sigma_horizontal_m, b.sigma_horizontal_m);
  EXPECT_EQ(a.sigma_vertical_m, b.sigma_vertical_m);
  EXPECT_EQ(a.sigma_velocity_m_s, b.sigma_velocity_m_s);
  EXPECT_EQ(a.simulated, b.simulated);
}

inline void expect_equal(const SensorBias& a, const SensorBias& b) {
  EXPECT_EQ(a.sensor, b.sensor);
  EXPECT_EQ(a.method, b.method);
  EXPECT_EQ(a.epoch, b.epoch);
  EXPECT_EQ(a.received, b.received);
  EXPECT_EQ(a.reference, b.reference);
  EXPECT_EQ(a.samples, b.samples);
  EXPECT_EQ(a.terms, b.terms);
  EXPECT_EQ(a.term, b.term);
  EXPECT_EQ(a.state, b.state);
  EXPECT_EQ(a.value, b.value);
  EXPECT_EQ(a.covariance, b.covariance);
}

inline void expect_equal(const Trajectory& a, const Trajectory& b) {
  EXPECT_EQ(a.target, b.target);
  EXPECT_EQ(a.method, b.method);
  EXPECT_EQ(a.primary, b.primary);
  EXPECT_EQ(a.epoch, b.epoch);
  EXPECT_EQ(a.received, b.received);
  EXPECT_EQ(a.quality, b.quality);
  EXPECT_EQ(a.state_size, b.state_size);
  EXPECT_EQ(a.state, b.state);
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.geodetic.latitude_rad, b.geodetic.latitude_rad);
  EXPECT_EQ(a.geodetic.longitude_rad, b.geodetic.longitude_rad);
  EXPECT_EQ(a.geodetic.height_m, b.geodetic.height_m);
  EXPECT_EQ(a.speed_m_s, b.speed_m_s);
  EXPECT_EQ(a.flight_path_rad, b.flight_path_rad);
  EXPECT_EQ(a.heading_rad, b.heading_rad);
  EXPECT_EQ(a.sources, b.sources);
  EXPECT_EQ(a.nis, b.nis);
  EXPECT_EQ(a.nis_dof, b.nis_dof);
}

inline void expect_equal(const SlavingCommand& a, const SlavingCommand& b) {
  EXPECT_EQ(a.antenna, b.antenna);
  EXPECT_EQ(a.target, b.target);
  EXPECT_EQ(a.tick, b.tick);
  EXPECT_EQ(a.apply_at, b.apply_at);
  EXPECT_EQ(a.valid_until, b.valid_until);
  EXPECT_EQ(a.data_epoch, b.data_epoch);
  EXPECT_EQ(a.age_s, b.age_s);
  EXPECT_EQ(a.azimuth_rad, b.azimuth_rad);
  EXPECT_EQ(a.elevation_rad, b.elevation_rad);
  EXPECT_EQ(a.range_m, b.range_m);
  EXPECT_EQ(a.azimuth_rate_rad_s, b.azimuth_rate_rad_s);
  EXPECT_EQ(a.elevation_rate_rad_s, b.elevation_rate_rad_s);
  EXPECT_EQ(a.range_rate_m_s, b.range_rate_m_s);
  EXPECT_EQ(a.sigma_azimuth_rad, b.sigma_azimuth_rad);
  EXPECT_EQ(a.sigma_elevation_rad, b.sigma_elevation_rad);
  EXPECT_EQ(a.source, b.source);
  EXPECT_EQ(a.limits, b.limits);
}

inline void expect_equal(const SourceHealth& a, const SourceHealth& b) {
  EXPECT_EQ(a.sensor, b.sensor);
  EXPECT_EQ(a.target, b.target);
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.rate_hz, b.rate_hz);
  EXPECT_EQ(a.latency_s, b.latency_s);
  EXPECT_EQ(a.count, b.count);
  EXPECT_EQ(a.residual_mean, b.residual_mean);
  EXPECT_EQ(a.residual_sigma, b.residual_sigma);
  EXPECT_EQ(a.nis, b.nis);
  EXPECT_EQ(a.qualified, b.qualified);
  EXPECT_EQ(a.why, b.why);
  EXPECT_EQ(a.rejected_for, b.rejected_for);
  EXPECT_EQ(a.nis_inside_95, b.nis_inside_95);
  EXPECT_EQ(a.nis_count, b.nis_count);
  EXPECT_EQ(a.mismatch, b.mismatch);
}

}  // namespace downrange::dds
