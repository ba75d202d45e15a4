#pragma once
/// The primary method on a part of the sources, and how it is run again without one of them.

#include <downrange/est/method/method.hpp>
#include <downrange/est/method/method_state.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "stage/integrity/chain_plan.hpp"
#include "stage/integrity/exclusions.hpp"
#include "stage/integrity/measurement_log.hpp"

namespace downrange {

/// Makes the primary method for a part of the sources.
using ChainMethodMaker = std::function<std::unique_ptr<Method>(const MethodSettings&)>;

/// Of one target; `all` is of every target, for methods share biases between targets.
///
/// A chain that is run again without a source goes on meanwhile as it was, with its own estimate; it is replaced when
/// the new run has caught up.
class Chain {
 public:
  /// `target`: the one that it follows; none: every target. `settings`: with all sources and targets.
  Chain(const ChainPlan& plan, std::optional<int> target, const MethodSettings& settings, ChainMethodMaker make,
        Duration coast);

  [[nodiscard]] const Name& name() const { return name_; }
  [[nodiscard]] SourceSet sources() const { return sources_; }
  /// One source: it hears that source whoever is excluded, so that it may show that it tells the truth again.
  [[nodiscard]] bool alone() const { return alone_; }
  /// One source, or all radars.
  [[nodiscard]] bool independent() const { return independent_; }

  /// A measurement that the log has put to `at`. What became of it; nothing where the chain does not hear it.
  std::optional<Verdict> process(const LoggedMeasurement& measurement, MeasurementLog::Position at, Time now,
                                 const Exclusions& exclusions);

  /// Predicted to `at`; nothing where there is no track, or none young enough to coast on. GPS alone is its own track
  /// where the method fuses radars only.
  [[nodiscard]] std::optional<TrackEstimate> estimate(int target, Time at) const;
  /// The method's fused track, predicted to `at`, else at its newest measurement.
  [[nodiscard]] std::optional<TrackEstimate> fused(int target, std::optional<Time> at) const;
  /// Terms is 0 where the chain does not hear the source, or it has none.
  [[nodiscard]] BiasEstimate bias(SourceId source) const;
  /// Epoch of the newest measurement of the target that it was given.
  [[nodiscard]] Time newest(int target) const { return newest_[index(target)]; }

  [[nodiscard]] const Method& method() const { return *method_; }
  /// The target as `method` counts.
  [[nodiscard]] int target_of_method(int target) const { return target_ ? 0 : target; }

  /// Keeps its state before `instant` (end of the history: nothing older comes any more) for `roll_back`, and forgets
  /// those before `oldest`.
  void keep(Time instant, Time oldest);

  /// To be run again, without what `liars` said of `target` from `from` on: `catch_up` does so by and by.
  void roll_back(int target, SourceSet liars, Time from, const MeasurementLog& log);
  [[nodiscard]] bool runs_again() const { return again_ != nullptr; }
  /// Up to `most` of the logged measurements; how many. `instants`: all that `keep` was called with and are kept.
  int catch_up(const MeasurementLog& log, const Exclusions& exclusions, std::span<const Time> instants, int most);
  /// Where the run stands that catches up.
  [[nodiscard]] MeasurementLog::Position cursor() const { return cursor_; }

  /// The sources that taught it, of that target, what they should not have.
  [[nodiscard]] SourceSet taught_by(int target) const { return taught_[index(target)]; }
  /// These are believed again.
  void believe(int target, SourceSet sources);
  /// Counts the runs that have caught up: with each, its estimate may jump.
  [[nodiscard]] std::uint64_t runs() const { return runs_; }

 private:
  struct Kept {
    Time instant;
    std::unique_ptr<MethodState> state;
  };

  [[nodiscard]] std::size_t index(int target) const { return target_ ? 0 : static_cast<std::size_t>(target); }
  [[nodiscard]] bool hears(const LoggedMeasurement& measurement, const Exclusions& exclusions) const;
  [[nodiscard]] Outcome give(Method& method, const LoggedMeasurement& measurement, Time now) const;
  [[nodiscard]] TrackEstimate with_source_ids(TrackEstimate estimate) const;
  void keep_of(const Method& method, Time instant);

  Name name_;
  SourceSet sources_;
  bool alone_;
  bool independent_;
  std::optional<int> target_;
  MethodSettings settings_;  ///< of its own sources and targets
  ChainMethodMaker make_;
  Duration coast_;
  std::vector<int> source_of_method_;  ///< by SourceId: as `method_` counts; -1: not heard
  std::vector<SourceId> ground_;       ///< as `method_` counts radars and trackers: their SourceId
  std::unique_ptr<Method> method_;
  std::vector<Time> newest_;

  std::vector<Kept> kept_;                           ///< ascending
  std::vector<std::unique_ptr<MethodState>> spare_;  ///< room
  std::unique_ptr<Method> again_;                    ///< the run that catches up
  MeasurementLog::Position cursor_ = 0;              ///< of the first measurement that it was not given
  Time again_at_;                                    ///< newest epoch that it was given
  std::vector<SourceSet> taught_;                    ///< by target
  std::vector<SourceSet> taught_for_good_;           ///< and the run that catches up as well
  std::uint64_t runs_ = 0;
};

}  // namespace downrange
