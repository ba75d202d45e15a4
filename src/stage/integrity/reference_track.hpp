#pragma once
/// How the target moves, as far as is needed to bring measurements of half a second to one instant. Any chain serves:
/// what it is wrong by drops out of the comparison of two sources.

#include <downrange/est/model/matrix.hpp>
#include <downrange/geo/time.hpp>
#include <optional>

#include "ring.hpp"

namespace downrange::integrity {

/// Position, velocity, acceleration after dt seconds of constant acceleration.
[[nodiscard]] Vec<9> moved(const Vec<9>& motion, double dt_s);

class ReferenceTrack {
 public:
  ReferenceTrack() : states_(capacity) {}

  /// In ascending order of epoch.
  void note(Time epoch, const Vec<9>& motion) { states_.push({epoch, motion}); }
  void forget() { states_.clear(); }
  /// From the state noted nearest to `at`; none farther than 2.5 s.
  [[nodiscard]] std::optional<Vec<9>> at(Time at) const;

 private:
  static constexpr std::size_t capacity = 64;
  struct State {
    Time epoch;
    Vec<9> motion = Vec<9>::Zero();
  };
  Ring<State> states_;
};

}  // namespace downrange::integrity
