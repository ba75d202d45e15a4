#pragma once
/// The command line of downranged.

#include <filesystem>
#include <optional>

#include "config/load.hpp"

namespace downrange::app {

struct Options {
  std::filesystem::path config;
  config::Overrides overrides;  ///< options that replace keys of the file
  bool check = false;           ///< only say whether they and the file are valid
};

/// Exit codes, also in deploy/README.md.
inline constexpr int exit_failed = 1;         ///< the environment: DDS domain, archive folder, log file
inline constexpr int exit_misconfigured = 2;  ///< the command line or the configuration file

/// Fills `options`; a value is the exit code: the command line was wrong, or asked for help or the version only.
[[nodiscard]] std::optional<int> parse_command_line(int argc, char** argv, Options& options);

}  // namespace downrange::app
