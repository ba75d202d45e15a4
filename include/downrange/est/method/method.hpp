#pragma once
/// What fills the stages ALIGN and FUSE: accepted measurements in, biases and trajectory out.

#include <cstdint>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/est/filter/estimates.hpp>
#include <downrange/est/filter/gaussian.hpp>
#include <downrange/est/filter/model_set.hpp>
#include <downrange/est/filter/noise_scale.hpp>
#include <downrange/est/model/measurement.hpp>
#include <downrange/est/model/sensors.hpp>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

namespace downrange {

/// What became of one measurement.
struct Outcome {
  Verdict verdict = Verdict::Accepted;
  double nis = 0;
  int dof = 0;
};

/// Account of one source inside the method, recomputed when history is rewound.
struct SourceAccount {
  std::uint64_t accepted = 0;
  std::uint64_t gated = 0;
  std::uint64_t frozen = 0;
  int rejected_in_row = 0;
  RunningResidual residual;
  MismatchAlarm mismatch;  ///< share of NIS inside 95 %; rings where the source's model is wrong
  NoiseScale noise;        ///< of methods that learn it
};

/// Where GPS stands at a radar's epoch: predicted from the fixes before it (the range paper), or smoothed by the next
/// `fixes` as well, which a plot then waits for.
struct GpsAlignment {
  bool smooth = false;
  int fixes = 1;
};

/// When a measurement, a track or a bias is given up. Of every method.
struct ArbitrationSettings {
  Duration history = milliseconds(5000);        ///< how late a measurement may be
  double gate_probability = 0.9999;             ///< 1: no gate
  Duration restart_after = milliseconds(5000);  ///< a track of which nothing was accepted for so long starts anew
  int reopen_after = 50;                        ///< rejections in a row before a source's bias is opened again
};

/// A target that nothing is known of: 1-sigma per axis.
struct StartSettings {
  double sigma_velocity_m_s = 3000;
  double sigma_acceleration_m_s2 = 20;
};

/// What of a GPS fix is used.
struct GpsUseSettings {
  bool velocity = true;  ///< where a fix has it
};

/// GPS as the reference of the biases.
struct GpsSettings {
  Duration max_age = milliseconds(3000);  ///< older GPS: biases are kept, not updated
  GpsErrorModel error;                    ///< of joint, schmidt and ts
  GpsAlignment alignment;                 ///< of schmidt, song2015 and the track-level rules
  NoGpsRegime no_gps;                     ///< of joint, schmidt and ts
};

/// Of song2015, the track-level rules and uncorrected: biases in Cartesian axes.
struct CartesianBiasSettings {
  double gps_q_m2_s3 = 1000;           ///< white acceleration PSD of the GPS track
  double offset_prior_m = 100;         ///< 1-sigma per SEZ axis
  double scale_prior = 3e-4;           ///< likewise
  int window = 20;                     ///< samples of the paper's windowed process noise; 0: none, drift only
  double offset_drift_m_sqrt_s = 0.3;  ///< random walk of the offsets, m/sqrt(s)
  double scale_drift_sqrt_s = 1e-6;    ///< random walk of the scales, 1/sqrt(s)
};

/// Of the same methods: fusion of the compensated plots.
struct CartesianFusionSettings {
  Duration batch = milliseconds(100);  ///< fusion interval of song2015 and federated, on the UTC grid
  double q_m2_s3 = 1000;               ///< white acceleration PSD
};

/// Of alpha-beta.
struct QuickLookSettings {
  double acceleration_m_s2 = 100;  ///< 1-sigma per axis, constant between two plots of a radar
};

/// All that the methods are told. The parts are those of the configuration (stage/range_config.hpp): where a default is
/// written here, it is written nowhere else.
struct MethodSettings {
  ArbitrationSettings arbitration;
  StartSettings start;
  KinematicsSettings motion;
  GpsUseSettings gps_use;
  GpsSettings gps;
  AdaptiveNoiseSettings noise;
  CartesianBiasSettings cartesian_bias;
  CartesianFusionSettings cartesian_fusion;
  QuickLookSettings quick_look;
  std::vector<RadarModel> radars;  ///< angles-only trackers behind the radars: the sources on the ground, by source id
  int stations = 0;                ///< telemetry stations, whose source ids follow
  int targets = 1;
};

/// A way to align and fuse. Measurements may arrive late or shuffled inside the history: the estimate is that of the
/// in-order arrival. Deterministic; the steady state allocates nothing.
class Method {
 public:
  virtual ~Method() = default;

  /// Gives a target that has none its first estimate (nominal trajectory, an experiment's prior) instead of its first
  /// measurement: position, velocity, acceleration, ECEF. Before the first measurement is processed.
  virtual void start(int target, Time epoch, const Gaussian<9>& estimate) = 0;

  /// `now` is the engine's time: what is older than now - arbitration.history is forgotten, and m.epoch is not.
  virtual Outcome process(const Measurement& m, Time now) = 0;

  /// The fused track predicted to `at`; at its newest measurement's epoch when `at` is not given. None: no track.
  [[nodiscard]] virtual std::optional<TrackEstimate> fused(int target, std::optional<Time> at = {}) const = 0;

  /// The track by GPS alone, predicted to `at`. None: no accepted fix, or a method that has no such track.
  [[nodiscard]] virtual std::optional<TrackEstimate> gps_track(int target, Time at) const = 0;

  /// Of a radar or tracker, by source id. Terms is 0 for a method that estimates no bias.
  [[nodiscard]] virtual BiasEstimate bias(int radar) const = 0;

  /// By source id.
  [[nodiscard]] virtual const SourceAccount& account(int source) const = 0;
};

/// Known to `make_method`, in the order of src/est/README.md.
[[nodiscard]] const std::vector<std::string_view>& method_names();

/// Throws std::invalid_argument for a name that is not in `method_names`, and for more radars than the method takes.
[[nodiscard]] std::unique_ptr<Method> make_method(std::string_view name, const MethodSettings& settings);

}  // namespace downrange
