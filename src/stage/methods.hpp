#pragma once
/// Stages 2 and 3, ALIGN and FUSE: the configured methods side by side, fed with accepted observations.

#include <downrange/est/method/method.hpp>
#include <downrange/stage/event.hpp>
#include <downrange/stage/range_config.hpp>
#include <downrange/stage/result.hpp>
#include <downrange/stage/source_table.hpp>
#include <memory>
#include <vector>

#include "residuals.hpp"

namespace downrange {

/// Radars and trackers behind them, as the methods are told of them.
[[nodiscard]] std::vector<RadarModel> radar_models(const RangeConfig& config);

class Methods {
 public:
  explicit Methods(const RangeConfig& config);

  /// Brings one accepted observation into every method. `in_flight`: the vehicle is known to have left its pad.
  void process(const Observation& o, bool in_flight);

  /// ALIGN's results: the bias of the observation's radar or tracker, for each method that accepted the observation.
  void emit_biases(const Observation& o, ResultSink& sink) const;
  /// FUSE's results: the trajectory of the observation's target, for each method that accepted the observation and
  /// whose estimate it changed.
  void emit_trajectories(const Observation& o, ResultSink& sink);
  /// FUSE's results on the tick: every target and method, predicted to `tick`.
  void emit_trajectories_at(Time tick, ResultSink& sink) const;

  /// Epoch of the newest measurement of each target that the methods were given, used or not: no estimate has newer
  /// data behind it. To be asked before an estimate is, which costs the more the older its data is.
  [[nodiscard]] const std::vector<Time>& newest() const { return newest_; }

  /// How far the sources are from the primary method's track.
  [[nodiscard]] const Residuals& residuals() const { return residuals_; }

  /// The first method: SLAVE points by its tracks, health reports its residuals.
  [[nodiscard]] const Method& primary() const { return *runners_.front().method; }

 private:
  Methods(const RangeConfig& config, const MethodSettings& settings);

  struct Published {
    Time epoch;
    Vec<9> mean = Vec<9>::Zero();
  };
  struct Runner {
    Name name;
    std::unique_ptr<Method> method;
    std::vector<Published> published;  ///< per target
    bool accepted = false;             ///< the last observation
  };

  void emit_trajectory(const Runner& runner, const TrackEstimate& estimate, const Name& target, Time received,
                       ResultSink& sink) const;

  RangeConfig config_;
  SourceTable sources_;
  std::vector<Runner> runners_;
  std::vector<Time> newest_;  ///< per target
  Residuals residuals_;
};

}  // namespace downrange
