#pragma once
/// One file of a mapping into records.

#include <archive/import/mapping.hpp>
#include <archive/import_csv.hpp>
#include <archive/record.hpp>
#include <functional>
#include <vector>

namespace downrange::archive {

struct Imported {
  std::vector<Event> events;
  std::vector<Truth> truths;
};

struct FlightClock {
  Time liftoff;
  std::optional<int> leap_seconds;  ///< GPS minus UTC
};

/// Appends the file's records to `out`. Throws ImportError, with the file's name, when it does not fit its mapping or
/// gives no record. `progress` is called now and then with the share of the file read, 0 to 1.
[[nodiscard]] FileReport import_file(const FileMapping& mapping, const FlightClock& clock, Imported& out,
                                     const std::function<void(double)>& progress);

}  // namespace downrange::archive
