#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/special_functions/owens_t.hpp>
#include <cmath>
#include <downrange/est/model/impact.hpp>
#include <downrange/geo/earth.hpp>
#include <downrange/geo/free_fall.hpp>
#include <numbers>

namespace downrange {
namespace {

/// Of states that tell how far the point is spread: a metre of theirs does not matter.
constexpr double coarse_step_s = 80;

PositionVelocity state_of(const Vec<6>& x) { return {{x.head<3>()}, {x.tail<3>()}}; }

/// Points of the ground near an impact point, as offsets from it.
class LocalPlane {
 public:
  LocalPlane(const Position<Ecef>& origin, const Geodetic& geodetic)
      : origin_(origin), R_enu_ecef_(enu_from_ecef_at(geodetic)) {}

  [[nodiscard]] const Eigen::Matrix3d& axes() const { return R_enu_ecef_.R; }
  /// East and north of where a state comes down; nothing where it does not.
  [[nodiscard]] std::optional<Eigen::Vector2d> landing_of(const Vec<6>& x, const FallSettings& settings) const {
    const auto landing = fall_to(state_of(x), settings.height_m, settings.horizon_s, coarse_step_s);
    if (!landing) return std::nullopt;
    return ground_offset(origin_, R_enu_ecef_, landing->state.position);
  }

