#pragma once
/// The life of a target, the same in every method: when its track starts anew, when a radar's bias is opened again, and
/// when a receiver that disagrees is believed. A method keeps its algebra; who is right is decided here, between
/// sources and never by how often one of them was rejected.

#include <algorithm>
#include <array>
#include <downrange/est/method/method.hpp>
#include <downrange/est/method/source_checks.hpp>
#include <limits>
#include <optional>
#include <vector>

namespace downrange {

/// Earlier than any measurement.
inline constexpr Time never{std::numeric_limits<std::int64_t>::min() / 2};

/// Measurements that a track refused, none accepted in between.
struct Refusals {
  std::optional<Time> since;

  void note(Time epoch) {
    if (!since) since = epoch;
  }
  [[nodiscard]] bool last(Time now, Duration duration) const { return since && now - *since >= duration; }
};

/// A radar's plot, as measured.
struct TimedPlot {
  Time epoch = never;
  Plot plot;
};
struct TimedFix {
  Time epoch = never;
  Fix fix;
};
/// Two plots that tell positions, of one vehicle: not an outlier and whatever came before it.
[[nodiscard]] bool of_one_vehicle(const RadarModel& radar, const TimedPlot& first, const TimedPlot& second);

/// How often a bias may be opened again: not while the last time was in vain.
struct BiasOpening {
  Time opened = never;
  int used_since = 0;  ///< plots, up to as many as show that it helped

  /// A plot of the radar agreed with what it is compared with.
  void used(int reopen_after) { used_since = std::min(used_since + 1, reopen_after); }
  /// Whether it may be opened, which then counts as done.
  bool open(Time now, int reopen_after);
  /// The same whatever came of the last time: once a minute.
  bool open_seldom(Time now);
};

/// What is remembered of one radar, or angles-only tracker, that follows the target.
struct RadarLife {
  TimedPlot accepted;  ///< newest of each
  TimedPlot refused;
  TimedPlot refused_since;  ///< the first of those of one vehicle that end with `refused`
  int rejected_in_row = 0;  ///< those that another bias would explain
  int refused_by_gps = 0;   ///< where the method has a track by GPS alone: plots in a row that it does not allow
  BiasOpening opening;
};

/// What is remembered of the vehicle's receiver, whichever stations relay it.
struct ReceiverLife {
  Time heard = never;                 ///< newest fix that was not frozen
  Time since = never;                 ///< since when, without a silence, it is believed
  std::optional<TimedFix> accepted;   ///< newest accepted fix
  std::array<TimedFix, 3> refused{};  ///< the last fixes since then, ascending, all rejected
  int refused_count = 0;              ///< how many of them are filled, from the back
  bool continuous = false;            ///< the first fix refused was where the accepted ones led
  Time agreeing_since = never;        ///< since when each rejected fix agrees with the one before it
};

/// A value: part of a method's checkpoint. Assigning one to another of as many sources allocates nothing.
struct TargetLife {
  Time accepted = never;  ///< newest accepted measurement of any source
  Refusals refused;       ///< of any source, since then
  ReceiverLife receiver;
  std::vector<RadarLife> radars;
  std::vector<Time> stations;  ///< newest accepted fix that each relayed
};

/// What a rejected measurement leads to.
enum class Remedy : std::uint8_t {
  None,
  Restart,   ///< the track is lost: it starts anew with this measurement
  OpenBias,  ///< this radar alone disagrees: its bias may be anything again that its prior allows
  Unite,     ///< the track and who returns to it may both be right: covariance union, then this measurement is used
};

/// What is used of a measurement after a union: its range rate was judged, by itself, when it came.
[[nodiscard]] inline Measurement without_range_rate(Measurement m) {
  if (auto* plot = std::get_if<Plot>(&m.measured)) plot->range_rate_valid = false;
  return m;
}

/// What the fixes say so far of a receiver that is not believed yet.
enum class FirstFixes : std::uint8_t {
  Wait,          ///< one alone, or they differ among themselves
  Contradicted,  ///< two agree, but radars do not allow them
  Hold,          ///< two agree and nothing speaks against them
};

/// The rules. Two positions of a target are told apart by what the radars measured last, with nothing known of their
/// biases but the priors: only what these can explain may overrule radars that agree.
class Arbitration {
 public:
  explicit Arbitration(const MethodSettings& settings);

  [[nodiscard]] TargetLife unborn() const;

