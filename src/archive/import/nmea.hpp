#pragma once
/// NMEA 0183 sentences of a receiver as a table.

#include <archive/import/mapping.hpp>
#include <map>
#include <string>
#include <string_view>

namespace downrange::archive {

/// Gives the mapping of a file of sentences the columns of nmea_table().
void declare_nmea(FileMapping& file);

struct NmeaTable {
  std::string text;                                ///< one line for each of the file, "#" for what is no fix
  std::map<std::string, std::uint64_t> sentences;  ///< how many of which type: "GGA"
  std::uint64_t wrong_checksums = 0;
  std::string first_wrong;  ///< "line 1: found 00, expected 4C"
};

/// Fixes of GGA, or of GNS where there is no GGA, from any talker, with the height above the ellipsoid (above the sea
/// plus the separation of the geoid), the sigmas of a GST of the same time, and the date of the nearest RMC or ZDA
/// before it. A sentence whose checksum is wrong makes a line that is no row. What stands before '$' in a line is
/// passed over.
[[nodiscard]] NmeaTable nmea_table(std::string_view text);

}  // namespace downrange::archive
