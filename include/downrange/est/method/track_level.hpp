#pragma once
/// Methods `information`, `federated`, `map`, `bar-shalom-campo` and `convex`: ALIGN as song2015, FUSE of tracks.
///
/// Every radar has a track of its own, nearly constant velocity with white acceleration `q_m2_s3`, of its compensated
/// plots; what the sites' tracks say together is the rule's (track_rules.hpp). For ranges whose sites deliver tracks
/// instead of plots, and to compare.

#include <algorithm>
#include <downrange/est/method/cartesian_align.hpp>
#include <downrange/est/track/track_rules.hpp>

namespace downrange {

/// The first plot of a target starts all its tracks: the radar that has it designates the others. A track without a
/// plot for `silent_after` does not take part; with its next plot it starts anew from the fused track, as one does
/// whose radar alone was rejected `reopen_after` times in a row. Plots are gated by the radar's own track, as at its
/// site; the federated rule's local tracks are wide by its shares, and so is their gate; their NIS are small, and
/// the mismatch alarm sees little.
///
/// Fused at every plot. The federated rule gives the local tracks their shares at the instants of `batch` on the UTC
/// grid, before the first plot after each.
template <class Rule>
class TrackLevel {
 public:
  static constexpr Duration silent_after = milliseconds(5000);

  struct Target {
    bool started = false;
    Time epoch;  ///< of the rule's tracks: the newest plot, accepted or not
    Rule rule;
    std::vector<Time> contributed;  ///< last accepted plot per track
    Time data_epoch;                ///< newest accepted plot
    Gaussian<6> fused;              ///< at data_epoch
    double nis = 0;
  };
  struct State {
    CartesianAlign::State align;
    std::vector<Target> targets;
    std::vector<SourceAccount> accounts;
  };

  /// Throws std::invalid_argument for more than max_fused_tracks radars that tell positions; others have no track.
  explicit TrackLevel(MethodSettings settings);

  [[nodiscard]] State initial() const;
  void reserve(State& state) const { align_.reserve(state.align); }
  void start(State& state, int target, Time epoch, const Gaussian<9>& estimate) const;
  Outcome apply(State& state, const Measurement& m) const;

  [[nodiscard]] std::optional<TrackEstimate> fused(const State& state, int target, std::optional<Time> at) const;
  [[nodiscard]] std::optional<TrackEstimate> gps_track(const State& state, int target, Time at) const {
    return align_.gps_track(state.align, target, at);
  }
  [[nodiscard]] BiasEstimate bias(const State& state, int radar) const { return align_.bias(state.align, radar); }
  [[nodiscard]] const SourceAccount& account(const State& state, int source) const {
    return state.accounts[static_cast<std::size_t>(source)];
  }
  [[nodiscard]] const MethodSettings& settings() const { return align_.settings(); }
  [[nodiscard]] std::size_t checkpoint_spacing() const {
    return 8 * static_cast<std::size_t>(std::max(1, settings().targets));
  }

 private:
  Outcome apply_plot(State& state, const Measurement& m) const;
  /// `refused`: GPS does not allow the plot.
  Outcome update(Target& t, SourceAccount& account, const Measurement& m, const TimedPosition& z, int track,
                 bool refused) const;
  static void start_target(Target& t, Time epoch, const Gaussian<6>& x);
  void advance(Target& t, Time to) const;
  [[nodiscard]] static bool silent(const Target& t, std::size_t track) {
    return t.epoch - t.contributed[track] > silent_after;
  }

  CartesianAlign align_;
  std::vector<int> radar_of_;  ///< by track
  std::vector<int> track_of_;  ///< by source; -1: none
  double gate3_;
};

extern template class TrackLevel<ConvexRule>;
extern template class TrackLevel<InformationRule>;
extern template class TrackLevel<CampoRule>;
extern template class TrackLevel<MapRule>;
extern template class TrackLevel<FederatedRule>;

}  // namespace downrange
