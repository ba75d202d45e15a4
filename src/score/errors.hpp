#pragma once
/// What an error is: one definition of each, for the report, the experiments and their tests.

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/est/filter/gaussian.hpp>
#include <downrange/geo/polar.hpp>
#include <downrange/geo/refraction.hpp>
#include <downrange/stage/range_config.hpp>
#include <downrange/stage/result.hpp>
#include <map>
#include <vector>

namespace downrange::score {

/// Sum of squares; of a bound, of expected squares.
struct Squares {
  double sum = 0;
  long count = 0;

  void add(double square) {
    sum += square;
    ++count;
  }
  Squares& operator+=(const Squares& other) {
    sum += other.sum;
    count += other.count;
    return *this;
  }
  /// NaN where nothing was added.
  [[nodiscard]] double rms() const { return std::sqrt(sum / static_cast<double>(count)); }
};

/// How many of how many.
struct Share {
  long inside = 0;
  long count = 0;

  void add(bool is_inside) {
    inside += is_inside ? 1 : 0;
    ++count;
  }
  Share& operator+=(const Share& other) {
    inside += other.inside;
    count += other.count;
    return *this;
  }
  /// NaN of nothing.
  [[nodiscard]] double value() const { return static_cast<double>(inside) / static_cast<double>(count); }
};

/// Magnitudes of errors, summed up. Of none, all are zero and say nothing.
struct Spread {
  std::size_t count = 0;
  double rms = 0;
  double p95 = 0;  ///< smallest error that 95 % of them do not exceed
  double worst = 0;
};
[[nodiscard]] Spread spread_of(std::vector<double> errors);

/// Whether a normalised square (NIS, NEES) is inside the 95 % region of chi2(dof); NaN is not.
[[nodiscard]] bool inside_95(double square, int dof);

/// Errors of a flight are alike over so long: a share, or a mean, over T has T / tau independent values.
inline constexpr double alike_for_s = 60;

/// Where the true share may be, 95 %, behind a share of `independent` values, which need not be a whole number:
/// Clopper, Pearson 1934 (doi 10.1093/biomet/26.4.404), its counts read as real numbers. 0 to 1 for less than one
/// value.
[[nodiscard]] Band honest_band(double share, double independent);

/// Covariance of a trajectory record's state.
[[nodiscard]] Eigen::MatrixXd covariance_of(const Trajectory& trajectory);

/// Position of a trajectory record, carried on at its velocity (and acceleration, where it has one) to `epoch`.
[[nodiscard]] Gaussian<3> position_at(const Trajectory& trajectory, Time epoch);

/// measured - true of a plot; azimuth on the sky: times the cosine of the true elevation.
[[nodiscard]] Eigen::Vector3d plot_error(const Polar& measured, const Polar& truth);

/// The bias's time tag; 0 where it has none.
[[nodiscard]] double time_tag_of(const SensorBias& bias);

/// A plot corrected for the bias, and then for the refraction of `air` where the radar's is modelled (null: it is not).
[[nodiscard]] Polar corrected(const Polar& measured, const SensorBias& bias, const RefractionTable* air);

/// A target as an antenna should point at it: with the refraction of `air` (null: none).
[[nodiscard]] Polar pointing_at(const Site& site, const RefractionTable* air, const Position<Ecef>& target);

/// The refraction tables of a range's antennas: each that has a refractivity (50 ms apiece).
[[nodiscard]] std::map<Name, RefractionTable> air_of_antennas(const RangeConfig& range);

/// Whether the antenna's travel and horizon have a place for a look.
[[nodiscard]] bool can_point_at(const AntennaConfig& antenna, const Polar& look);

/// Angle between where a command points and where the target is. The mount's own error that it has in it is taken out.
[[nodiscard]] double pointing_error(const SlavingCommand& command, const Polar& look);

/// How many of a command's two axes are within 2 sigma of the target, likewise.
[[nodiscard]] int axes_within_2_sigma(const SlavingCommand& command, const Polar& look);

}  // namespace downrange::score
