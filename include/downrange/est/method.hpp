#pragma once
/// What fills the stages ALIGN and FUSE: accepted measurements in, biases and trajectory out.

#include <array>
#include <cstdint>
#include <downrange/est/bias_terms.hpp>
#include <downrange/est/consistency.hpp>
#include <downrange/est/gaussian.hpp>
#include <downrange/geo/polar.hpp>
#include <downrange/geo/refraction.hpp>
#include <downrange/geo/site.hpp>
#include <downrange/geo/time.hpp>
#include <memory>
#include <numbers>
#include <optional>
#include <string_view>
#include <vector>

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

/// What became of one measurement.
struct Outcome {
  Verdict verdict = Verdict::Accepted;
  double nis = 0;
  int dof = 0;
};

/// A target's state with covariance, ECEF. Entries beyond `size` are unused.
struct TrackEstimate {
  Time epoch;       ///< the estimate's instant
  Time data_epoch;  ///< newest measurement behind it
  int size = 6;     ///< 6: position, velocity; 9: and acceleration
  Vec<9> mean = Vec<9>::Zero();
  Mat<9, 9> cov = Mat<9, 9>::Zero();
  std::uint64_t sources = 0;  ///< bit i: radar i contributed within the last second before data_epoch
  double nis = 0;             ///< of the newest measurement
  int nis_dof = 0;
};

/// A radar's bias with covariance. `terms` entries are used.
struct BiasEstimate {
  static constexpr int max_terms = bias_term_count;

  Time epoch;  ///< newest plot of this radar that was processed
  BiasReference reference = BiasReference::None;
  std::uint64_t samples = 0;
  int terms = 0;
  std::array<BiasTerm, max_terms> term{};
  std::array<BiasState, max_terms> state{};
  Vec<max_terms> value = Vec<max_terms>::Zero();
  Mat<max_terms, max_terms> cov = Mat<max_terms, max_terms>::Zero();
};

/// Account of one source inside the method, recomputed when history is rewound.
struct SourceAccount {
  std::uint64_t accepted = 0;
  std::uint64_t gated = 0;
  std::uint64_t frozen = 0;
  int rejected_in_row = 0;
  RunningResidual residual;
  MismatchAlarm mismatch;  ///< share of NIS inside 95 %; rings where the source's model is wrong
};

/// Slowly varying pointing error of a mount, of each of its axes: first-order Gauss-Markov. Two states per radar of
/// joint and schmidt (ts knows none: give the angle offsets a drift there).
struct PointingWander {
  double sigma_rad = 0;  ///< 0: none
  double tau_s = 30;
};

/// One radar, or one angles-only tracker, as the filters see it.
struct RadarModel {
  Site site;
  PolarSigma sigma;  ///< as the filter uses it, inflation included
  /// sigma.azimuth_rad is on the sky, as a mount's pointing errors are: the noise of the azimuth itself is that over
  /// cos(elevation). False: it is the axis's own.
  bool azimuth_sigma_on_sky = false;
  /// Terms of joint, schmidt and ts; song2015 and the track-level rules always use their own Cartesian ones.
  BiasModel bias = bias_model({BiasBlock::Polar, BiasBlock::SezOffset, BiasBlock::Time});
  PointingWander wander{};
  std::shared_ptr<const RefractionTable> refraction =
      nullptr;                 ///< of the air over the site; none: plots are free of it
  bool measures_range = true;  ///< false: an angles-only tracker, `plot.range_m` means nothing
};

/// How a vehicle moves between two measurements (est/THEORY.md section 2).
enum class Kinematics : std::uint8_t {
  Cv,      ///< white acceleration
  Ca,      ///< white jerk
  Launch,  ///< interacting models: ballistic, thrust, event; gravity and rotation of the Earth known
  Vdie,    ///< cv that opens an acceleration when input estimation detects a manoeuvre
};

/// Slowly varying error of a receiver's position, per axis: first-order Gauss-Markov.
struct GpsErrorModel {
  bool enabled = true;
  double sigma_m = 3;
  double tau_s = 80;
};

