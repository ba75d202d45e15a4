#pragma once
/// Method `alpha-beta`: a cheap track per radar and target, for hundreds of objects at once.
///
/// No biases, no GPS, no fusion: every radar follows every target by itself with an AlphaBetaTracker<3>
/// (alpha_beta.hpp) about its site, and the best of these tracks is the target's. What a plot costs does not depend on
/// how many targets there are.

#include <downrange/est/filter/alpha_beta.hpp>
#include <downrange/est/method/method.hpp>
#include <downrange/est/method/method_state.hpp>
#include <downrange/est/method/rewind.hpp>
#include <downrange/est/method/target_life.hpp>

namespace downrange {

/// One radar's track of one target, east-north-up of the site; an estimator for Rewinder.
class RadarTracker {
 public:
  struct State {
    std::optional<AlphaBetaTracker<3>> tracker;
    AlphaBetaTracker<3>::Scan scan;  ///< of the newest plot
    Time epoch;                      ///< of the newest accepted plot
    Refusals refused;
    TimedPlot refused_plot;  ///< newest
  };

  /// `radar` outlives it.
  RadarTracker(const RadarModel& radar, const AlphaBetaSettings& tracker, Duration restart_after)
      : radar_(&radar), tracker_(tracker), restart_after_(restart_after) {}

  void start(State& state, int target, Time epoch, const Gaussian<9>& estimate) const;
  /// Starts by the first plot, and again where none was accepted for `restart_after`. Of two plots of one instant the
  /// second is Singular: there is no interval to have gains of.
  Outcome apply(State& state, const Measurement& m) const;
  /// None: no track.
  [[nodiscard]] std::optional<TrackEstimate> estimate(const State& state, std::optional<Time> at) const;

 private:
  const RadarModel* radar_;
  AlphaBetaSettings tracker_;
  Duration restart_after_;
};

/// The target's track is, of the radars that had a plot accepted within the last second before the newest one of the
/// target, that of the radar with the smallest position covariance: the newest plot's would jump from one radar's bias
/// to the other's with every plot.
///
/// Late data rewinds the one track that it belongs to. The accounts tell every plot's verdict as it was on arrival.
class QuickLook final : public Method, public RestorableMethod {
 public:
  explicit QuickLook(MethodSettings settings);
  QuickLook(const QuickLook&) = delete;  // its tracks refer to its radars
  QuickLook& operator=(const QuickLook&) = delete;

  void start(int target, Time epoch, const Gaussian<9>& estimate) override;
  Outcome process(const Measurement& m, Time now) override;
  [[nodiscard]] std::optional<TrackEstimate> fused(int target, std::optional<Time> at) const override;
  [[nodiscard]] std::optional<TrackEstimate> gps_track(int, Time) const override { return std::nullopt; }
  [[nodiscard]] BiasEstimate bias(int) const override { return {}; }
  [[nodiscard]] const SourceAccount& account(int source) const override {
    return accounts_[static_cast<std::size_t>(source)];
  }

  [[nodiscard]] std::unique_ptr<MethodState> make_state() const override;
  void save(Time before, MethodState& state) const override;
  void restore(const MethodState& state) override;

 private:
  /// The accounts are those of the instant of saving: they tell verdicts as they were on arrival.
  struct State {
    std::vector<RadarTracker::State> tracks;
    std::vector<SourceAccount> accounts;
  };

  [[nodiscard]] std::size_t index(std::size_t radar, int target) const {
    return static_cast<std::size_t>(target) * settings_.radars.size() + radar;
  }

  MethodSettings settings_;
  std::vector<Rewinder<RadarTracker>> tracks_;  ///< per target and radar
  std::vector<SourceAccount> accounts_;
};

}  // namespace downrange
