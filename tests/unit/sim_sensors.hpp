/// The example of the tests of simulated sensors: one radar and one station watch the launch from Naro.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "sim/simulation.hpp"

namespace downrange::sim {
inline constexpr double deg = std::numbers::pi / 180;
inline constexpr std::uint64_t seed = 20260301;

inline RadarScenario make_radar(const char* id) {
  RadarScenario radar;
  radar.id = id;
  radar.site = Site({34.4450 * deg, 127.5200 * deg, 120});
  radar.sigma = {25, 0.01 * deg, 0.01 * deg};
  radar.rate_hz = 10;
  radar.phase_s = 0.013;
  radar.track = {100, 480};
  radar.range_max_m = 4e6;
  radar.elevation_min_rad = -90 * deg;
  return radar;
}

inline StationScenario make_station(const char* id, double delay_s, double jitter_s) {
  StationScenario station;
  station.id = id;
  station.site = Site({34.4480 * deg, 127.5165 * deg, 105});
  station.elevation_min_rad = -90 * deg;
  station.delay_s = delay_s;
  station.delay_jitter_s = jitter_s;
  return station;
}

inline Scenario make_scenario() {
  Scenario scenario;
  scenario.name = "test";
  scenario.target = "kslv";
  scenario.liftoff = {1'772'352'000'000'000'000};
  scenario.start_s = -10;
  scenario.end_s = 480;
  scenario.profile = naro_launch_profile();
  scenario.radars = {make_radar("one")};
  scenario.gps.active = {-10, 480};
  scenario.gps.sigma_enu_m = {5, 5, 8};
  scenario.stations = {make_station("near", 0.1, 0.05)};
  return scenario;
}

template <class T>
inline std::vector<T> all_of(const Simulation& simulation) {
  std::vector<T> all;
  for (const Event& event : simulation.events())
    if (const T* e = std::get_if<T>(&event)) all.push_back(*e);
  return all;
}

inline std::vector<RadarTspi> plots_of(const Simulation& simulation, const Name& sensor) {
  std::vector<RadarTspi> plots = all_of<RadarTspi>(simulation);
  std::erase_if(plots, [&](const RadarTspi& plot) { return plot.sensor != sensor; });
  return plots;
}

inline Polar true_polar(const Simulation& simulation, const Site& site, Time t) {
  return polar_from_enu(site.enu_of(simulation.truth(t)->position));
}

struct Moments {
  double mean;
  double sigma;
};

inline Moments moments(const std::vector<double>& x) {
  double sum = 0, squares = 0;
  for (const double v : x) sum += v;
  const double mean = sum / static_cast<double>(x.size());
  for (const double v : x) squares += (v - mean) * (v - mean);
  return {mean, std::sqrt(squares / static_cast<double>(x.size() - 1))};
}

/// 4.5 sigma of the estimates: one false alarm in 150 000 checks, were the seed not fixed.
inline void expect_moments(const std::vector<double>& x, double mean, double sigma) {
  const Moments m = moments(x);
  const double n = static_cast<double>(x.size());
  EXPECT_NEAR(m.mean, mean, 4.5 * sigma / std::sqrt(n)) << "seed " << seed;
  EXPECT_NEAR(m.sigma, sigma, 4.5 * sigma / std::sqrt(2 * n)) << "seed " << seed;
}

}  // namespace downrange::sim
