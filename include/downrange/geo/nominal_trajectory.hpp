#pragma once
/// Where a vehicle should be: its planned trajectory, by time after lift-off.

#include <downrange/geo/hermite.hpp>
#include <optional>
#include <vector>

namespace downrange {

struct NominalSample {
  double t_s = 0;  ///< after lift-off
  PositionVelocity state;
  bool operator==(const NominalSample&) const = default;
};

/// A plain value: samples, continuous in between by cubic Hermite interpolation. Empty: there is no plan.
class NominalTrajectory {
 public:
  NominalTrajectory() = default;
  /// Throws std::invalid_argument when there are fewer than two samples, their times do not increase or a number is not
  /// finite.
  explicit NominalTrajectory(std::vector<NominalSample> samples);

  [[nodiscard]] bool empty() const { return samples_.empty(); }
  [[nodiscard]] const std::vector<NominalSample>& samples() const { return samples_; }

  /// Nothing before the first sample and after the last, and of an empty one.
  [[nodiscard]] std::optional<PositionVelocity> at(double t_s) const;

  bool operator==(const NominalTrajectory&) const = default;

 private:
  std::vector<NominalSample> samples_;
};

/// The same samples, each with the velocity of the parabola through it and its neighbours, for plans that tell
/// positions only: exact for constant acceleration. At least three samples with increasing times; two: the chord's.
[[nodiscard]] std::vector<NominalSample> with_velocities(std::vector<NominalSample> samples);

}  // namespace downrange
