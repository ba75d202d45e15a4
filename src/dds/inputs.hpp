#pragma once
/// Events over DDS: radar plots, angles, GPS fixes, mission events, and observations made by another node.

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include <downrange/geo/name.hpp>
#include <downrange/stage/event.hpp>

#include "dds/participant.hpp"

namespace downrange::dds {

/// Where a sample stands in a run on the range clock. Zeros on the wall clock. The sensors' own sequences may repeat
/// and restart, as recorded flights do, so the driver numbers the samples itself.
struct RangeStamp {
  std::uint64_t run_id = 0;
  std::uint64_t sequence = 0;  ///< from 1 in each (topic, source); of observations: in each ingest node
};

struct InputSelection {
  bool sensors = true;  ///< range/radar_tspi, range/angles and range/gps
  bool mission = true;  ///< range/mission
  /// Ingest nodes whose observations are taken. Empty: downrange/observation is not read.
  std::vector<Name> ingest_nodes;
};

/// Reads events. The callback is called on the middleware's threads, one at a time per topic: it must be thread-safe,
/// quick, and must not throw. Nothing is called after the destructor returns.
class InputReader {
 public:
  /// `node`: the ingest node of an Observation, else empty. On the wall clock `received` is the UTC time of arrival
  /// here, of an Observation too: `received` drives the ticks, and no other node's clock may. On the range clock the
  /// follower stamps. A sample of the other clock mode is malformed.
  using Callback = std::function<void(const Event& event, const RangeStamp& stamp, const Name& node)>;

  InputReader(Participant& participant, const InputSelection& selection, Callback callback);
  ~InputReader();
  InputReader(const InputReader&) = delete;
  InputReader& operator=(const InputReader&) = delete;

  [[nodiscard]] ReadCounts counts() const;
  /// Whether every topic read has met at least `writers` writers, waiting at most `timeout`.
  [[nodiscard]] bool wait_for_matched(int writers, std::chrono::milliseconds timeout) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// Writes events as sensors do: for the simulator and for replay on the wall clock. On the range clock use
/// RangeClockDriver, which owns one.
class InputWriters {
 public:
  explicit InputWriters(Participant& participant);
  ~InputWriters();
  InputWriters(const InputWriters&) = delete;
  InputWriters& operator=(const InputWriters&) = delete;

  /// False, and counted, where DDS refused the sample. `received` is not sent. An Observation is not an input of the
  /// range: false.
  [[nodiscard]] bool write(const Event& event, const RangeStamp& stamp = {});

  [[nodiscard]] WriteCounts counts() const;
  /// Whether every topic has met at least `readers` readers, waiting at most `timeout`.
  [[nodiscard]] bool wait_for_matched(int readers, std::chrono::milliseconds timeout) const;
  /// Whether this one topic (its place in Inputs) has met a reader, waiting at most `timeout`.
  [[nodiscard]] bool wait_for_reader(std::size_t topic, std::chrono::milliseconds timeout) const;

  class Impl;
  [[nodiscard]] Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

/// Writes range/antenna and nothing else, as an antenna's control unit does. From any thread.
class AntennaReportWriter {
 public:
  explicit AntennaReportWriter(Participant& participant);
  ~AntennaReportWriter();
  AntennaReportWriter(const AntennaReportWriter&) = delete;
  AntennaReportWriter& operator=(const AntennaReportWriter&) = delete;

  /// False, and counted, where DDS refused the sample.
  [[nodiscard]] bool write(const AntennaReport& report);
  [[nodiscard]] WriteCounts counts() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace downrange::dds
