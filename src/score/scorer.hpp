#pragma once
/// How good a flight was: position error per phase, systematic error left per sensor, pointing error per antenna, what
/// became of each source's messages, what was found of each bias. Against the truth where it is known; without one,
/// what the sources say of each other. Fed with the engine's results in the order the engine made them.

#include <downrange/geo/refraction.hpp>
#include <downrange/stage/range_config.hpp>
#include <downrange/stage/result.hpp>
#include <downrange/stage/source_table.hpp>
#include <list>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "score/outliers.hpp"
#include "score/summary.hpp"
#include "score/truth.hpp"

namespace downrange::score {

class Scorer {
 public:
  /// Results of other targets than `target` are left out, as are results at times without truth. An empty `truth`: none
  /// is known. `liftoff` anchors the phases.
  Scorer(const RangeConfig& range, const Name& target, TruthFunction truth, Time liftoff, std::vector<Phase> phases);
  ~Scorer();
  Scorer(const Scorer&) = delete;
  Scorer& operator=(const Scorer&) = delete;

  /// Opens a run and returns where its results go; valid as long as the scorer. The first run is the service's own: its
  /// primary method is a row "label (method)", a method beside it a row "method"; its sensors and antennas are scored.
  /// Runs to compare follow ("goheung alone"): of those the primary method's trajectory counts.
  [[nodiscard]] ResultSink& open_run(const std::string& label);

  /// These plots are outliers: no part of a systematic error, and counted. Before any of them is emitted.
  void know_outliers(std::set<MessageId> outliers, OutlierOrigin origin);

  [[nodiscard]] Summary summary() const;

 private:
  class Run;
  [[nodiscard]] bool in_a_phase(Time t) const;
  [[nodiscard]] Name first_method() const;
  [[nodiscard]] std::optional<TrueState> truth_at(Time t) const;
  [[nodiscard]] const Site* site_of(const Name& sensor) const;  ///< null: not configured

  RangeConfig range_;
  SourceTable sources_;
  Name target_;
  TruthFunction truth_;
  Time liftoff_;
  std::vector<Phase> phases_;
  std::map<Name, RefractionTable> air_;  ///< of sensors whose refraction the range models
  std::map<Name, RefractionTable> antenna_air_;
  std::set<MessageId> outliers_;
  OutlierOrigin outlier_origin_ = OutlierOrigin::None;
  std::list<Run> runs_;
};

}  // namespace downrange::score
