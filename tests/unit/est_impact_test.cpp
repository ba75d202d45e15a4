/// The impact point's covariance against draws, its velocity, the probability of being outside of a polygon.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/est/model/impact.hpp>
#include <downrange/geo/earth.hpp>
#include <downrange/geo/free_fall.hpp>
#include <numbers>
#include <random>

#include "../support/allocations.hpp"

namespace downrange {
namespace {

constexpr double deg = std::numbers::pi / 180;
const FallSettings ground{.height_m = 0, .horizon_s = 3600};

GroundPoint at(double latitude_deg, double longitude_deg) { return {latitude_deg * deg, longitude_deg * deg}; }

PositionVelocity state_of(const Vec<6>& x) { return {{x.head<3>()}, {x.tail<3>()}}; }

/// Velocity east, north, up; sigmas along all axes alike, position and velocity correlated as a track has them.
Gaussian<6> track(double latitude_deg, double longitude_deg, double height_m, const Eigen::Vector3d& enu_m_s,
                  double sigma_m, double sigma_m_s) {
  const Geodetic g{latitude_deg * deg, longitude_deg * deg, height_m};
  Gaussian<6> x;
  x.mean << ecef_from_geodetic(g).m, (enu_from_ecef_at(g).inverse() * Velocity<Enu>{enu_m_s}).m_s;
  x.cov.setZero();
  x.cov.topLeftCorner<3, 3>().diagonal().setConstant(sigma_m * sigma_m);
  x.cov.bottomRightCorner<3, 3>().diagonal().setConstant(sigma_m_s * sigma_m_s);
  x.cov.topRightCorner<3, 3>().diagonal().setConstant(0.6 * sigma_m * sigma_m_s);
  x.cov.bottomLeftCorner<3, 3>() = x.cov.topRightCorner<3, 3>();
  return x;
}

Gaussian<6> far_south(double sigma_m, double sigma_m_s) {
  return track(33, 127.8, 140e3, {250, -2000, 1500}, sigma_m, sigma_m_s);
}
/// Nearly an orbit, at perigee: comes down a quarter of the Earth away, and what is a little faster does not.
Gaussian<6> nearly_around(double sigma_m_s) { return track(5.2, -52.8, 180e3, {6900, 800, 500}, 30, sigma_m_s); }

Vec<6> drawn(const Gaussian<6>& x, std::mt19937_64& rng) {
  std::normal_distribution<double> normal;
  Vec<6> white;
  for (double& w : white) w = normal(rng);
  return x.mean + x.cov.llt().matrixL() * white;
}

/// Of 60 seeds, each a flight whose track errs as its covariance says: the share of true impact points inside the 95 %
/// ellipse about the track's.
double share_inside(const Gaussian<6>& truth, int* curved = nullptr) {
  constexpr int seeds = 60;
  constexpr int draws = 50;
  const auto exact = impact_of(truth, ground);
  int inside = 0;
  int count = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    std::mt19937_64 rng(static_cast<std::uint64_t>(seed));
    for (int i = 0; i < draws; ++i) {
      const Gaussian<6> track{.mean = drawn(truth, rng), .cov = truth.cov};
      const auto impact = impact_of(track, ground);
      if (!impact) continue;
      ++count;
      if (curved != nullptr && impact->curved) ++*curved;
      const Position<Ecef> mean = ecef_from_geodetic(impact->point);
      const Eigen::Vector2d off =
          ground_offset(mean, enu_from_ecef_at(impact->point), ecef_from_geodetic(exact->point));
      if (normalised_square<2>(off, impact->cov) <= chi2_quantile(0.95, 2)) ++inside;
    }
  }
  EXPECT_GT(count, 0.8 * seeds * draws) << "the others have a sigma point in orbit";
  return static_cast<double>(inside) / count;
}

TEST(Impact, CovarianceAgainstDraws) {
  int curved = 0;
  // 3000 draws leave a share of 0.95 uncertain by 0.004.
  EXPECT_NEAR(share_inside(far_south(10, 0.3), &curved), 0.95, 0.015);
  EXPECT_NEAR(share_inside(far_south(300, 5), &curved), 0.95, 0.015);
  EXPECT_NEAR(share_inside(track(34.2, 127.57, 30e3, {60, -400, 700}, 20, 1), &curved), 0.95, 0.015);
  EXPECT_NEAR(share_inside(nearly_around(0.2), &curved), 0.95, 0.015);
  EXPECT_EQ(curved, 0);
}

TEST(Impact, WhereTheFallIsCurvedSigmaPointsHoldIt) {
  int curved = 0;
  const double share = share_inside(nearly_around(80), &curved);
  EXPECT_GT(curved, 2000);
  EXPECT_GT(share, 0.92);
  EXPECT_LT(share, 0.97);
  const auto impact = impact_of(nearly_around(80), ground);
  ASSERT_TRUE(impact);
  EXPECT_TRUE(impact->curved);
  const Eigen::Matrix2d straight = impact->by_state * nearly_around(80).cov * impact->by_state.transpose();
  EXPECT_GT(impact->cov.trace(), 1.02 * straight.trace()) << "more spread towards the orbit than a straight one";
}

TEST(Impact, AStateThatDoesNotComeDownMakesItNone) {
  EXPECT_TRUE(impact_of(nearly_around(1), ground));
  EXPECT_FALSE(impact_of(nearly_around(400), ground)) << "one of its sigma points is in orbit";
  Gaussian<6> orbit = nearly_around(1);
  orbit.mean.tail<3>() *= 7800.0 / orbit.mean.tail<3>().norm();
  EXPECT_FALSE(impact_of(orbit, ground));
  Gaussian<6> broken = far_south(10, 1);
  broken.cov(2, 2) = -1;
  EXPECT_FALSE(impact_of(broken, ground));
  broken.cov(2, 2) = std::nan("");
  EXPECT_FALSE(impact_of(broken, ground));
}

TEST(Impact, ByStateAgainstCentralDifferences) {
  for (const Gaussian<6>& x : {far_south(10, 1), nearly_around(1), track(34.2, 127.57, 30e3, {60, -400, 700}, 20, 1),
                               track(69, 16, 200e3, {100, 4200, 1800}, 20, 1)}) {
    const auto impact = impact_of(x, ground);
    ASSERT_TRUE(impact);
    const Position<Ecef> origin = ecef_from_geodetic(impact->point);
    const auto off = [&](const Vec<6>& state) {
      return ground_offset(origin, enu_from_ecef_at(impact->point), fall_to(state_of(state), 0, 3600)->state.position);
    };
    for (int i = 0; i < 6; ++i) {
      const Vec<6> d = (i < 3 ? 5 : 0.01) * Vec<6>::Unit(i);
      const Eigen::Vector2d slope = (off(x.mean + d) - off(x.mean - d)) / (2 * d.norm());
      EXPECT_LT((impact->by_state.col(i) - slope).norm(), 1e-4 * slope.norm() + 1e-3) << i;
    }
  }
}

TEST(Impact, InFreeFallItStandsStillAndUnderThrustItMovesAsItDoes) {
  Gaussian<9> motion;
  motion.mean.head<6>() = far_south(10, 1).mean;
  const Vec<3> fall = free_fall_acceleration({motion.mean.head<3>()}, {motion.mean.segment<3>(3)});
  motion.mean.tail<3>() = fall;
  const auto impact = impact_of(far_south(10, 1), ground);
  ASSERT_TRUE(impact);
  EXPECT_LT(velocity_of(*impact, motion).m_s.norm(), 1e-9);
  // 20 m/s^2 along the flight: against the impact points of a tenth of a second before and after.
  const Vec<3> thrust = 20 * motion.mean.segment<3>(3).normalized();
  motion.mean.tail<3>() = fall + thrust;
  const Eigen::Vector2d moving = velocity_of(*impact, motion).m_s;
  const auto later = [&](double dt) {
    Vec<6> x = motion.mean.head<6>();
    x.head<3>() += dt * x.tail<3>() + dt * dt / 2 * motion.mean.tail<3>();
    x.tail<3>() += dt * motion.mean.tail<3>();
    return ground_offset(ecef_from_geodetic(impact->point), enu_from_ecef_at(impact->point),
                         fall_to(state_of(x), 0, 3600)->state.position);
  };
  const Eigen::Vector2d slope = (later(0.05) - later(-0.05)) / 0.1;
  EXPECT_GT(slope.norm(), 5000);
  EXPECT_LT((moving - slope).norm(), 1e-3 * slope.norm());
}

TEST(Impact, AllocatesNothing) {
  const GroundPolygon polygon({at(30, 120), at(30, 135), at(20, 135), at(20, 120)});
  const Gaussian<6> straight = far_south(10, 1);
  const Gaussian<6> curved = nearly_around(80);
  ASSERT_TRUE(impact_of(curved, ground)->curved);  // and what is made once, is made
  (void)probability_outside(polygon, at(25, 128), Eigen::Matrix2d::Identity() * 1e10);
  (void)polygon.signed_distance_m(at(25, 128));
  EXPECT_EQ(test::allocations_of([&] {
              for (const Gaussian<6>& x : {straight, curved}) {
                const auto impact = impact_of(x, ground);
                (void)polygon.signed_distance_m(impact->ground());
                (void)polygon.distance_ahead_m(impact->ground(), 1);
                (void)probability_outside(polygon, impact->ground(), impact->cov);
              }
            }),
            0u);
}

/// Upper tail of the standard normal distribution.
double tail(double sigmas) { return std::erfc(sigmas / std::numbers::sqrt2) / 2; }

TEST(ProbabilityOutside, NearOneEdgeIsTheTailOfANormalDistribution) {
  const GroundPolygon polygon({at(-3, -3), at(-3, 3), at(3, 3), at(3, -3)});
  for (const double sigmas : {0.0, 0.5, 1.0, 2.0, 3.0, 5.0, 6.5}) {
    const double sigma_m = 10'000;
    // Near the equator the eastern edge is a meridian.
    const double longitude_deg = 3 - sigmas * sigma_m / (6378137.0 * deg);
    const Eigen::Matrix2d cov = sigma_m * sigma_m * Eigen::Matrix2d::Identity();
    const double expected = tail(sigmas);
    EXPECT_NEAR(probability_outside(polygon, at(0, longitude_deg), cov), expected, 0.01 * expected) << sigmas;
    const double mirrored = 6 - longitude_deg;
    EXPECT_NEAR(1 - probability_outside(polygon, at(0, mirrored), cov), expected, 0.01 * expected + 1e-15) << sigmas;
  }
}

TEST(ProbabilityOutside, AgainstDraws) {
  const GroundPolygon polygon({at(0, 0), at(0.5, 2), at(2, 2.5), at(1.2, 1.2), at(2.5, 0.3)});  // not convex
  std::mt19937_64 rng(5);
  std::normal_distribution<double> normal;
  Eigen::Matrix2d cov;
  cov << 6e9, 3e9, 3e9, 3e9;
  const Eigen::Matrix2d L = cov.llt().matrixL();
  for (const GroundPoint& mean : {at(1, 1), at(1.5, 1.7), at(3, 0), at(0.2, 0.3)}) {
    const Geodetic g{mean.latitude_rad, mean.longitude_rad, 0};
    const Site here(g);
    int outside = 0;
    constexpr int draws = 40'000;
    for (int i = 0; i < draws; ++i) {
      const Eigen::Vector2d off = L * Eigen::Vector2d(normal(rng), normal(rng));
      const Geodetic there = geodetic_from_ecef(here.ecef_of({{off.x(), off.y(), 0}}));
      if (!polygon.contains({there.latitude_rad, there.longitude_rad})) ++outside;
    }
    // Five sigmas of the draws; the plane that touches here is not the ellipsoid to 1e-3.
    EXPECT_NEAR(probability_outside(polygon, mean, cov), static_cast<double>(outside) / draws, 0.0135);
  }
}

TEST(ProbabilityOutside, CertainAndImpossible) {
  const GroundPolygon polygon({at(70, 0), at(75, 60), at(68, 120), at(72, 180), at(70, 240), at(74, 300)});
  const Eigen::Matrix2d cov = 1e6 * Eigen::Matrix2d::Identity();
  EXPECT_EQ(probability_outside(polygon, at(90, 0), cov), 0);
  EXPECT_EQ(probability_outside(polygon, at(85, 179), cov), 0);
  EXPECT_EQ(probability_outside(polygon, at(0, 0), cov), 1);
  EXPECT_EQ(probability_outside(polygon, at(-89, 10), cov), 1) << "the other side of the Earth";
  EXPECT_EQ(probability_outside(polygon, at(85, 179), Eigen::Matrix2d::Zero()), 0);
  // On the line itself, at a corner of 90 deg: three quarters.
  const GroundPolygon square({at(0, 0), at(0, 3), at(3, 3), at(3, 0)});
  EXPECT_NEAR(probability_outside(square, at(0, 0), cov), 0.75, 1e-3);
  EXPECT_NEAR(probability_outside(square, at(1.5, 0), cov), 0.5, 1e-3);
}

}  // namespace
}  // namespace downrange
