#pragma once
/// Where a target will be, kept up to date.

#include <downrange/stage/range_config.hpp>
#include <downrange/stage/result.hpp>
#include <optional>

#include "stage/slave/ladder.hpp"
#include "stage/slave/pass.hpp"

namespace downrange {

/// Antennas plan by a path that is at most so old.
inline constexpr Duration planned_every = milliseconds(1000);

/// Of one target: its plan, where it is known and the vehicle keeps to it, else free fall.
class TargetPath {
 public:
  /// Remakes the path where it is older than `planned_every`.
  void update(const Aim& aim, const NominalTrajectory& nominal, const SlaveConfig& config, std::optional<Time> liftoff,
              Time tick);

  [[nodiscard]] const PredictedPath& path() const { return path_; }
  /// The path tells when the target will be where; false: of a vehicle that will lift off some time.
  [[nodiscard]] bool timed() const { return timed_; }
  /// When the path begins; of one that is not timed, with the planned lift-off. None: nobody knows when.
  [[nodiscard]] std::optional<Time> begins(std::optional<Time> planned_liftoff) const;
  [[nodiscard]] PassBasis basis() const { return basis_; }

 private:
  PredictedPath path_;
  std::optional<Time> made_;
  bool timed_ = false;
  double begins_t_plus_s_ = 0;  ///< where not timed
  PassBasis basis_ = PassBasis::FreeFall;
};

}  // namespace downrange
