#pragma once
/// The terms of a radar's bias and how they are taken out of a measurement.

#include <cstdint>
#include <downrange/geo/polar.hpp>
#include <downrange/geo/site.hpp>
#include <span>
#include <string_view>

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

/// Takes the given bias out of a measurement: SEZ offsets and scales first, then polar offsets and scales, all
/// evaluated at the measured point (the difference to the true point is of second order in the bias). TimeTag moves the
/// epoch, not the measurement, and is left to the caller. `term` and `value` have equal sizes.
[[nodiscard]] Polar compensate(const Polar& measured, std::span<const BiasTerm> term, std::span<const double> value);

}  // namespace downrange
