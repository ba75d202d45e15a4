#pragma once
/// The five stages in order, driven by events and ticks. Deterministic: same configuration and events, same results.

#include <cstdint>
#include <memory>
#include <string_view>

#include <downrange/stage/event.hpp>
#include <downrange/stage/range_config.hpp>
#include <downrange/stage/result.hpp>

namespace downrange {

/// Which stages this node runs. Without ingest, the engine reads Observations made by another node.
struct StageSet {
  bool ingest = true;
  bool align = true;  ///< and fuse: the method is one
  bool fuse = true;
  bool slave = true;
};

/// Of a node that runs these stages: "all"; "ingest"; "centre", which lives on the observations of ingest nodes; else
/// "part".
[[nodiscard]] std::string_view role_of(const StageSet& stages);

class Engine {
 public:
  /// `sink` outlives the engine.
  Engine(const RangeConfig& config, const StageSet& stages, ResultSink& sink);
  ~Engine();
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  /// Consumes one event. Every tick with time <= its `received` runs first. An event received before the last tick
  /// run is raised to that tick's time: `admit` does so, and what it returns is what a recorder must write.
  [[nodiscard]] Event admit(Event event) const;
  void handle(const Event& admitted);

  /// Runs every tick with time <= now, up to 700 s after the last event: nothing coasts longer. Before the first event
  /// or call there is no tick. Times before 1970 and after 2100 are no times and move nothing. A tick costs the same
  /// however long a target has been silent; once it coasts no more, next to nothing.
  void advance_to(Time now);

  /// Time of the last tick run, or {INT64_MIN} when none has.
  [[nodiscard]] Time last_tick() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace downrange
