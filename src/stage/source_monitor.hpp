#pragma once
/// Running account of every source: what came, how late, what was rejected and why, does it fit its model, and what an
/// operator or INTEGRITY says of it.

#include <downrange/est/method/method.hpp>
#include <downrange/stage/range_config.hpp>
#include <downrange/stage/result.hpp>
#include <downrange/stage/source_table.hpp>
#include <optional>
#include <vector>

#include "orders.hpp"
#include "residuals.hpp"

namespace downrange {

class SourceMonitor {
 public:
  explicit SourceMonitor(const RangeConfig& config);

  /// What others know of the sources. Null: nobody does.
  struct Views {
    const Method* method = nullptr;        ///< what its gate rejected and how its innovations fit
    const Residuals* residuals = nullptr;  ///< in units
    const Orders* orders = nullptr;
  };

  void count(const Observation& o);
  /// The newest of each target.
  void note(const Integrity& record);
  /// By the newest record of its target, INTEGRITY does not agree with the observation's source.
  [[nodiscard]] bool doubted(const Observation& o) const;

  /// One record per configured source, heard or not, and one for all that is not configured once something came of it.
  /// Call once a second.
  void report(Time tick, const Views& views, ResultSink& sink);

 private:
  /// Of a count of the method's: where the method is run again without the source it loses what it had counted of it.
  class LastingCount {
   public:
    /// `counted`: by the method now. `excluded`: a smaller count than before is such a loss.
    std::uint64_t total(std::uint64_t counted, bool excluded) {
      if (excluded && counted < counted_) lost_ += counted_ - counted;
      counted_ = counted;
      return lost_ + counted;
    }
    [[nodiscard]] std::uint64_t counted() const { return counted_; }

   private:
    std::uint64_t counted_ = 0;
    std::uint64_t lost_ = 0;
  };
  /// What came of one source.
  struct Account {
    Name target;  ///< of its newest message
    std::array<std::uint64_t, reason_count> count{};
    std::uint64_t messages = 0;
    std::uint64_t reported_messages = 0;
    Time newest;  ///< received
    double latency_s = 0;
    bool seen = false;        ///< one was accepted: there is a latency
    bool was_good = false;    ///< one was accepted, or was the double of one
    int rejected_in_row = 0;  ///< by ingest
    Time rejected_since;      ///< the first of them
    Reason rejected_for = Reason::Accepted;
    LastingCount gated_count;
    LastingCount frozen_count;
    bool frozen = false;                  ///< by the method, and none accepted since
    int gated_in_row = 0;                 ///< by the method
    std::uint64_t reported_accepted = 0;  ///< by the method, when it last accepted one
    Time gated_since;                     ///< the report before the first that saw it reject
    /// As the last report told it, and since when.
    Disqualification why = Disqualification::None;
    bool suspect = false;
    Name by;
    Time since;
    bool mismatch = false;
    Time alarm_since;  ///< as it is now: not qualified for what `why` says, suspect, mismatch
  };
  /// What INTEGRITY says of one source of one target.
  struct Verdict {
    IntegrityVerdict verdict = IntegrityVerdict::Agrees;
    Time since;
    Name by;
  };

  [[nodiscard]] static SourceHealth health(Time tick, const Name& name, Account& account);
  /// What the method made of the source's messages; `excluded`: by INTEGRITY.
  static void add(Time tick, const SourceAccount& of_method, bool excluded, Account& account, SourceHealth& health);
  /// By the source's own messages.
  static void qualify(Time tick, const Source& source, const Account& account, SourceHealth& health);
  /// By integrity and operators; then since when it is so.
  void overrule(SourceId source, const Orders* orders, SourceHealth& health) const;
  /// Who has seen the present alarm. Before tell_since, which forgets the last report.
  static void tell_acknowledged(const StandingOrder* acknowledgement, Account& account, SourceHealth& health);
  static void tell_since(const StandingOrder* order, const Verdict& verdict, Account& account, SourceHealth& health);
  /// Where the verdicts on sources of a target begin; none: no such target.
  [[nodiscard]] std::optional<std::size_t> verdicts_of(const Name& target) const;
  /// The worst of all targets.
  [[nodiscard]] const Verdict& verdict_on(SourceId source) const;

  SourceTable sources_;
  std::vector<Name> targets_;
  std::vector<Account> accounts_;  ///< by SourceId
  std::vector<Verdict> verdicts_;  ///< by target, then SourceId
  Account unknown_;                ///< of whoever is not configured
};

}  // namespace downrange
