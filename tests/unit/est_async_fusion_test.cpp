/// Optimal asynchronous fusion: reference vectors, the identity with the sequential filter, and its edges.
#include <gtest/gtest.h>

#include <algorithm>
#include <downrange/est/filter/async_fusion.hpp>
#include <downrange/est/model/motion.hpp>
#include <limits>
#include <random>
#include <vector>

#include "../support/vectors.hpp"

namespace downrange {
namespace {

using test::matrix_of;
using test::relative_error;
using test::vector_of;

struct Batch {
  Gaussian<6> previous;
  double T = 0;
  double q = 0;
  std::vector<TimedPosition> positions;
};

/// The sequential Kalman filter over the same data: predict to each epoch in turn, update, predict to the end.
Gaussian<6> sequential(const Batch& b) {
  std::vector<TimedPosition> ordered = b.positions;
  std::stable_sort(ordered.begin(), ordered.end(), [](const auto& x, const auto& y) { return x.age_s > y.age_s; });
  const Mat<3, 6> H = (Mat<3, 6>() << Mat<3, 3>::Identity(), Mat<3, 3>::Zero()).finished();
  Gaussian<6> x = b.previous;
  double age = b.T;
  for (const TimedPosition& z : ordered) {
    x = cv::predict(x, age - z.age_s, b.q);
    age = z.age_s;
    x = kalman_update<6, 3>(x, z.z - H * x.mean, H, z.R, std::numeric_limits<double>::infinity()).posterior;
  }
  return cv::predict(x, age, b.q);
}

TEST(AsyncFusion, Vectors) {
  DOWNRANGE_VECTOR_CASES(cases, "async_fusion.json");
  for (const auto& c : cases) {
    Batch b;
    b.previous.mean = vector_of(c["x0"]);
    b.previous.cov = matrix_of(c["P0"]);
    const double t1 = c["t1"];
    b.T = t1 - c["t0"].get<double>();
    b.q = c["q"];
    for (std::size_t i = 0; i < c["times"].size(); ++i)
      b.positions.push_back({t1 - c["times"][i].get<double>(), vector_of(c["Z"][i]), matrix_of(c["R"][i])});
    const Gaussian<6> fused = fuse_asynchronous(b.previous, b.T, b.positions, b.q);
    EXPECT_LT(relative_error(fused.mean, vector_of(c["x"])), 1e-9);
    EXPECT_LT(relative_error(fused.cov, matrix_of(c["P"])), 1e-9);
    EXPECT_LT(relative_error(fused.mean, vector_of(c["seq_x"])), 1e-9);
    EXPECT_LT(relative_error(fused.cov, matrix_of(c["seq_P"])), 1e-9);
  }
}

TEST(MotionVectors, ConstantVelocity) {
  DOWNRANGE_VECTOR_CASES(cases, "models.json");
  int checked = 0;
  for (const auto& c : cases) {
    if (c["model"] != "cv" || c["d"] != 3) continue;
    ++checked;
    EXPECT_LT(relative_error(cv::transition(c["T"]), matrix_of(c["F"])), 1e-9);
    EXPECT_LT(relative_error(cv::process_noise(c["T"], c["q"]), matrix_of(c["Q"])), 1e-9);
  }
  EXPECT_GT(checked, 0);
}

TEST(AsyncFusion, EqualsSequentialFilterForRandomBatchesInAnyOrder) {
  std::mt19937_64 rng(7);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int run = 0; run < 200; ++run) {
    Batch b;
    b.T = 0.01 + uniform(rng);
    b.q = std::pow(10.0, 4 * uniform(rng));
    Mat<6, 6> A = Mat<6, 6>::NullaryExpr([&] { return normal(rng); });
    b.previous.cov = A * A.transpose() * 100 + Mat<6, 6>::Identity();
    b.previous.mean.head<3>() = Vec<3>::NullaryExpr([&] { return 6e6 * normal(rng); });  // as large as in ECEF
    b.previous.mean.tail<3>() = Vec<3>::NullaryExpr([&] { return 7e3 * normal(rng); });
    const int n = 1 + static_cast<int>(uniform(rng) * (max_batch - 1));
    for (int i = 0; i < n; ++i) {
      const Mat<3, 3> B = Mat<3, 3>::NullaryExpr([&] { return normal(rng); });
      const double age = i % 3 == 2 ? b.positions.back().age_s : b.T * uniform(rng);  // equal times among them
      b.positions.push_back({age, b.previous.mean.head<3>() + Vec<3>::NullaryExpr([&] { return 30 * normal(rng); }),
                             B * B.transpose() * 400 + Mat<3, 3>::Identity()});
    }
    const Gaussian<6> expected = sequential(b);
    const Gaussian<6> fused = fuse_asynchronous(b.previous, b.T, b.positions, b.q);
    const Vec<6> sigma = expected.cov.diagonal().cwiseSqrt();
    // Positions of 6e6 m carry 1e-9 m of rounding a step, and the sequential filter takes up to 15 steps of it.
    EXPECT_LT((fused.mean - expected.mean).cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 1e-8) << "run " << run;
    EXPECT_LT(relative_error(fused.cov, expected.cov), 1e-9) << "run " << run;

    std::shuffle(b.positions.begin(), b.positions.end(), rng);
    const Gaussian<6> shuffled = fuse_asynchronous(b.previous, b.T, b.positions, b.q);
    EXPECT_LT(relative_error(shuffled.cov, fused.cov), 1e-9);
  }
}

}  // namespace
}  // namespace downrange
