#pragma once
/// The range paper's two stages done right: biases against GPS, then a fusion of radars only (est/THEORY.md
/// section 4). For ranges whose radar track must stay independent of telemetry.

#include <array>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/est/filter/hypothesis.hpp>
#include <downrange/est/method/method.hpp>
#include <downrange/est/method/source_checks.hpp>
#include <downrange/est/method/target_life.hpp>

namespace downrange {

/// Schmidt-Kalman filter (Schmidt 1966): the joint covariance of everything is kept, but each measurement corrects only
/// what it is allowed to. State vector, ECEF:
///
///  0-8    motion of the fused track: radars only
///  9-17   motion of the GPS track: fixes only, constant acceleration
///  18-20  slowly varying GPS error (first-order Gauss-Markov)
///  21-    where GPS is smoothed by L later fixes: motion of the GPS track at the last L + 1 fixes, oldest first, which
///         every fix corrects through what they have in common
///  then   per radar the terms of its BiasModel
///
/// A plot corrects the biases by what it differs from the GPS track, whose error is *considered*: all plots between two
/// fixes share it and do not count it as independent; a later fix corrects the biases through that covariance. The same
/// plot corrects the fused track, whose biases' error is considered alike. Only where it starts, or starts anew after a
/// silence of all radars in which it came to know less than a plot tells, is the fused track GPS's: one plot would put
/// it hundreds of metres off, and the bias of a radar just heard would stay in it.
///
/// Until a target's first two fixes that agree the regime is another (NoGpsRegime): tight priors, for wide ones would
/// let every outlier through the gate, and the radars' plots correct the biases along with the fused track, as in
/// method joint. It is left once: the biases may be anything again, and the fused track is then wrong by that of the
/// radar which it last heard.
class Schmidt {
 public:
  static constexpr int fused_at = 0;
  static constexpr int gps_at = 9;
  static constexpr int gps_error_at = 18;
  static constexpr int knots_at = 21;
  static constexpr int max_radars = 64;
  static constexpr int max_knots = 10;
  static constexpr std::size_t max_held = 1024;

  struct Radar {
    Time epoch;    ///< newest accepted plot
    Time updated;  ///< newest plot that corrected the bias
    std::uint64_t samples = 0;
    int blind = 0;            ///< plots that told the motion before its velocity was known
    int rejected_in_row = 0;  ///< by the bias, though another would explain them
    BiasOpening opening;      ///< by plots that the bias rejects
  };
  /// A plot that waits for the fixes after it.
  struct Held {
    Time epoch;
    int source = 0;
    Plot plot;
  };
  struct Target {
    bool has_state = false;     ///< the bank is sized and holds the biases
    bool without_gps = false;   ///< the regime
    bool learns_biases = true;  ///< in it, not before the velocity is known (time_tags.hpp)
    bool fused_started = false;
    GpsReference gps;
    Time epoch;  ///< of the bank
    Time mixed;
    Bank bank;
    Time data_epoch;  ///< newest accepted plot
    Time gps_epoch;   ///< newest accepted fix
    TargetLife life;
    std::vector<Radar> radars;
    std::array<Time, max_knots> knots{};  ///< one per fix smoothed, ascending; the last knot_count are known
    int knot_count = 0;
    std::vector<Held> held;  ///< ascending; a plot beyond max_held teaches nothing of the bias
    LastFix last_fix;
    double nis = 0;
    int nis_dof = 0;
  };
  struct State {
    std::vector<Target> targets;
    std::vector<SourceAccount> accounts;
  };

  /// Throws std::invalid_argument for more than max_radars radars.
  explicit Schmidt(MethodSettings settings);

  [[nodiscard]] State initial() const;
  /// Room for all plots that may wait for fixes (Rewinder).
  void reserve(State& state) const;
  /// Gives the fused track its first estimate.
  void start(State& state, int target, Time epoch, const Gaussian<9>& estimate) const;
  Outcome apply(State& state, const Measurement& m) const;

