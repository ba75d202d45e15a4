#include "config/schema.hpp"

#include "config/sections.hpp"

namespace downrange::config {

const std::vector<Section>& schema() {
  static const std::vector<Section> sections{
      range_section(),    target_section(), radar_section(),     angle_sensor_section(), telemetry_section(),
      antenna_section(),  rotctl_section(), gps_section(),       pad_section(),          ingest_section(),
      align_section(),    fuse_section(),   integrity_section(), slave_section(),        impact_section(),
      boundary_section(), clock_section(),  node_section(),      dds_section(),          archive_section(),
      log_section()};
  return sections;
}

}  // namespace downrange::config
