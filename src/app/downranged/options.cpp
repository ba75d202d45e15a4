#include "options.hpp"

#include <CLI/CLI.hpp>
#include <array>
#include <string>
#include <vector>

namespace downrange::app {
namespace {

/// An option that replaces one key of the file.
struct KeyOption {
  const char* flag;
  const char* value_name;
  const char* key;
  const char* help;
};
constexpr std::array key_options{
    KeyOption{"--clock", "MODE", "clock.mode", "wall: this node's UTC clock; range: simulation and replay over DDS"},
    KeyOption{"--domain", "N", "dds.domain", "DDS domain, 0 to 232"},
    KeyOption{"--node", "ID", "node.id", "node_id of this process; each process of a range has its own"},
    KeyOption{"--log-level", "LEVEL", "log.level", "trace, debug, info, warning or error"},
};

/// a,b -> ["a", "b"]
std::string toml_list(const std::vector<std::string>& items) {
  std::string list;
  for (const std::string& item : items) list += (list.empty() ? "\"" : ", \"") + item + '"';
  return '[' + list + ']';
}

}  // namespace

std::optional<int> parse_command_line(int argc, char** argv, Options& options) {
  CLI::App app{
      "Downrange service: reads radar plots and GPS fixes from DDS, publishes biases, the fused trajectory and\n"
      "one pointing command per antenna. Options replace the configuration file's keys.",
      "downranged"};
  app.set_version_flag("--version", "downranged " DOWNRANGE_VERSION);
  app.add_option("--config", options.config, "configuration of the range (TOML)")->required()->type_name("FILE");

  std::array<std::string, key_options.size()> values;
  for (std::size_t i = 0; i < key_options.size(); ++i) {
    app.add_option(key_options[i].flag, values[i], key_options[i].help)->type_name(key_options[i].value_name);
  }
  std::vector<std::string> stages;
  std::vector<std::string> sources;
  std::string archive;
  std::vector<std::string> set;
  app.add_option("--stages", stages, "stages to run, of ingest,align,fuse,slave")->delimiter(',')->type_name("A,B");
  app.add_option("--sources", sources, "radars, trackers and stations that ingest accepts")
      ->delimiter(',')
      ->type_name("A,B");
  app.add_option("--archive", archive, "record to this folder, or to this file *.mcap")->type_name("PATH");
  app.add_option("--set", set, "replace any key, e.g. ingest.expect_simulated=true")->type_name("KEY=VALUE");
  app.add_flag("--check", options.check, "only check the configuration with these options: exit code 0, or 2");

  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& done) {  // --help, --version
    return app.exit(done);
  } catch (const CLI::ParseError& error) {
    app.exit(error);
    return exit_misconfigured;
  }

  for (std::size_t i = 0; i < key_options.size(); ++i) {
    if (app.count(key_options[i].flag) > 0) {
      options.overrides.push_back({key_options[i].key, values[i], key_options[i].flag});
    }
  }
  if (!stages.empty()) options.overrides.push_back({"node.stages", toml_list(stages), "--stages"});
  if (!sources.empty()) options.overrides.push_back({"node.sources", toml_list(sources), "--sources"});
  if (!archive.empty()) {
    options.overrides.push_back({"archive.enabled", "true", "--archive"});
    options.overrides.push_back({"archive.directory", std::filesystem::absolute(archive).string(), "--archive"});
  }
  for (const std::string& assignment : set) {
    const std::size_t equals = assignment.find('=');
    const std::string value = equals == std::string::npos ? "" : assignment.substr(equals + 1);
    options.overrides.push_back({assignment.substr(0, equals), value, "--set"});
  }
  return std::nullopt;
}

}  // namespace downrange::app
