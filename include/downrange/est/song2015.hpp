#pragma once
/// The method of the range paper: H.-R. Song, GPS-based multiple radar bias estimation and sensor fusion for launch
/// vehicle tracking, 2015 (doi 10.9723/jksiis.2015.20.6), with the corrections of the range's errata.

#include <array>
#include <downrange/est/async_fusion.hpp>
#include <downrange/est/method.hpp>
#include <downrange/est/rewind.hpp>
#include <downrange/est/source_checks.hpp>

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
};

/// A plot that waits for the fixes after it (GpsAlignment::smooth).
struct HeldPlot {
  Time epoch;
  int radar = 0;
  Vec<3> z_sez;
  Mat<3, 3> R_sez;
};

/// The GPS Kalman filter of one target: CV in ECEF.
struct GpsTrack {
  static constexpr int max_knots = 10;
  static constexpr std::size_t max_held = 1024;

  struct Knot {
    Time epoch;
    Gaussian<6> filtered;
  };

  bool started = false;
  bool confirmed = false;  ///< a second fix agreed: before, the track is no reference
  Time epoch;              ///< of the last accepted fix
  Gaussian<6> state;
  LastFix last_fix;
  int rejected_in_row = 0;
  // For the smoothed reference only.
  std::array<Knot, max_knots> knots{};  ///< the last fixes of this track, ascending
  int knot_count = 0;
  std::vector<HeldPlot> held;  ///< ascending; a plot beyond max_held teaches nothing of the bias
};

/// GPS at `t`, between two knots of the track, by all knots: fixed-interval smoothing (Rauch, Tung, Striebel 1965) of
/// the CV model with white acceleration q. None: `t` is not between two knots.
[[nodiscard]] std::optional<Gaussian<6>> smoothed_at(const GpsTrack& track, Time t, double q);

/// The radar fusion of one target: the estimate at the last batch instant and the plots since.
struct FusedTrack {
  static constexpr int max_radars = 64;

  bool started = false;
  Time base_epoch;
  Gaussian<6> base;
  int pending_count = 0;
  std::array<TimedPosition, max_batch> pending{};
  std::array<Time, max_batch> pending_epoch{};
  Time epoch;                                  ///< of the newest plot
  Gaussian<6> current;                         ///< base and pending fused at `epoch`
  std::array<Time, max_radars> contributed{};  ///< last accepted plot per radar
  double nis = 0;
  int rejected_in_row = 0;
};

/// GPS predicted to the radar epochs -> pseudo bias measurement -> bias Kalman filter per radar -> compensation ->
/// optimal asynchronous fusion. Without bias estimation (`correct` false) it is the *uncorrected* fusion: radars only,
/// no bias states, no gate.
class Song2015 {
 public:
  struct State {
    std::vector<RadarBias> radars;
    std::vector<GpsTrack> gps;      ///< per target
    std::vector<FusedTrack> fused;  ///< per target
    std::vector<SourceAccount> accounts;
  };

  Song2015(MethodSettings settings, bool correct);

  [[nodiscard]] State initial() const;
  Outcome apply(State& state, const Measurement& m) const;
  void start(State& state, int target, Time epoch, const Gaussian<9>& estimate) const;

  [[nodiscard]] std::optional<TrackEstimate> fused(const State& state, int target, std::optional<Time> at) const;
  [[nodiscard]] std::optional<TrackEstimate> gps_track(const State& state, int target, Time at) const;
  [[nodiscard]] BiasEstimate bias(const State& state, int radar) const;
  [[nodiscard]] const SourceAccount& account(const State& state, int source) const {
    return state.accounts[static_cast<std::size_t>(source)];
  }

  [[nodiscard]] const MethodSettings& settings() const { return settings_; }
  [[nodiscard]] bool corrects() const { return correct_; }

 private:
  Outcome apply_fix(State& state, const Measurement& m) const;
  Outcome follow_fix(GpsTrack& gps, SourceAccount& account, const Measurement& m) const;
  void start_gps(GpsTrack& gps, const Measurement& m) const;
  Outcome apply_plot(State& state, const Measurement& m) const;
  /// By GPS predicted to the plot, or later when the fixes after it have come.
  void align(State& state, const Measurement& m, const Vec<3>& z_sez, const Mat<3, 3>& R_sez) const;
  void release_held(State& state, GpsTrack& gps) const;
  void estimate_bias(RadarBias& bias, const HeldPlot& plot, const Gaussian<6>& reference) const;
  [[nodiscard]] Gaussian<6> prior_bias() const;
  [[nodiscard]] Mat<6, 6> bias_process_noise(const RadarBias& bias, double dt) const;
  void start_track(FusedTrack& track, const Measurement& m, const TimedPosition& z) const;
  void fuse_into(FusedTrack& track, const Measurement& m, const TimedPosition& z) const;

  MethodSettings settings_;
  bool correct_;
  double gate3_;  ///< chi2 quantile, 3 degrees of freedom; infinity when not correcting
  double gate6_;
};

/// State of the bias terms as reported: from sigma against prior, correlation, age.
[[nodiscard]] BiasEstimate describe(const RadarBias& bias, const MethodSettings& settings);

}  // namespace downrange
