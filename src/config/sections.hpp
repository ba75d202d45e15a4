#pragma once
/// The tables of the configuration, one function each: keys, limits, meaning.

#include "config/schema.hpp"

namespace downrange::config {

// range_sections.cpp: the range, its targets, sensors and antennas.
[[nodiscard]] Section range_section();
[[nodiscard]] Section target_section();
[[nodiscard]] Section radar_section();
[[nodiscard]] Section angle_sensor_section();
[[nodiscard]] Section telemetry_section();
[[nodiscard]] Section antenna_section();
[[nodiscard]] Section gps_section();
[[nodiscard]] Section pad_section();

// rotctl_section.cpp: an antenna that is reached through a rotator daemon.
[[nodiscard]] Section rotctl_section();

// processing_sections.cpp: what the stages do with the data.
[[nodiscard]] Section ingest_section();
[[nodiscard]] Section align_section();
[[nodiscard]] Section fuse_section();
[[nodiscard]] Section integrity_section();
[[nodiscard]] Section slave_section();

// impact_sections.cpp: the impact point, and what it is held against.
[[nodiscard]] Section impact_section();
[[nodiscard]] Section boundary_section();

// service_sections.cpp: the node that they run in.
[[nodiscard]] Section clock_section();
[[nodiscard]] Section node_section();
[[nodiscard]] Section dds_section();
[[nodiscard]] Section archive_section();
[[nodiscard]] Section log_section();

}  // namespace downrange::config
