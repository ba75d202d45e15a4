#pragma once
/// One flight: an engine, its results published, and both sides of it recorded; the log tells how its sources do.

#include <cstdint>
#include <downrange/stage/engine.hpp>
#include <memory>
#include <string>

#include "dds/outputs.hpp"
#include "health_notes.hpp"
#include "recorder.hpp"

namespace downrange::app {

class Flight final : private ResultSink {
 public:
  /// `outputs` outlives the flight. Without a `recorder` the flight is not recorded.
  Flight(const config::ServiceConfig& config, dds::OutputWriters& outputs, std::unique_ptr<Recorder> recorder);
  /// Closes the archive.
  ~Flight() override;
  Flight(const Flight&) = delete;
  Flight& operator=(const Flight&) = delete;

  void consume(const Event& event);
  /// Ticks up to `now`, from the first event on: so a replay, which knows the events only, has the same ticks.
  void advance(Time now);

  [[nodiscard]] std::uint64_t consumed() const { return consumed_; }
  [[nodiscard]] std::uint64_t emitted() const { return emitted_; }
  [[nodiscard]] Time last_tick() const { return engine_.last_tick(); }
  /// None: the flight is not recorded.
  [[nodiscard]] Recorder* recorder() { return recorder_.get(); }

 private:
  void emit(const Result& result) override;

  dds::OutputWriters& outputs_;
  std::unique_ptr<Recorder> recorder_;
  HealthNotes notes_;
  Engine engine_;
  std::uint64_t consumed_ = 0;
  std::uint64_t emitted_ = 0;
};

}  // namespace downrange::app
