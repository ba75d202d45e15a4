#pragma once
/// What the engine needs to know of a range. Plain values, SI and radians; filled and validated by src/config.

#include <cstdint>
#include <numbers>
#include <optional>
#include <vector>

#include <downrange/est/method/method.hpp>
#include <downrange/est/model/impact.hpp>
#include <downrange/geo/ground_polygon.hpp>
#include <downrange/geo/name.hpp>
#include <downrange/geo/nominal_trajectory.hpp>
#include <downrange/geo/polar.hpp>
#include <downrange/geo/site.hpp>
#include <downrange/geo/time.hpp>

namespace downrange {

/// One size per kind of bias term.
struct BiasSizes {
  double range_m = 0;  ///< block polar
  double angle_rad = 0;
  double range_scale = 0;
  double angle_scale = 0;
  double sez_offset_m = 0;  ///< block sez_offset
  double sez_scale = 0;     ///< block sez_scale
  double time_tag_s = 0;    ///< block time
};

/// What an earlier flight or a survey found of some terms of a sensor's bias: their prior instead of the sizes below.
struct BiasCalibration {
  std::vector<BiasTerm> terms;  ///< empty: no calibration; else terms of the configured blocks, each once
  Eigen::VectorXd mean;
  Eigen::MatrixXd cov;  ///< positive definite
};

/// polar, sez_offset, time.
[[nodiscard]] std::vector<BiasBlock> default_bias_blocks();

/// What a radar's bias is made of (est/THEORY.md section 3), for the methods that leave it open (joint, schmidt, ts).
struct BiasConfig {
  std::vector<BiasBlock> blocks = default_bias_blocks();
  /// 1-sigma before any data.
  BiasSizes prior{.range_m = 100,
                  .angle_rad = 0.2 * std::numbers::pi / 180,
                  .range_scale = 1e-4,
                  .angle_scale = 1e-3,
                  .sez_offset_m = 100,
                  .sez_scale = 3e-4,
                  .time_tag_s = 0.02};
  BiasSizes drift;  ///< random walk per square root of a second
  BiasCalibration calibration;
};

/// The terms of the blocks with their priors, the calibration's where it has them, and drifts.
[[nodiscard]] BiasModel bias_model_of(const BiasConfig& config);

/// What a radar measures of a target.
struct MeasuredParts {
  bool range = true;
  bool angles = true;

