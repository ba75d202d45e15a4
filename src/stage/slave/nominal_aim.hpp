#pragma once
/// Where a vehicle should be, as an estimate.

#include <downrange/est/filter/estimates.hpp>
#include <downrange/geo/nominal_trajectory.hpp>
#include <downrange/stage/range_config.hpp>
#include <optional>

namespace downrange {

/// Of all three axes together.
[[nodiscard]] double position_sigma_m(const TrackEstimate& e);

/// Seconds of the plan at `at`: until lift-off is known the vehicle stands where the plan is at 0.
[[nodiscard]] double planned_time_s(std::optional<Time> liftoff, Time at);

/// The plan at `at`, with position, velocity and acceleration; before its first sample the vehicle stands where that
/// is. Covariance: slave.nominal_sigma_m and nominal_sigma_share of the way from the plan's begin. `data_epoch` is
/// lift-off, without one `tick`. None: no plan, or it has ended.
[[nodiscard]] std::optional<TrackEstimate> nominal_aim(const NominalTrajectory& nominal, const SlaveConfig& config,
                                                       std::optional<Time> liftoff, Time tick, Time at);

/// Whether a vehicle that is estimated to be there may still be said to follow its plan: within five sigmas of both.
[[nodiscard]] bool keeps_to_plan(const TrackEstimate& vehicle, const TrackEstimate& plan);

}  // namespace downrange
