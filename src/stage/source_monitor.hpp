#pragma once
/// Running account of every source: what came, how late, what was rejected and why.

#include <downrange/est/method.hpp>
#include <downrange/stage/range_config.hpp>
#include <downrange/stage/result.hpp>
#include <vector>

namespace downrange {

class SourceMonitor {
 public:
  explicit SourceMonitor(const RangeConfig& config);

  void count(const Observation& o);

  /// One record per source; `method` (null on an ingest node) adds what its gate rejected. Call once a second.
  void report(Time tick, const Method* method, ResultSink& sink);

 private:
  struct Source {
    Name sensor;
    Name target;
    ObservationKind kind = ObservationKind::Radar;
    int account = -1;  ///< index in the method's accounts, -1: none
    std::array<std::uint64_t, reason_count> count{};
    std::uint64_t messages = 0;
    std::uint64_t reported_messages = 0;
    double latency_s = 0;
    bool seen = false;
  };

  std::vector<Source> sources_;  ///< as a method counts them, and last whoever is not configured
};

}  // namespace downrange
