#pragma once
/// When an antenna will see its target.

#include <downrange/stage/result.hpp>
#include <optional>

#include "stage/slave/pass.hpp"
#include "stage/slave/travel.hpp"

namespace downrange {

/// Acquisition, loss and the highest elevation between them, from `tick` on: of the pass under way, else of the next
/// one on `path`, which begins at `begins` (before, the target stands where it begins). Crossings of the horizon to a
/// millisecond. Without names, orders and basis. Not of an empty path.
[[nodiscard]] AntennaAccount sighting(const PredictedPath& path, Time begins, const Site& site,
                                      const RefractionTable* air, const Horizon& horizon, Time tick);

}  // namespace downrange
