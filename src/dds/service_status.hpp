#pragma once
/// What every node tells of itself on downrange/status.

#include <array>
#include <cstdint>
#include <string>

#include <downrange/geo/name.hpp>
#include <downrange/geo/time.hpp>
#include <downrange/stage/engine.hpp>

#include "dds/participant.hpp"

namespace downrange::dds {

struct ServiceStatus {
  Name node;
  StageSet stages;
  std::string version;             ///< at most 31 characters, as the other texts unless said otherwise; longer is cut
  std::string configuration_hash;  ///< at most 64 characters
  ClockMode clock = ClockMode::Wall;
  Time time;       ///< UTC of this status (wall clock)
  Time last_tick;  ///< of the engine, in its own clock
  std::uint32_t queue_depth = 0;
  std::uint64_t consumed = 0;          ///< events handled by the engine
  std::uint64_t emitted = 0;           ///< results
  std::uint64_t dropped = 0;           ///< inputs lost before the engine (queue full, malformed)
  std::uint64_t write_failures = 0;    ///< results that DDS did not take
  std::array<double, 4> latency_us{};  ///< received -> result written: median, 95 %, 99 %, maximum
  std::string archive_state;           ///< e.g. "recording", "off", "disk full"
  std::string state;                   ///< e.g. "running", "waiting for the range clock"
  /// At most 255 characters: how many of Participant::mismatches() there are, and the first. Empty: none.
  std::string mismatch;
};

}  // namespace downrange::dds
