#pragma once
/// A witness: one source of truth about a target. A radar, an angles-only tracker, or an on-board receiver, whichever
/// stations relay it.

#include <downrange/est/filter/estimates.hpp>
#include <downrange/est/model/matrix.hpp>
#include <downrange/est/model/sensors.hpp>
#include <downrange/geo/name.hpp>
#include <downrange/geo/time.hpp>
#include <downrange/stage/range_config.hpp>
#include <vector>

#include "ring.hpp"
#include "sample_series.hpp"
#include "source_set.hpp"

namespace downrange::integrity {

/// Angles: a tracker, or a radar that measures no range. One that measures range alone is never compared.
enum class WitnessKind : std::uint8_t { Radar, Angles, Receiver };

/// A sensor's bias as it was known at some time, indexed by BiasTerm.
struct KnownBias {
  Time epoch;
  Vec<bias_term_count> mean = Vec<bias_term_count>::Zero();
  Mat<bias_term_count, bias_term_count> cov = Mat<bias_term_count, bias_term_count>::Zero();
};

struct Witness {
  WitnessKind kind = WitnessKind::Radar;
  SourceSet sources = 0;             ///< of a receiver: the stations that relayed it so far
  Name receiver;                     ///< of a receiver
  bool heard = false;                ///< a receiver's place may be free yet
  RadarModel model;                  ///< sigma is the instrument's, without inflation; of a receiver unused
  double slow_factor = 0;            ///< slow pointing error: this times the angles' noise variance, beside `wander`
  double slow_tau_s = 30;            ///< correlation time of what varies slowly
  double slow_sigma_m = 0;           ///< of a receiver, per axis
  PointingWander wander_beside_gps;  ///< what the mount wanders, as configured
  KnownBias prior;                   ///< calibration included
  SampleSeries series;
  Ring<KnownBias> known{75};  ///< one each second

  [[nodiscard]] bool is_receiver() const { return kind == WitnessKind::Receiver; }
  [[nodiscard]] bool tells_position() const { return kind != WitnessKind::Angles; }
  /// As it was known at `at`; its prior where GPS had taught nothing by then.
  [[nodiscard]] const KnownBias& known_at(Time at) const;
  void note_bias(Time now, const BiasEstimate& bias);
  /// Until a receiver is heard, a sensor on the ground may wander as the methods allow it to without GPS; from then on
  /// as configured.
  void receiver_is_heard();
};

/// Radars first, then trackers, both by SourceId, then places for `receivers` receivers.
[[nodiscard]] std::vector<Witness> witnesses_of(const RangeConfig& config, int receivers);

}  // namespace downrange::integrity
