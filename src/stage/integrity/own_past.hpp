#pragma once
/// Does a witness contradict itself? Its newest sample against its sample before, carried on by what was known then (a
/// fix: by its own velocity). Tells who of two that disagree broke with the past; and finds velocities that are not
/// those of the positions.

#include <optional>

#include "difference.hpp"

namespace downrange::integrity {

struct OwnPast {
  double ratio = 0;                ///< chi2 over its threshold
  double apart_m = 0;              ///< or m/s
  Vec<3> step_m = Vec<3>::Zero();  ///< a receiver's jump, ECEF
};

/// A jump: `now` against `before`, at most two seconds apart, fifteen of a radar; else nothing.
[[nodiscard]] OwnPast own_jump(const Witness& witness, const Sample& before, const Sample& now,
                               const Threshold& threshold);

/// Of a receiver: the slope of its positions over the last `span_s` seconds against the velocities that it told
/// meanwhile, in m/s. `lag_s`: how late a velocity may be for the position told with it.
[[nodiscard]] OwnPast own_velocity(const Witness& receiver, double span_s, double lag_s, const Threshold& threshold);

/// The jumps of a receiver beside which nobody else is heard: no vehicle leaps, so its past tells which side is wrong.
/// Not told of one that had no quiet past, nor of a single wild fix; taken back when it has jumped back.
class Leap {
 public:
  /// Each sample in turn; `alone`: no other witness is heard.
  void note(Time at, const OwnPast& jump, bool alone);
  /// Since when it is elsewhere than it was before it leapt. For half a minute: then nobody has contradicted it.
  [[nodiscard]] std::optional<Time> since() const { return stays_ ? leapt_ : std::nullopt; }
  [[nodiscard]] double apart_m() const { return by_m_.norm(); }
  void forget() { *this = {}; }

 private:
  std::optional<Time> quiet_from_;
  std::optional<Time> leapt_;
  Vec<3> by_m_ = Vec<3>::Zero();
  double largest_m_ = 0;
  bool stays_ = false;
};

/// A jump of a receiver that nobody could judge by then: the first radar that comes tells on which side of it the
/// receiver was right. Where that is after the jump, what it said before was the lie.
class Return {
 public:
  void jumped(Time at, const Vec<3>& step_m);
  /// The last jump, for half a minute: not judged yet.
  [[nodiscard]] const std::optional<Time>& jump() const { return jump_; }
  [[nodiscard]] const Vec<3>& step_m() const { return step_m_; }
  /// A radar's test of the receiver as it is, and as it would be had it not jumped, at an instant after the jump.
  void judge(Time at, double ratio, double ratio_without_jump);
  /// When it came back to the truth.
  [[nodiscard]] const std::optional<Time>& since() const { return since_; }

 private:
  std::optional<Time> jump_;
  std::optional<Time> since_;
  Vec<3> step_m_ = Vec<3>::Zero();
  int in_a_row_ = 0;
};

/// What no vehicle does: below ground, beyond 100 m/s^2. Of the newest sample.
[[nodiscard]] bool impossible(const Witness& witness);

}  // namespace downrange::integrity
