#pragma once
/// INTEGRITY: the primary method as chains of sources, so that one that lies is found, what it taught is undone, and
/// how far a lie may reach is known (est/THEORY.md section 12).

#include <algorithm>
#include <downrange/stage/event.hpp>
#include <downrange/stage/range_config.hpp>
#include <downrange/stage/result.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "stage/followed.hpp"
#include "stage/integrity/chain.hpp"
#include "stage/integrity/judge.hpp"

namespace downrange {

/// What judges the sources of one target: `Judge`, or what a test puts in its place.
class SourceJudge {
 public:
  virtual ~SourceJudge() = default;
  /// Every observation of the target that INGEST accepted, and every double of a fix, in order of arrival.
  virtual void note(SourceId source, const Observation& o) = 0;
  /// One Judgement per source, by SourceId. `biases` likewise: what the selected chain knows; terms 0: nothing.
  virtual std::span<const Judgement> judge(const JudgedTick& tick, std::span<const ChainState> chains,
                                           std::span<const BiasEstimate> biases) = 0;
};
using JudgeMaker =
    std::function<std::unique_ptr<SourceJudge>(const RangeConfig& config, const SourceTable& sources, int target)>;
/// Makes a `Judge` for each target.
[[nodiscard]] JudgeMaker impartial_judges();

/// What operators and the mission clock tell it at a tick. The spans may be empty: nobody ordered anything.
struct OperatorWill {
  SourceSet forced = 0;                ///< nobody may exclude these
  SourceSet inhibited = 0;             ///< not used
  std::span<const Name> ordered_by{};  ///< by SourceId: who forced or inhibited it; empty: nobody
  std::span<const Name> held{};        ///< by target: the chain to be followed; empty: INTEGRITY selects
  std::span<const Name> held_by{};     ///< by target: who wants that
  std::optional<Time> liftoff{};
};

/// Switched off (integrity.enabled, fewer than two sources, or no judge) it is one chain of all sources, which is
/// always selected.
///
/// The verdicts are those of the tick that judged; late data changes the chains and never a verdict. What a chain hears
/// is told by the measurements' epochs, so that a chain does not depend on the order of arrival.
class IntegrityStage {
 public:
  IntegrityStage(const RangeConfig& config, const MethodSettings& settings, const JudgeMaker& make_judge);

  /// What INGEST accepted into every chain that hears it, and the doubles of a fix (Reason::Duplicate), which a chain
  /// hears where the stations that relayed it before are excluded. Whether the selected chain accepted it.
  bool process(const Observation& o, const Measurement& m);

  /// Judges ten times a second and says what it thinks of each target, goes on with what is run again, selects. To be
  /// called with every tick, before anything is asked for that tick.
  void tick(Time tick, const OperatorWill& will, ResultSink& sink);
  /// Whether the last tick judged.
  [[nodiscard]] bool judged() const { return judged_; }

  /// The chain of all sources.
  [[nodiscard]] const Chain& all() const { return all_; }
  [[nodiscard]] const Chain& selected(int target) const { return chain(of(target), of(target).selected); }
  /// By target.
  [[nodiscard]] std::span<const Followed> followed() const { return followed_; }
  /// m; none: nothing bounds what one lying source can do.
  [[nodiscard]] std::optional<double> bound(int target) const { return of(target).bound_m; }

  /// What is selected, predicted to the last tick, which is to be one that judged where any judges. Nothing where there
  /// is no estimate.
  [[nodiscard]] std::optional<TrackEstimate> selected_estimate(int target) const;

  /// The chains beside that of all sources, and their estimates at the last tick, where that judged.
  [[nodiscard]] std::span<const Chain> others(int target) const { return of(target).others; }
  [[nodiscard]] std::span<const ChainState> states_of_others(int target) const {
    return std::span(of(target).states).subspan(1);
  }

 private:
  static constexpr int of_all = 0;  ///< place of the chain of all sources; the others follow

  struct Target {
    std::vector<Chain> others;
    std::unique_ptr<SourceJudge> judge;
    Time newest;                      ///< measurement of any source, excluded or not
    bool in_flight = false;           ///< as of its newest observation
    SourceSet reported = 0;           ///< the sources that told of it
    std::vector<Time> first_told;     ///< by SourceId: its oldest measurement
    SourceSet excluded = 0;           ///< by verdict
    SourceSet inhibited = 0;          ///< by operators
    std::vector<Judgement> verdicts;  ///< by SourceId
    std::vector<ChainState> states;   ///< of `all` and the others, at the last tick that judged or ended a run
    std::vector<Alternative> alternatives;
    int selected = of_all;
    std::uint64_t revision = 0;   ///< of what is selected
    std::uint64_t runs_seen = 0;  ///< of the selected chain
    std::optional<double> bound_m;
    bool changed = false;  ///< a verdict or the chain, since the last report
    std::uint64_t events = 0;
    Result record;  ///< Integrity; its room is used again
  };

  [[nodiscard]] Target& of(int target) { return targets_[static_cast<std::size_t>(target)]; }
  [[nodiscard]] const Target& of(int target) const { return targets_[static_cast<std::size_t>(target)]; }
  [[nodiscard]] const Chain& chain(const Target& t, int place) const {
    return place == of_all ? all_ : t.others[static_cast<std::size_t>(place - 1)];
  }
  [[nodiscard]] Chain& chain(Target& t, int place) {
    return place == of_all ? all_ : t.others[static_cast<std::size_t>(place - 1)];
  }
  template <class Function>
  void for_each_chain(const Function& function) {
    function(all_);
    for (Target& t : targets_) std::ranges::for_each(t.others, function);
  }
  template <class Function>
  void for_each_chain_of(Target& t, const Function& function) {
    function(all_);
    std::ranges::for_each(t.others, function);
  }

  /// The states that are kept are of the history's end: nothing older comes any more.
  void keep_states(Time tick);
  /// What each chain of the target says at `tick`.
  void estimate_all(int target, Time tick);
  void judge(int target, Time tick, const OperatorWill& will);
  void exclude(int target, SourceId source, Time undone_from);
  /// Whether a run has ended: a chain is free of what a liar taught it.
  [[nodiscard]] bool catch_up();
  /// Whom the antennas follow, and how far one lie could move that.
  void choose(int target, const OperatorWill& will);
  [[nodiscard]] int select(int target, const Name& held) const;
  void find_alternatives(int target);
  void update_followed(int target);
  void report(int target, Time tick, const OperatorWill& will, ResultSink& sink);

  SourceTable sources_;
  std::vector<Name> names_;  ///< of the targets
  Duration history_;
  Duration coast_;
  int rerun_per_tick_;
  bool judges_;
  std::vector<SourceUnit> units_;
  ChainPlans plans_;
  MeasurementLog log_;
  Exclusions exclusions_;
  std::vector<Time> instants_;               ///< of the states that are kept
  MeasurementLog::Position kept_until_ = 0;  ///< end of the log when a state was kept last
  Chain all_;
  std::vector<Target> targets_;
  std::vector<Followed> followed_;
  std::vector<BiasEstimate> biases_;  ///< by SourceId
  int arrived_ = 0;                   ///< measurements since the last tick
  bool runs_again_ = false;           ///< some chain does
  std::optional<Time> last_tick_;
  bool judged_ = false;
};

}  // namespace downrange
