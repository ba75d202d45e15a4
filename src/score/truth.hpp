#pragma once
/// Where the target truly was: a table of samples, continuous in between.

#include <downrange/geo/hermite.hpp>
#include <downrange/geo/time.hpp>
#include <functional>
#include <optional>
#include <vector>

namespace downrange::score {

using TrueState = PositionVelocity;

/// The true state at a time, or nothing where the truth is not known.
using TruthFunction = std::function<std::optional<TrueState>(Time)>;

struct TruthSample {
  Time time;
  TrueState state;
};

/// Cubic Hermite interpolation of samples. Error of position below |d4p/dt4| h^4 / 384 for samples h apart.
class TruthTable {
 public:
  /// Throws std::invalid_argument when there are fewer than two samples or their times do not increase.
  explicit TruthTable(std::vector<TruthSample> samples);

  /// Nothing before the first sample and after the last.
  [[nodiscard]] std::optional<TrueState> at(Time t) const;

  [[nodiscard]] const std::vector<TruthSample>& samples() const { return samples_; }

 private:
  std::vector<TruthSample> samples_;
};

}  // namespace downrange::score
