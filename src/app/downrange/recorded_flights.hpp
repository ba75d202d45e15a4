#pragma once
/// Recorded flights in a folder beside the checkout, as experiments read them.

#include <filesystem>
#include <string>
#include <vector>

#include "experiment/flights_replay.hpp"

namespace downrange::app {

/// The folder of recorded flights: `given`, else $DOWNRANGE_DATA, else `data` of $DOWNRANGE_SHARED or of the folder
/// shared beside the checkout. It may not exist.
[[nodiscard]] std::filesystem::path flights_folder(const std::string& given);

/// Known flights that `folder` has: those of the same name as a mapping in tools/imports, flown at config/cape.toml.
[[nodiscard]] std::vector<std::string> flights_in(const std::filesystem::path& folder);

/// Configuration, mapping and CSV files of a flight: what must not be written over.
[[nodiscard]] std::vector<std::string> files_of_flight(const std::filesystem::path& folder, const std::string& flight);

/// Imports it by its mapping in tools/imports. Throws ImportError, ArchiveError, ConfigError, or std::runtime_error
/// where the flight has no true trajectory.
[[nodiscard]] experiment::flights::RecordedFlight load_flight(const std::filesystem::path& folder,
                                                              const std::string& flight);

}  // namespace downrange::app
