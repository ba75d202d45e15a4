#pragma once
/// What every node tells of itself on downrange/status.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <downrange/geo/name.hpp>
#include <downrange/geo/time.hpp>
#include <downrange/stage/engine.hpp>

#include "dds/participant.hpp"

namespace downrange::dds {

/// What became of an operator's order or of a mark of the mission clock at a node.
struct Acknowledgement {
  std::size_t topic = 0;  ///< its place in Inputs: of OperatorCommand or of MissionEvent
  Name sender;            ///< operator or mission
  std::uint64_t sequence = 0;
  Remark refusal;  ///< why it is not carried out; empty: it is in force

  bool operator==(const Acknowledgement&) const = default;
};

/// How well a machine's clock keeps UTC, as its kernel tells.
struct UtcState {
  bool known = false;
  bool synchronised = false;  ///< disciplined by NTP or PTP
  double offset_s = 0;        ///< what the discipline still has to correct
  double error_s = 0;         ///< at most

  bool operator==(const UtcState&) const = default;
};

struct ServiceStatus {
  Name node;
  StageSet stages;
  std::string version;             ///< at most 31 characters, as the other texts unless said otherwise; longer is cut
  std::string configuration_hash;  ///< at most 64 characters
  ClockMode clock = ClockMode::Wall;
  Time time;       ///< UTC of this status (wall clock)
  Time last_tick;  ///< of the engine, in its own clock
  std::uint32_t queue_depth = 0;
  std::uint64_t consumed = 0;  ///< events handled by the engine
  std::uint64_t emitted = 0;   ///< results
  double consumed_per_s = 0;   ///< since the status before
  double emitted_per_s = 0;
  std::uint64_t dropped = 0;           ///< inputs lost before the engine (queue full, malformed)
  std::uint64_t write_failures = 0;    ///< results that DDS did not take
  std::array<double, 4> latency_us{};  ///< received -> result written: median, 95 %, 99 %, maximum
  std::string archive_state;           ///< e.g. "recording", "off", "disk full"
  std::string state;                   ///< e.g. "running", "waiting for the range clock"
  /// At most 255 characters: how many of Participant::mismatches() there are, and the first. Empty: none.
  std::string mismatch;
  UtcState utc;                                   ///< of the node's machine
  std::vector<Acknowledgement> acknowledgements;  ///< the newest first, at most 8
};

}  // namespace downrange::dds
