#pragma once
/// How far what a mount reads is from where it points.

#include <downrange/geo/time.hpp>
#include <downrange/stage/range_config.hpp>
#include <optional>

namespace downrange {

/// Of a mount whose tracker or radar is known.
struct MountNoise {
  double sigma_azimuth_rad = 0;  ///< of one reading, 1-sigma
  double sigma_elevation_rad = 0;
  bool azimuth_sigma_on_sky = false;
  double prior_rad = 0;  ///< what is assumed of its error before any reading, 1-sigma per axis
  double drift_azimuth_rad_sqrt_s = 0;
  double drift_elevation_rad_sqrt_s = 0;
};

/// None: the antenna has no such sensor.
[[nodiscard]] std::optional<MountNoise> mount_noise(const RangeConfig& range, const AntennaConfig& antenna);

/// What the mount reads too much, and how well that is known (1-sigma).
struct MountOffset {
  double azimuth_rad = 0;
  double elevation_rad = 0;
  double sigma_azimuth_rad = 0;
  double sigma_elevation_rad = 0;
};

/// Per axis a Kalman filter of two errors that each reading has: the mount's (a random walk), and what the followed
/// track is off at this place (correlated over `track_tau_s`, as large as the track says). What is added to commands is
/// both: with the track that is followed the antenna then meets what it saw. Where nothing is read any more the second
/// fades. A mount that was bumped is told by readings that stay away for a second, and begins anew.
class MountError {
 public:
  static constexpr Duration settles_in = milliseconds(1000);
  static constexpr int settles_with = 5;
  static constexpr double track_tau_s = 5;

  MountError(const MountNoise& noise, double most_rad);

  /// A reading minus where the followed track was then, and that one's 1-sigma of the same angles.
  void note(Time epoch, double azimuth_rad, double elevation_rad, double cos_elevation, double track_azimuth_rad,
            double track_elevation_rad);

  /// Of an error beyond `most_rad` nothing is taken out: the mount tracks something else, a side lobe perhaps.
  [[nodiscard]] MountOffset at(Time t) const;

 private:
  struct Axis {
    double mount = 0;
    double track = 0;
    double P_mount = 0;
    double P_track = 0;
    double P_both = 0;  ///< covariance of the two

    void predict(double drift_rad_sqrt_s, double track_sigma_rad, double dt_s);
    void update(double innovation, double variance);
    [[nodiscard]] double variance() const { return P_mount + 2 * P_both + P_track; }
  };
  void begin_anew();
  void tell(Time epoch);

  MountNoise noise_;
  double most_rad_;
  Axis azimuth_;
  Axis elevation_;
  std::optional<Time> newest_;
  Time begun_;          ///< with this reading
  int taken_ = 0;       ///< readings since
  int refused_ = 0;     ///< in a row
  Time refused_since_;  ///< first of these
  /// What is known: of the readings up to `told_`, beyond `most_rad` nothing.
  std::optional<Time> told_;
  Axis told_azimuth_;
  Axis told_elevation_;
};

}  // namespace downrange
