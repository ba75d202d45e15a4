#pragma once
/// What one witness says at instants of a common grid: the median of its measurements around each, brought to it along
/// a reference track. One wrong measurement among five changes nothing.

#include <array>
#include <downrange/est/model/matrix.hpp>
#include <downrange/est/model/sensors.hpp>
#include <downrange/geo/time.hpp>
#include <optional>

#include "reference_track.hpp"
#include "ring.hpp"

namespace downrange::integrity {

inline constexpr Duration grid_step = milliseconds(500);

/// One measurement, as INGEST accepted it: range (m), azimuth, elevation (rad), or a position (ECEF, m).
struct RawMeasurement {
  Time epoch;
  Vec<3> z = Vec<3>::Zero();
  Vec<3> velocity_m_s = Vec<3>::Zero();  ///< of a fix, where velocity_valid
  bool velocity_valid = false;
  double sigma_horizontal_m = 0;  ///< of a fix
  double sigma_vertical_m = 0;
  double sigma_velocity_m_s = 0;
};

struct Sample {
  Time epoch;                      ///< on the grid
  Vec<3> z = Vec<3>::Zero();       ///< as RawMeasurement
  Vec<9> motion = Vec<9>::Zero();  ///< of the reference track; position and velocity of a fix are its own
  int measurements = 0;            ///< behind the median
  double sigma_horizontal_m = 0;   ///< of a fix
  double sigma_vertical_m = 0;
  double sigma_velocity_m_s = 0;
  bool velocity_valid = false;
  double own_break = 0;  ///< how much it contradicts the witness's own past, in units of the threshold
  double own_break_m = 0;

  /// Of the median of that many measurements, of the variance of one.
  [[nodiscard]] double median_factor() const;
};

class SampleSeries {
 public:
  /// `fixes`: of a receiver, whose rate nobody configures; a sample is made of what is there.
  explicit SampleSeries(double rate_hz = 10, bool fixes = false);

  void note(const RawMeasurement& measurement);
  /// Whether a fix of this epoch, give or take a millisecond, is among the last ones.
  [[nodiscard]] bool knows(Time epoch) const;
  /// Newest measurement.
  [[nodiscard]] std::optional<Time> heard() const;
  /// The oldest grid instant not yet made a sample of, once all that belongs to it is there or it is too late for
  /// more. `residual(raw, predicted motion)` is the measurement minus what the motion predicts.
  template <class Predict, class Residual>
  std::optional<Sample> form(Time now, const ReferenceTrack& track, const Predict& predict, const Residual& residual) {
    while (const std::optional<Time> at = due(now)) {
      next_ = *at + step_;
      const std::optional<Vec<9>> motion = track.at(*at);
      if (!motion) continue;
      Picked picked;
      for (std::size_t i = 0; i < raw_.size() && picked.count < max_picked; ++i) {
        const RawMeasurement& raw = raw_.newest(i);
        if (raw.epoch <= *at - half_ || raw.epoch > *at + half_) continue;
        const Vec<9> then = moved(*motion, (raw.epoch - *at).seconds());
        picked.residual[picked.count++] = residual(raw.z, predict(then));
        picked.last = &raw;
      }
      if (picked.count < least_) continue;
      return sample_of(*at, *motion, picked, predict(*motion));
    }
    return std::nullopt;
  }

  void keep(const Sample& sample) { samples_.push(sample); }
  [[nodiscard]] const Ring<Sample>& samples() const { return samples_; }
  /// None: no sample at this grid instant.
  [[nodiscard]] const Sample* at(Time epoch) const;

 private:
  static constexpr std::size_t max_picked = 32;
  struct Picked {
    std::array<Vec<3>, max_picked> residual;
    std::size_t count = 0;
    const RawMeasurement* last = nullptr;
  };

  [[nodiscard]] std::optional<Time> due(Time now);
  [[nodiscard]] static Sample sample_of(Time at, const Vec<9>& motion, Picked& picked, const Vec<3>& predicted);

  Duration period_;
  Duration half_;  ///< of the window around a grid instant
  Duration step_;  ///< from sample to sample
  std::size_t least_ = 1;
  bool fixes_ = false;
  std::optional<Time> next_;
  Time newest_;
  Ring<RawMeasurement> raw_;
  Ring<Sample> samples_;
};

}  // namespace downrange::integrity
