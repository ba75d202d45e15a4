#pragma once
/// Of which instants no chain hears a source: told by the measurement's epoch, so that the order of arrival is nothing.

#include <downrange/geo/time.hpp>
#include <downrange/stage/source_table.hpp>
#include <limits>
#include <vector>

#include "stage/integrity/measurement_log.hpp"

namespace downrange {

/// Before every instant; far enough from the first that may be written down for durations to be taken from it.
inline constexpr Time before_all{std::numeric_limits<std::int64_t>::min() / 2};

class Exclusions {
 public:
  /// Measurements of that source and target with epoch >= `from` are not heard, until it is closed.
  void open(int target, SourceId source, Time from);
  /// Measurements with epoch >= `until` are heard again.
  void close(int target, SourceId source, Time until);
  [[nodiscard]] bool cover(int target, SourceId source, Time epoch) const;
  /// Not covered, and where it is another copy of a fix, all copies before it are.
  [[nodiscard]] bool leave(const LoggedMeasurement& measurement) const;
  /// Forgets those that ended before `time`.
  void forget_before(Time time);

 private:
  struct Interval {
    int target;
    SourceId source;
    Time from;
    Time until;
  };
  std::vector<Interval> intervals_;
};

}  // namespace downrange
