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

/// Ticks with which antennas' accounts go out.
[[nodiscard]] constexpr bool tells_accounts(Time tick) { return tick.ns % 1'000'000'000 == 0; }

/// Allocates at construction only. src/stage/slave/README.md says what becomes of a track on its way to a command.
class Slave {
 public:
  explicit Slave(const RangeConfig& config);
  ~Slave();

  /// An accepted measurement: where its sensor's mount read the target.
  void note(const Observation& o);
  /// Where a moving antenna is.
  void note(const PlatformState& state);

  /// One command per antenna that has something to follow, and once a second each one's account. `followed`: of
  /// each target. `liftoff`: announced or found; until it is known, a vehicle stands where its nominal trajectory
  /// begins, and passes count from the planned one. `will`: of each antenna; empty: operators want nothing.
  void tick(Time tick, std::span<const Followed> followed, std::optional<Time> liftoff, ResultSink& sink,
            std::span<const AntennaWill> will = {}, std::optional<Time> planned_liftoff = {});

 private:
  /// One antenna's command. Where its target will be; null: it has nothing to follow.
  const TargetPath* command(std::size_t antenna, const AntennaWill& wanted, std::span<const Followed> followed,
                            std::optional<Time> liftoff, Time tick, ResultSink& sink);

  std::unique_ptr<const RangeConfig> config_;
  std::vector<std::unique_ptr<AntennaPointing>> antennas_;
  std::vector<TargetPath> paths_;         ///< by target
  std::vector<TargetPath> pinned_paths_;  ///< by antenna
};

}  // namespace downrange
