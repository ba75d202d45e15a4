#include "stage/slave/axis_offset.hpp"

#include <cmath>

namespace downrange {

void AxisOffset::want(double azimuth_rad, double elevation_rad) {
  azimuth_.wanted = azimuth_rad;
  elevation_.wanted = elevation_rad;
}

void AxisOffset::step(double dt_s, double cos_elevation) {
  const double azimuth = azimuth_.wanted - azimuth_.now;
  const double elevation = elevation_.wanted - elevation_.now;
  const double away = std::hypot(azimuth * cos_elevation, elevation);
  const double most = rate_rad_s_ * dt_s;
  const double share = away > most ? most / away : 1;
  const auto move = [&](Axis& axis, double by) {
    axis.now = share == 1 ? axis.wanted : axis.now + share * by;
    axis.rate = share * by / dt_s;
  };
  move(azimuth_, azimuth);
  move(elevation_, elevation);
}

void AxisOffset::jump() {
  azimuth_ = {.now = azimuth_.wanted, .wanted = azimuth_.wanted};
  elevation_ = {.now = elevation_.wanted, .wanted = elevation_.wanted};
}

}  // namespace downrange
