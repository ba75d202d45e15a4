#pragma once

#include <stdexcept>

namespace downrange::sim {

/// What a scenario's author reads: "launch.toml:12: radar.rate_hz: 0 is not allowed: greater than 0, up to 1000".
class ScenarioError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace downrange::sim
