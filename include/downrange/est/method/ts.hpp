#pragma once
/// Many targets, biases shared by all of them, no GPS needed: two-stage estimation as a method of the service (`ts`).

#include <algorithm>
#include <array>
#include <downrange/est/filter/hypothesis.hpp>
#include <downrange/est/filter/model_set.hpp>
#include <downrange/est/filter/two_stage.hpp>
#include <downrange/est/method/method.hpp>
#include <downrange/est/method/source_checks.hpp>
#include <downrange/est/method/target_life.hpp>
#include <optional>
#include <vector>

namespace downrange {

/// A filter per target over all radars, white jerk, and one estimate of all radars' biases (two_stage.hpp). Equals the
/// filter over all targets and biases at a cost that is linear in the number of targets. State of a target, ECEF:
///
///  0-8   position (m), velocity (m/s), acceleration (m/s^2)
///  9-11  where N = 12: slowly varying GPS error (m, first-order Gauss-Markov): fix = position + error + noise
///
/// A target's first plot makes a track whose error is the radar's bias (its V), not an independent one: of many
/// targets, independent errors would average out and the biases with them.
///
/// Radars are found against each other: what they have in common shows only through their priors, or through the GPS of
/// any target, whose fixes are free of bias. Priors are those of the regime without GPS where that is enabled, with the
/// slow pointing errors left out: a radar whose pointing wanders needs a drift of its angle offsets instead.
template <int N>
class Ts {
 public:
  static_assert(N == 9 || N == 12);
  static constexpr int max_radars = 64;
  static constexpr int max_biases = max_radars * bias_term_count;
  using Shared = SharedBias<Eigen::Dynamic, max_biases>;

  struct Target {
    bool started = false;
    Time epoch;  ///< of the track
    BiasFreeTrack<N, Eigen::Dynamic> track;
    Time data_epoch;  ///< newest accepted measurement
    TargetLife life;
    LastFix last_fix;
    double nis = 0;
    int nis_dof = 0;
  };
  struct Radar {
    Time epoch;  ///< newest accepted plot
    std::uint64_t samples = 0;
    bool referenced = false;  ///< of a target with GPS
  };
  struct State {
    Shared bias;
    std::optional<Time> drifted;  ///< until when the drift of the biases is counted
    std::vector<Target> targets;
    std::vector<Radar> radars;
    std::vector<SourceAccount> accounts;
  };

  /// Throws std::invalid_argument for more than max_radars radars.
  explicit Ts(MethodSettings settings);

  [[nodiscard]] State initial() const;
  void start(State& state, int target, Time epoch, const Gaussian<9>& estimate) const;
  Outcome apply(State& state, const Measurement& m) const;

  [[nodiscard]] std::optional<TrackEstimate> fused(const State& state, int target, std::optional<Time> at) const;
  /// A term is not observable also where it cannot be told from another radar's.
  [[nodiscard]] BiasEstimate bias(const State& state, int radar) const;
  [[nodiscard]] const MethodSettings& settings() const { return settings_; }
  [[nodiscard]] std::size_t checkpoint_spacing() const { return 8 * std::max<std::size_t>(1, settings_.targets); }

 private:
  void restart(Target& t, Time epoch, const Gaussian<9>& motion) const;
  void restart_by(State& s, const Measurement& m) const;
  void predict(Target& t, Time to) const;
  void drift(State& s, Time to) const;
  /// All biases take a step of the variances in `step_`.
  void loosen_all(State& s) const;
  Outcome apply_fix(State& s, const Measurement& m) const;
  Outcome update_by_fix(State& s, const Measurement& m) const;
  Outcome apply_plot(State& s, const Measurement& m) const;
  Outcome update_by_range_rate(State& s, Target& t, std::size_t source, const Plot& plot, bool learns) const;
  /// As Joint's.
  void bound_gps_error(const State& s, Target& t) const;
  /// After a rejection; for a fix that is used after all, what became of it.
  Outcome arbitrate(State& s, const Measurement& m, const Outcome& rejected) const;
  /// The biases of the radars whose bits are set step by that share of their prior variance.
  void loosen_priors(State& s, std::uint64_t radars, double share) const;

  MethodSettings settings_;
  Arbitration arbitration_;
  MotionModel motion_;
  BiasLayout layout_;
  bool drifts_;
  mutable typename Shared::Step step_;  ///< nothing is remembered in it
  Gates gates_;
};

extern template class Ts<9>;
extern template class Ts<12>;

}  // namespace downrange
