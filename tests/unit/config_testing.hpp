#pragma once
/// Configurations for tests, and what is said of them.

#include <filesystem>
#include <fstream>
#include <source_dir.hpp>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "config/load.hpp"

namespace downrange::config::test {

inline const std::filesystem::path source_dir = DOWNRANGE_SOURCE_DIR;
inline const std::filesystem::path naro = source_dir / "config/naro.toml";

inline std::string read(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

inline std::string joined(const std::vector<Problem>& problems) {
  std::string text;
  for (const Problem& problem : problems) text += problem.to_string() + '\n';
  return text;
}

inline std::vector<Problem> problems_of(std::string_view text, const Overrides& overrides = {}) {
  try {
    static_cast<void>(load_text(text, "test.toml", overrides));
    return {};
  } catch (const ConfigError& error) {
    return error.problems();
  }
}

/// As small as a range with a radar can be.
inline const std::string small = R"([range]
name = "cape"
[[target]]
id = "falcon9"
[[radar]]
id = "cape"
latitude_deg = 28.43
longitude_deg = -80.57
height_m = -10
sigma_range_m = 8
sigma_azimuth_deg = 0.01
sigma_elevation_deg = 0.01
)";

inline std::string site(const std::string& table, const std::string& id, double latitude_deg, double longitude_deg) {
  return "[[" + table + "]]\nid = \"" + id + "\"\nlatitude_deg = " + std::to_string(latitude_deg) +
         "\nlongitude_deg = " + std::to_string(longitude_deg) + "\nheight_m = 5\n";
}

}  // namespace downrange::config::test
