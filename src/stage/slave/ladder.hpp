#pragma once
/// What an antenna follows: the best that there is.

#include <downrange/stage/range_config.hpp>
#include <downrange/stage/result.hpp>
#include <optional>

#include "stage/followed.hpp"
#include "stage/slave/look.hpp"

namespace downrange {

/// Where an aim comes from: from another one, it may have jumped.
struct Origin {
  SlavingSource source = SlavingSource::Fused;
  Name chain{};
  std::uint64_t revision = 0;
  int target = 0;

  bool operator==(const Origin&) const = default;
};

/// What is followed at an instant.
struct Aim {
  TrackEstimate estimate;
  Look look;
  Origin origin;
  bool bounded = false;  ///< as of Followed
};

/// Of one antenna. From the top: the selected chain; coasting; the best source alone; GPS; coasting on, where the
/// antenna's beam is known and still holds the target; the nominal trajectory. Nothing: no command is better than a
/// wrong one.
class Ladder {
 public:
  /// `air`: null, no refraction. Both must outlive it.
  Ladder(const AntennaConfig& antenna, const SlaveConfig& config, const RefractionTable* air)
      : antenna_(antenna), config_(config), air_(air) {}

  /// A method is not asked for what is too old to coast on.
  [[nodiscard]] std::optional<Aim> choose(const Followed& followed, const NominalTrajectory& nominal,
                                          std::optional<Time> liftoff, Time tick, Time apply_at);

  /// Another target is followed from now on.
  void forget();

  /// What one lying source can have done to the pointing, 0 where that is not known: a coasting track keeps what it was
  /// told last.
  void note_bound(double bound_rad) { bound_rad_ = bound_rad; }

 private:
  [[nodiscard]] std::optional<Aim> judged(const std::optional<TrackEstimate>& estimate, Time tick, Duration oldest,
                                          const Origin& origin) const;
  [[nodiscard]] std::optional<Aim> best_alone(const Followed& followed, Time tick, Time apply_at, bool receiver);
  [[nodiscard]] std::optional<Aim> from_above(const Followed& followed, Time tick, Time apply_at);
  [[nodiscard]] std::optional<Aim> planned(const NominalTrajectory& nominal, std::optional<Time> liftoff, Time tick,
                                           Time apply_at) const;
  /// Is the vehicle so far from its plan that the plan tells nothing any more?
  void compare_with_plan(const Aim& aim, const NominalTrajectory& nominal, std::optional<Time> liftoff, Time tick);

  const AntennaConfig& antenna_;
  const SlaveConfig& config_;
  const RefractionTable* air_;
  Name alone_{};  ///< the chain of one source that is followed
  double bound_rad_ = 0;
  bool left_plan_ = false;
};

}  // namespace downrange
