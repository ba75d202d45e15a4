#include "stage/slave/blend.hpp"

#include <cmath>
#include <utility>

namespace downrange {

void Blend::apply(Time tick, const Origin& origin, AxisMotion& azimuth, AxisMotion& elevation) {
  const auto last = std::exchange(previous_, Previous{tick, origin, azimuth, elevation});
  if (!last || tick - last->tick > longest_blended_gap) {
    azimuth_rad_ = elevation_rad_ = 0;
    return;
  }
  const double dt = (tick - last->tick).seconds();
  if (last->origin != origin) {
    azimuth_rad_ = wrap_pi(last->azimuth.angle_rad + dt * last->azimuth.rate_rad_s - azimuth.angle_rad);
    elevation_rad_ = last->elevation.angle_rad + dt * last->elevation.rate_rad_s - elevation.angle_rad;
  }
  const double away = std::hypot(azimuth_rad_ * std::cos(elevation.angle_rad), elevation_rad_);
  const double step = rate_rad_s_ * dt;
  const double shrink = away > step ? step / away : 1;
  azimuth.rate_rad_s -= shrink * azimuth_rad_ / dt;
  elevation.rate_rad_s -= shrink * elevation_rad_ / dt;
  azimuth_rad_ *= 1 - shrink;
  elevation_rad_ *= 1 - shrink;
  azimuth.angle_rad += azimuth_rad_;
  elevation.angle_rad += elevation_rad_;
  previous_->azimuth.angle_rad = azimuth.angle_rad;
  previous_->elevation.angle_rad = elevation.angle_rad;
}

void Blend::was(const AxisMotion& azimuth, const AxisMotion& elevation) {
  if (!previous_) return;
  previous_->azimuth = azimuth;
  previous_->elevation = elevation;
}

}  // namespace downrange
