#pragma once
/// Stage 1: accept or reject with a reason.

#include <downrange/stage/event.hpp>
#include <downrange/stage/range_config.hpp>
#include <downrange/stage/source_table.hpp>
#include <map>
#include <vector>

#include "departure.hpp"
#include "mission_clock.hpp"
#include "orders.hpp"

namespace downrange {

/// Judges every measurement that reaches the node. What it accepts is finite, inside the instrument's limits, inside
/// the history and new; everything else leaves with the first reason that applies.
class Ingest {
 public:
  explicit Ingest(const RangeConfig& config);

  /// The mission clock tells when the vehicle leaves its pad.
  void note(const MissionEvent& event);
  /// A source that is inhibited is rejected until it is released.
  void note(const OperatorCommand& command) { orders_.note(command); }
  /// A sensor on an antenna's mount measures nothing of its own while that one is slaved.
  void note(const AntennaReport& report);
  [[nodiscard]] const MissionClock& mission() const { return mission_; }
  [[nodiscard]] const Orders& orders() const { return orders_; }
  /// By the mission's lift-off, or else by the target's motion.
  [[nodiscard]] bool left_pad(const Name& target, Time epoch) const;

  [[nodiscard]] Observation judge(const RadarTspi& tspi);
  [[nodiscard]] Observation judge(const GpsFix& fix);
  [[nodiscard]] Observation judge(const AngleTspi& tspi);

  /// At a centre: an observation of another node, against this node's configuration and the observations of
  /// all ingest nodes together. Two nodes may have accepted the same fix from two stations; one that saw a part of the
  /// fixes may not know yet that the vehicle has left the pad.
  [[nodiscard]] Observation judge(Observation observation);

 private:
  /// What one sender (radar, tracker or station) and receiver said of one target within the history.
  struct Stream {
    struct Entry {
      Time epoch;
      std::uint64_t sequence;
      Name sender;
    };
    std::vector<Entry> recent;
    Time numbered_twice;  ///< newest epoch that one sender's messages gave under two numbers: by two networks
    Time heard;           ///< of its newest message, by the node's clock
  };
  struct StreamKey {
    SourceKind kind;
    Name source;  ///< radar or tracker; for GPS the on-board receiver: a double has the same receiver, whatever station
                  ///< relayed it
    Name target;

    auto operator<=>(const StreamKey&) const = default;
  };

  /// Without what the radar is not configured to measure; what a plot lacks is 0.
  [[nodiscard]] Plot usable(Plot plot, const Name& sensor) const;
  /// What an antenna last said of itself.
  struct AntennaSaid {
    Time epoch;
    Time received;
    bool slaved = false;
  };

  /// What holds for every message: source and target are known, it is of this node's world, no operator inhibits it.
  [[nodiscard]] Reason judge_sender(const Observation& o) const;
  /// By what its antenna says.
  [[nodiscard]] Reason judge_antenna(const Observation& o) const;
  [[nodiscard]] Reason judge_instrument(const Observation& o, const Plot& plot) const;
  [[nodiscard]] Reason judge_instrument(const Observation& o, const Angles& angles) const;
  [[nodiscard]] Reason judge_instrument(const Observation& o, const Fix& fix) const;
  /// Reasons that hold for any source: time against the node's clock, and against what the source said before.
  [[nodiscard]] Reason judge_time(const Observation& o);
  /// The pad's radius, and after an announced lift-off how far a vehicle may have come. There must be a pad.
  [[nodiscard]] double reach_from_pad_m(const Name& target, Time epoch) const;
  /// Of a fix: can the vehicle be there, for all that is known of its departure from the pad? One that cannot still
  /// tells whether the vehicle moves.
  [[nodiscard]] Reason judge_pad(const Observation& o);
  [[nodiscard]] Stream& stream_of(const Observation& o);

  RangeConfig config_;
  SourceTable sources_;
  Departure departure_;
  MissionClock mission_;
  Orders orders_;
  std::vector<AntennaSaid> antennas_;  ///< as configured
  std::map<StreamKey, Stream> streams_;
  std::size_t most_streams_;
};

}  // namespace downrange
