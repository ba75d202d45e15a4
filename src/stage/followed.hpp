#pragma once
/// What SLAVE follows of a target, and where the target may be instead.

#include <Eigen/Core>
#include <cstdint>
#include <downrange/est/method/method.hpp>
#include <downrange/geo/name.hpp>
#include <span>

namespace downrange {

/// Where the target may be if one source lies: what the others say by themselves.
struct Alternative {
  Eigen::Vector3d from_selected_m = Eigen::Vector3d::Zero();  ///< ECEF
  Eigen::Matrix3d cov = Eigen::Matrix3d::Zero();
};

/// What one source alone says of a target.
struct LoneSource {
  const Method* method = nullptr;
  int target = 0;  ///< as `method` counts
  Time newest;     ///< measurement that the method was given
  Name chain{};
  bool receiver = false;  ///< the vehicle's own, else a radar or tracker
};

struct Followed {
  const Method* method = nullptr;
  int target = 0;              ///< as `method` counts
  Time newest;                 ///< measurement that the method was given, used or not
  Name chain{};                ///< of sources; empty: all
  std::uint64_t revision = 0;  ///< another one: what is followed may have jumped
  std::span<const Alternative> alternatives{};
  bool bounded = false;                ///< the alternatives are all that one lying source leaves possible
  std::span<const LoneSource> lone{};  ///< sources that are believed, each by itself
};

}  // namespace downrange
