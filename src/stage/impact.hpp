#pragma once
/// Where each target falls when its engines stop now, by the selected chain and by each that is independent of others
/// (est/THEORY.md section 15).

#include <downrange/geo/ground_polygon.hpp>
#include <downrange/stage/range_config.hpp>
#include <downrange/stage/result.hpp>
#include <optional>
#include <span>
#include <vector>

#include "stage/integrity/integrity_stage.hpp"

namespace downrange {

/// The limit at `t_plus_s`: linear between rows, the first and the last hold before and after. Nothing of no rows.
[[nodiscard]] std::optional<double> data_loss_limit_s(std::span<const DataLossLimit> table, double t_plus_s);

/// The chains of a target that are told of: the selected one (empty), and those that are independent.
[[nodiscard]] std::vector<Name> impact_chains(const RangeConfig& config);

/// Allocates at construction only. Where it is switched off it says nothing.
class ImpactStage {
 public:
  /// `integrity`: whose chains it tells of.
  ImpactStage(const RangeConfig& config, const IntegrityStage& integrity);

  /// To be called with every tick, after INTEGRITY: ten times a second, on the ticks that INTEGRITY judges, a record
  /// for each chain that has had an estimate and whose data is not lost for longer than anything coasts.
  void tick(Time tick, std::optional<Time> liftoff, const IntegrityStage& integrity, ResultSink& sink);

 private:
  struct Boundary {
    Name id;
    GroundPolygon polygon;
  };
  /// What one chain says of one target.
  struct Line {
    Result record;                      ///< ImpactPoint; its room is used again
    std::optional<Time> last_accepted;  ///< epoch of the newest measurement that the chain has accepted
  };
  struct Target {
    Line selected;
    std::vector<Line> others;  ///< by the place among IntegrityStage::others; of those that are not independent unused
  };

  [[nodiscard]] Line line_of(const Name& target, const Name& chain) const;
  void say(Line& line, const std::optional<TrackEstimate>& estimate, Time tick, std::optional<Time> liftoff,
           ResultSink& sink) const;
  void add_fall(ImpactPoint& record, const TrackEstimate& estimate) const;

  ImpactConfig config_;
  std::vector<Boundary> boundaries_;
  std::vector<Target> targets_;
  std::optional<Time> last_tick_;
};

}  // namespace downrange
