#pragma once
/// A drawn flight for tests of methods: a vehicle climbing past two biased radars, GPS at 1 Hz with velocity, the
/// truth.

#include <algorithm>
#include <array>
#include <cmath>
#include <downrange/est/method/method.hpp>
#include <numbers>
#include <random>

#include "measurements.hpp"

namespace downrange::test {

inline constexpr double deg = std::numbers::pi / 180;

struct Flight {
  MethodSettings settings;
  std::vector<Measurement> measurements;  ///< in order of epoch
};

/// A vehicle climbing with constant acceleration past two radars with polar biases; GPS at 1 Hz with velocity.
inline Position<Ecef> truth_at(const Site& pad, double t) {
  return pad.ecef_of({{30 * t, -400 * t - 3 * t * t, 300 * t + 4 * t * t}});
}

inline Flight draw_flight(std::uint64_t seed, double duration_s, bool with_bias, bool with_gps = true) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  const Site pad({34.43 * deg, 127.53 * deg, 100});
  Flight f;
  const PolarSigma sigma{25, 0.01 * deg, 0.01 * deg};
  f.settings.radars = {{Site({34.4450 * deg, 127.52 * deg, 120}), sigma},
                       {Site({33.29 * deg, 126.46 * deg, 350}), sigma}};
  f.settings.stations = 2;
  const Polar bias[2] = {{40, 0.04 * deg, -0.03 * deg}, {-35, -0.03 * deg, 0.02 * deg}};
  std::uint64_t sequence = 0;
  for (int i = 0; i < static_cast<int>(duration_s * 20); ++i) {
    for (int radar = 0; radar < 2; ++radar) {
      if (radar == 0 && i % 2 == 1) continue;
      const double t = 10 + i * 0.05 + (radar == 0 ? 0.013 : 0.031);
      Polar q = polar_from_enu(f.settings.radars[static_cast<std::size_t>(radar)].site.enu_of(truth_at(pad, t)));
      q.range_m += sigma.range_m * normal(rng);
      q.azimuth_rad += sigma.azimuth_rad * normal(rng);
      q.elevation_rad += sigma.elevation_rad * normal(rng);
      if (with_bias) {
        q.range_m += bias[radar].range_m;
        q.azimuth_rad += bias[radar].azimuth_rad;
        q.elevation_rad += bias[radar].elevation_rad;
      }
      Measurement m;
      m.epoch = Time{} + seconds(t);
      m.source = radar;
      m.sequence = ++sequence;
      polar(m) = q;
      f.measurements.push_back(m);
    }
    if (with_gps && i % 20 == 0) {
      const double t = 10 + i * 0.05;
      Measurement m;
      m.epoch = Time{} + seconds(t);
      m.source = 2;
      m.sequence = ++sequence;
      m.measured = Fix{};
      fix(m).position = truth_at(pad, t);
      for (int k = 0; k < 3; ++k) fix(m).position.m[k] += 5 * normal(rng);
      fix(m).velocity.m_s = (truth_at(pad, t + 0.01).m - truth_at(pad, t - 0.01).m) / 0.02;
      for (int k = 0; k < 3; ++k) fix(m).velocity.m_s[k] += 0.2 * normal(rng);
      fix(m).velocity_valid = true;
      fix(m).sigma_horizontal_m = fix(m).sigma_vertical_m = 5;
      fix(m).sigma_velocity_m_s = 0.2;
      f.measurements.push_back(m);
    }
  }
  std::sort(f.measurements.begin(), f.measurements.end(), processed_before);
  return f;
}

/// The same flight where every third plot of radar 0 has no angles and every third of radar 1 no range, and a tracker
/// at radar 0 sees what radar 1 does. Stations stand behind the tracker.
inline Flight with_partial_plots(Flight f) {
  constexpr int tracker = 2;
  f.settings.radars.push_back(
      {.site = f.settings.radars[0].site, .sigma = {0, 0.01 * deg, 0.01 * deg}, .bias = f.settings.radars[0].bias});
  f.settings.radars.back().bias.terms = {BiasTerm::OffsetAzimuth, BiasTerm::OffsetElevation};
  const Site pad({34.43 * deg, 127.53 * deg, 100});
  std::vector<Measurement> seen;
  std::array<int, 2> plots{};
  for (Measurement& m : f.measurements) {
    if (is_fix(m)) {
      m.source += 1;
      continue;
    }
    Plot& plot = std::get<Plot>(m.measured);
    const bool lacks = ++plots[static_cast<std::size_t>(m.source)] % 3 == 0;
    (m.source == 0 ? plot.angles_valid : plot.range_valid) = !lacks;
    if (m.source == 0) continue;
    const Polar q = polar_from_enu(f.settings.radars[0].site.enu_of(truth_at(pad, (m.epoch - Time{}).seconds())));
    Measurement angles = m;
    angles.source = tracker;
    angles.measured = Angles{.azimuth_rad = q.azimuth_rad, .elevation_rad = q.elevation_rad};
    seen.push_back(angles);
  }
  f.measurements.insert(f.measurements.end(), seen.begin(), seen.end());
  std::sort(f.measurements.begin(), f.measurements.end(), processed_before);
  return f;
}

