/// The launch trajectory against vectors computed elsewhere, and the laws its integration must obey.
#include <gtest/gtest.h>

#include <cmath>
#include <downrange/geo/earth.hpp>

#include "../support/vectors.hpp"
#include "sim/launch_trajectory.hpp"

namespace downrange::sim {
namespace {

constexpr Time liftoff{1'772'352'000'000'000'000};

TEST(LaunchTrajectory, EqualsTheReferenceAtOneHertz) {
  DOWNRANGE_VECTOR_CASES(cases, "launch_trajectory.json");
  const LaunchTrajectory trajectory(naro_launch_profile(), liftoff, 480);
  const Site pad(naro_launch_profile().pad);
  const auto& times = cases[0]["t"];
  ASSERT_EQ(times.size(), 481u);
  for (std::size_t i = 0; i < times.size(); ++i) {
    const Time t = liftoff + seconds(times[i].get<double>());
    const Eigen::VectorXd expected = test::vector_of(cases[0]["pva"][i]);
    const auto state = trajectory.at(t);
    const auto acceleration = trajectory.acceleration(t);
    ASSERT_TRUE(state && acceleration);
    const Eigen::Vector3d p = pad.enu_of(state->position).m;
    const Eigen::Vector3d v = (pad.R_enu_ecef() * state->velocity).m_s;
    const Eigen::Vector3d a = pad.R_enu_ecef().R * *acceleration;
    // The reference steps across the corners of the pitch table: until the first, at 15 s, the two agree to rounding,
    // then differ by 1e-5 m/s, 5 mm in 1 100 km at the end. The accelerations stay equal.
    const bool straight = times[i].get<double>() < 15;
    EXPECT_LT((p - expected.segment<3>(0)).norm(), straight ? 1e-7 : 6e-3) << times[i];
    EXPECT_LT((v - expected.segment<3>(3)).norm(), straight ? 1e-7 : 5e-5) << times[i];
    EXPECT_LT((a - expected.segment<3>(6)).norm(), 1e-9 * a.norm() + 1e-8) << times[i];
  }
}

TEST(LaunchTrajectory, HalvingTheStepMovesNothing) {
  const LaunchTrajectory coarse(naro_launch_profile(), liftoff, 480);
  const LaunchTrajectory fine(naro_launch_profile(), liftoff, 480, 0.025);
  for (double t_s = 0.017; t_s < 480; t_s += 0.731) {  // between the nodes of both: interpolation error included
    const auto a = coarse.at(liftoff + seconds(t_s));
    const auto b = fine.at(liftoff + seconds(t_s));
    EXPECT_LT((a->position.m - b->position.m).norm(), 1e-4) << t_s;
    EXPECT_LT((a->velocity.m_s - b->velocity.m_s).norm(), 1e-4) << t_s;
  }
}

TEST(LaunchTrajectory, ErrorFallsWithTheFourthPowerOfTheStep) {
  const Time end = liftoff + seconds(480);
  const auto position = [&](double step_s) {
    return LaunchTrajectory(naro_launch_profile(), liftoff, 480, step_s).at(end)->position.m;
  };
  const Eigen::Vector3d exact = position(0.05);
  const double ratio = (position(4) - exact).norm() / (position(2) - exact).norm();
  EXPECT_GT(ratio, 12);  // 16 for a fourth-order method; a step across a cut-off would give 2
  EXPECT_LT(ratio, 20);
}

TEST(LaunchTrajectory, CoastingKeepsTheEnergyOfTheRotatingFrame) {
  // Jacobi integral: v^2/2 - w^2 (x^2 + y^2)/2 + potential is constant where no thrust acts.
  const auto potential = [](const Eigen::Vector3d& p) {
    const double r = p.norm();
    const double s = p.z() / r;
    const double ratio = wgs84::semi_major_axis_m / r;
    return -wgs84::gm_m3_s2 / r * (1 - wgs84::j2 * ratio * ratio * (1.5 * s * s - 0.5));
  };
  const auto energy = [&](const score::TrueState& x) {
    const double w = wgs84::rotation_rate_rad_s;
    return 0.5 * x.velocity.m_s.squaredNorm() - 0.5 * w * w * x.position.m.head<2>().squaredNorm() +
           potential(x.position.m);
  };
  const LaunchTrajectory trajectory(naro_launch_profile(), liftoff, 480);
  const double begin = energy(*trajectory.at(liftoff + seconds(229)));
  for (double t_s = 230; t_s <= 395; t_s += 5)
    EXPECT_NEAR(energy(*trajectory.at(liftoff + seconds(t_s))), begin, 1e-3) << t_s;  // of 6e7 m^2/s^2
  EXPECT_GT(std::abs(energy(*trajectory.at(liftoff + seconds(400))) - begin), 1e3);
}

TEST(LaunchTrajectory, StandsOnThePadBeforeLiftoffAndEndsAtTheEnd) {
  const LaunchTrajectory trajectory(naro_launch_profile(), liftoff, 480);
  const auto before = trajectory.at(liftoff - seconds(3600));
  ASSERT_TRUE(before);
  EXPECT_EQ(before->position.m, ecef_from_geodetic(naro_launch_profile().pad).m);
  EXPECT_EQ(before->velocity.m_s, Eigen::Vector3d::Zero());
  EXPECT_EQ(*trajectory.acceleration(liftoff - seconds(1)), Eigen::Vector3d::Zero());
  EXPECT_TRUE(trajectory.at(liftoff + seconds(480)));
  EXPECT_FALSE(trajectory.at(liftoff + seconds(480) + Duration{1}));
  EXPECT_FALSE(trajectory.acceleration(liftoff + seconds(481)));
}

TEST(LaunchTrajectory, RefusesAnEmptyProfile) {
  LaunchProfile profile = naro_launch_profile();
  profile.burns.clear();
  EXPECT_THROW(LaunchTrajectory(profile, liftoff, 480), std::invalid_argument);
  EXPECT_THROW(LaunchTrajectory(naro_launch_profile(), liftoff, 0), std::invalid_argument);
}

}  // namespace
}  // namespace downrange::sim
