#pragma once
/// Part of a flight that errors are summarised for.

#include <string>

namespace downrange::score {

/// `from_s` <= t < `to_s` after lift-off.
struct Phase {
  std::string name;
  double from_s = 0;
  double to_s = 0;
};

}  // namespace downrange::score
