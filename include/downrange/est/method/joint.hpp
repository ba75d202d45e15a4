#pragma once
/// One filter for everything: a target's motion, the biases of the radars, the coloured error of the GPS. Every plot
/// and fix is processed one by one in time order: the optimum of its class (est/THEORY.md section 4).

#include <array>
#include <downrange/est/filter/hypothesis.hpp>
#include <downrange/est/filter/manoeuvre.hpp>
#include <downrange/est/method/method.hpp>
#include <downrange/est/method/source_checks.hpp>
#include <downrange/est/method/target_life.hpp>

namespace downrange {

/// Extended Kalman filter per target, an interacting bank of them for kinematics `launch`. State vector, ECEF:
///
///  0-8   position (m), velocity (m/s), acceleration or specific force (m/s^2)
///  9-11  slowly varying GPS error (m, first-order Gauss-Markov): fix = position + error + noise
///  12-   per radar the terms of its BiasModel; measured(t) = true(t - time tag) + bias
///
/// Plots are used as measured (range, azimuth, elevation, or what there is of them), linearised at the bias-compensated
/// prediction: linearising at the plot drifts 20-30 % off the bound. A target that starts takes over the biases that
/// another one has found by GPS. Until a target's first fix the regime is another (NoGpsRegime); it is left once, when
/// two fixes agree.
class Joint {
 public:
  static constexpr int motion_at = 0;
  static constexpr int gps_error_at = 9;
  static constexpr int first_radar_at = 12;
  static constexpr int max_radars = 64;

  struct Radar {
    Time epoch;    ///< newest accepted plot
    Time updated;  ///< newest accepted plot while GPS was there
    std::uint64_t samples = 0;
    int blind = 0;  ///< plots that told the motion before its velocity was known
    bool referenced = false;
  };
  struct Target {
    bool started = false;
    bool without_gps = false;   ///< the regime
    bool learns_biases = true;  ///< in it, not before the velocity is known (time_tags.hpp)
    Time epoch;                 ///< of the bank
    Time mixed;                 ///< last interaction of the bank's models
    Bank bank;
    Manoeuvre manoeuvre;  ///< kinematics vdie only
    Time data_epoch;      ///< newest accepted measurement
    TargetLife life;
    std::vector<Radar> radars;
    LastFix last_fix;
    double nis = 0;
    int nis_dof = 0;
  };
  struct State {
    std::vector<Target> targets;
    std::vector<SourceAccount> accounts;
  };

  /// Throws std::invalid_argument for more than max_radars radars.
  explicit Joint(MethodSettings settings);

  [[nodiscard]] State initial() const;
  /// Gives a target its first estimate, and the regime with GPS.
  void start(State& state, int target, Time epoch, const Gaussian<9>& estimate) const;
  Outcome apply(State& state, const Measurement& m) const;

  [[nodiscard]] std::optional<TrackEstimate> fused(const State& state, int target, std::optional<Time> at) const;
  /// As the target knows it that last saw the radar; a target with GPS before one without.
  [[nodiscard]] BiasEstimate bias(const State& state, int radar) const;

  [[nodiscard]] const MethodSettings& settings() const { return settings_; }
  /// Of a target at present: those of the kinematics, but for vdie while a manoeuvre lasts.
  [[nodiscard]] const ModelSet& models(const Target& target) const {
    return target.manoeuvre.open() ? manoeuvring_ : models_;
  }
  [[nodiscard]] const BiasLayout& layout(const Target& target) const {
    return target.without_gps ? layout_without_gps_ : layout_;
  }

 private:
  void set_motion(Target& t, const Gaussian<9>& motion) const;
  void start_by(State& s, const Measurement& m, bool without_gps) const;
  void restart_motion(Target& t, const Measurement& m) const;
  void size_state(State& s, Target& t, bool without_gps) const;
  void advance(Target& t, Time to) const;
  void predict(Target& t, Time to) const;
  Outcome apply_fix(State& s, const Measurement& m) const;
  Outcome update_by_fix(State& s, const Measurement& m) const;
  Outcome first_fix(State& s, const Measurement& m) const;
  Outcome apply_plot(State& s, const Measurement& m) const;
  /// `heard`: the radars that have told something of the target, this one included. `lesson`, where given, gets what
  /// the innovation tells of R.
  template <int M, class Linearise>
  Outcome update(Target& t, SourceAccount& account, std::uint64_t heard, const Mat<M, M>& R, const Linearise& linearise,
                 NoiseLesson<M>* lesson) const;
  /// By a radar's components from `first` on (NoiseScale), whose configured variances are given.
  template <int M, class Linearise>
  Outcome update_by_radar(Target& t, SourceAccount& account, std::uint64_t heard, bool learns, int first,
                          const Vec<M>& configured, const Linearise& linearise) const;
  /// After a rejection; for a fix that is used after all, what became of it.
  Outcome arbitrate(State& s, const Measurement& m, const Outcome& rejected) const;

  MethodSettings settings_;
  Arbitration arbitration_;
  ModelSet models_;
  ModelSet manoeuvring_;
  BiasLayout layout_;
  BiasLayout layout_without_gps_;
  Gates gates_;
  mutable Bank scratch_;  ///< of the interaction; nothing is remembered in it
};

}  // namespace downrange
