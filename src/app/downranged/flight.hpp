#pragma once
/// One flight: an engine, its results published, and both sides of it recorded; the log tells how its sources do.

#include <cstdint>
#include <downrange/stage/engine.hpp>
#include <functional>
#include <memory>
#include <string>

#include "acknowledgements.hpp"
#include "dds/outputs.hpp"
#include "health_notes.hpp"
#include "recorder.hpp"
#include "stage/integrity_notes.hpp"
#include "stage/slaving_notes.hpp"

namespace downrange::app {

class Flight final : private ResultSink {
 public:
  /// `outputs` outlives the flight. Without a `recorder` the flight is not recorded. `utc`: of the node on the wall
  /// clock, by which commands expire; none on the range clock, where they do not.
  Flight(const config::ServiceConfig& config, dds::OutputWriters& outputs, std::unique_ptr<Recorder> recorder,
         std::function<Time()> utc);
  /// Closes the archive.
  ~Flight() override;
  Flight(const Flight&) = delete;
  Flight& operator=(const Flight&) = delete;

  void consume(const Event& event);
  /// Ticks up to `now`, from the first event on: so a replay, which knows the events only, has the same ticks. On the
  /// wall clock the first event is the node's own, a gap of no length: every source has health from the first second.
  void advance(Time now);

  [[nodiscard]] std::uint64_t consumed() const { return consumed_; }
  [[nodiscard]] std::uint64_t emitted() const { return emitted_; }
  /// Commands that were not sent: they were no longer valid when they were made.
  [[nodiscard]] std::uint64_t expired() const { return expired_; }
  [[nodiscard]] Time last_tick() const { return engine_.last_tick(); }
  /// What became of orders and marks.
  [[nodiscard]] const Acknowledgements& acknowledgements() const { return acknowledgements_; }
  /// None: the flight is not recorded.
  [[nodiscard]] Recorder* recorder() { return recorder_.get(); }

 private:
  void emit(const Result& result) override;
  [[nodiscard]] bool is_expired(const Result& result) const;

  dds::OutputWriters& outputs_;
  std::unique_ptr<Recorder> recorder_;
  std::function<Time()> utc_;
  Acknowledgements acknowledgements_;
  HealthNotes notes_;
  IntegrityNotes integrity_notes_;
  SlavingNotes slaving_notes_;
  Engine engine_;
  Time newest_;  ///< `received` of the newest event
  std::uint64_t consumed_ = 0;
  std::uint64_t emitted_ = 0;
  std::uint64_t expired_ = 0;
};

}  // namespace downrange::app
