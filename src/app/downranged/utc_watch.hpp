#pragma once
/// Sees steps of UTC (an operator's or a time daemon's), against the steady clock.

#include <chrono>
#include <downrange/geo/time.hpp>
#include <optional>

namespace downrange::app {

class UtcWatch {
 public:
  using Steady = std::chrono::steady_clock::time_point;
  /// Smaller ones are slewing, or a look that took long.
  static constexpr Duration smallest_step{500'000'000};

  /// Both clocks read together. The step of UTC since the last look, back below zero, if there was one.
  [[nodiscard]] std::optional<Duration> look(Time utc, Steady steady) {
    std::optional<Duration> step;
    if (last_) {
      const Duration passed{std::chrono::nanoseconds(steady - last_->steady).count()};
      const Duration off = (utc - last_->utc) - passed;
      if (off > smallest_step || off < -smallest_step) step = off;
    }
    last_ = {utc, steady};
    return step;
  }

 private:
  struct Look {
    Time utc;
    Steady steady;
  };
  std::optional<Look> last_;
};

}  // namespace downrange::app
