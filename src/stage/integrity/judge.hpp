#pragma once
/// INTEGRITY's tests and verdicts for the sources of one target: which of them agree, who lies, since when.

#include <array>
#include <downrange/est/filter/estimates.hpp>
#include <downrange/est/method/source_checks.hpp>
#include <downrange/stage/event.hpp>
#include <downrange/stage/range_config.hpp>
#include <downrange/stage/result.hpp>
#include <downrange/stage/source_table.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bias_test.hpp"
#include "copies.hpp"
#include "identification.hpp"
#include "own_past.hpp"
#include "pad_test.hpp"
#include "pair.hpp"
#include "reference_track.hpp"
#include "source_set.hpp"
#include "witness.hpp"

namespace downrange {

/// One chain of a target at the common epoch of a judged tick.
struct ChainState {
  SourceSet sources = 0;                  ///< what it was run on
  std::optional<TrackEstimate> estimate;  ///< predicted to the common epoch; none: no track

  /// One source alone.
  [[nodiscard]] bool single() const { return count(sources) == 1; }
};

/// Of one source.
struct Judgement {
  IntegrityVerdict verdict = IntegrityVerdict::Agrees;
  Finding why = Finding::None;
  Time since;             ///< of the verdict
  Time onset;             ///< the disagreement began about then
  Time undone_from;       ///< what the source taught after is undone
  double test_value = 0;  ///< of the test that speaks most against it, in units of its threshold
  SourceSet against = 0;  ///< the sources that it disagrees with
  double apart_m = 0;     ///< from them; m/s where `why` is about velocity, s where about a clock
  double agree_m = 0;     ///< these agree among themselves within
  Name receiver;          ///< of a station: the receiver that is judged
  /// Said once: it is believed, but only from then on; what it taught in the minute before is undone.
  std::optional<Time> true_from{};
};

/// What else is known at a judged tick.
struct JudgedTick {
  Time epoch;
  bool in_flight = false;         ///< the vehicle is known to have left its pad
  std::optional<Time> liftoff{};  ///< announced, or found from motion
  SourceSet forced = 0;           ///< by operators: never excluded
  SourceSet inhibited = 0;        ///< by operators: not judged
};

/// Judges the sources of one target. Stations that relay one receiver are one witness: they share its judgement, but
/// for a station whose copies differ. Never rewound; a value; deterministic; after construction it allocates nothing.
class Judge {
 public:
  /// Receivers of a target that are told apart; more are not judged.
  static constexpr int max_receivers = 3;

  Judge(const RangeConfig& config, const SourceTable& sources, int target);

  /// Every observation of the target that INGEST accepted, in order of arrival; and every double of a fix
  /// (Reason::Duplicate), which is held against the first copy. Others are passed over.
  void note(SourceId source, const Observation& o);

  /// Once per judged tick (10 Hz), epochs ascending. The chains' estimates are at its epoch. `biases` by SourceId
  /// (those of stations are passed over, and may be missing at the end): what the selected chain knows of each sensor's
  /// bias now. One Judgement per SourceId, until the next call.
  std::span<const Judgement> judge(const JudgedTick& tick, std::span<const ChainState> chains,
                                   std::span<const BiasEstimate> biases);

  /// Of a receiver by its name, for ranges where one station relays several. None: not heard.
  [[nodiscard]] const Judgement* of_receiver(const Name& receiver) const;

  /// How far the newest value of each pair of sources is, in units of its threshold: for displays and tests.
  struct PairView {
    SourceSet first = 0;
    SourceSet second = 0;
    double value = 0;
    double apart_m = 0;
    bool fails = false;
  };
  [[nodiscard]] std::size_t pair_count() const { return pairs_.size(); }
  [[nodiscard]] PairView pair(std::size_t i) const;

 private:
  /// A test that needs nobody else: counts of samples in a row beyond and within its threshold.
  struct AloneTest {
    int beyond = 0;
    int within = 0;
    bool guilty = false;
    double value = 0;
    double apart_m = 0;
    bool judged = false;
    Time calm_at;  ///< newest without doubt
    void judge(Time at, double ratio, double apart);
  };
  /// What is remembered of a witness.
  struct Standing {
    Judgement judgement;
    AloneTest velocity;
    AloneTest pad;
    AloneTest bias;
    integrity::Leap leap;    ///< of a receiver
    integrity::Return back;  ///< of a receiver
    bool is_back = false;    ///< a short while ago
    /// Guilty of what only a break with its own past can end: its biases and the pad are no witnesses any more.
    Finding held_for = Finding::None;
    Time held_onset;
    /// A receiver that is frozen, as the methods have it (is_frozen): its first fix of those that are equal. The
    /// methods refuse the others, and here they are no witness: nothing is to be undone, and nobody has to wait for it.
    std::optional<Time> repeats_since;
    bool active = false;  ///< heard, not inhibited
  };
  /// Of a receiver: what it repeats, and the newest time that it was frozen (after `from`, to `until`).
  struct Repeated {
    LastFix last;
    Time newest;
    std::optional<Time> from;
    Time until;
    [[nodiscard]] bool covers(Time epoch) const { return from && epoch > *from && epoch <= until; }
  };
  struct Station {
    Judgement judgement;
    int odd = 0;       ///< copies in a row that differ from a majority
    int disputed = 0;  ///< that differ from one other
    Time counted;      ///< the newest fix that was counted
    Time odd_since;
    Time right_since;
    double apart_m = 0;
    SourceSet against = 0;
  };

