#pragma once
/// What a source measures of a target. SI and radians.

#include <cstdint>
#include <downrange/geo/frames.hpp>
#include <downrange/geo/polar.hpp>
#include <variant>

namespace downrange {

/// Of a radar. measured = true + bias + noise. What is not valid means nothing: a radar may tell range alone, or angles
/// alone.
struct Plot {
  Polar measured{};
  bool range_valid = true;
  bool angles_valid = true;
  double range_rate_m_s = 0;  ///< positive: the target recedes
  bool range_rate_valid = false;
  double snr_db = 0;
  bool snr_valid = false;

  bool operator==(const Plot&) const = default;
};

/// Of a vehicle's own receiver, the accuracies as they hold (stated, or configured where nothing is stated).
struct Fix {
  Position<Ecef> position{};
  Velocity<Ecef> velocity{};
  bool velocity_valid = false;
  double sigma_horizontal_m = 0;  ///< 1-sigma per axis
  double sigma_vertical_m = 0;
  double sigma_velocity_m_s = 0;

  bool operator==(const Fix&) const = default;
};

/// Of a telemetry antenna or an optical tracker: the direction it follows. measured = true + bias + noise.
struct Angles {
  double azimuth_rad = 0;
  double elevation_rad = 0;

  bool operator==(const Angles&) const = default;
};

/// The alternatives are in the order of the wire's ObservationKind: append only.
using Measured = std::variant<Plot, Fix, Angles>;

/// Of what a sensor on the ground saw (no fix): angles alone are a plot without range.
[[nodiscard]] inline Plot plot_of(const Measured& measured) {
  if (const auto* angles = std::get_if<Angles>(&measured))
    return {.measured = {0, angles->azimuth_rad, angles->elevation_rad}, .range_valid = false};
  return std::get<Plot>(measured);
}

/// It says by itself where the target is, so that a track may start with it: a fix, or a plot of range and angles.
[[nodiscard]] inline bool tells_position(const Measured& measured) {
  if (std::holds_alternative<Fix>(measured)) return true;
  const Plot plot = plot_of(measured);
  return plot.range_valid && plot.angles_valid;
}

}  // namespace downrange