 private:
  Position<Ecef> origin_;
  Rotation<Enu, Ecef> R_enu_ecef_;
};

/// d(east, north)/d(state): the place when the mean comes down, and how much later or earlier the state does.
Mat<2, 6> landing_by_state(const PositionVelocity& start, const Landing& landing, const Eigen::Matrix3d& R_enu_ecef) {
  if (landing.time_s == 0) {  // where it is
    Mat<2, 6> J = Mat<2, 6>::Zero();
    J.leftCols<3>() = R_enu_ecef.topRows<2>();
    return J;
  }
  const Mat<3, 6> place = R_enu_ecef * free_fall_transition(start, landing.time_s).topRows<3>();
  const Eigen::Vector3d v = R_enu_ecef * landing.state.velocity.m_s;
  // Higher by du it comes down later by du / -v_u, and moves on meanwhile.
  return place.topRows<2>() - v.head<2>() / v.z() * place.row(2);
}

/// Are the states two sigmas off, along the direction that moves the point most, off by as much on both sides?
bool is_curved(const Vec<6>& mean, const Mat<6, 6>& L, const Mat<2, 6>& by_sigma, const Eigen::Matrix2d& cov,
               const LocalPlane& plane, const FallSettings& settings) {
  constexpr double sigmas = 2;
  constexpr double most_bend = 0.1;
  // Principal axis of the ellipse, and what of the state it is made of.
  const double angle = 0.5 * std::atan2(2 * cov(0, 1), cov(0, 0) - cov(1, 1));
  const Vec<6> w = by_sigma.transpose() * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  const double size = w.norm();
  if (!(size > 0)) return false;
  const Vec<6> off = sigmas / size * (L * w);
  const auto ahead = plane.landing_of(mean + off, settings);
  const auto behind = plane.landing_of(mean - off, settings);
  if (!ahead || !behind) return true;
  return (*ahead + *behind).norm() > most_bend * (*ahead - *behind).norm();
}

/// Second moment about the impact point of the mean.
std::optional<Eigen::Matrix2d> by_sigma_points(const Vec<6>& mean, const Mat<6, 6>& L, const LocalPlane& plane,
                                               const FallSettings& settings) {
  Eigen::Matrix2d moment = Eigen::Matrix2d::Zero();
  for (int i = 0; i < 6; ++i) {
    for (const double side : {-1.0, 1.0}) {
      const auto off = plane.landing_of(mean + side * std::sqrt(6.0) * L.col(i), settings);
      if (!off) return std::nullopt;
      moment += *off * off->transpose() / 12;
    }
  }
  return moment;
}

/// Of the integral of a standard Gaussian beyond an edge (from `a` to `b`, the mean in the origin): the share of the
/// full angle that the edge spans, and that of the probability, both positive to the left of the edge.
struct EdgeShare {
  double angle = 0;
  double beyond = 0;
};

EdgeShare share_of(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  using Policy = boost::math::policies::policy<boost::math::policies::promote_double<false>>;
  constexpr double negligible = 8.5;  // sigmas: 1e-17
  const double area = a.x() * b.y() - a.y() * b.x();
  EdgeShare share{.angle = std::atan2(area, a.dot(b)) / (2 * std::numbers::pi)};
  const Eigen::Vector2d d = b - a;
  const double length = d.norm();
  const double distance = std::abs(area) / length;
  if (!(distance < negligible)) return share;
  // On the line through the edge, both are the same where the mean lies on it.
  if (distance < 1e-12) {
    share.beyond = share.angle;
    return share;
  }
  const auto T = [&](const Eigen::Vector2d& end) {
    return boost::math::owens_t(distance, end.dot(d) / length / distance, Policy());
  };
  share.beyond = std::copysign(T(b) - T(a), area);
  return share;
}

}  // namespace

std::optional<Impact> impact_of(const Gaussian<6>& state, const FallSettings& settings) {
  const PositionVelocity start = state_of(state.mean);
  const auto landing = fall_to(start, settings.height_m, settings.horizon_s);
  const Eigen::LLT<Mat<6, 6>> llt(state.cov);
  if (!landing || llt.info() != Eigen::Success) return std::nullopt;
  Impact impact;
  impact.point = geodetic_from_ecef(landing->state.position);
  impact.time_s = landing->time_s;
  const LocalPlane plane(landing->state.position, impact.point);
  impact.by_state = landing_by_state(start, *landing, plane.axes());
  const Mat<6, 6> L = llt.matrixL();
  const Mat<2, 6> by_sigma = impact.by_state * L;
  impact.cov = by_sigma * by_sigma.transpose();
  if (landing->time_s > 0 && is_curved(state.mean, L, by_sigma, impact.cov, plane, settings)) {
    const auto moment = by_sigma_points(state.mean, L, plane, settings);
    if (!moment) return std::nullopt;
    impact.cov = *moment;
    impact.curved = true;
  }
  if (!impact.cov.allFinite() || !impact.by_state.allFinite()) return std::nullopt;
  return impact;
}

GroundVelocity velocity_of(const Impact& impact, const Gaussian<9>& motion) {
  const Mat<2, 3> J = impact.by_state.rightCols<3>();
  const Vec<3> specific_force =
      motion.mean.tail<3>() - free_fall_acceleration({motion.mean.head<3>()}, {motion.mean.segment<3>(3)});
  return {.m_s = J * specific_force, .cov = J * motion.cov.bottomRightCorner<3, 3>() * J.transpose()};
}

double probability_outside(const GroundPolygon& polygon, const GroundPoint& mean, const Eigen::Matrix2d& cov) {
  const Geodetic here{mean.latitude_rad, mean.longitude_rad, 0};
  const Position<Ecef> origin = ecef_from_geodetic(here);
  const Rotation<Enu, Ecef> R_enu_ecef = enu_from_ecef_at(here);
  const Eigen::LLT<Eigen::Matrix2d> llt(cov + 1e-6 * Eigen::Matrix2d::Identity());
  // So far from the line that nothing is left on its other side.
  constexpr double certain = 9;  // sigmas
  const double distance = polygon.signed_distance_m(mean);
  if (distance * distance > certain * certain * (cov.trace() + 2e-6)) return distance > 0 ? 0 : 1;
  const auto whitened = [&](const Position<Ecef>& p) -> Eigen::Vector2d {
    return llt.matrixL().solve(ground_offset(origin, R_enu_ecef, p));
  };
  double turns = 0;
  double beyond = 0;
  Eigen::Vector2d a = whitened(polygon.outline().back());
  for (const Position<Ecef>& p : polygon.outline()) {
    const Eigen::Vector2d b = whitened(p);
    const EdgeShare share = share_of(a, b);
    turns += share.angle;
    beyond += share.beyond;
    a = b;
  }
  // Around the mean once: it is inside (on a corner, for its angle's part). Whole turns are taken as such, so that a
  // small probability keeps its digits.
  const double whole = std::round(turns);
  return std::clamp(1 - (std::abs(turns - whole) < 1e-6 ? whole : turns) + beyond, 0.0, 1.0);
}

}  // namespace downrange
