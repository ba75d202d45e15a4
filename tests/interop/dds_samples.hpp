#pragma once
/// What the tests over DDS share.

#include <gtest/gtest.h>

#include <source_dir.hpp>
#include <string>

#include "../support/samples.hpp"
#include "dds/participant.hpp"

namespace downrange::dds {

inline ParticipantOptions test_participant(int domain, const char* node, ClockMode clock) {
  return {domain, std::string(DOWNRANGE_SOURCE_DIR) + "/config/dds-qos.xml", node, clock};
}

/// Samples that tests number, name or change.
inline RadarTspi sample_plot(std::uint64_t sequence = 7) {
  RadarTspi plot = test::sample<RadarTspi>();
  plot.sequence = sequence;
  return plot;
}
inline AngleTspi sample_angles(std::uint64_t sequence = 6) {
  AngleTspi angles = test::sample<AngleTspi>();
  angles.sequence = sequence;
  return angles;
}
inline GpsFix sample_fix(std::uint64_t sequence = 8) {
  GpsFix fix = test::sample<GpsFix>();
  fix.sequence = sequence;
  return fix;
}
inline MissionEvent sample_mark(std::uint64_t sequence = 9) {
  MissionEvent mark = test::sample<MissionEvent>();
  mark.sequence = sequence;
  return mark;
}
inline Observation sample_observation(std::uint64_t sequence = 10) {
  Observation observation = test::sample<Observation>();
  observation.sequence = sequence;
  return observation;
}
inline SlavingCommand sample_command(const Name& antenna = "jeju-antenna") {
  SlavingCommand command = test::sample<SlavingCommand>();
  command.antenna = antenna;
  return command;
}

}  // namespace downrange::dds
