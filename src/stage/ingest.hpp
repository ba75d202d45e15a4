#pragma once
/// Stage 1: accept or reject with a reason.

#include <downrange/stage/event.hpp>
#include <downrange/stage/range_config.hpp>
#include <vector>

#include "departure.hpp"

namespace downrange {

/// Judges every measurement that reaches the node. What it accepts is finite, inside the instrument's limits, inside
/// the history and new; everything else leaves with the first reason that applies.
class Ingest {
 public:
  explicit Ingest(const RangeConfig& config);

  /// The mission clock tells when the vehicle leaves its pad.
  void note(const MissionEvent& event) { departure_.note(event); }
  [[nodiscard]] bool left_pad(const Name& target, Time epoch) const { return departure_.left_pad(target, epoch); }

  [[nodiscard]] Observation judge(const RadarTspi& tspi);
  [[nodiscard]] Observation judge(const GpsFix& fix);
  [[nodiscard]] Observation judge(const AngleTspi& tspi);

  /// At a centre: an observation that another node accepted, against this node's configuration and the observations of
  /// all ingest nodes together. Two nodes may have accepted the same fix from two stations.
  [[nodiscard]] Observation judge(Observation observation);

 private:
  /// What one sender (radar, tracker or station) and receiver said of one target within the history.
  struct Stream {
    struct Entry {
      Time epoch;
      std::uint64_t sequence;
      Name sender;
    };
    Name source;  ///< radar or tracker; for GPS the on-board receiver: a double has the same receiver, whatever station
                  ///< relayed it
    Name target;
    ObservationKind kind;
    std::vector<Entry> recent;
  };

  [[nodiscard]] Stream& stream_of(ObservationKind kind, const Name& source, const Name& target);
  /// Where a fix is: a place for a vehicle, and its pad before lift-off.
  [[nodiscard]] Reason judge_place(const Observation& fix) const;
  /// Time, then place: a fix away from the pad still tells whether the vehicle moves.
  [[nodiscard]] Reason judge_fix(const Observation& fix);
  /// Reasons that hold for any source: time against the node's clock, and against what the source said before.
  [[nodiscard]] Reason judge_time(const Observation& o, Stream& stream) const;

  RangeConfig config_;
  Departure departure_;
  std::vector<Stream> streams_;
};

}  // namespace downrange
