#pragma once
/// Between the listeners and the engine on the wall clock: one ring per source, one for the mission and the operators,
/// one for what else comes. Events leave in order of arrival; a source that floods loses its own oldest events only, a
/// stranger's measurements are refused.

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <downrange/stage/event.hpp>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace downrange::app {

/// By a sensor or a receiver, whether an ingest node has judged it or not.
[[nodiscard]] bool is_measured(const Event& event);

class EventQueue {
 public:
  /// What did not get through, so far.
  struct Losses {
    std::uint64_t dropped = 0;        ///< pushed out of a full ring
    std::uint64_t refused = 0;        ///< measurements of sources that are not configured
    std::string worst;                ///< whose ring dropped most ("orders", "others" as below); empty: none
    std::uint64_t worst_dropped = 0;  ///< of that ring
  };

  /// All memory is taken here.
  EventQueue(std::vector<Name> sources, int capacity_per_ring);

  /// From any thread; never waits for the engine.
  void push(const Event& event);
  /// Until an event is there, the time is over or the queue is closed.
  void wait(std::chrono::nanoseconds at_most);
  /// The oldest event, if any.
  [[nodiscard]] std::optional<Event> pop();
  /// Ends every wait, now and later.
  void close();

  [[nodiscard]] std::size_t depth() const;
  [[nodiscard]] Losses losses() const;

 private:
  struct Arrival {
    std::uint64_t order = 0;
    Event event;
  };
  struct Ring {
    std::vector<Arrival> slots;
    std::size_t first = 0;
    std::size_t size = 0;
    std::uint64_t dropped = 0;
  };
  /// None: a stranger's.
  [[nodiscard]] Ring* ring_of(const Event& event);
  [[nodiscard]] Ring* oldest_locked();

  std::vector<Name> sources_;
  /// As sources_; then the orders', of mission and operators; then one of whatever else comes and is no measurement.
  std::vector<Ring> rings_;
  mutable std::mutex mutex_;
  std::condition_variable filled_;
  std::uint64_t arrivals_ = 0;
  std::uint64_t refused_ = 0;
  std::size_t depth_ = 0;
  bool closed_ = false;
};

}  // namespace downrange::app
