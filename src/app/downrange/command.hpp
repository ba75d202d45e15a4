#pragma once
/// What the subcommands of `downrange` share.

#include <CLI/CLI.hpp>
#include <functional>
#include <optional>
#include <string>

#include "config/load.hpp"
#include "dds/participant.hpp"

namespace downrange::app {

/// Each adds its subcommand; when the user chose it, `*run` is set to what shall be done, which returns the exit code.
using Run = std::function<int()>;
void add_check(CLI::App& app, Run& run);
void add_simulate(CLI::App& app, Run& run);
void add_replay(CLI::App& app, Run& run);
void add_record(CLI::App& app, Run& run);
void add_import(CLI::App& app, Run& run);
void add_watch(CLI::App& app, Run& run);
void add_operator(CLI::App& app, Run& run);
void add_preflight(CLI::App& app, Run& run);
void add_rotctl(CLI::App& app, Run& run);
void add_rotctld(CLI::App& app, Run& run);
void add_report(CLI::App& app, Run& run);
void add_diff(CLI::App& app, Run& run);
void add_experiment(CLI::App& app, Run& run);
void add_firewall(CLI::App& app, Run& run);

/// Exit codes, as in the README.
inline constexpr int exit_ok = 0;
inline constexpr int exit_failed = 1;   ///< the work could not be done, or a comparison failed
inline constexpr int exit_usage = 2;    ///< command line or configuration
inline constexpr int exit_cut_off = 3;  ///< done, but an archive read ends before its end: a crash or a full disk

/// The options of a command that talks DDS, over a configuration.
struct DdsOptions {
  std::string config;
  std::optional<int> domain;
  std::optional<std::string> clock;
  std::vector<std::string> set;

  /// Adds --domain, --clock and --set (the configuration is the command's own argument).
  void add_to(CLI::App& command);
  /// What the options replace in the configuration.
  [[nodiscard]] config::Overrides overrides() const;
  /// Throws ConfigError.
  [[nodiscard]] config::ServiceConfig load() const { return config::load(config, overrides()); }
};

/// The files a command writes: a recording is never lost to a slip of the keyboard.
struct OutputFiles {
  bool force = false;

  /// Adds --force.
  void add_to(CLI::App& command);
  /// Before anything is opened for writing. Throws std::runtime_error where an output is one of the inputs or another
  /// output (--force or not), and where it exists already as a regular file without --force. Empty names are none.
  void check(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs) const;
  /// Whether a writer of this output, checked before, may take what is there: asked for, or a device or pipe. A file
  /// that came to be since is still not written over.
  [[nodiscard]] bool overwrite(const std::string& output) const;
};

/// Throws ConfigError where the configuration has no [dds].
[[nodiscard]] dds::ParticipantOptions participant_options(const config::ServiceConfig& config, const Name& node);

/// "max" or a positive number of seconds of flight per second; 0 stands for max. Throws CLI::ValidationError.
[[nodiscard]] double parse_rate(const std::string& text);

/// "a,b,c" as names. Throws CLI::ValidationError on one that is empty or too long.
[[nodiscard]] std::vector<Name> parse_names(const std::string& text);

}  // namespace downrange::app
