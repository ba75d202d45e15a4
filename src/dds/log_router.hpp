#pragma once
/// The middleware reports some errors by nothing but a log line: these lines are caught here.

#include <mutex>
#include <string>
#include <vector>

#include "dds/participant.hpp"

namespace downrange::dds {

/// Collects the log lines of its lifetime beside the sink. One at a time in the process: the constructor waits.
class LogCapture {
 public:
  LogCapture();
  ~LogCapture();
  LogCapture(const LogCapture&) = delete;
  LogCapture& operator=(const LogCapture&) = delete;

  /// Waits for what is queued. Errors (and warnings, where asked for) so far, whose category begins with `category`.
  [[nodiscard]] std::vector<std::string> lines(std::string_view category, bool warnings) const;

 private:
  std::unique_lock<std::mutex> only_one_;
};

}  // namespace downrange::dds
