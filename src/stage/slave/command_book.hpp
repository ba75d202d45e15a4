#pragma once
/// What becomes of the commands at an antenna: those that came, and where it shall point at an instant between, or
/// shortly behind, them. Of whoever follows them, not of the engine: it allocates.

#include <cstdint>
#include <deque>
#include <downrange/stage/result.hpp>
#include <optional>

namespace downrange {

/// Where an antenna shall point at an instant.
struct CommandedPointing {
  double azimuth_rad = 0;  ///< unwrapped, as the command's
  double elevation_rad = 0;
  Time tick;  ///< of the command that it is made of, the next likewise
  SlavingSource source = SlavingSource::Fused;
};

class CommandBook {
 public:
  /// `ahead`: how far ahead of now a command applies at most: link delay and lead. A second more is taken for clocks
  /// that differ; beyond it the sender's clock is wrong, and such a command would outrank all that follow.
  explicit CommandBook(Duration ahead) : ahead_(ahead) {}

  /// False: not taken, because it is old news (it applies no later than one that is here), has expired, applies too far
  /// ahead, or is not finite.
  bool take(const SlavingCommand& command, Time now);

  /// Between two commands: both carried to the instant, by rate and, where both have it, acceleration, and weighed by
  /// how near they are, so that nothing steps. Behind the newest: that one, carried on. Nothing: no command applies
  /// yet, or the one that does has expired by then.
  [[nodiscard]] std::optional<CommandedPointing> at(Time t) const;

  /// When the last command expires. Nothing: there is none.
  [[nodiscard]] std::optional<Time> valid_until() const;

  // Not taken: the clocks differ, or the way is too long.
  [[nodiscard]] std::uint64_t expired() const { return expired_; }
  [[nodiscard]] std::uint64_t from_future() const { return from_future_; }

 private:
  Duration ahead_;
  std::deque<SlavingCommand> commands_;  ///< ascending in apply_at
  std::uint64_t expired_ = 0;
  std::uint64_t from_future_ = 0;
};

}  // namespace downrange
