#pragma once
/// The scenarios, mappings and ranges that come with the program.

#include <filesystem>

namespace downrange::app {

/// E.g. "scenarios/launch.toml", "imports/juno3.toml", "config/cape.toml": beside the installed program (bin/ and
/// share/downrange/), else in the sources that it was built from.
[[nodiscard]] std::filesystem::path shipped_file(const std::filesystem::path& name);

}  // namespace downrange::app
