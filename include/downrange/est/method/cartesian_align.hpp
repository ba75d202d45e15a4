#pragma once
/// ALIGN as the range paper has it: each radar's bias in Cartesian axes against the vehicle's GPS, and plots without
/// it.
///
/// H.-R. Song, GPS-based multiple radar bias estimation and sensor fusion for launch vehicle tracking, 2015 (doi
/// 10.9723/jksiis.2015.20.6), eq. (8)-(22), with the corrections of est/ERRATA.md. Method song2015 fuses the plots
/// that come out of it, the track-level rules (track_level.hpp) the tracks that are made of them.

#include <array>
#include <downrange/est/filter/async_fusion.hpp>
#include <downrange/est/method/method.hpp>
#include <downrange/est/method/source_checks.hpp>
#include <downrange/est/method/target_life.hpp>

namespace downrange {

/// One radar's bias filter. State: offsets (m) and scales (1) along the radar's south, east, zenith axes;
/// measured = (1 + scale) true + offset.
struct RadarBias {
  static constexpr int max_window = 64;

  Gaussian<6> estimate;
  std::array<Vec<6>, max_window> window{};  ///< the last estimates, for the paper's process noise (20)
  int windowed = 0;                         ///< how many of them are filled
  int next = 0;
  Time updated;  ///< epoch of the last update by GPS
  Time epoch;    ///< epoch of the last plot
  std::uint64_t samples = 0;
  int rejected_in_row = 0;
  BiasOpening opening;
};

/// A plot that waits for the fixes after it (GpsAlignment::smooth).
struct HeldPlot {
  Time epoch;
  int radar = 0;
  Vec<3> z_sez = Vec<3>::Zero();
  Mat<3, 3> R_sez = Mat<3, 3>::Zero();
};

/// The GPS Kalman filter of one target: CV in ECEF.
struct GpsTrack {
  static constexpr int max_knots = 10;
  static constexpr std::size_t max_held = 1024;

  struct Knot {
    Time epoch;
    Gaussian<6> filtered;
  };

  GpsReference reference;
  Time epoch;  ///< of the last fix that it followed
  Gaussian<6> state;
  LastFix last_fix;
  // For the smoothed reference only.
  std::array<Knot, max_knots> knots{};  ///< the last fixes of this track, ascending
  int knot_count = 0;
  std::vector<HeldPlot> held;  ///< ascending; a plot beyond max_held teaches nothing of the bias
};

/// GPS at `t`, between two knots of the track, by all knots: fixed-interval smoothing (Rauch, Tung, Striebel 1965) of
/// the CV model with white acceleration q. None: `t` is not between two knots.
[[nodiscard]] std::optional<Gaussian<6>> smoothed_at(const GpsTrack& track, Time t, double q);

/// GPS predicted to the radar epochs -> pseudo bias measurement -> bias Kalman filter per radar -> compensation.
class CartesianAlign {
 public:
  struct State {
    std::vector<RadarBias> radars;
    std::vector<GpsTrack> gps;      ///< per target
    std::vector<TargetLife> lives;  ///< likewise
  };

  /// `correct` false: no bias is estimated, and no fix gated by its position.
  CartesianAlign(MethodSettings settings, bool correct);

  [[nodiscard]] State initial() const;
  /// Room for all plots that may wait for fixes (Rewinder).
  void reserve(State& state) const;
  /// Into the target's GPS track, and the station's account. `fused`: where the radars saw the target at their newest
  /// plot; none: they do not follow it.
  Outcome apply_fix(State& state, SourceAccount& account, const Measurement& m,
                    const std::optional<TrackEstimate>& fused) const;
  /// GPS says that this plot, whose bias has just been brought up to date, is not of the target.
  [[nodiscard]] bool is_refused(State& state, const Measurement& plot) const;
  /// The track is the method's, who is right is decided by the same rules for all.
  [[nodiscard]] const Arbitration& arbitration() const { return arbitration_; }
  /// A plot that was not used: the radar's bias is opened again where that is due. What remains to do is the track's.
  Remedy rejected(State& state, const Measurement& plot, Verdict verdict) const;
  /// Brings the bias of the plot's radar up to date and takes it out: position in ECEF, age 0, with what is not known
  /// of the bias as noise. Of a plot that tells a position.
  [[nodiscard]] TimedPosition compensated(State& state, const Measurement& m) const;

  [[nodiscard]] std::optional<TrackEstimate> gps_track(const State& state, int target, Time at) const;
  [[nodiscard]] BiasEstimate bias(const State& state, int radar) const;
  [[nodiscard]] const MethodSettings& settings() const { return settings_; }

 private:
  Outcome update_by_fix(GpsTrack& gps, SourceAccount& account, const Measurement& m) const;
  void loosen_biases(State& state, std::uint64_t radars) const;
  void start_gps(GpsTrack& gps, const Measurement& m) const;
  /// By GPS predicted to the plot, or later when the fixes after it have come.
  void align(State& state, const Measurement& m, const Vec<3>& z_sez, const Mat<3, 3>& R_sez) const;
  void release_held(State& state, GpsTrack& gps) const;
  void forget(RadarBias& bias) const;
  void estimate_bias(RadarBias& bias, const HeldPlot& plot, const Gaussian<6>& reference) const;
  [[nodiscard]] Gaussian<6> prior_bias() const;
  [[nodiscard]] Mat<6, 6> bias_process_noise(const RadarBias& bias, double dt) const;

  MethodSettings settings_;
  Arbitration arbitration_;
  bool correct_;
  double gate3_;  ///< chi2 quantile, 3 degrees of freedom; infinity when not correcting
  double gate6_;
};

/// The first estimate of a CV track: a measured position, and a velocity of which nothing but its size is known.
[[nodiscard]] Gaussian<6> started_from(const TimedPosition& z, double sigma_velocity_m_s);

/// A CV track with white acceleration q, at its newest measurement's epoch, predicted to `at`.
[[nodiscard]] TrackEstimate estimate_at(const Gaussian<6>& state, Time data_epoch, Time at, double q);

}  // namespace downrange
