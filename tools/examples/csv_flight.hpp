#pragma once
// A range in code, and a flight out of CSV files: what fly_csv and own_method have in common.

#include <algorithm>
#include <downrange/stage/event.hpp>
#include <downrange/stage/range_config.hpp>
#include <fstream>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace example {

using namespace downrange;

inline constexpr double deg = std::numbers::pi / 180;
inline constexpr Time liftoff{1'767'254'400'000'000'000};  // 2026-01-01T08:00:00Z

// One radar, one telemetry station, one antenna that follows the vehicle.
inline RangeConfig example_range() {
  RangeConfig range;
  range.name = "example";
  range.targets = {{"kslv"}};
  RadarConfig radar;
  radar.id = "goheung";
  radar.site = Site({34.4450 * deg, 127.5200 * deg, 120});
  radar.sigma = {.range_m = 25, .azimuth_rad = 0.01 * deg, .elevation_rad = 0.01 * deg};
  radar.rate_hz = 5;
  range.radars = {radar};
  range.telemetry = {{"goheung-tgs", Site({34.4400 * deg, 127.5100 * deg, 90})}};
  AntennaConfig antenna;
  antenna.id = "goheung-tm";
  antenna.site = Site({34.4400 * deg, 127.5100 * deg, 90});
  antenna.link_delay = milliseconds(50);
  antenna.lead = milliseconds(50);
  range.antennas = {antenna};
  return range;
}

// The numbers of each row after the line of names; `columns` of them.
inline std::vector<std::vector<double>> read_rows(const std::string& path, std::size_t columns) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": cannot be read");
  std::vector<std::vector<double>> rows;
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream text(line);
    std::vector<double> row(columns);
    for (double& number : row) text >> number;
    if (!text) throw std::runtime_error(path + ": a row without " + std::to_string(columns) + " numbers: " + line);
    rows.push_back(row);
  }
  return rows;
}

// radar.csv and gps.csv of `folder` in the order in which they were received, as the engine takes them.
inline std::vector<Event> read_flight(const std::string& folder) {
  std::vector<Event> events;
  std::uint64_t sequence = 0;
  for (const auto& row : read_rows(folder + "/radar.csv", 5)) {
    RadarTspi plot;
    plot.sensor = "goheung";
    plot.target = "kslv";
    plot.sequence = ++sequence;
    plot.epoch = liftoff + seconds(row[0]);
    plot.received = liftoff + seconds(row[1]);
    plot.measured = {.range_m = row[2], .azimuth_rad = row[3] * deg, .elevation_rad = row[4] * deg};
    events.emplace_back(plot);
  }
  sequence = 0;
  for (const auto& row : read_rows(folder + "/gps.csv", 8)) {
    GpsFix fix;
    fix.target = "kslv";
    fix.station = "goheung-tgs";
    fix.sequence = ++sequence;
    fix.epoch = liftoff + seconds(row[0]);
    fix.received = liftoff + seconds(row[1]);
    fix.position = {{row[2], row[3], row[4]}};
    fix.velocity = {{row[5], row[6], row[7]}};
    fix.velocity_valid = true;
    events.emplace_back(fix);
  }
  std::stable_sort(events.begin(), events.end(),
                   [](const Event& a, const Event& b) { return received_of(a) < received_of(b); });
  return events;
}

}  // namespace example
