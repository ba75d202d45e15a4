/// Truth between its samples.
#include <gtest/gtest.h>

#include <stdexcept>

#include "score/truth.hpp"

namespace downrange::score {
namespace {

TEST(TruthTable, IsExactForACubic) {
  const auto state = [](double t) {
    const Eigen::Vector3d c0(1, 2, 3), c1(4, -5, 6), c2(0.7, 0.8, -0.9), c3(-0.01, 0.02, 0.03);
    return TrueState{{c0 + t * (c1 + t * (c2 + t * c3))}, {c1 + t * (2 * c2 + t * 3 * c3)}};
  };
  std::vector<TruthSample> samples;
  for (const double t : {0.0, 1.0, 2.5, 7.0}) samples.push_back({Time{0} + seconds(t), state(t)});
  const TruthTable table(samples);
  for (const double t : {0.0, 0.3, 1.0, 2.0, 2.5, 6.99, 7.0}) {
    const auto x = table.at(Time{0} + seconds(t));
    ASSERT_TRUE(x) << t;
    EXPECT_LT((x->position.m - state(t).position.m).norm(), 1e-12) << t;
    EXPECT_LT((x->velocity.m_s - state(t).velocity.m_s).norm(), 1e-12) << t;
  }
  EXPECT_FALSE(table.at(Time{-1}));
  EXPECT_FALSE(table.at(Time{0} + seconds(7) + Duration{1}));
}

TEST(TruthTable, RefusesTimesThatDoNotIncrease) {
  const TrueState rest{{Eigen::Vector3d::Zero()}, {Eigen::Vector3d::Zero()}};
  EXPECT_THROW(TruthTable({{Time{1}, rest}}), std::invalid_argument);
  EXPECT_THROW(TruthTable({{Time{1}, rest}, {Time{1}, rest}}), std::invalid_argument);
  EXPECT_THROW(TruthTable({{Time{2}, rest}, {Time{1}, rest}}), std::invalid_argument);
}

}  // namespace
}  // namespace downrange::score
