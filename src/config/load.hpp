#pragma once
/// TOML file -> validated ServiceConfig. Degrees and milliseconds end here.

#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "config/service_config.hpp"

namespace downrange::config {

/// All problems of a configuration; what() lists one a line.
class ConfigError : public std::runtime_error {
 public:
  explicit ConfigError(std::vector<Problem> problems);
  [[nodiscard]] const std::vector<Problem>& problems() const { return problems_; }

 private:
  std::vector<Problem> problems_;
};

/// A key set from outside of the file, after it was read and under the same rules.
struct Override {
  std::string key;     ///< path, e.g. "dds.domain"; not into an array of tables
  std::string value;   ///< TOML value; quotes around text may be left out
  std::string option;  ///< how problems name it, e.g. "--domain"
};
using Overrides = std::vector<Override>;

/// Reads and validates. Relative paths in the file are relative to the file's folder. Throws ConfigError with all
/// problems.
[[nodiscard]] ServiceConfig load(const std::filesystem::path& file, const Overrides& overrides = {});

/// The same from memory, e.g. from an archive's attachment. `name` stands for the file in problems.
[[nodiscard]] ServiceConfig load_text(std::string_view text, const std::filesystem::path& name,
                                      const Overrides& overrides = {});

/// Throws ConfigError where the configuration has no [dds], or its profiles are no file. Replay, report and experiments
/// do without; whatever talks on the bus asks here first.
void require_dds(const ServiceConfig& config);

/// Every problem of the file, in its order; none: it is a valid configuration. Where
/// it has [dds], the file of its profiles is there.
[[nodiscard]] std::vector<Problem> check(const std::filesystem::path& file);

/// Reference of all keys with type, default, allowed values and meaning, for people.
[[nodiscard]] std::string key_reference();

/// Paths of the keys whose values differ, in the reference's order.
[[nodiscard]] std::vector<std::string> differences(const ServiceConfig& a, const ServiceConfig& b);

}  // namespace downrange::config