  /// To be called with every measurement that was used; one that starts a track likewise.
  void accepted(TargetLife& life, const Measurement& m) const;
  /// To be called with every measurement that was not: `track` is the target's motion at its instant, as the method
  /// knows it without that measurement.
  [[nodiscard]] Remedy rejected(TargetLife& life, const Measurement& m, Verdict verdict,
                                const Gaussian<9>& track) const;
  /// Whether a bias that the prior of this radar, or tracker, allows brings the plot together with the motion given at
  /// `epoch`. A bias is opened for no other plot: what follows something else, or measures in feet, has nothing to
  /// learn.
  [[nodiscard]] bool explained_by_bias(int source, const TimedPlot& plot, Time epoch, const Gaussian<9>& motion) const;

  /// Of a target that one radar has followed alone, without any receiver, after its accepted plot: `bias_misfit` is how
  /// far the radar's bias is from its prior in force, chi2 with as many degrees of freedom as it has terms. While the
  /// cross-range is open, a change of thrust may be explained by a target elsewhere and a bias to match. None is so
  /// large, in one of a million: then it is the motion that has gone elsewhere. Once a minute: a radar may be worse.
  [[nodiscard]] bool led_astray(TargetLife& life, const Measurement& plot, double bias_misfit, int terms) const;

  /// Of a target that radars follow and whose receiver is not believed yet, to be called with every fix until it is.
  [[nodiscard]] FirstFixes first_fixes(TargetLife& life, const Measurement& fix, const Vec<9>& track) const;
  /// The receiver was silent, or gave no usable fix, for longer than its track is worth anything.
  [[nodiscard]] bool was_silent(const TargetLife& life, const Measurement& fix) const {
    return fix.epoch - life.receiver.heard > gps_max_age_;
  }
  /// The receiver tells where the target is: a fix was accepted not longer ago than its track is worth anything.
  [[nodiscard]] bool has_receiver(const TargetLife& life, Time at) const {
    const auto& accepted = life.receiver.accepted;
    return accepted && at - accepted->epoch <= gps_max_age_;
  }
  /// Its fixes came, but none was accepted for as long.
  [[nodiscard]] bool was_refused(const TargetLife& life, const Measurement& fix) const {
    const auto& accepted = life.receiver.accepted;
    return accepted && fix.epoch - accepted->epoch > gps_max_age_;
  }
  /// Of a method with a track by GPS alone: whether it allows this plot. A radar that it refuses follows something
  /// else, unless another radar that is refused likewise sides with it.
  [[nodiscard]] bool alone_against_gps(TargetLife& life, const Measurement& plot, bool refused_by_gps) const;
  /// Radars that had a plot accepted within the last second before `now`, a bit each.
  [[nodiscard]] static std::uint64_t recent_radars(const TargetLife& life, Time now);
  /// These and, behind them, the stations that relayed an accepted fix within that second: by source id, those from 64
  /// on left out.
  [[nodiscard]] static std::uint64_t recent_sources(const TargetLife& life, Time now);

  /// Of these, all but the plot's own.
  [[nodiscard]] static std::uint64_t other_radars(const TargetLife& life, const Measurement& plot) {
    return recent_radars(life, plot.epoch) & ~(std::uint64_t{1} << plot.source);
  }
  /// A fix that the motion does not explain, though the fix before it was accepted: an engine that was lit or cut off
  /// in between is the first explanation, but of one fix only.
  [[nodiscard]] static bool may_be_engine_event(const TargetLife& life) {
    return life.receiver.accepted && life.receiver.refused_count == 0;
  }
  /// What such an event may have done to a motion since the fix before, `since` ago: to add to the covariance of its
  /// position, velocity and acceleration.
  static void add_engine_event(Mat<9, 9>& cov, Duration since);
  /// No receiver's slow error is so large, in one of a million: then it is the motion that has gone elsewhere.
  [[nodiscard]] bool is_no_gps_error(const Vec<3>& error) const;

  /// Covariance union with a measurement that is `nu` away from the track in position and velocity: what to add to the
  /// covariance of these six, so that both may be right.
  [[nodiscard]] static Mat<6, 6> union_term(const Vec<6>& nu);
  /// Position and velocity by which a fix, or a plot with its bias at the prior's mean, differs from the track. Where
  /// it has no velocity, that of the fixes or plots refused before it counts.
  [[nodiscard]] Vec<6> away_from(const TargetLife& life, const Measurement& m, const Vec<9>& track) const;
  /// Whose biases a union with the measurement loosens: the radars that follow, and its own.
  [[nodiscard]] static std::uint64_t loosened_by(const TargetLife& life, const Measurement& m);

