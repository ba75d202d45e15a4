#pragma once
/// Running account of every source: what came, how late, what was rejected and why, does it fit its model.

#include <downrange/est/method/method.hpp>
#include <downrange/stage/range_config.hpp>
#include <downrange/stage/result.hpp>
#include <downrange/stage/source_table.hpp>
#include <vector>

namespace downrange {

class SourceMonitor {
 public:
  explicit SourceMonitor(const RangeConfig& config);

  void count(const Observation& o);

  /// One record per configured source, heard or not, and one for all that is not configured once something came of it;
  /// `method` (null on an ingest node) adds what its gate rejected and how its innovations fit. Call once a second.
  void report(Time tick, const Method* method, ResultSink& sink);

 private:
  /// What came of one source.
  struct Account {
    Name target;  ///< of its newest message
    std::array<std::uint64_t, reason_count> count{};
    std::uint64_t messages = 0;
    std::uint64_t reported_messages = 0;
    Time newest;  ///< received
    double latency_s = 0;
    bool seen = false;
    int rejected_in_row = 0;  ///< by ingest
    Reason rejected_for = Reason::Accepted;
    std::uint64_t reported_frozen = 0;
    bool frozen = false;  ///< by the method, and none accepted since
  };

  [[nodiscard]] static SourceHealth health(Time tick, const Name& name, Account& account);
  /// What the method made of the source's messages.
  static void add(const SourceAccount& of_method, Account& account, SourceHealth& health);
  static void qualify(Time tick, const Source& source, const Account& account, int gated_in_row, SourceHealth& health);

  SourceTable sources_;
  std::vector<Account> accounts_;  ///< by SourceId
  Account unknown_;                ///< of whoever is not configured
};

}  // namespace downrange
