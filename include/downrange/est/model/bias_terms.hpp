#pragma once
/// The terms of a radar's bias and how they are taken out of a measurement.

#include <Eigen/Core>
#include <cstdint>
#include <downrange/geo/polar.hpp>
#include <downrange/geo/site.hpp>
#include <initializer_list>
#include <span>
#include <string_view>
#include <vector>

namespace downrange {

/// What one entry of a bias vector means. Order is the wire's: append only.
enum class BiasTerm : std::uint8_t {
  OffsetSouth,  ///< m, measured = true + b, radar's SEZ axes (block sez_offset)
  OffsetEast,
  OffsetZenith,
  ScaleSouth,  ///< 1, measured = (1 + eps) true per SEZ axis (block sez_scale)
  ScaleEast,
  ScaleZenith,
  OffsetRange,  ///< m, measured = true + b (block polar)
  OffsetAzimuth,
  OffsetElevation,
  ScaleRange,    ///< 1, measured = true + eps true
  ScaleAzimuth,  ///< 1, measured = true + eps wrap(true - south)
  ScaleElevation,
  TimeTag,  ///< s, positive: the radar's clock is fast, its stamps are later than the truth (block time)
};
inline constexpr int bias_term_count = 13;
enum class BiasState : std::uint8_t { Estimating, Converged, NotObservable, Frozen };
enum class BiasReference : std::uint8_t { None, Gps, CrossRadar };

[[nodiscard]] std::string_view to_string(BiasTerm term);
[[nodiscard]] std::string_view to_string(BiasState state);

/// Which terms a radar's bias has, what they may be before any data and how they drift (est/THEORY.md section 3).
/// Vectors and matrices are indexed by BiasTerm; entries of terms that are not in `terms` mean nothing.
struct BiasModel {
  std::vector<BiasTerm> terms;  ///< in ascending order
  Eigen::Matrix<double, bias_term_count, 1> prior_mean = Eigen::Matrix<double, bias_term_count, 1>::Zero();
  Eigen::Matrix<double, bias_term_count, bias_term_count> prior_cov =
      Eigen::Matrix<double, bias_term_count, bias_term_count>::Identity();
  /// Random walk per square root of a second, in the term's unit. 0: constant.
  Eigen::Matrix<double, bias_term_count, 1> drift = Eigen::Matrix<double, bias_term_count, 1>::Zero();
};

/// Groups of terms that are switched together.
enum class BiasBlock : std::uint8_t { Polar, SezOffset, SezScale, Time };

/// The model of the given blocks with the default priors: offsets 100 m and 0.2 deg, scales 1e-4 of range and 1e-3 of
/// angles (polar), 100 m (sez_offset), 3e-4 (sez_scale), 20 ms (time); no drift.
[[nodiscard]] BiasModel bias_model(std::initializer_list<BiasBlock> blocks);
[[nodiscard]] BiasModel bias_model(std::span<const BiasBlock> blocks);

/// Takes the given bias out of a measurement: SEZ offsets and scales first, then polar offsets and scales, all
/// evaluated at the measured point (the difference to the true point is of second order in the bias). TimeTag moves the
/// epoch, not the measurement, and is left to the caller. `term` and `value` have equal sizes.
[[nodiscard]] Polar compensate(const Polar& measured, std::span<const BiasTerm> term, std::span<const double> value);

}  // namespace downrange
