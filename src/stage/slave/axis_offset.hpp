#pragma once
/// What an antenna's axes are told beside where it shall point: an operator's trim and the mount's own error.

namespace downrange {

/// Goes over to a new value at a rate on the sky.
class AxisOffset {
 public:
  explicit AxisOffset(double rate_rad_s) : rate_rad_s_(rate_rad_s) {}

  void want(double azimuth_rad, double elevation_rad);
  /// `dt_s` later.
  void step(double dt_s, double cos_elevation);
  /// At once.
  void jump();

  [[nodiscard]] double azimuth_rad() const { return azimuth_.now; }
  [[nodiscard]] double elevation_rad() const { return elevation_.now; }
  [[nodiscard]] double azimuth_rate_rad_s() const { return azimuth_.rate; }
  [[nodiscard]] double elevation_rate_rad_s() const { return elevation_.rate; }
  /// What it goes over to: an antenna whose axes have that added points where it shall.
  [[nodiscard]] double wanted_azimuth_rad() const { return azimuth_.wanted; }
  [[nodiscard]] double wanted_elevation_rad() const { return elevation_.wanted; }

 private:
  struct Axis {
    double now = 0;
    double rate = 0;
    double wanted = 0;
  };
  double rate_rad_s_;
  Axis azimuth_;
  Axis elevation_;
};

}  // namespace downrange