  [[nodiscard]] std::optional<TrackEstimate> fused(const State& state, int target, std::optional<Time> at) const;
  [[nodiscard]] std::optional<TrackEstimate> gps_track(const State& state, int target, Time at) const;
  /// As the target knows it that last saw the radar.
  [[nodiscard]] BiasEstimate bias(const State& state, int radar) const;
  [[nodiscard]] const MethodSettings& settings() const { return settings_; }
  /// Where the biases begin in the state vector.
  [[nodiscard]] int first_radar_at() const { return first_radar_; }

 private:
  [[nodiscard]] const BiasLayout& layout(const Target& target) const {
    return target.without_gps ? layout_without_gps_ : layout_;
  }
  void size_state(Target& t, Time epoch, bool without_gps) const;
  void leave_regime(Target& t) const;
  /// The fused track is wrong by the bias of the radar that it last heard.
  void tie_fused_to_bias(Target& t) const;
  void start_fused(Target& t, Time epoch, const Gaussian<9>& motion) const;
  /// Where GPS tells the target's place, there; else by the plot.
  void start_fused_by(Target& t, const Measurement& plot) const;
  void start_fused_by_gps(Target& t) const;
  /// Where no radar tells a position by itself: where GPS is, to a kilometre, so that the track stays the radars'.
  void start_fused_near_gps(Target& t) const;
  void start_gps(Target& t, const Measurement& m) const;
  [[nodiscard]] static int knot_at(int knot) { return knots_at + 9 * knot; }
  static void forget_knots(Target& t);
  void add_knot(Target& t) const;
  void release_held(Target& t) const;
  /// The bias by GPS between the two oldest knots.
  template <int First, int M>
  void update_biases_between_knots(Target& t, const Held& plot) const;
  void note_learnt(Target& t, int source, const TimedPlot& plot, bool learnt) const;
  void advance(Target& t, Time to) const;
  void predict(Target& t, Time to) const;
  [[nodiscard]] bool has_reference(const Target& t, Time at) const;
  /// The GPS track, which is the same in all modes.
  [[nodiscard]] static Gaussian<9> gps_motion(const Target& t);
  /// The motion that a measurement is judged by: the radars' where they follow the target.
  [[nodiscard]] Gaussian<9> judging_motion(const Target& t, Time at) const;
  [[nodiscard]] bool fused_agrees(const Target& t, const Measurement& fix) const;
  /// No bias that the radar may have brings the plot together with the GPS track.
  [[nodiscard]] bool gps_refuses(const Target& t, const Measurement& plot) const;
  Outcome apply_fix(State& s, const Measurement& m) const;
  void believe(Target& t, const Measurement& fix) const;
  void unite(Target& t, const Measurement& fix) const;
  template <int M>
  Outcome update_by_fix(Target& t, SourceAccount& account, const Measurement& m) const;
  Outcome apply_plot(State& s, const Measurement& m) const;
  Outcome update_by_plot(State& s, const Measurement& m) const;
  void note_used(Target& t, const Measurement& plot, const Outcome& outcome) const;
  /// The fused track alone: what is not known of the biases is considered.
  Outcome update_by_range_rate(Target& t, SourceAccount& account, std::size_t source, const Plot& plot,
                               bool learns_noise) const;
  /// Whether the fused track tells less of where a plot must lie than the plot's own noise.
  template <int M>
  [[nodiscard]] static bool knows_less(const Hypothesis& h, const BlockJacobian<M>& H, const Mat<M, M>& R);
  template <int First, int M>
  Outcome correct(Target& t, SourceAccount& account, const Measurement& m, bool learns_noise) const;

  MethodSettings settings_;
  Arbitration arbitration_;
  ModelSet models_;
  MotionModel gps_model_;
  int knots_;
  int first_radar_;
  bool starts_near_gps_;
  BiasLayout layout_;
  BiasLayout layout_without_gps_;
  Gates gates_;
  mutable Bank scratch_;  ///< of the interaction; nothing is remembered in it
};

}  // namespace downrange
