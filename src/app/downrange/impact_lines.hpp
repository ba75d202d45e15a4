#pragma once
/// What `watch` tells of a target's impact points.

#include <downrange/stage/result.hpp>
#include <map>
#include <string>

namespace downrange::app {

/// A target's newest impact points by chain, the selected one (empty) among them.
using ImpactsByChain = std::map<Name, ImpactPoint>;

/// In lines of at most 80 columns (longer names make longer ones): the selected chain's point, time to go and ellipse;
/// the three boundaries that it is least inside of; for how long there is no data, from one second on, and whether that
/// is allowed; how far from it the independent chains say it is. Empty without the selected chain.
[[nodiscard]] std::string impact_lines(const ImpactsByChain& impacts);

}  // namespace downrange::app
