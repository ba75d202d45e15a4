#pragma once
/// What times that lie far from lift-off can be.

#include <archive/import/mapping.hpp>
#include <archive/import/plausibility.hpp>
#include <string>
#include <vector>

namespace downrange::archive {

/// Whether the epochs are dates, times of day or countdowns: no unit and no reference of numbers would help.
[[nodiscard]] bool times_are_text(const std::vector<PlausibleRow>& rows);

/// The keys under which the epochs of a file would be near lift-off: "with since = \"unix\"", "as
/// local time of ...". Empty: none does.
[[nodiscard]] std::string time_hint(const FileMapping& mapping, Time liftoff, const std::vector<PlausibleRow>& rows);

}  // namespace downrange::archive
