#pragma once
/// The tables of a configuration file, one line per key (sections.hpp), and what is done with them: read, show,
/// describe.

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "config/key.hpp"
#include "config/service_config.hpp"

namespace toml {
inline namespace v3 {
class table;
}
}  // namespace toml

namespace downrange::config {

/// A problem at a key's path. `node` says where; none: the file as a whole.
using Report = std::function<void(const toml::node* node, const std::string& path, const std::string& message)>;

/// One table, or one array of tables, of the file.
struct Section {
  std::string name;
  bool many = false;      ///< [[name]] instead of [name]
  int at_least = 0;       ///< entries of an array of tables
  std::string within;     ///< [within.x] of an entry of the array of tables `within`; it is given that entry's table
  bool optional = false;  ///< the file may leave out the table, whatever keys it requires
  std::string help;
  std::vector<KeyInfo> keys;
  std::vector<std::string> defaults;  ///< per key, as the file would say it

  /// Adds one table to the configuration: every problem of its keys is reported.
  std::function<void(ServiceConfig&, const toml::table&, const std::string& path, const Report&)> read;
  /// (path, value) of every key.
  std::function<std::vector<std::pair<std::string, std::string>>(const ServiceConfig&)> flatten;
};

[[nodiscard]] const std::vector<Section>& schema();

/// As the file has it: [name] or [[name]].
[[nodiscard]] std::string heading(const Section& section);

/// Reads the whole file's tables by the schema.
void read_tables(ServiceConfig& config, const toml::table& root, const Report& report);

/// What the single keys' limits cannot say: identifiers unique, minima below maxima, times that fit together.
void cross_check(const ServiceConfig& config, const toml::table& root, const Report& report);

/// Reports what is allowed, but hardly meant: sites that no range is wide enough for, keys that cancel each other. The
/// configuration has no problems.
void warn_about(const ServiceConfig& config, const toml::table& root, const Report& report);

/// ", did you mean ...?" for the nearest of `known`, or nothing when none is near.
[[nodiscard]] std::string suggestion(const std::string& unknown, const std::vector<std::string>& known);

}  // namespace downrange::config
