#pragma once
/// Who lies: the smallest set of witnesses whose removal makes the remaining tests pass, as receiver-autonomous
/// integrity monitoring excludes a satellite.

#include <cstdint>
#include <downrange/geo/time.hpp>
#include <span>

namespace downrange::integrity {

/// Bit i: witness i.
using WitnessSet = std::uint64_t;
[[nodiscard]] constexpr WitnessSet only(int witness) { return WitnessSet{1} << static_cast<unsigned>(witness); }

/// A test of two witnesses.
struct Edge {
  int first = 0;
  int second = 0;
  bool fails = false;
  /// What speaks for a disagreement and is not enough to fail, as a multiple of the threshold: the smaller of the last
  /// two values since the onset, 0 where there are not two.
  double doubt = 0;
};

/// What a witness alone tells, for ties.
struct Character {
  double own_break = 0;  ///< with its own past about the onset, in units of the threshold
  double acquittal = 0;  ///< what others say for it and against whom it disagrees with, in units of the threshold
  bool impossible = false;
  double off_nominal = 0;  ///< from the nominal trajectory, in units of its threshold; 0 where none is known
  int distrust = 0;        ///< place in the configured order of trust; the same for all where none is configured
};

struct Accusation {
  WitnessSet guilty = 0;  ///< named; its removal leaves nothing that fails
  WitnessSet tied = 0;    ///< beside these: one of them, and nothing says which
};

/// `alone`: witnesses that a test of their own has found guilty; so is who broke overwhelmingly with its own past when
/// it began to disagree with one who did not, whatever the votes. `innocent`: never to be named (forced by an
/// operator). `named`: those excluded now. To accuse one of them again costs little: where one of them and one other
/// disagree with a third, nobody can tell; two others are believed. A doubt that an explanation leaves costs as well,
/// and what others say for whom it accuses. Sets of up to three are tried beyond `alone` and `named`; what needs more
/// is tied.
[[nodiscard]] Accusation identify(std::span<const Edge> edges, std::span<const Character> characters, WitnessSet alone,
                                  WitnessSet innocent, WitnessSet named);

}  // namespace downrange::integrity