/// Where GPS stands at a radar's epoch: predicted from the fixes before it (the range paper), or smoothed by the next
/// `fixes` as well, which a plot then waits for.
struct GpsAlignment {
  bool smooth = false;
  int fixes = 1;
};

/// How joint, schmidt and ts work until a target's first fix: what a radar's bias may then be, and how its pointing
/// wanders.
struct NoGpsRegime {
  bool enabled = true;
  double offset_prior_m = 25;
  double angle_prior_rad = 0.05 * std::numbers::pi / 180;
  PointingWander wander{.sigma_rad = 0.02 * std::numbers::pi / 180, .tau_s = 30};
};

/// Settings of the methods; meaning and units as in stage/range_config.hpp.
struct MethodSettings {
  std::vector<RadarModel> radars;  ///< angles-only trackers behind the radars
  int stations = 0;
  int targets = 1;
  Duration history = milliseconds(5000);
  double gate_probability = 0.9999;  ///< 1: no gate
  Duration restart_after = milliseconds(5000);
  int reopen_after = 50;

  Kinematics kinematics = Kinematics::Launch;  ///< of joint and schmidt
  double q_cv_m2_s3 = 1000;                    ///< white acceleration of cv and vdie
  double q_ca_m2_s5 = 10;                      ///< white jerk of ca
  double initial_sigma_velocity_m_s = 3000;
  double initial_sigma_acceleration_m_s2 = 20;

  bool gps_use_velocity = true;
  Duration gps_max_age = milliseconds(3000);
  GpsErrorModel gps_error;
  GpsAlignment gps_alignment;  ///< of schmidt, song2015 and the track-level rules
  NoGpsRegime no_gps;

  /// Of alpha-beta: 1-sigma per axis, constant between two plots of a radar.
  double alpha_beta_acceleration_m_s2 = 100;

  // Of song2015, the track-level rules and uncorrected.
  Duration batch = milliseconds(100);
  double q_m2_s3 = 1000;
  double gps_q_m2_s3 = 1000;
  double bias_offset_prior_m = 100;
  double bias_scale_prior = 3e-4;
  int bias_window = 20;
  double bias_offset_drift_m_sqrt_s = 0.3;
  double bias_scale_drift_sqrt_s = 1e-6;
};

/// A way to align and fuse. Measurements may arrive late or shuffled inside the history: the estimate is that of the
/// in-order arrival. Deterministic; the steady state allocates nothing.
class Method {
 public:
  virtual ~Method() = default;

  /// Gives a target that has none its first estimate (nominal trajectory, an experiment's prior) instead of its first
  /// measurement: position, velocity, acceleration, ECEF. Before the first measurement is processed.
  virtual void start(int target, Time epoch, const Gaussian<9>& estimate) = 0;

  /// `now` is the engine's time: history older than now - settings.history is forgotten. m.epoch >= now - history.
  virtual Outcome process(const Measurement& m, Time now) = 0;

  /// The fused track predicted to `at`; at its newest measurement's epoch when `at` is not given. None: no track.
  [[nodiscard]] virtual std::optional<TrackEstimate> fused(int target, std::optional<Time> at = {}) const = 0;

  /// The track by GPS alone, predicted to `at`. None: no accepted fix, or a method that has no such track.
  [[nodiscard]] virtual std::optional<TrackEstimate> gps_track(int target, Time at) const = 0;

  /// Terms is 0 for a method that estimates no bias.
  [[nodiscard]] virtual BiasEstimate bias(int radar) const = 0;

  /// Radars first, then stations.
  [[nodiscard]] virtual const SourceAccount& account(int source) const = 0;
};

/// Known to `make_method`, in the order of src/est/README.md.
[[nodiscard]] const std::vector<std::string_view>& method_names();

/// Radars that measure range, at most, of a method in `method_names`; 64 where its arithmetic sets no other limit.
[[nodiscard]] int most_radars(std::string_view method);

/// Throws std::invalid_argument for a name that is not in `method_names`, and for more radars than the method takes.
[[nodiscard]] std::unique_ptr<Method> make_method(std::string_view name, const MethodSettings& settings);

}  // namespace downrange
