#pragma once
/// A flight through the engine in this process, and through another node's over DDS.

#include <archive/new_archive.hpp>
#include <archive/replay.hpp>
#include <downrange/stage/engine.hpp>
#include <functional>
#include <span>

#include "command.hpp"

namespace downrange::app {

/// Results into an archive, beside the events that the caller writes.
class ArchiveSink final : public ResultSink {
 public:
  explicit ArchiveSink(archive::Writer& writer) : writer_(writer) {}
  void emit(const Result& result) override { writer_.write(result); }

 private:
  archive::Writer& writer_;
};

/// Results to several sinks, in their order.
class FanOut final : public ResultSink {
 public:
  explicit FanOut(std::vector<ResultSink*> sinks) : sinks_(std::move(sinks)) {}
  void emit(const Result& result) override {
    for (ResultSink* sink : sinks_) sink->emit(result);
  }

 private:
  std::vector<ResultSink*> sinks_;
};

/// Replays the events of an archive through an engine of its own, then to the last tick it recorded.
/// `before` is called with each admitted event before the engine has it. Throws ArchiveError.
void replay_in_process(archive::EventSource& source, const RangeConfig& range, const StageSet& stages, ResultSink& sink,
                       const std::function<void(const Event&)>& before);

/// The same of events that are at hand, in order of `received`.
void replay_in_process(std::span<const Event> events, std::optional<Time> last_tick, const RangeConfig& range,
                       const StageSet& stages, ResultSink& sink, const std::function<void(const Event&)>& before);

/// Drives a flight over DDS. On the range clock: one step per distinct `received`, at `rate` (0: full speed). On the
/// wall clock: as sensors would, each message when it arrived then, all times moved to now and marked as simulated; a
/// second of flight takes one. `next` yields events in order of `received`; `progress` is told the time of each step.
/// Throws std::runtime_error where nobody takes part, or the events are out of order.
struct DriveOptions {
  std::vector<Name> nodes;
  double rate = 0;
};
void drive_over_dds(const config::ServiceConfig& config, const Name& driver, const DriveOptions& options,
                    const std::function<std::optional<Event>()>& next, const std::function<void(Time)>& progress,
                    std::optional<Time> last_tick = {});

/// Closes and says so on failure. The exit code.
[[nodiscard]] int close_archive(archive::Writer& writer, const std::string& path);
[[nodiscard]] int close_archive(archive::NewArchive& archive, const std::string& path);

}  // namespace downrange::app
