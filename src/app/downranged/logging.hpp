#pragma once
/// Messages for people: spdlog's default logger, on a thread of its own behind a bounded queue.

#include <string_view>

#include "config/service_config.hpp"

namespace downrange::app {

/// To standard error, before and after the log: each line with the priority of an error under journald.
void print_errors(std::string_view lines);

class Logging {
 public:
  /// Throws std::runtime_error when the log file cannot be opened.
  explicit Logging(const config::LogConfig& config);
  /// Writes what waits.
  ~Logging();
  Logging(const Logging&) = delete;
  Logging& operator=(const Logging&) = delete;

  void set_level(config::LogLevel level);
};

}  // namespace downrange::app
