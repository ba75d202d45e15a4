#pragma once

#include <string>

namespace downrange::config {

/// One thing that is wrong, or odd, with a configuration.
struct Problem {
  std::string where;    ///< the file, or the command-line option
  int line = 0;         ///< 0: no line (file not readable, command line)
  std::string key;      ///< path of the key, e.g. radar[0].sigma_range_m; empty: the file as a whole
  std::string message;  ///< what was found, and what is allowed

  /// "naro.toml:12: radar[0].sigma_range_m: found -3, allowed ..."
  [[nodiscard]] std::string to_string() const;
};

}  // namespace downrange::config
