#pragma once
/// What a file's numbers look like, and whether they can be what the mapping says.

#include <archive/import/mapping.hpp>
#include <archive/import/times.hpp>
#include <downrange/geo/frames.hpp>
#include <downrange/geo/polar.hpp>
#include <downrange/geo/time.hpp>
#include <optional>
#include <string>
#include <vector>

namespace downrange::archive {

/// One imported row, as far as it is judged.
struct PlausibleRow {
  Time epoch;
  Time received;
  Polar polar;                      ///< radar, angles
  bool range_valid = false;         ///< polar.range_m says something
  bool angles_valid = false;        ///< likewise its angles
  Position<Ecef> position;          ///< gps, truth
  std::optional<double> speed_m_s;  ///< stated, gps and truth
  std::optional<ClockTime> clock;   ///< the epoch's cell, where it is no number
  std::uint64_t line = 0;           ///< in the file
};

struct Plausibility {
  std::string line;                 ///< "T+10.0 to T+11.9 s, 10.0 rows/s, range 12.0 to 12.6 km, ..."
  std::string impossible;           ///< what cannot be, and which key would help; empty: nothing
  std::vector<std::string> doubts;  ///< what can be, but hardly
};

/// Judges the rows of one file, at least one. Medians: outliers do not count. A number that stands for no value
/// (sentinels.hpp) is told as such.
[[nodiscard]] Plausibility judge_plausibility(const FileMapping& mapping, Time liftoff,
                                              const std::vector<PlausibleRow>& rows);

}  // namespace downrange::archive
