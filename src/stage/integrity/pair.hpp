#pragma once
/// Two witnesses, held against each other as long as the flight lasts.

#include <array>
#include <optional>
#include <span>

#include "clock_test.hpp"
#include "fine_test.hpp"

namespace downrange::integrity {

class Pair {
 public:
  /// `first` tells a position.
  Pair(int first, int second) : first_(first), second_(second) {}

  /// Compares the samples of both at one instant, newer than any compared before. `hold`: one of them is under
  /// accusation: what they agreed on before stays the measure. `elsewhere`: and not for its clock: nothing is to be
  /// learnt of clocks from it. `in_flight`: the vehicle has left its pad.
  void compare(const Witness& first, const Sample& a, const Witness& second, const Sample& b, bool hold, bool elsewhere,
               bool in_flight, const Threshold& threshold);

  [[nodiscard]] int first() const { return first_; }
  [[nodiscard]] int second() const { return second_; }
  [[nodiscard]] bool has(int witness) const { return witness == first_ || witness == second_; }
  [[nodiscard]] int other(int witness) const { return witness == first_ ? second_ : first_; }
  /// Newest instant compared.
  [[nodiscard]] const std::optional<Time>& compared() const { return compared_; }

  /// Three in a row beyond the threshold, or two far beyond, of one direction; until three in a row are within.
  [[nodiscard]] bool fails() const { return fails_; }
  [[nodiscard]] bool doubtful() const { return fails_ || (exceeding_ >= 2 && value_ >= 1); }
  /// In the coarse test, that is: whatever the biases are within their priors.
  [[nodiscard]] bool coarsely() const { return coarsely_; }
  /// By what a wrong clock explains.
  [[nodiscard]] bool by_clock() const { return by_clock_; }
  [[nodiscard]] std::optional<ClocksApart> clocks() const { return clock_test_.apart(); }
  /// How long they had been compared at `t`.
  [[nodiscard]] Duration known_for(Time t) const { return compared_ ? t - compared_first_ : Duration{0}; }
  /// Of the newest comparison, as a multiple of the threshold.
  [[nodiscard]] double value() const { return value_; }
  /// The smaller of the last two values after `onset`; 0 where there are not two.
  [[nodiscard]] double doubt_since(Time onset) const;
  [[nodiscard]] double apart_m() const { return apart_m_; }
  /// When the present disagreement began, as far as can be told.
  [[nodiscard]] Time onset() const { return onset_; }
  /// When it was first noticed.
  [[nodiscard]] Time noticed_at() const { return noticed_at_; }
  /// How long they have agreed, without a break, at the newest instant compared.
  [[nodiscard]] Duration agreement() const;
  /// One of them lied meanwhile, seen here or not: what was sampled then is no measure.
  void forget(Time from, Time until);

 private:
  /// Of references, while they agree: five seconds, twelve, thirty (at the beginning ten).
  static constexpr std::size_t ages = 3;

  void renew_references(const Witness& first, const Witness& second, Time at);
  void judge(Time at, const TestResult& result);
  /// When a disagreement began that is noticed at `at`.
  [[nodiscard]] Time onset_noticed(Time at, double ratio) const;
  /// What GPS taught of the biases is the measure at `at`.
  [[nodiscard]] bool proven_at(Time at, bool with_receiver) const;

  int first_;
  int second_;
  std::array<std::optional<Reference>, ages> learnt_;  ///< with what GPS taught of the biases
  std::array<std::optional<Reference>, ages> prior_;   ///< without; not of two receivers
  ClockTest clock_test_;
  Time compared_first_;  ///< where `compared_`
  std::optional<Time> compared_;
  std::optional<Time> compared_before_;
  int exceeding_ = 0;  ///< in a row
  int passing_ = 0;    ///< likewise
  bool fails_ = false;
  bool coarsely_ = false;
  bool by_clock_ = false;
  double value_ = 0;
  double value_before_ = 0;
  double apart_m_ = 0;
  Vec<3> whitened_ = Vec<3>::Zero();
  Time taught_well_since_;  ///< what GPS taught of their biases explains how they differ
  std::optional<Time> last_on_pad_;
  bool proven_ = false;  ///< as of the newest instant without doubt
  Time calm_;            ///< newest instant of little doubt
  Time onset_;
  Time noticed_at_;
  Time agrees_since_;
  Time not_before_;  ///< what was sampled while they disagreed, or one of them lied, is no measure
};

/// Two clocks are apart, those of `accused` and of its partner in `disagreement`. How much better `third`, compared
/// with either, fits the partner's clock being wrong than `accused`'s; in units of the threshold, 0: it does not.
[[nodiscard]] double clock_acquittal(std::span<const Pair> pairs, const Pair& disagreement, int accused, int third);

}  // namespace downrange::integrity