  bool operator==(const MeasuredParts&) const = default;
};

struct RadarConfig {
  Name id;
  Site site;
  MeasuredParts measures;             ///< one of them at least; what it does not measure is not taken of its plots
  PolarSigma sigma;                   ///< instrument noise, 1-sigma, of what it measures
  double sigma_range_rate_m_s = 0;    ///< 0: its range rate is not used
  SnrNoise snr{};                     ///< what is added where the signal is weak
  double angle_inflation = 4;         ///< on the angle variances, for slow pointing errors (est/THEORY.md section 4a)
  PointingWander wander{};            ///< states of joint and schmidt; 0: half of sigma over 100 s where inflated
  bool azimuth_sigma_on_sky = false;  ///< sigma of azimuth is on the sky: the axis's own is that over cos(elevation)
  double refractivity = 0;            ///< N-units at the site; 0: plots are free of refraction, or corrected already
  BiasConfig bias;
  double rate_hz = 10;  ///< nominal plot rate
  double range_min_m = 0;
  double range_max_m = 4e6;
  double elevation_min_rad = 0;
  double elevation_max_rad = std::numbers::pi / 2;
};

/// 0 for what it does not measure.
[[nodiscard]] PolarSigma measured_sigma(const RadarConfig& radar);
/// Without the terms of what it does not measure.
[[nodiscard]] BiasModel bias_model_of(const RadarConfig& radar);

/// A telemetry antenna or an optical tracker that reports the direction it tracks.
struct AngleSensorConfig {
  Name id;
  Site site;
  double sigma_azimuth_rad = 0;  ///< instrument noise, 1-sigma
  double sigma_elevation_rad = 0;
  bool azimuth_sigma_on_sky = false;  ///< as RadarConfig, the next two likewise
  double angle_inflation = 4;
  PointingWander wander{};
  double refractivity = 0;
  double rate_hz = 10;
  double elevation_min_rad = 0;
  double elevation_max_rad = std::numbers::pi / 2;
  double bias_prior_rad = 0.2 * std::numbers::pi / 180;  ///< offset of each angle before any data, 1-sigma
  double bias_drift_rad_sqrt_s = 0;
  BiasCalibration calibration{};
};

/// The offsets of both angles.
[[nodiscard]] BiasModel bias_model_of(const AngleSensorConfig& config);

/// A telemetry ground station: relays GPS fixes.
struct TelemetryConfig {
  Name id;
  Site site;
};

/// The vehicle's receiver. A message may state that it is worse; no receiver is believed to be better.
struct GpsConfig {
  GpsUseSettings use;
  double sigma_horizontal_m = 5;
  double sigma_vertical_m = 8;
  double sigma_velocity_m_s = 0.2;
  int min_satellites = 4;  ///< fixes that state fewer are rejected
};

/// An antenna is not pointed lower than this at that azimuth; between two points the line.
struct HorizonPoint {
  double azimuth_rad = 0;  ///< [0, 2 pi)
  double elevation_rad = 0;
};

struct AntennaConfig {
  Name id;
  Site site;
  Name target;  ///< what it follows; empty: the first target
  Name sensor;  ///< tracker or radar on the same mount: what it reads is how the mount points; empty: none
  double mount_error_max_rad = 1 * std::numbers::pi / 180;  ///< per axis; a larger one is not taken out of its commands
  bool moves = false;  ///< on a ship or an aircraft: range/platform tells where it is; no command before
  double azimuth_min_rad = -1.5 * std::numbers::pi;  ///< travel, cable wrap included
  double azimuth_max_rad = 1.5 * std::numbers::pi;
  double elevation_min_rad = 0;
  double elevation_max_rad = std::numbers::pi / 2;  ///< beyond the zenith: the mount can plunge
  double azimuth_rate_max_rad_s = 0.2;
  double elevation_rate_max_rad_s = 0.2;
  double azimuth_acceleration_max_rad_s2 = 0;  ///< 0: not known, and passes near the zenith are not planned
  double elevation_acceleration_max_rad_s2 = 0;
  std::vector<HorizonPoint> horizon{};  ///< ascending azimuth; empty: elevation_min all around
  double beamwidth_rad = 0;             ///< full width of the beam; 0: not known
  double refractivity = 0;              ///< N-units at the site; 0: pointed at the target without refraction
  Duration link_delay;                  ///< command leaves the node -> antenna control unit has it
  Duration lead;                        ///< servo lag to be led
};

struct IngestConfig {
  Duration max_future = milliseconds(100);
  bool expect_simulated = false;  ///< the `simulated` flag every input must carry
};

/// Bias estimation: the methods' own settings.
struct AlignConfig {
  GpsSettings gps;
  CartesianBiasSettings cartesian_bias;
};

struct FuseConfig {
  ArbitrationSettings arbitration;
  StartSettings start;
  KinematicsSettings motion;
  AdaptiveNoiseSettings noise;
  CartesianFusionSettings cartesian_fusion;
  QuickLookSettings quick_look;
  std::vector<Name> methods{"joint"};   ///< side by side; SLAVE points by the first
  bool publish_on_data = true;          ///< trajectory with each measurement; false: on the tick
  Duration stale = milliseconds(500);   ///< newest measurement older than this: the trajectory is coasting
  Duration coast = milliseconds(5000);  ///< older than this: no trajectory on the tick
  bool publish_chains = false;          ///< those of INTEGRITY's chains as well, ten times a second
};

struct SlaveConfig {
  Duration stale = milliseconds(500);     ///< newest measurement older than this: coasting
  Duration coast = milliseconds(5000);    ///< coasting longer than this: next source of the ladder, or no command
  double coast_sigma_max_m = 5000;        ///< position 1-sigma above which coasting ends as well
  Duration validity = milliseconds(200);  ///< valid_until - apply_at
  /// After a change of what is followed, commands move no faster against the target than this, on the sky.
  double blend_rate_rad_s = 5 * std::numbers::pi / 180;
  /// Of an antenna whose beamwidth is known: coasting ends where it is less probable than this that the target is in
  /// the beam; beyond `coast` also where one lying source can have moved the pointing by more than this.
  double beam_probability_min = 0.1;
  double coast_bound_max_rad = std::numbers::pi / 180;
  /// How far a vehicle may be from its nominal trajectory, 1-sigma per axis: this, and a share of the way flown.
  double nominal_sigma_m = 100;
  double nominal_sigma_share = 0.01;
};

/// Are the sources of a target judged against each other?
struct IntegrityConfig {
  bool enabled = true;        ///< where there are two sources or more
  int rerun_per_tick = 1000;  ///< measurements by which a run without a liar catches up, with each tick
  /// In ties, the most trusted source (sensor, station or receiver) first; empty: a tie stays one.
  std::vector<Name> trust;
  /// Copies of one fix by several stations describe one message: they agree to this.
  double copy_position_m = 0.1;
  double copy_velocity_m_s = 0.01;
  Duration readmit_after = milliseconds(10'000);  ///< of agreement
};

/// How long a vehicle may go on unseen.
struct DataLossLimit {
  double t_plus_s = 0;  ///< since lift-off
  double limit_s = 0;

  bool operator==(const DataLossLimit&) const = default;
};

/// The vacuum impact point.
struct ImpactConfig {
  bool enabled = true;
  FallSettings fall;
  /// By time after lift-off, increasing; linear in between, and the first and the last hold before and after. Empty:
  /// there is no limit.
  std::vector<DataLossLimit> data_loss;
};

/// A closed line that an impact point is held against.
struct BoundaryConfig {
  Name id;
  std::vector<GroundPoint> vertices;  ///< without defect (GroundPolygon::defect_of)
};
inline constexpr std::size_t max_boundaries = 32;

struct TargetConfig {
  Name id;
  NominalTrajectory nominal{};  ///< empty: no plan is known
};

/// Where the vehicle stands until lift-off.
struct PadConfig {
  Site site;
  double radius_m = 2000;  ///< fixes farther from it are rejected, or farther than one may have come since lift-off
};

struct RangeConfig {
  Name name;
  Duration tick = milliseconds(25);
  int leap_seconds = 18;
  std::vector<TargetConfig> targets;
  std::vector<RadarConfig> radars;
  std::vector<AngleSensorConfig> angle_sensors;
  std::vector<TelemetryConfig> telemetry;
  std::vector<AntennaConfig> antennas;
  GpsConfig gps;
  std::optional<PadConfig> pad;
  IngestConfig ingest;
  AlignConfig align;
  FuseConfig fuse;
  IntegrityConfig integrity;
  SlaveConfig slave;
  ImpactConfig impact;
  std::vector<BoundaryConfig> boundaries;  ///< at most max_boundaries
};

}  // namespace downrange
