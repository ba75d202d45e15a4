#include <algorithm>
#include <cmath>
#include <downrange/geo/earth.hpp>
#include <downrange/geo/free_fall.hpp>
#include <downrange/geo/site.hpp>

namespace downrange {
namespace {

constexpr double transition_step_s = 120;
/// Farther below the ellipsoid nothing flies, and the gravity of a point mass is none.
constexpr double deepest_m = -50'000;
/// To which a landing is found.
constexpr double height_tolerance_m = 1e-4;
constexpr int most_iterations = 60;

using State = Eigen::Matrix<double, 6, 1>;
/// Position and velocity, and their derivatives by those at the start.
using Flow = Eigen::Matrix<double, 6, 7>;

State derivative(const State& x) {
  State d;
  d << x.tail<3>(), free_fall_acceleration({x.head<3>()}, {x.tail<3>()});
  return d;
}

Flow derivative(const Flow& x) {
  constexpr double omega = wgs84::rotation_rate_rad_s;
  const Eigen::Vector3d p = x.block<3, 1>(0, 0);
  Flow d;
  d.topRows<3>() = x.bottomRows<3>();
  d.block<3, 6>(3, 1).noalias() = free_fall_gradient({p}) * x.block<3, 6>(0, 1);
  // Coriolis: (2 omega v_y, -2 omega v_x, 0)
  d.block<1, 6>(3, 1) += 2 * omega * x.block<1, 6>(4, 1);
  d.block<1, 6>(4, 1) -= 2 * omega * x.block<1, 6>(3, 1);
  d.block<3, 1>(3, 0) = free_fall_acceleration({p}, {x.block<3, 1>(3, 0)});
  return d;
}

/// One step of Dormand and Prince's fifth-order formula.
template <class X>
X step(const X& x, double h) {
  const X k1 = derivative(x);
  const X k2 = derivative(X(x + h / 5 * k1));
  const X k3 = derivative(X(x + h * (3.0 / 40 * k1 + 9.0 / 40 * k2)));
  const X k4 = derivative(X(x + h * (44.0 / 45 * k1 - 56.0 / 15 * k2 + 32.0 / 9 * k3)));
  const X k5 =
      derivative(X(x + h * (19372.0 / 6561 * k1 - 25360.0 / 2187 * k2 + 64448.0 / 6561 * k3 - 212.0 / 729 * k4)));
  const X k6 = derivative(
      X(x + h * (9017.0 / 3168 * k1 - 355.0 / 33 * k2 + 46732.0 / 5247 * k3 + 49.0 / 176 * k4 - 5103.0 / 18656 * k5)));
  return x + h * (35.0 / 384 * k1 + 500.0 / 1113 * k3 + 125.0 / 192 * k4 - 2187.0 / 6784 * k5 + 11.0 / 84 * k6);
}

/// Height above the ellipsoid and its rate.
struct Vertical {
  double height_m = 0;
  double rate_m_s = 0;
};

Vertical vertical_of(const State& x) {
  const Geodetic g = geodetic_from_ecef({x.head<3>()});
  const double c = std::cos(g.latitude_rad);
  const Eigen::Vector3d up(c * std::cos(g.longitude_rad), c * std::sin(g.longitude_rad), std::sin(g.latitude_rad));
  return {g.height_m, up.dot(x.tail<3>())};
}

PositionVelocity state_of(const State& x) { return {{x.head<3>()}, {x.tail<3>()}}; }

/// A part of a step, by its ends: seconds after the step's begin.
struct Span {
  double from_s;
  double to_s;
};

/// When it comes down within a step: above at `span.from_s` (or there, rising), below at its end. From the end Newton's
/// method goes to the last crossing, bisection takes over where it leaves the span.
Landing landing_in(const State& begin, Span span, double height_m) {
  double t = span.to_s;
  State x = step(begin, t);
  for (int i = 0; i < most_iterations; ++i) {
    const Vertical v = vertical_of(x);
    const double above = v.height_m - height_m;
    if (std::abs(above) < height_tolerance_m && v.rate_m_s < 0) break;
    (above > 0 || v.rate_m_s >= 0 ? span.from_s : span.to_s) = t;
    const double newton = t - above / v.rate_m_s;
    t = v.rate_m_s < 0 && newton > span.from_s && newton < span.to_s ? newton : (span.from_s + span.to_s) / 2;
    x = step(begin, t);
  }
  return {state_of(x), t};
}

/// Where between the ends of a step that begins falling and ends rising it is lowest, seconds after its begin.
double lowest_in(const State& begin, double h) {
  Span span{0, h};
  for (int i = 0; i < 30; ++i) {
    const double t = (span.from_s + span.to_s) / 2;
    (vertical_of(step(begin, t)).rate_m_s < 0 ? span.from_s : span.to_s) = t;
  }
  return span.from_s;
}

}  // namespace

Eigen::Matrix3d free_fall_gradient(const Position<Ecef>& p) {
  constexpr double omega2 = wgs84::rotation_rate_rad_s * wgs84::rotation_rate_rad_s;
  const double r2 = p.m.squaredNorm();
  const double r = std::sqrt(r2);
  const double z2 = p.m.z() * p.m.z();
  const double mu_r3 = wgs84::gm_m3_s2 / (r2 * r);
  const double k = 1.5 * wgs84::j2 * wgs84::semi_major_axis_m * wgs84::semi_major_axis_m / r2;
  // g = -mu/r^3 [(1 + k - 5 k z^2/r^2) p + 2 k z e_z], k = 3/2 J2 a^2/r^2; with d(r^-n) = -n r^-(n+2) p':
  const double along = 1 + k - 5 * k * z2 / r2;
  const Eigen::Vector3d e_z = Eigen::Vector3d::UnitZ();
  Eigen::Matrix3d G = -mu_r3 * along * Eigen::Matrix3d::Identity();
  G += mu_r3 / r2 * (3 + 5 * k - 35 * k * z2 / r2) * p.m * p.m.transpose();
  G += mu_r3 / r2 * 10 * k * p.m.z() * (p.m * e_z.transpose() + e_z * p.m.transpose());
  G -= mu_r3 * 2 * k * e_z * e_z.transpose();
  G(0, 0) += omega2;
  G(1, 1) += omega2;
  return G;
}

std::optional<Landing> fall_to(const PositionVelocity& start, double height_m, double horizon_s,
                               double longest_step_s) {
  State x;
  x << start.position.m, start.velocity.m_s;
  if (!x.allFinite()) return std::nullopt;
  Vertical at_start = vertical_of(x);
  if (!(at_start.height_m > deepest_m)) return std::nullopt;
  const double height = std::min(height_m, at_start.height_m);
  if (at_start.height_m <= height + height_tolerance_m && at_start.rate_m_s <= 0) return Landing{start, 0};

  // Above this radius nothing is near `height`, whatever its latitude and however it moves in a step.
  constexpr double near_m = 50'000;
  const double low_radius = wgs84::semi_major_axis_m + height + near_m;
  std::optional<Vertical> before = at_start;
  for (double t = 0; t < horizon_s; t += longest_step_s) {
    const double h = std::min(longest_step_s, horizon_s - t);
    const State y = step(x, h);
    const double radius = y.head<3>().norm();
    if (!std::isfinite(radius)) return std::nullopt;
    std::optional<Vertical> after;
    if (radius < low_radius) {
      after = vertical_of(y);
      Span span{0, h};
      bool down = after->height_m < height;
      const bool turned = before.value_or(Vertical{.rate_m_s = -1}).rate_m_s < 0 && after->rate_m_s >= 0;
      if (turned) {  // it may have been below in between
        span.to_s = lowest_in(x, h);
        down = vertical_of(step(x, span.to_s)).height_m < height;
      }
      if (down) {
        Landing landing = landing_in(x, span, height);
        landing.time_s += t;
        return landing;
      }
    }
    before = after;
    x = y;
  }
  return std::nullopt;
}

Eigen::Matrix<double, 6, 6> free_fall_transition(const PositionVelocity& start, double time_s) {
  Flow x;
  x << start.position.m, Eigen::Matrix<double, 3, 6>::Identity(), start.velocity.m_s,
      Eigen::Matrix<double, 3, 6>::Identity();
  x.block<3, 6>(3, 1) << Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Identity();
  const int steps = std::max(1, static_cast<int>(std::ceil(time_s / transition_step_s)));
  for (int i = 0; i < steps; ++i) x = step(x, time_s / steps);
  return x.rightCols<6>();
}

}  // namespace downrange
