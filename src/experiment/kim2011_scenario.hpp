#pragma once
/// What the experiment of kim2011 section 7 looks at: two radars in a plane, 32 targets, plots that come in turn.

#include <array>
#include <cstdint>
#include <downrange/est/filter/gaussian.hpp>
#include <vector>
#include "experiment/biased_track.hpp"

namespace downrange::experiment::kim2011 {

inline constexpr int sensors = 2;
inline constexpr int targets = 32;
inline constexpr int scans = 120;  ///< both sensors' together, numbered from 1: odd ones sensor 1, even ones sensor 2
inline constexpr double scan_s = 0.5;
inline constexpr double sigma_range_m = 10;
inline constexpr double sigma_azimuth_rad = 1e-3;
inline constexpr double q_m2_s3 = 6;  ///< white acceleration, of the targets and in the filters

/// Terms of one sensor: offsets of range (m) and azimuth (rad), scales of the same (1); azimuth is atan2(y, x) here,
/// and its scale multiplies all of it. measured = true + b + eps true.
inline constexpr int terms = 4;
inline constexpr int biases = sensors * terms;
[[nodiscard]] Vec<terms> true_bias();
/// Of all sensors: zero with the paper's covariance.
[[nodiscard]] Gaussian<biases> bias_prior();
/// Of a target's start: the truth with an error of this covariance, state [x y vx vy].
[[nodiscard]] Mat<4, 4> start_covariance();

[[nodiscard]] constexpr int sensor_of(int scan) { return (scan - 1) % sensors; }

/// Nearly constant velocity over dt seconds, (42), (43).
[[nodiscard]] Mat<4, 4> transition(double dt);
[[nodiscard]] Mat<4, 4> process_noise(double dt);

/// A predicted plot (range, azimuth) of a sensor with bias beta, and its Jacobians.
struct PlanarPlot {
  Vec<2> q;
  Mat<2, 4> d_state;
  Mat<2, terms> d_bias;
};
[[nodiscard]] PlanarPlot predict_plot(int sensor, const Vec<4>& x, const Vec<terms>& beta);
/// Plot minus prediction, azimuth wrapped.
[[nodiscard]] Vec<2> residual(const Vec<2>& plot, const Vec<2>& predicted);
[[nodiscard]] Mat<2, 2> plot_noise();

/// (2)-(6): the plot in Cartesian axes, bias matrix and noise taken at the plot.
[[nodiscard]] BiasedPosition<2, terms> converted(int sensor, const Vec<2>& plot);

/// One run. Targets are in the order of their distance from sensor 1 at the start: 0 is the paper's track 1.
struct Draw {
  /// [scan 0 ... scans][target]; scan 0 is the start.
  std::vector<std::array<Vec<4>, targets>> truth;
  std::vector<std::array<Vec<2>, targets>> plots;
  /// Each radar's own start of each target: truth with an error of `start_covariance`.
  std::array<std::array<Vec<4>, targets>, sensors> start;
};
[[nodiscard]] Draw draw(std::uint64_t seed, int run);

}  // namespace downrange::experiment::kim2011
