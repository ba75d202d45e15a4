#pragma once
/// Sites that no one range has: coordinates that were mistyped.

#include "config/checker.hpp"

namespace downrange::config {

/// Warns of sites farther from the others than a range is wide, of those that a slip of the keyboard explains better
/// than a station downrange, and of antennas that stand alone. Of all tables of the file that have a latitude and a
/// longitude.
void warn_of_sites(const toml::table& root, const Checker& warn);

}  // namespace downrange::config
