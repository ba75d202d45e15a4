#pragma once
/// Numbers that stand for no value: -9999, 0 of a range.

#include <archive/import/mapping.hpp>
#include <archive/import/plausibility.hpp>
#include <string>
#include <vector>

namespace downrange::archive {

/// -9999, 99999.9: three nines at least, and no other digit, before the point.
[[nodiscard]] bool is_all_nines(double number);

/// A number that several rows have to the last digit, which no site can measure.
struct Sentinel {
  std::string what;                ///< where it is, how often, and which key leaves it out; empty: there is none
  std::vector<PlausibleRow> rows;  ///< the others
};
[[nodiscard]] Sentinel find_sentinel(const FileMapping& mapping, const std::vector<PlausibleRow>& rows);

}  // namespace downrange::archive
