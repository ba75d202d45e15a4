#pragma once
/// The method of the range paper: H.-R. Song, GPS-based multiple radar bias estimation and sensor fusion for launch
/// vehicle tracking, 2015 (doi 10.9723/jksiis.2015.20.6), with the corrections of est/ERRATA.md.

#include <array>
#include <downrange/est/filter/async_fusion.hpp>
#include <downrange/est/method/cartesian_align.hpp>
#include <downrange/est/method/method.hpp>

namespace downrange {

/// The radar fusion of one target: the estimate at the last batch instant and the plots since.
struct BatchTrack {
  static constexpr int max_radars = 64;

  bool started = false;
  Time base_epoch;
  Gaussian<6> base;
  int pending_count = 0;
  std::array<TimedPosition, max_batch> pending{};
  std::array<Time, max_batch> pending_epoch{};
  Time epoch;           ///< of the newest plot
  Gaussian<6> current;  ///< base and pending fused at `epoch`
  double nis = 0;
};

/// GPS predicted to the radar epochs -> pseudo bias measurement -> bias Kalman filter per radar -> compensation ->
/// optimal asynchronous fusion. Without bias estimation (`correct` false) it is the *uncorrected* fusion: radars only,
/// no bias states, no gate.
class Song2015 {
 public:
  struct State {
    CartesianAlign::State align;
    std::vector<BatchTrack> fused;  ///< per target
    std::vector<SourceAccount> accounts;
  };

  Song2015(MethodSettings settings, bool correct);

  [[nodiscard]] State initial() const;
  void reserve(State& state) const { align_.reserve(state.align); }
  Outcome apply(State& state, const Measurement& m) const;
  void start(State& state, int target, Time epoch, const Gaussian<9>& estimate) const;

  [[nodiscard]] std::optional<TrackEstimate> fused(const State& state, int target, std::optional<Time> at) const;
  [[nodiscard]] std::optional<TrackEstimate> gps_track(const State& state, int target, Time at) const {
    return align_.gps_track(state.align, target, at);
  }
  [[nodiscard]] BiasEstimate bias(const State& state, int radar) const { return align_.bias(state.align, radar); }
  [[nodiscard]] const SourceAccount& account(const State& state, int source) const {
    return state.accounts[static_cast<std::size_t>(source)];
  }

  [[nodiscard]] const MethodSettings& settings() const { return align_.settings(); }

 private:
  Outcome apply_plot(State& state, const Measurement& m) const;
  /// `refused`: GPS does not allow the plot.
  [[nodiscard]] Outcome judge(const BatchTrack& track, SourceAccount& account, const Measurement& m,
                              const TimedPosition& z, bool refused) const;
  void start_track(BatchTrack& track, const Measurement& m, const TimedPosition& z) const;
  void fuse_into(BatchTrack& track, const Measurement& m, const TimedPosition& z) const;

  CartesianAlign align_;
  double gate3_;  ///< chi2 quantile, 3 degrees of freedom; infinity when not correcting
};

}  // namespace downrange
