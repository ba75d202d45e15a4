/// Assignment against trying everything; OSPA and GOSPA against hand-computed sets and as metrics.
#include <gtest/gtest.h>

#include <cmath>
#include <downrange/est/track/assignment.hpp>
#include <downrange/est/track/multi_target.hpp>
#include <limits>
#include <random>
#include <vector>

namespace downrange {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Least cost over all ways to give each row from `row` on a free column or none.
double exhaustive(const std::vector<double>& cost, int rows, int columns, double miss, std::vector<bool>& used,
                  int row = 0) {
  if (row == rows) return 0;
  double best = miss + exhaustive(cost, rows, columns, miss, used, row + 1);
  for (int j = 0; j < columns; ++j) {
    const double c = cost[static_cast<std::size_t>(row * columns + j)];
    if (used[static_cast<std::size_t>(j)] || std::isnan(c)) continue;
    used[static_cast<std::size_t>(j)] = true;
    best = std::min(best, c + exhaustive(cost, rows, columns, miss, used, row + 1));
    used[static_cast<std::size_t>(j)] = false;
  }
  return best;
}

TEST(Assignment, EqualsTryingEverything) {
  std::mt19937_64 rng(21);
  std::uniform_real_distribution<double> uniform(-3, 10);
  Assignment assignment;
  for (int run = 0; run < 2000; ++run) {
    const int rows = static_cast<int>(rng() % 6);
    const int columns = static_cast<int>(rng() % 6);
    std::vector<double> cost(static_cast<std::size_t>(rows * columns));
    for (double& c : cost) {
      c = run % 2 == 0 ? uniform(rng) : std::floor(uniform(rng));  // ties among them
      if (rng() % 5 == 0) c = infinity;
      if (rng() % 50 == 0) c = std::nan("");
    }
    const double miss = uniform(rng);
    const auto column = assignment.solve(cost, rows, columns, miss);
    std::vector<bool> used(static_cast<std::size_t>(columns), false);
    double sum = 0;
    for (int i = 0; i < rows; ++i) {
      const int j = column[static_cast<std::size_t>(i)];
      sum += j == Assignment::none ? miss : cost[static_cast<std::size_t>(i * columns + j)];
      if (j == Assignment::none) continue;
      ASSERT_FALSE(used[static_cast<std::size_t>(j)]) << "a column given twice, run " << run;
      used[static_cast<std::size_t>(j)] = true;
    }
    used.assign(used.size(), false);
    ASSERT_NEAR(sum, exhaustive(cost, rows, columns, miss, used), 1e-12) << "run " << run;
    EXPECT_DOUBLE_EQ(assignment.total(), sum);
  }
}

TEST(Assignment, GlobalIsNotGreedy) {
  // The cheapest pair (0, 0) first would force (1, 1) at 10: 11 instead of 2 + 3.
  Assignment assignment;
  const auto column = assignment.solve(std::vector<double>{1, 2, 3, 10}, 2, 2, 100);
  EXPECT_EQ(column[0], 1);
  EXPECT_EQ(column[1], 0);
  EXPECT_DOUBLE_EQ(assignment.total(), 5);
}

std::vector<Eigen::Vector3d> on_a_line(std::initializer_list<double> xs) {
  std::vector<Eigen::Vector3d> points;
  for (const double x : xs) points.emplace_back(x, 0, 0);
  return points;
}

TEST(Ospa, HandComputed) {
  SetDistance one(10, 1);
  SetDistance two(10, 2);
  const auto none = on_a_line({});
  EXPECT_EQ(one.ospa(none, none), 0);
  EXPECT_DOUBLE_EQ(one.ospa(on_a_line({0}), none), 10);
  EXPECT_DOUBLE_EQ(one.ospa(on_a_line({0, 100}), on_a_line({101, 3})), 2);             // (3 + 1) / 2
  EXPECT_DOUBLE_EQ(two.ospa(on_a_line({0, 100}), on_a_line({101, 3})), std::sqrt(5));  // (9 + 1) / 2
  EXPECT_DOUBLE_EQ(one.ospa(on_a_line({0, 100}), on_a_line({1})), 5.5);                // (1 + 10) / 2
  EXPECT_DOUBLE_EQ(one.ospa(on_a_line({0}), on_a_line({50})), 10);                     // cut off
  EXPECT_DOUBLE_EQ(one.ospa(on_a_line({std::nan("")}), on_a_line({50})), 10);
}

TEST(Gospa, HandComputed) {
  SetDistance two(10, 2);
  const Gospa g = two.gospa(on_a_line({0, 100, 200}), on_a_line({103, 4, 500, 600}));
  EXPECT_EQ(g.pairs, 2);
  EXPECT_EQ(g.missed, 1);
  EXPECT_EQ(g.false_tracks, 2);
  EXPECT_DOUBLE_EQ(g.localisation, 25);
  EXPECT_DOUBLE_EQ(g.distance, std::sqrt(25 + 3 * 50));
  // Just inside the cut-off a pair is still cheaper than one missed and one false.
  EXPECT_EQ(two.gospa(on_a_line({0}), on_a_line({9.9})).pairs, 1);
  EXPECT_DOUBLE_EQ(two.gospa(on_a_line({0}), on_a_line({50})).distance, 10);
}

TEST(SetDistances, AreMetrics) {
  std::mt19937_64 rng(4);
  std::uniform_real_distribution<double> uniform(0, 20);
  SetDistance distance(7, 2);
  const auto draw = [&] {
    std::vector<Eigen::Vector3d> set(rng() % 5);
    for (auto& p : set) p = Eigen::Vector3d(uniform(rng), uniform(rng), uniform(rng));
    return set;
  };
  for (int run = 0; run < 500; ++run) {
    const auto a = draw();
    const auto b = draw();
    const auto c = draw();
    EXPECT_NEAR(distance.ospa(a, b), distance.ospa(b, a), 1e-12);
    EXPECT_NEAR(distance.gospa(a, b).distance, distance.gospa(b, a).distance, 1e-12);
    EXPECT_LE(distance.ospa(a, c), distance.ospa(a, b) + distance.ospa(b, c) + 1e-12);
    EXPECT_LE(distance.gospa(a, c).distance, distance.gospa(a, b).distance + distance.gospa(b, c).distance + 1e-12);
    EXPECT_EQ(distance.ospa(a, a), 0);
  }
}

}  // namespace
}  // namespace downrange
