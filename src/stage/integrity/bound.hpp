#pragma once
/// How far from what is selected a target may be if one source lies (est/THEORY.md section 12).

#include <Eigen/Core>
#include <span>

#include "stage/followed.hpp"

namespace downrange {

/// Sigmas of an alternative's own noise: chi2 with three degrees of freedom at 0.999.
inline constexpr double bound_sigmas = 4.1;

/// m. Over all alternatives.
[[nodiscard]] double bound_m(std::span<const Alternative> alternatives);

/// rad, on the sky, at most pi: between the direction that is commanded and the target, seen from an antenna.
/// `commanded`: a unit vector; `selected`: from the antenna to where the target is selected to be. Both ECEF.
[[nodiscard]] double bound_rad(std::span<const Alternative> alternatives, const Eigen::Vector3d& commanded,
                               const Eigen::Vector3d& selected);

}  // namespace downrange
