#pragma once
/// Stage 5: where every antenna shall point.

#include <downrange/stage/range_config.hpp>
#include <downrange/stage/result.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "stage/followed.hpp"
#include "stage/slave/antenna_will.hpp"

namespace downrange {

class AntennaPointing;
class TargetPath;

/// Allocates at construction only. src/stage/slave/README.md says what becomes of a track on its way to a command.
class Slave {
 public:
  explicit Slave(const RangeConfig& config);
  ~Slave();

  /// One command per antenna that has something to follow. `followed`: of each target. `liftoff`: announced or found;
  /// until it is known, a vehicle stands where its nominal trajectory begins. `will`: of each antenna; empty: operators
  /// want nothing.
  void tick(Time tick, std::span<const Followed> followed, std::optional<Time> liftoff, ResultSink& sink,
            std::span<const AntennaWill> will = {});

 private:
  std::unique_ptr<const RangeConfig> config_;
  std::vector<std::unique_ptr<AntennaPointing>> antennas_;
  std::vector<TargetPath> paths_;  ///< by target
};

}  // namespace downrange
