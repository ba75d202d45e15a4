#pragma once
/// How near the impact points that the service tells are to where the true states fall, and whether their ellipses are
/// honest (est/THEORY.md section 15).

#include <cstdint>
#include <vector>

#include "experiment/experiment.hpp"
#include "experiment/honesty.hpp"
#include "score/errors.hpp"

namespace downrange::experiment {

namespace impact {

/// Of one impact point of the selected chain.
struct Miss {
  double t_s = 0;          ///< after lift-off
  double downrange_m = 0;  ///< from the pad to the true impact point
  double along_m = 0;      ///< told - true, the way on from the pad
  double across_m = 0;     ///< to the right of it
  double sigma_m = 0;      ///< root of the trace of its covariance
  bool inside_95 = false;  ///< of its ellipse
  bool settled = true;     ///< no engine was lit or cut off in the last 3 s
};

struct Flown {
  std::vector<Miss> misses{};
  long untold = 0;  ///< records without a point, although the true state comes down
};

/// The launch of experiment honesty, with a receiver that tells the velocity to 0.1 m/s, so often.
[[nodiscard]] honesty::Profile profile(double gps_rate_hz);

/// One seed, with everything drawn as experiment honesty does; impact points twice a second from T+10 s on.
[[nodiscard]] Flown fly(const honesty::Profile& profile, bool gps, std::uint64_t seed);

}  // namespace impact

/// Throws std::invalid_argument for a method that is not compared (honesty_methods).
[[nodiscard]] ExperimentResult run_impact(const ExperimentOptions& options);
inline constexpr int impact_runs = 60;

}  // namespace downrange::experiment
