#pragma once
/// Residuals of one radar with the band that the filter promises, as song2015 draws them (fig. 5 and 6).

#include <Eigen/Core>
#include <array>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "experiment/experiment.hpp"

namespace downrange::experiment {

/// One coordinate of a plot.
struct Component {
  std::string_view name;
  std::string_view unit;
  Eigen::Index index;
  double scale;  ///< one `unit` in SI
};
inline constexpr double mdeg = std::numbers::pi / 180 / 1000;
inline constexpr std::array<Component, 3> components{
    Component{"Range", "m", 0, 1}, Component{"Azimuth", "mdeg", 1, mdeg}, Component{"Elevation", "mdeg", 2, mdeg}};

/// A plot against the track just before it, the bias known then taken out.
struct Residual {
  double t_s = 0;                                   ///< after lift-off
  Eigen::Vector3d value = Eigen::Vector3d::Zero();  ///< range (m), azimuth, elevation (rad)
  Eigen::Vector3d sigma = Eigen::Vector3d::Zero();  ///< of the same, from the track's covariance and the plot's noise
};

/// At most 600 of the residuals, evenly taken, and +-2 sigma; those that are far outside are drawn on the edge. `row`:
/// as Plot has it.
[[nodiscard]] Plot residual_plot(std::string title, std::string row, const std::vector<Residual>& residuals,
                                 const Component& component);

}  // namespace downrange::experiment
