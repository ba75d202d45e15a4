#pragma once
/// What the methods are given.

#include <cstdint>
#include <downrange/est/model/matrix.hpp>
#include <downrange/geo/frames.hpp>
#include <downrange/geo/polar.hpp>
#include <downrange/geo/time.hpp>

namespace downrange {

/// An accepted radar plot or GPS fix. Sources are counted radars first, then telemetry stations, as configured.
struct Measurement {
  enum class Kind : std::uint8_t { Radar, Gps };

  Time epoch;
  Kind kind = Kind::Radar;
  int source = 0;  ///< index of the radar, or of the telemetry station
  int target = 0;
  std::uint64_t sequence = 0;
  Polar plot;               ///< Radar
  Position<Ecef> position;  ///< Gps
  Velocity<Ecef> velocity;  ///< Gps, where velocity_valid
  bool velocity_valid = false;
  bool in_flight = false;  ///< the vehicle is known to have left its pad
  double sigma_horizontal_m = 0;
  double sigma_vertical_m = 0;
  double sigma_velocity_m_s = 0;
};

/// The order of processing: (epoch, source, target, sequence); radars before stations.
[[nodiscard]] bool processed_before(const Measurement& a, const Measurement& b);

/// Position covariance of a fix, ECEF, m^2.
[[nodiscard]] Mat<3, 3> fix_covariance(const Measurement& fix);

}  // namespace downrange