 private:
  [[nodiscard]] Remedy rejected_fix(TargetLife& life, const Measurement& fix, const Vec<9>& track) const;
  [[nodiscard]] Remedy rejected_plot(TargetLife& life, const Measurement& plot, const Gaussian<9>& track) const;
  /// Whether a radar that returns shows, with others and as their priors allow, that the track was led astray.
  [[nodiscard]] bool overrules(const TargetLife& life, const Measurement& plot, const Gaussian<9>& track) const;
  /// Where a plot says the target is, with what its noise and its radar's prior leave open.
  [[nodiscard]] Gaussian<3> position_by_prior(std::size_t radar, const TimedPlot& plot, const Vec<9>& near) const;
  void remember_refused(ReceiverLife& receiver, const Measurement& m, const Vec<9>& track) const;
  [[nodiscard]] bool agree(const TimedFix& first, const TimedFix& second, const Vec<9>& track) const;
  /// Three fixes without velocity that move as one vehicle, whatever the track thinks of its velocity.
  [[nodiscard]] bool in_line(const TimedFix& first, const TimedFix& second, const TimedFix& third) const;
  [[nodiscard]] bool three_agree(const ReceiverLife& receiver, const Vec<9>& track) const;
  [[nodiscard]] bool overrules(const TargetLife& life, const Measurement& m, const Vec<9>& track) const;
  [[nodiscard]] bool plausible(const TargetLife& life, const Measurement& m, const Vec<9>& track) const;
  /// How far plots are from a motion in terms of their radars' priors, noise and `P`, the covariance of its position.
  /// chi2 with `dof` degrees of freedom where the motion is the truth.
  struct Misfit {
    double chi2 = 0;
    int dof = 0;
  };
  [[nodiscard]] Misfit misfit(std::size_t radar, const TimedPlot& plot, Time epoch, const Vec<9>& motion,
                              const Mat<3, 3>& P) const;
  /// Of the radars in `mask`, their newest accepted plots.
  [[nodiscard]] Misfit misfit(const TargetLife& life, std::uint64_t mask, Time epoch, const Vec<9>& motion,
                              const Mat<3, 3>& P) const;
  /// The motion that the fix tells, the track's where it tells nothing.
  [[nodiscard]] Vec<9> motion_of(const Fix& fix, const Vec<9>& track) const;

  std::vector<RadarModel> radars_;
  int stations_;
  Duration restart_after_;
  int reopen_after_;
  Duration gps_max_age_;
  bool gps_use_velocity_;
  double gps_error_variance_;
  double gate_probability_;
};

/// A fix for a track by GPS alone, beside that of the radars: `reference` is its state, `motion` the target's as the
/// radars know it, `agrees` whether they agree with the fix. The algebra is the method's: `start()` the track by this
/// fix; `update()`, what became of it at the track's gate; `believe()`, the track is a reference from now on;
/// `unite()`, both radars and receiver may be right.
struct GpsReference {
  bool started = false;
  bool confirmed = false;  ///< fixes agreed and were plausible: before, the track is no reference
};
template <class Start, class Update, class Believe, class Unite>
Outcome update_gps_track(const Arbitration& rules, TargetLife& life, GpsReference& reference, const Measurement& fix,
                         const Vec<9>& motion, bool agrees, const Start& start, const Update& update,
                         const Believe& believe, const Unite& unite) {
  const auto start_anew = [&] {
    start();
    reference = {.started = true, .confirmed = false};
  };
  const auto confirm = [&] {
    believe();
    rules.accepted(life, fix);
    reference.confirmed = true;
  };
  Outcome outcome;
  // A track too old to serve as reference is no judge of the receiver either: not of one that was silent, and not of
  // one whose fixes it refused for so long.
  const bool starts = !reference.started || rules.was_silent(life, fix);
  if (starts) {
    start_anew();
  } else if (reference.confirmed && rules.was_refused(life, fix)) {
    outcome = {.verdict = Verdict::Gated, .nis = 0, .dof = 0};
  } else {
    outcome = update();
  }
  const bool fits = outcome.verdict == Verdict::Accepted;
  if (!reference.confirmed) {
    const FirstFixes so_far = rules.first_fixes(life, fix, motion);
    if (!fits) start_anew();  // a track that nothing has confirmed gives way at once
    if (so_far == FirstFixes::Contradicted) return {.verdict = Verdict::Gated, .nis = outcome.nis, .dof = 0};
    if (so_far == FirstFixes::Hold && fits && !starts) {
      if (!agrees) unite();
      confirm();
    }
    return fits ? outcome : Outcome{};
  }
  if (!fits) {
    const Remedy remedy = rules.rejected(life, fix, outcome.verdict, {.mean = motion, .cov = Mat<9, 9>::Zero()});
    if (remedy == Remedy::None && !agrees) return outcome;
    if (remedy == Remedy::Unite) unite();
    start_anew();
    outcome = {};
  }
  confirm();
  return outcome;
}

}  // namespace downrange
