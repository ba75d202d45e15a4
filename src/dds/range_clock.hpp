#pragma once
/// Flights on the range clock: one driver tells the time, followers consume exactly the samples of each step.

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <downrange/geo/name.hpp>
#include <downrange/geo/time.hpp>
#include <downrange/stage/event.hpp>

#include "dds/participant.hpp"

namespace downrange::dds {

class OutputWriters;

/// The flight cannot go on in lockstep: the text names the node, or topic, source, expected and received counts.
class LockstepError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct DriverOptions {
  std::vector<Name> nodes;  ///< nodes that must acknowledge every step; each takes part from the first step on
  int window = 32;          ///< steps outstanding at most
  std::chrono::milliseconds timeout{10'000};  ///< without progress of a node: the flight is stopped
};

/// Drives one run. One driver per domain. Single-threaded use.
class RangeClockDriver {
 public:
  RangeClockDriver(Participant& participant, const DriverOptions& options);
  ~RangeClockDriver();
  RangeClockDriver(const RangeClockDriver&) = delete;
  RangeClockDriver& operator=(const RangeClockDriver&) = delete;

  /// Until every node is there and listens to what it needs. Throws LockstepError naming the absent ones.
  void wait_for_nodes(std::chrono::milliseconds timeout);

  /// Writes the step's events, then its clock sample. `time` rises from call to call: one step per distinct
  /// `received`. An empty span moves time alone. Blocks while the window is full. Throws LockstepError: a node that
  /// failed or did not acknowledge in time, a sample that DDS did not take, time that does not rise.
  void step(Time time, std::span<const Event> events);

  /// Tells the end of the run and waits until every node has consumed everything. Throws as step().
  void finish();

  [[nodiscard]] std::uint64_t run_id() const;
  [[nodiscard]] std::uint64_t steps() const;
  /// Steps that every node has acknowledged.
  [[nodiscard]] std::uint64_t acknowledged() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// The events of one step, `received` = `time`, in the order of step_order_less.
struct RangeStep {
  std::uint64_t run_id = 0;
  std::uint64_t step = 0;  ///< from 1: a new run, hence a new engine
  Time time;
  bool end = false;  ///< the last step of the run: no events
  std::vector<Event> events;
};

struct FollowerOptions {
  bool sensors = true;             ///< consume range/radar_tspi, range/angles and range/gps
  std::vector<Name> ingest_nodes;  ///< consume these nodes' observations: a step closes when each has reported it
  std::chrono::milliseconds timeout{5'000};  ///< for the samples of a step that the clock has announced
};

/// Follows runs, one after the other, on the thread that calls next(). Mission events are always consumed.
class RangeClockFollower {
 public:
  /// `outputs`: the node's own writers, or null; the follower reports their observations of each step to the centre.
  /// It outlives the follower.
  RangeClockFollower(Participant& participant, const FollowerOptions& options, OutputWriters* outputs);
  ~RangeClockFollower();
  RangeClockFollower(const RangeClockFollower&) = delete;
  RangeClockFollower& operator=(const RangeClockFollower&) = delete;

  /// The next step, complete; nothing when none was announced within `wait`. Throws LockstepError when announced
  /// samples are missing after the timeout; the driver is told, and the rest of that run is ignored. Steps of a
  /// run whose first step was not seen are ignored: see notice().
  [[nodiscard]] std::optional<RangeStep> next(std::chrono::milliseconds wait);

  /// To be called when the engine has consumed the step and its results are emitted.
  void acknowledge(const RangeStep& step);

  /// What the operator should know, once each: a run that was under way already and is not joined, a run that was
  /// broken off by a new one.
  [[nodiscard]] std::optional<std::string> notice();

  [[nodiscard]] ReadCounts counts() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace downrange::dds