  /// A receiver's newest fix that no copy disputes.
  struct Settled {
    Time epoch;
    Fix fix;
  };

  void note_fix(SourceId source, const Observation& o, const Fix& fix);
  [[nodiscard]] bool is_repeated(std::size_t place, const Observation& o);
  [[nodiscard]] int receiver_place(const Name& receiver);
  void follow_reference(Time epoch, std::span<const ChainState> chains);
  void form_samples(Time epoch, bool in_flight);
  void judge_sample(int witness, integrity::Sample sample, bool in_flight);
  void compare(int witness, Time at, bool in_flight);
  /// Which side of its jump a receiver was right on, by the first radar that hears the vehicle.
  void ask_radar(const integrity::Witness& radar, const integrity::Sample& seen, int receiver,
                 const integrity::Sample& told);
  void judge_biases(Time epoch, std::span<const BiasEstimate> biases);
  void judge_stations(Time epoch, SourceSet forced);
  /// Which pairs count, and how far ties are broken.
  enum class Evidence : std::uint8_t { Doubtful, Failing, FailingAndCharacter };
  [[nodiscard]] integrity::Accusation accuse(Evidence evidence, const JudgedTick& tick, integrity::WitnessSet innocent);
  void decide(const JudgedTick& tick, integrity::WitnessSet innocent);
  [[nodiscard]] IntegrityVerdict verdict_on(int witness, const integrity::Accusation& named,
                                            const integrity::Accusation& suspected, bool tie_stands) const;
  void set_verdict(int witness, IntegrityVerdict verdict, Time epoch);
  void describe(int witness);
  [[nodiscard]] Finding guilty_alone(int witness) const;
  [[nodiscard]] bool excluded(int witness) const;
  [[nodiscard]] bool explained(int witness, integrity::WitnessSet guilty) const;
  [[nodiscard]] bool is_compared(int witness) const;  ///< with any other, ever
  [[nodiscard]] bool agrees_again(int witness) const;
  /// Within how many metres these agree with each other; 0: they do not, or nobody has compared them.
  [[nodiscard]] double agreement_among(SourceSet sources) const;
  [[nodiscard]] Time undone_from(int witness, Time onset) const;
  [[nodiscard]] double own_break_about(int witness, Time onset, Time noticed) const;
  /// The largest about the onsets of its pairs that fail.
  template <class Fails>
  [[nodiscard]] double own_break_when(int witness, const Fails& fails) const;
  /// What a third witness's clock says for it where its own and another's are apart.
  template <class Fails>
  [[nodiscard]] double clock_acquittal(int witness, const Fails& fails) const;
  [[nodiscard]] int distrust(int witness) const;
  [[nodiscard]] bool undecided_third(Time epoch, integrity::WitnessSet involved) const;
  void publish();

  IntegrityConfig settings_;
  std::vector<Name> names_;  ///< by SourceId
  GpsConfig receiver_;       ///< no receiver is believed to be better
  NominalTrajectory nominal_;
  integrity::Threshold threshold_;
  integrity::BiasTest bias_test_;
  std::optional<integrity::PadTest> pad_test_;
  integrity::ReferenceTrack track_;
  integrity::ReferenceTrack track_without_receivers_;
  std::vector<integrity::Witness> witnesses_;
  std::vector<Standing> standing_;  ///< by witness
  std::vector<integrity::Pair> pairs_;
  std::vector<integrity::Copies> copies_;         ///< by receiver
  std::vector<Settled> settled_;                  ///< by receiver
  std::vector<Repeated> repeated_;                ///< by receiver
  std::vector<Station> stations_;                 ///< by SourceId
  std::vector<integrity::Edge> edges_;            ///< scratch
  std::vector<integrity::Character> characters_;  ///< scratch
  std::vector<integrity::LearntBias> learnt_;     ///< scratch
  integrity::WitnessSet disputed_ = 0;            ///< by what GPS taught of biases
  AloneTest common_clock_;                        ///< of the receivers, by the radars' clocks
  std::optional<Time> tied_since_;
  bool in_flight_ = false;
  std::vector<Judgement> judgements_;  ///< by SourceId
};

}  // namespace downrange
