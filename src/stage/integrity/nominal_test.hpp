#pragma once
/// Is a witness where the plan has the vehicle? Flights depart from their plan by far more than sources err, so this
/// decides ties only, and only between a witness that is near the plan and one that is nowhere near it.

#include <downrange/geo/nominal_trajectory.hpp>

#include "witness.hpp"

namespace downrange::integrity {

/// Of the newest sample: squared distance from the plan over the largest that a flight of this plan may have. 0:
/// nothing is known of it (no plan, none for this time, no sample, or a witness that tells directions only).
[[nodiscard]] double off_nominal(const Witness& witness, const NominalTrajectory& nominal, Time liftoff);

}  // namespace downrange::integrity
