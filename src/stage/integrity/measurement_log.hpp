#pragma once
/// The measurements of the last minute, in the order of processing: what a chain is run again on.

#include <cstdint>
#include <downrange/est/model/measurement.hpp>
#include <vector>

#include "stage/integrity/source_set.hpp"

namespace downrange {

struct LoggedMeasurement {
  Measurement m;
  SourceSet copies_before = 0;  ///< of a fix: the stations that relayed it before
};

class MeasurementLog {
 public:
  /// Counts from the first measurement ever logged. What is inserted before it moves it by one.
  using Position = std::uint64_t;

  /// Where it was put.
  Position insert(const LoggedMeasurement& measurement);

  [[nodiscard]] Position begin() const { return forgotten_; }
  [[nodiscard]] Position end() const { return forgotten_ + entries_.size(); }
  [[nodiscard]] const LoggedMeasurement& operator[](Position at) const { return entries_[at - forgotten_]; }
  /// Of the first measurement with epoch >= `time`.
  [[nodiscard]] Position first_from(Time time) const;

  /// The stations that relayed the same fix (target, and epoch +- 1 ms).
  [[nodiscard]] SourceSet copies_of(const LoggedMeasurement& fix) const;

  /// Nothing was forgotten yet.
  [[nodiscard]] bool complete() const { return forgotten_ == 0; }
  /// Forgets what is before `end` and before `time`.
  void forget_before(Time time, Position end);

 private:
  std::vector<LoggedMeasurement> entries_;
  Position forgotten_ = 0;
};

}  // namespace downrange
