/// Planned trajectories: what stands between samples, velocities that a plan does not tell.
#include <gtest/gtest.h>

#include <cmath>
#include <downrange/geo/nominal_trajectory.hpp>
#include <limits>
#include <stdexcept>

namespace downrange {
namespace {

/// A cubic in each axis: what Hermite interpolation meets exactly.
PositionVelocity cubic(double t) {
  const Eigen::Vector3d a(6.4e6, 10, -20);
  const Eigen::Vector3d b(1, 200, 30);
  const Eigen::Vector3d c(0.5, -4, 9);
  const Eigen::Vector3d d(0.01, 0.02, -0.03);
  return {{a + t * (b + t * (c + t * d))}, {b + t * (2 * c + t * 3 * d)}};
}

std::vector<NominalSample> samples_of(const std::vector<double>& times) {
  std::vector<NominalSample> samples;
  for (const double t : times) samples.push_back({t, cubic(t)});
  return samples;
}

TEST(NominalTrajectory, IsExactForACubicAndMeetsItsSamples) {
  const NominalTrajectory nominal(samples_of({-3, 0, 1, 4.5}));
  for (const double t : {-3.0, -1.7, 0.0, 0.25, 1.0, 3.0, 4.5}) {
    const auto at = nominal.at(t);
    ASSERT_TRUE(at) << t;
    EXPECT_LT((at->position.m - cubic(t).position.m).norm(), 1e-8) << t;
    EXPECT_LT((at->velocity.m_s - cubic(t).velocity.m_s).norm(), 1e-8) << t;
  }
}

TEST(NominalTrajectory, SaysNothingOutsideOfItsSamples) {
  const NominalTrajectory nominal(samples_of({0, 1}));
  EXPECT_FALSE(nominal.at(-1e-9));
  EXPECT_FALSE(nominal.at(1 + 1e-9));
  EXPECT_FALSE(nominal.at(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_FALSE(NominalTrajectory().at(0));
  EXPECT_TRUE(NominalTrajectory().empty());
}

TEST(NominalTrajectory, RefusesWhatIsNoTrajectory) {
  EXPECT_THROW(NominalTrajectory(samples_of({0})), std::invalid_argument);
  EXPECT_THROW(NominalTrajectory(samples_of({0, 0})), std::invalid_argument);
  EXPECT_THROW(NominalTrajectory(samples_of({1, 0})), std::invalid_argument);
  auto infinite = samples_of({0, 1});
  infinite[1].state.position.m.x() = std::numeric_limits<double>::infinity();
  EXPECT_THROW(NominalTrajectory{infinite}, std::invalid_argument);
}

TEST(WithVelocities, AreExactForConstantAccelerationWhateverTheSpacing) {
  const Eigen::Vector3d acceleration(1, -2, 3);
  const Eigen::Vector3d start(7, 8, 9);
  std::vector<NominalSample> samples;
  for (const double t : {0.0, 1.0, 1.5, 4.0, 4.1}) {
    samples.push_back({t, {{Eigen::Vector3d(6.4e6, 0, 0) + t * start + t * t / 2 * acceleration}, {}}});
  }
  for (const NominalSample& s : with_velocities(samples))
    EXPECT_LT((s.state.velocity.m_s - (start + s.t_s * acceleration)).norm(), 1e-7) << s.t_s;
  samples.resize(2);
  for (const NominalSample& s : with_velocities(samples))
    EXPECT_LT((s.state.velocity.m_s - (start + 0.5 * acceleration)).norm(), 1e-7) << "two samples: the chord";
}

}  // namespace
}  // namespace downrange
