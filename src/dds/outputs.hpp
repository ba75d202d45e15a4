#pragma once
/// Results over DDS: what a node publishes, and what antennas, screens and recorders read.

#include <array>
#include <chrono>
#include <cstdint>
#include <downrange/stage/catalogue.hpp>
#include <functional>
#include <memory>
#include <vector>

#include "dds/participant.hpp"
#include "dds/service_status.hpp"

namespace downrange::dds {

struct OutputOptions {
  int strength = 100;        ///< of exclusive ownership: of two nodes alive, the stronger one's results count
  bool observations = true;  ///< publish downrange/observation, and the ingest progress on the range clock
  bool results = true;       ///< publish bias, trajectory, slaving: nodes that align, fuse or slave
  /// The keys of the results that are to be expected, by their place in Outputs. On the wall clock each has a writer of
  /// its own: see result_writers.hpp.
  std::array<std::vector<OwnedKey>, Outputs::size> owned{};

  template <class Record>
  [[nodiscard]] std::vector<OwnedKey>& owned_keys() {
    return owned[Outputs::index_of<Record>()];
  }
  template <class Record>
  [[nodiscard]] const std::vector<OwnedKey>& owned_keys() const {
    return owned[Outputs::index_of<Record>()];
  }
};

/// Publishes what the engine emits. emit() from the engine's thread, the rest from any thread.
class OutputWriters final : public ResultSink {
 public:
  OutputWriters(Participant& participant, const OutputOptions& options);
  ~OutputWriters() override;
  OutputWriters(const OutputWriters&) = delete;
  OutputWriters& operator=(const OutputWriters&) = delete;

  /// A write that DDS refuses is counted. On the wall clock it does not block for longer than the profile's
  /// max_blocking_time; on the range clock it waits for slow reliable consumers, bounded likewise.
  void emit(const Result& result) override;
  void publish(const ServiceStatus& status);

  [[nodiscard]] WriteCounts counts() const;
  /// Readers of downrange/slaving at this moment.
  [[nodiscard]] int slaving_readers() const;
  /// Whether bias, trajectory and slaving (the observations where no results are published) have each met at least
  /// `readers` readers, waiting at most `timeout`.
  [[nodiscard]] bool wait_for_matched(int readers, std::chrono::milliseconds timeout) const;

  class Impl;
  [[nodiscard]] Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

struct OutputSelection {
  bool observations = false;
  bool results = true;         ///< what nodes own: bias, trajectory, integrity, slaving
  bool commands_only = false;  ///< of these slaving alone: what an antenna needs
  bool health = true;
  bool status = true;
  /// On the range clock: receive every sample, and hold the flight back rather than lose one. False for screens.
  bool lossless = true;
};

/// Callbacks run on the middleware's threads, one at a time per topic: thread-safe, quick, no exceptions. Empty ones
/// are skipped.
struct OutputCallbacks {
  std::function<void(const Result&)> result;
  std::function<void(const ServiceStatus&)> status;
  /// Where set: source accounts come here, with the node that keeps them, instead of to `result`.
  std::function<void(const SourceHealth&, const Name& node)> health = {};
};

/// Reads results as any consumer does: of several nodes that publish, only the owner's arrive.
class OutputReaders {
 public:
  OutputReaders(Participant& participant, const OutputSelection& selection, OutputCallbacks callbacks);
  ~OutputReaders();
  OutputReaders(const OutputReaders&) = delete;
  OutputReaders& operator=(const OutputReaders&) = delete;

  [[nodiscard]] ReadCounts counts() const;
  /// Whether every selected topic has met at least `writers` writers, waiting at most `timeout`.
  [[nodiscard]] bool wait_for_matched(int writers, std::chrono::milliseconds timeout) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace downrange::dds
