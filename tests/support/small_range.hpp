#pragma once
/// A small range for tests: one target, two radars (and an angles-only tracker where a test wants one), two telemetry
/// stations, two antennas, and a vehicle to follow.

#include <algorithm>
#include <downrange/geo/polar.hpp>
#include <downrange/geo/site.hpp>
#include <downrange/stage/event.hpp>
#include <downrange/stage/range_config.hpp>
#include <downrange/stage/result.hpp>
#include <numbers>
#include <random>
#include <vector>

namespace downrange::test {

inline constexpr double deg = std::numbers::pi / 180;
inline constexpr Time liftoff{1'700'000'000'000'000'000};

inline Site pad() { return Site({34.4319 * deg, 127.5351 * deg, 100}); }

inline RangeConfig small_range() {
  RangeConfig c;
  c.name = "test";
  c.targets = {{"kslv"}};
  const PolarSigma sigma{25, 0.01 * deg, 0.01 * deg};
  const auto radar = [&](Name id, double lat, double lon, double h, double rate) {
    RadarConfig r;
    r.id = id;
    r.site = Site({lat * deg, lon * deg, h});
    r.sigma = sigma;
    r.rate_hz = rate;
    return r;
  };
  c.radars = {radar("goheung", 34.4450, 127.5200, 120, 10), radar("jeju", 33.2900, 126.4600, 350, 20)};
  c.telemetry = {{"goheung-tgs", Site({34.44 * deg, 127.52 * deg, 100})},
                 {"jeju-tgs", Site({33.3 * deg, 126.5 * deg, 100})}};
  AntennaConfig antenna;
  antenna.id = "goheung-tm";
  antenna.site = Site({34.4400 * deg, 127.5100 * deg, 90});
  antenna.link_delay = milliseconds(20);
  antenna.lead = milliseconds(30);
  c.antennas.push_back(antenna);
  antenna.id = "jeju-tm";
  antenna.site = Site({33.3000 * deg, 126.4700 * deg, 300});
  c.antennas.push_back(antenna);
  c.ingest.expect_simulated = true;
  c.fuse.methods = {"song2015", "uncorrected"};
  return c;
}

/// A steady climb to the south, seconds after lift-off.
inline Position<Ecef> vehicle_at(double t) {
  return pad().ecef_of({{20 * t, -300 * t - 3 * t * t, 400 * t + 4 * t * t}});
}

inline RadarTspi plot_at(const RadarConfig& radar, double t, std::uint64_t sequence, double delay_s = 0.04) {
  RadarTspi p;
  p.sensor = radar.id;
  p.target = "kslv";
  p.sequence = sequence;
  p.epoch = liftoff + seconds(t);
  p.received = p.epoch + seconds(delay_s);
  p.measured = polar_from_enu(radar.site.enu_of(vehicle_at(t)));
  p.simulated = true;
  return p;
}

/// An optical tracker by the pad. Not part of small_range.
inline AngleSensorConfig small_tracker() {
  AngleSensorConfig tracker;
  tracker.id = "optical";
  tracker.site = Site({34.4390 * deg, 127.5105 * deg, 160});
  tracker.sigma_azimuth_rad = 0.003 * deg;
  tracker.sigma_elevation_rad = 0.003 * deg;
  return tracker;
}

inline AngleTspi angles_at(const AngleSensorConfig& tracker, double t, std::uint64_t sequence, double delay_s = 0.04) {
  AngleTspi a;
  a.sensor = tracker.id;
  a.target = "kslv";
  a.sequence = sequence;
  a.epoch = liftoff + seconds(t);
  a.received = a.epoch + seconds(delay_s);
  const Polar q = polar_from_enu(tracker.site.enu_of(vehicle_at(t)));
  a.azimuth_rad = q.azimuth_rad;
  a.elevation_rad = q.elevation_rad;
  a.simulated = true;
  return a;
}

inline GpsFix fix_at(Name station, double t, std::uint64_t sequence, double delay_s = 0.5) {
  GpsFix f;
  f.target = "kslv";
  f.station = station;
  f.sequence = sequence;
  f.epoch = liftoff + seconds(t);
  f.received = f.epoch + seconds(delay_s);
  f.position = vehicle_at(t);
  f.velocity.m_s = (vehicle_at(t + 0.01).m - vehicle_at(t - 0.01).m) / 0.02;
  f.velocity_valid = true;
  f.simulated = true;
  return f;
}

/// Noisy, biased, late and doubled: a flight of `duration_s` seconds in order of `received`.
inline std::vector<Event> small_flight(const RangeConfig& range, double duration_s, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<Event> events;
  for (std::size_t r = 0; r < range.radars.size(); ++r) {
    const RadarConfig& radar = range.radars[r];
    const double sign = r == 0 ? 1 : -1;
    std::uint64_t sequence = 0;
    for (double t = 1 + 0.013 * static_cast<double>(r + 1); t < duration_s; t += 1 / radar.rate_hz) {
      RadarTspi p = plot_at(radar, t, ++sequence, 0.03 + 0.05 * uniform(rng));
      p.measured.range_m += sign * 40 + radar.sigma.range_m * normal(rng);
      p.measured.azimuth_rad += sign * 0.03 * deg + radar.sigma.azimuth_rad * normal(rng);
      p.measured.elevation_rad += -sign * 0.02 * deg + radar.sigma.elevation_rad * normal(rng);
      events.emplace_back(p);
    }
  }
  std::uint64_t sequence = 0;
  for (double t = 0; t < duration_s; t += 1) {
    GpsFix f = fix_at(range.telemetry[0].id, t, ++sequence, 0.4 + 0.4 * uniform(rng));
    for (int k = 0; k < 3; ++k) f.position.m[k] += 5 * normal(rng);
    events.emplace_back(f);
    f.station = range.telemetry[1].id;  // the same fix by another station
    f.received = f.received + seconds(0.2 * uniform(rng));
    events.emplace_back(f);
  }
  std::stable_sort(events.begin(), events.end(),
                   [](const Event& a, const Event& b) { return received_of(a) < received_of(b); });
  return events;
}

/// Keeps everything that an engine emits.
struct Collector final : ResultSink {
  void emit(const Result& result) override { results.push_back(result); }
  template <class T>
  [[nodiscard]] std::vector<T> of() const {
    std::vector<T> found;
    for (const Result& r : results) {
      if (const T* t = std::get_if<T>(&r)) found.push_back(*t);
    }
    return found;
  }
  std::vector<Result> results;
};

}  // namespace downrange::test
