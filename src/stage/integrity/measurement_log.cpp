#include "stage/integrity/measurement_log.hpp"

#include <algorithm>

namespace downrange {
MeasurementLog::Position MeasurementLog::insert(const LoggedMeasurement& measurement) {
  const auto place = std::upper_bound(
      entries_.begin(), entries_.end(), measurement,
      [](const LoggedMeasurement& a, const LoggedMeasurement& b) { return processed_before(a.m, b.m); });
  const auto at = static_cast<Position>(place - entries_.begin());
  entries_.insert(place, measurement);
  return forgotten_ + at;
}

MeasurementLog::Position MeasurementLog::first_from(Time time) const {
  const auto place = std::lower_bound(entries_.begin(), entries_.end(), time,
                                      [](const LoggedMeasurement& e, Time t) { return e.m.epoch < t; });
  return forgotten_ + static_cast<Position>(place - entries_.begin());
}

SourceSet MeasurementLog::copies_of(const LoggedMeasurement& fix) const {
  constexpr Duration same_epoch = milliseconds(1);
  SourceSet copies = 0;
  for (Position at = first_from(fix.m.epoch - same_epoch); at < end(); ++at) {
    const LoggedMeasurement& other = (*this)[at];
    if (other.m.epoch - fix.m.epoch > same_epoch) break;
    if (is_fix(other.m) && other.m.target == fix.m.target) copies |= set_of(other.m.source);
  }
  return copies;
}

void MeasurementLog::forget_before(Time time, Position end) {
  const Position until = std::min(first_from(time), end);
  if (until <= forgotten_) return;
  entries_.erase(entries_.begin(), entries_.begin() + static_cast<std::ptrdiff_t>(until - forgotten_));
  forgotten_ = until;
}

}  // namespace downrange
