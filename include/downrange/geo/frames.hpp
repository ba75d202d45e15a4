#pragma once
/// Frame-tagged vectors: adding, subtracting or rotating across the wrong frame does not compile.

#include <Eigen/Core>

namespace downrange {

struct Ecef {};  ///< WGS-84 Earth-fixed. x: lat 0 lon 0; z: north pole; origin: ellipsoid centre.
struct Enu {};   ///< East, north, up (ellipsoid normal) at one Site's reference point. Never crosses a stage.
struct Sez {};   ///< South, east, zenith at one Site's reference point: the axes of song2015. Never crosses a stage.

/// Free vector in F's axes, metres.
template <class F>
struct Displacement {
  Eigen::Vector3d m = Eigen::Vector3d::Zero();
  bool operator==(const Displacement&) const = default;
};

/// Point: metres from F's origin.
template <class F>
struct Position {
  Eigen::Vector3d m = Eigen::Vector3d::Zero();
  bool operator==(const Position&) const = default;
};

/// Velocity relative to F, in F's axes, m/s.
template <class F>
struct Velocity {
  Eigen::Vector3d m_s = Eigen::Vector3d::Zero();
  bool operator==(const Velocity&) const = default;
};

/// Rotation of axes: v_To = R * v_From. Orthonormal, right-handed.
template <class To, class From>
struct Rotation {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();

  [[nodiscard]] Rotation<From, To> inverse() const { return {R.transpose()}; }
};

template <class F>
Displacement<F> operator-(const Position<F>& to, const Position<F>& from) {
  return {to.m - from.m};
}
template <class F>
Position<F> operator+(const Position<F>& p, const Displacement<F>& d) {
  return {p.m + d.m};
}
template <class F>
Displacement<F> operator+(const Displacement<F>& a, const Displacement<F>& b) {
  return {a.m + b.m};
}
template <class F>
Displacement<F> operator-(const Displacement<F>& a, const Displacement<F>& b) {
  return {a.m - b.m};
}
template <class To, class From>
Displacement<To> operator*(const Rotation<To, From>& rotation, const Displacement<From>& d) {
  return {rotation.R * d.m};
}
template <class To, class From>
Velocity<To> operator*(const Rotation<To, From>& rotation, const Velocity<From>& v) {
  return {rotation.R * v.m_s};
}
template <class A, class B, class C>
Rotation<A, C> operator*(const Rotation<A, B>& ab, const Rotation<B, C>& bc) {
  return {ab.R * bc.R};
}

}  // namespace downrange
