#pragma once
/// Running histogram of latencies: 1 us to 1000 s, 10 % wide bins.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <downrange/geo/time.hpp>

namespace downrange::app {

class LatencyHistogram {
 public:
  /// `latency` below zero (a clock that was set back) counts as zero.
  void add(Duration latency) {
    const double us = std::max(1.0, static_cast<double>(latency.ns) * 1e-3);
    const auto bin = static_cast<std::size_t>(std::log10(us) * double{bins_per_decade});
    ++counts_[std::min(bin, counts_.size() - 1)];
    ++total_;
    max_us_ = std::max(max_us_, static_cast<double>(latency.ns) * 1e-3);
  }

  /// Upper edge of the bin that holds the quantile, microseconds; 0 without data. `share` in (0, 1].
  [[nodiscard]] double quantile_us(double share) const {
    std::uint64_t below = 0;
    for (std::size_t bin = 0; bin < counts_.size(); ++bin) {
      below += counts_[bin];
      if (total_ > 0 && static_cast<double>(below) >= share * static_cast<double>(total_)) {
        return std::min(max_us_, std::pow(10.0, static_cast<double>(bin + 1) / double{bins_per_decade}));
      }
    }
    return 0;
  }
  [[nodiscard]] double max_us() const { return max_us_; }

 private:
  static constexpr std::size_t bins_per_decade = 24;
  std::array<std::uint64_t, 9 * bins_per_decade> counts_{};
  std::uint64_t total_ = 0;
  double max_us_ = 0;
};

}  // namespace downrange::app
