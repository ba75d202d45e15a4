#pragma once
/// The biases that a flight found, for the next flight's configuration.

#include <string>

#include "config/service_config.hpp"

namespace downrange::app {

/// Writes each radar's and tracker's last bias of one method ("": the first) to `out`, and shows
/// it. The exit code. Throws std::runtime_error when the archive holds none or `out` cannot be written.
[[nodiscard]] int write_calibration(const std::string& flight, const std::string& method, const std::string& out,
                                    const config::ServiceConfig& config);

}  // namespace downrange::app
