#pragma once
/// A flight with a fault in it, judged: how far off, who was accused, how soon it recovered, whether the bound held.
/// The one definition of each (README.md).

#include <downrange/stage/range_config.hpp>
#include <downrange/stage/result.hpp>
#include <downrange/stage/source_table.hpp>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "score/errors.hpp"
#include "score/mount_tally.hpp"
#include "score/truth.hpp"

namespace downrange::score {

/// What a fault may do. Where there is no number, nothing is expected.
struct FaultLimits {
  std::optional<double> error_m{};          ///< worst position error while it lasts, or as it is without the liars
  std::optional<double> recovery_s{};       ///< after its end
  std::optional<double> accusation_s{};     ///< after its begin, of a source that lies
  double bound_share = 0.999;               ///< of ticks with a bound, those that it covers
  std::optional<double> on_target_share{};  ///< of the time that mounts follow the target, all antennas together
  std::optional<double> excursion_rad{};    ///< how far a mount that follows commands is from the target at most
  /// Most sources lie alike: confidently wrong commands, a bound that fails and an innocent source accused first are
  /// allowed.
  bool majority_lies = false;
};

/// A fault and what is true.
struct FaultCase {
  Name target;
  TruthFunction truth{};
  Time begin{};
  std::optional<Time> end{};  ///< none: it lasts to the end of the flight
  std::vector<Name> liars{};  ///< sources that are rightly accused; none: nobody is
  double recovered_m = 10;    ///< position errors up to this are those of the flight without the fault
};

/// The first source that was accused after the fault began.
struct Accusation {
  Name source;
  double delay_s = 0;  ///< after the fault's begin
  bool right = false;  ///< one of those that lie
};

/// One second of a flight, for drawing.
struct FaultSecond {
  double t_s = 0;      ///< its begin, after the fault's begin
  double error_m = 0;  ///< the worst position error
  double sigma_m = 0;  ///< with it: the largest 1-sigma of any direction
  std::optional<double> bound_m{};
  std::vector<Name> accused{};
  Name chain{};  ///< that the track was made of; empty: all sources
};

struct FaultScore {
  Spread whole;       ///< position errors of the primary track, whole flight
  Spread during;      ///< while the fault lasts; no sample: there was no track
  long commands = 0;  ///< judged: not held at the end of an antenna's travel, target beyond 5 km
  long confidently_wrong = 0;
  long wrong_by_sigma = 0;  ///< the same without regard to the bound
  Share bound;              ///< positions that the bound sent with them covers
  Share pointing_bound;     ///< commands likewise
  long unbounded = 0;       ///< positions sent without a bound
  std::optional<Accusation> accusation{};
  bool recovers = false;               ///< there is an end to recover from
  std::optional<double> recovery_s{};  ///< none: not within `recovery_horizon`
  /// Worst position error, while the fault lasts, of the same flight with the liars silent; where it was flown.
  std::optional<double> without_liars_m{};
  std::map<Name, MountScore> mounts{};  ///< at each antenna that follows the target, from the fault's begin on

  [[nodiscard]] MountScore all_mounts() const;
  std::vector<FaultSecond> seconds{};
};

/// An error that does not go back within this is not recovered from.
inline constexpr Duration recovery_horizon = seconds(60);
/// A command this far off, and further from its own uncertainty, is confidently wrong.
inline constexpr double wrong_rad = 0.25 * std::numbers::pi / 180;
inline constexpr double wrong_sigmas = 5;
inline constexpr double wrong_beyond_m = 5000;  ///< of range: nearer, a metre is an angle

/// Takes the results of one flight as the engine made them. Mounts stand still where neither a command nor a health
/// record, which comes once a second, tells that time goes on.
class FaultJudge final : public ResultSink {
 public:
  FaultJudge(const RangeConfig& range, FaultCase fault);
  FaultJudge(const FaultJudge&) = delete;
  FaultJudge& operator=(const FaultJudge&) = delete;

  void emit(const Result& result) override;

  [[nodiscard]] FaultScore score() const;

 private:
  void add(const Trajectory& trajectory);
  void add(const SlavingCommand& command);
  void add(const SourceHealth& health);
  void add(const Integrity& integrity);
  template <class Other>
  void add(const Other&) {}
  enum class Accuser : std::uint8_t { Health = 1, Integrity = 2 };
  /// Whether `by` accuses `source` from `time` on.
  void accuse(const Name& source, Time time, Accuser by, bool accused);
  FaultSecond& second_of(Time t);
  [[nodiscard]] std::optional<double> recovery() const;

  struct ErrorAt {
    Time time;
    double error_m;
  };

  RangeConfig range_;
  FaultCase fault_;
  SourceTable sources_;
  std::map<Name, RefractionTable> air_;  ///< by antenna
  std::map<Name, MountTally> mounts_;
  std::vector<ErrorAt> errors_;
  struct Accused {
    Name source;
    unsigned by = 0;  ///< Accuser, as bits
  };
  std::vector<Accused> accused_;  ///< now
  bool integrity_heard_ = false;
  FaultScore score_;
};

/// Who excludes a liar has what is left: this much more than the worst error without it is as good.
inline constexpr double as_without_ratio = 1.2;

/// The error is larger than expected.
[[nodiscard]] bool is_too_far_off(const FaultScore& score, const FaultLimits& limits);
/// What is not as expected, one sentence each: "worst 812 m, allowed 50 m". None: all is.
[[nodiscard]] std::vector<std::string> missed(const FaultScore& score, const FaultLimits& limits);

}  // namespace downrange::score
