#pragma once
/// The order of a file's rows in time.

#include <archive/import/mapping.hpp>
#include <cstdint>
#include <downrange/geo/time.hpp>
#include <string>
#include <vector>

namespace downrange::archive {

struct RowTimes {
  Time epoch;
  Time received;
  std::uint64_t line = 0;
};

/// Why the rows cannot be taken as they stand, and which key of the mapping would help; empty when they can. A step
/// back of a day (or a week) is a counter that starts anew; rows whose times fall more often than they rise are newest
/// first; and where no column says when a row was received, a row far behind the one before would arrive late.
[[nodiscard]] std::string order_problem(const FileMapping& mapping, const std::vector<RowTimes>& rows);

}  // namespace downrange::archive
