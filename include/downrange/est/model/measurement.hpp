#pragma once
/// What the methods are given.

#include <cstdint>
#include <downrange/est/model/matrix.hpp>
#include <downrange/est/model/measured.hpp>
#include <downrange/geo/time.hpp>

namespace downrange {

/// An accepted measurement.
struct Measurement {
  Time epoch;
  int source = 0;  ///< dense over all kinds: MethodSettings::radars, then the telemetry stations
  int target = 0;
  std::uint64_t sequence = 0;
  Measured measured;
  bool in_flight = false;  ///< the vehicle is known to have left its pad
  /// Nothing is learnt of the source's noise: INTEGRITY doubts it, or the vehicle stands on its pad, where errors stay
  /// alike for long.
  bool noise_held = false;
  /// An operator's order that came before it: the sensor's bias begins anew, with its prior, before this one is used.
  bool reset_bias = false;
};

[[nodiscard]] inline bool is_fix(const Measurement& m) { return std::holds_alternative<Fix>(m.measured); }
/// Of a measurement that is one.
[[nodiscard]] inline const Fix& fix_of(const Measurement& m) { return std::get<Fix>(m.measured); }

/// The order of processing: (epoch, source, target, sequence).
[[nodiscard]] bool processed_before(const Measurement& a, const Measurement& b);

/// Position covariance of a fix, ECEF, m^2.
[[nodiscard]] Mat<3, 3> fix_covariance(const Fix& fix);

}  // namespace downrange
