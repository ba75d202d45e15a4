#pragma once
/// A flight over Jeju whose results have the errors that a test asks for.

#include <cmath>
#include <initializer_list>
#include <numbers>
#include <optional>
#include <utility>

#include "score/scorer.hpp"

namespace downrange::score::test {

inline constexpr double deg = std::numbers::pi / 180;
inline constexpr Time liftoff{1'772'352'000'000'000'000};

inline RangeConfig make_range() {
  RangeConfig range;
  range.fuse.methods = {"song2015"};
  range.targets = {{"kslv"}};
  RadarConfig radar;
  radar.sigma = {10, 1e-3, 1e-3};
  radar.id = "goheung";
  radar.site = Site({34.4450 * deg, 127.5200 * deg, 120});
  range.radars = {radar};
  AntennaConfig antenna;
  antenna.id = "dish";
  antenna.site = Site({34.0 * deg, 127.0 * deg, 50});
  range.antennas = {antenna};
  return range;
}

/// Straight and level over Jeju, known from lift-off to 100 s.
inline std::optional<TrueState> truth(Time t) {
  const double t_s = (t - liftoff).seconds();
  if (t_s < 0 || t_s > 100) return std::nullopt;
  static const Position<Ecef> start = ecef_from_geodetic({33.5 * deg, 127.2 * deg, 80e3});
  const Eigen::Vector3d v(900, 400, -700);
  return TrueState{{start.m + v * t_s}, {v}};
}

inline Time at(double t_s) { return liftoff + seconds(t_s); }

/// Off by `error` (ECEF), claiming `sigma` on every position axis.
inline Trajectory make_trajectory(double t_s, const Eigen::Vector3d& error, double sigma,
                                  const Name& method = "song2015") {
  Trajectory trajectory;
  trajectory.target = "kslv";
  trajectory.method = method;
  trajectory.primary = method == Name("song2015");
  trajectory.epoch = at(t_s);
  const auto state = truth(at(t_s));
  if (state) Eigen::Vector3d::Map(trajectory.state.data()) = state->position.m + error;
  trajectory.covariance[0] = sigma * sigma;   // xx of the 6 x 6 triangle
  trajectory.covariance[6] = sigma * sigma;   // yy
  trajectory.covariance[11] = sigma * sigma;  // zz
  return trajectory;
}

inline Observation make_plot(std::uint64_t sequence, double t_s, const Polar& bias, double time_tag_s = 0) {
  Observation plot;
  plot.sensor = "goheung";
  plot.target = "kslv";
  plot.sequence = sequence;
  plot.epoch = at(t_s);
  const Polar q = polar_from_enu(make_range().radars[0].site.enu_of(truth(at(t_s - time_tag_s))->position));
  plot.measured = Plot{.measured = {q.range_m + bias.range_m, wrap_two_pi(q.azimuth_rad + bias.azimuth_rad),
                                    q.elevation_rad + bias.elevation_rad}};
  return plot;
}

inline SensorBias make_bias(std::initializer_list<std::pair<BiasTerm, double>> terms) {
  SensorBias bias;
  bias.sensor = "goheung";
  bias.method = "song2015";
  for (const auto& [term, value] : terms) {
    bias.term[static_cast<std::size_t>(bias.terms)] = term;
    bias.value[static_cast<std::size_t>(bias.terms++)] = value;
  }
  return bias;
}

inline Polar look(double t_s) { return polar_from_enu(make_range().antennas[0].site.enu_of(truth(at(t_s))->position)); }

inline SlavingCommand make_command(double t_s, double azimuth_error_rad, double elevation_error_rad, double sigma_rad) {
  SlavingCommand command;
  command.antenna = "dish";
  command.target = "kslv";
  command.apply_at = at(t_s);
  command.age_s = 0.1;
  command.azimuth_rad = look(t_s).azimuth_rad + azimuth_error_rad;
  command.elevation_rad = look(t_s).elevation_rad + elevation_error_rad;
  command.sigma_azimuth_rad = sigma_rad;
  command.sigma_elevation_rad = sigma_rad;
  return command;
}

inline SourceHealth make_health(double t_s, std::uint64_t accepted, std::uint64_t gated, int nis_count, double share) {
  SourceHealth health;
  health.sensor = "goheung";
  health.time = at(t_s);
  health.count[static_cast<std::size_t>(Reason::Accepted)] = accepted;
  health.count[static_cast<std::size_t>(Reason::Gated)] = gated;
  health.nis_count = nis_count;
  health.nis_inside_95 = share;
  health.mismatch = nis_count == 1000 && share < 0.93;
  return health;
}

inline Scorer make_scorer(const RangeConfig& range = make_range()) {
  return {range, "kslv", truth, liftoff, {{"first", 0, 50}, {"second", 50, 60}, {"empty", 200, 300}}};
}

/// With an antenna that cannot be pointed at the target.
inline RangeConfig make_range_out_of_sight() {
  RangeConfig range = make_range();
  range.antennas[0].elevation_min_rad = 89 * deg;
  return range;
}

}  // namespace downrange::score::test
