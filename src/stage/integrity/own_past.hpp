#pragma once
/// Does a witness contradict itself? Its newest sample against its sample before, carried on by what was known then (a
/// fix: by its own velocity). Tells who of two that disagree broke with the past; and finds velocities that are not
/// those of the positions.

#include "difference.hpp"

namespace downrange::integrity {

struct OwnPast {
  double ratio = 0;    ///< chi2 over its threshold
  double apart_m = 0;  ///< or m/s
};

/// A jump: `now` against `before`, at most two seconds apart; else nothing.
[[nodiscard]] OwnPast own_jump(const Witness& witness, const Sample& before, const Sample& now,
                               const Threshold& threshold);

/// Of a receiver: the slope of its positions over the last `span_s` seconds against the velocities that it told
/// meanwhile, in m/s. `lag_s`: how late a velocity may be for the position told with it.
[[nodiscard]] OwnPast own_velocity(const Witness& receiver, double span_s, double lag_s, const Threshold& threshold);

/// What no vehicle does: below ground, beyond 100 m/s^2. Of the newest sample.
[[nodiscard]] bool impossible(const Witness& witness);

}  // namespace downrange::integrity