/// The same flight where radars tell range rate, and a signal that comes and goes.
inline Flight with_range_rate(Flight f) {
  constexpr double sigma_m_s = 0.5;
  const Site pad({34.43 * deg, 127.53 * deg, 100});
  std::mt19937_64 rng(1);
  std::normal_distribution<double> normal;
  for (RadarModel& radar : f.settings.radars) {
    radar.sigma_range_rate_m_s = sigma_m_s;
    radar.snr = {.ref_db = 20, .at_ref = {10, 0, 0.01 * deg}, .range_rate_at_ref_m_s = sigma_m_s};
  }
  for (Measurement& m : f.measurements) {
    if (is_fix(m)) continue;
    constexpr double h = 0.01;
    const double t = (m.epoch - Time{}).seconds();
    const Site& site = f.settings.radars[static_cast<std::size_t>(m.source)].site;
    const auto range_at = [&](double at) { return site.enu_of(truth_at(pad, at)).m.norm(); };
    Plot& plot = std::get<Plot>(m.measured);
    plot.range_rate_m_s = (range_at(t + h) - range_at(t - h)) / (2 * h) + sigma_m_s * normal(rng);
    plot.range_rate_valid = true;
    plot.snr_db = 22 + 10 * std::sin(t);
    plot.snr_valid = true;
  }
  return f;
}

/// By the receiver alone.
inline Flight without_radars(Flight f) {
  const int radars = static_cast<int>(f.settings.radars.size());
  std::erase_if(f.measurements, [](const Measurement& m) { return !is_fix(m); });
  for (Measurement& m : f.measurements) m.source -= radars;
  f.settings.radars.clear();
  return f;
}

/// By one radar alone.
inline Flight with_one_radar(Flight f) {
  std::erase_if(f.measurements, [](const Measurement& m) { return m.source != 0; });
  f.settings.radars.resize(1);
  return f;
}

/// By a tracker and a receiver.
inline Flight without_radars_but_a_tracker(const Flight& all) {
  Flight f = with_partial_plots(all);
  const int tracker = static_cast<int>(f.settings.radars.size()) - 1;
  std::erase_if(f.measurements, [](const Measurement& m) { return std::holds_alternative<Plot>(m.measured); });
  for (Measurement& m : f.measurements) m.source -= tracker;
  f.settings.radars = {f.settings.radars.back()};
  return f;
}

/// By radars of range alone and a receiver.
inline Flight with_ranges_alone(Flight f) {
  for (Measurement& m : f.measurements) {
    if (auto* plot = std::get_if<Plot>(&m.measured)) {
      plot->angles_valid = false;
      plot->measured.azimuth_rad = plot->measured.elevation_rad = 0;
    }
  }
  return f;
}

/// What any method may meet: every kind of source, together and alone.
struct KindOfFlight {
  const char* sources;
  Flight flight;
};
inline std::vector<KindOfFlight> flights_of_all_kinds(std::uint64_t seed, double duration_s) {
  const Flight all = draw_flight(seed, duration_s, true);
  return {{"radars and a receiver", all},
          {"radars that tell range rate and signal, and a receiver", with_range_rate(all)},
          {"plots that lack a part, a tracker, a receiver", with_partial_plots(all)},
          {"a tracker and a receiver", without_radars_but_a_tracker(all)},
          {"radars of range alone and a receiver", with_ranges_alone(all)},
          {"radars alone", draw_flight(seed, duration_s, true, false)},
          {"one radar alone", with_one_radar(draw_flight(seed, duration_s, true, false))},
          {"a receiver alone", without_radars(all)}};
}

struct Flown {
  double rms_m = 0;
  double inside95 = 0;
};

inline Flown fly(Method& method, const Flight& f, double from_s) {
  const Site pad({34.43 * deg, 127.53 * deg, 100});
  double sum = 0;
  int inside = 0;
  int n = 0;
  for (const Measurement& m : f.measurements) {
    (void)method.process(m, m.epoch);
    const auto e = method.fused(0);
    if (!e || m.epoch < Time{} + seconds(from_s)) continue;
    const Vec<3> error = e->mean.head<3>() - truth_at(pad, (e->epoch - Time{}).seconds()).m;
    sum += error.squaredNorm();
    inside += error.dot(e->cov.topLeftCorner<3, 3>().llt().solve(error)) <= chi2_quantile(0.95, 3) ? 1 : 0;
    ++n;
  }
  return {std::sqrt(sum / n), static_cast<double>(inside) / n};
}

}  // namespace downrange::test
