#pragma once
/// Between the listeners and the engine on the wall clock: one ring per source, events leave in order of arrival, and a
/// source that floods loses its own oldest events only.

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <downrange/stage/event.hpp>
#include <mutex>
#include <optional>
#include <vector>

namespace downrange::app {

/// Who an event came from: radar, station, or mission.
[[nodiscard]] Name source_of(const Event& event);

class EventQueue {
 public:
  /// `sources` have a ring each; all others share one. All memory is taken here.
  EventQueue(std::vector<Name> sources, int capacity_per_source);

  /// From any thread; never waits for the engine.
  void push(const Event& event);
  /// Until an event is there, the time is over or the queue is closed.
  void wait(std::chrono::nanoseconds at_most);
  /// The oldest event, if any.
  [[nodiscard]] std::optional<Event> pop();
  /// Ends every wait, now and later.
  void close();

  [[nodiscard]] std::size_t depth() const;
  [[nodiscard]] std::uint64_t dropped() const;

 private:
  struct Arrival {
    std::uint64_t order = 0;
    Event event;
  };
  struct Ring {
    std::vector<Arrival> slots;
    std::size_t first = 0;
    std::size_t size = 0;
  };
  [[nodiscard]] Ring& ring_of(const Name& source);
  [[nodiscard]] Ring* oldest_locked();

  std::vector<Name> sources_;
  std::vector<Ring> rings_;  ///< as sources_, then the shared one
  mutable std::mutex mutex_;
  std::condition_variable filled_;
  std::uint64_t arrivals_ = 0;
  std::uint64_t dropped_ = 0;
  std::size_t depth_ = 0;
  bool closed_ = false;
};

}  // namespace downrange::app
