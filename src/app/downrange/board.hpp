#pragma once
/// What `watch` shows: the newest of everything, and how old it is.

#include <chrono>
#include <cstdint>
#include <downrange/stage/result.hpp>
#include <map>
#include <mutex>
#include <string>
#include <utility>

#include "dds/service_status.hpp"
#include "impact_lines.hpp"

namespace downrange::app {

/// Filled by the middleware's threads, read by the screen.
class Board {
 public:
  using Clock = std::chrono::steady_clock;

  /// On the wall clock ages count against UTC; on the range clock against the newest range time that was received.
  explicit Board(dds::ClockMode clock) : clock_(clock) {}

  void add(const Result& result, Clock::time_point now);
  void add(const SourceHealth& health, const Name& node, Clock::time_point now);
  void add(const dds::ServiceStatus& status, Clock::time_point now);

  /// Whether no result has come for this long: since the board was made where none came at all.
  [[nodiscard]] bool idle_for(double seconds, Clock::time_point now) const;
  [[nodiscard]] std::uint64_t commands() const;

  /// One line per track, antenna, source and node. A node not heard for 3 s is SILENT, a command past `valid_until` is
  /// EXPIRED, a track over 2 s and a source's account over 3 s behind is old. Of a source: the share of its NIS inside
  /// 95 %, its residual in units, whether it is qualified, or why not, since when and by whom, and MISMATCH while the
  /// mismatch alarm rings. Of a target that INTEGRITY judges: what is followed, and a sentence for each source that
  /// does not agree. Of each antenna what operators ordered of it, and when it sees its target. Of each target where it
  /// falls when its engines stop now (impact_lines.hpp).
  [[nodiscard]] std::string lines(Clock::time_point now, Time utc) const;
  /// The newest status of the busiest node, for the archive.
  [[nodiscard]] std::map<std::string, std::string> status_metadata() const;

 private:
  struct Heard {
    dds::ServiceStatus status;
    Clock::time_point at;
  };
  using HealthKey = std::pair<Name, Name>;  ///< sensor, node

  [[nodiscard]] std::string integrity_lines(Time time) const;
  [[nodiscard]] std::string impact_lines_of_all(Time time) const;
  [[nodiscard]] std::string health_lines(Time time) const;
  [[nodiscard]] std::string node_lines(Clock::time_point now) const;
  void keep(const Trajectory& trajectory);
  void keep(const SlavingCommand& command);
  void keep(const AntennaAccount& account);
  void keep(const Integrity& record);
  void keep(const ImpactPoint& record);
  /// Has no line: health comes with the node that tells it.
  template <class Other>
  void keep(const Other&) {}

  const dds::ClockMode clock_;
  mutable std::mutex mutex_;
  std::map<std::pair<Name, Name>, Trajectory> tracks_;
  std::map<Name, SlavingCommand> commands_by_antenna_;
  std::map<Name, AntennaAccount> accounts_;  ///< by antenna
  std::map<Name, Integrity> integrity_;      ///< by target
  std::map<Name, ImpactsByChain> impacts_;   ///< likewise
  std::map<HealthKey, SourceHealth> health_;
  std::map<Name, Heard> nodes_;
  std::uint64_t commands_ = 0;
  Time newest_range_time_{};
  Clock::time_point newest_ = Clock::now();
};

}  // namespace downrange::app
