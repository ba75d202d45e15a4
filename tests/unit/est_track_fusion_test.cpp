/// Fusion of tracks: reference vectors, the identities with the centralised filter, honesty over Monte Carlo runs.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/est/track/track_fusion.hpp>
#include <limits>
#include <random>

#include "../support/vectors.hpp"

namespace downrange {
namespace {

using test::matrix_of;
using test::relative_error;
using test::vector_of;

constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(TrackFusion, Vectors) {
  DOWNRANGE_VECTOR_CASES(cases, "track_fusion.json");
  for (const auto& c : cases) {
    const Gaussian<2> i{vector_of(c["xi"]), matrix_of(c["Pi"])};
    const Gaussian<2> j{vector_of(c["xj"]), matrix_of(c["Pj"])};
    const std::array<Gaussian<2>, 2> both{i, j};
    const auto convex = fuse_convex<2>(both);
    EXPECT_LT(relative_error(convex.state.mean, vector_of(c["convex_x"])), 1e-12);
    EXPECT_LT(relative_error(convex.state.cov, matrix_of(c["convex_P"])), 1e-12);
    const auto campo = fuse_bar_shalom_campo<2>(i, j, matrix_of(c["Pij"]));
    EXPECT_LT(relative_error(campo.state.mean, vector_of(c["bsc_x"])), 1e-12);
    EXPECT_LT(relative_error(campo.state.cov, matrix_of(c["bsc_P"])), 1e-12);
    MapFusion<2, 2> map(vector_of(c["x_prior"]), matrix_of(c["joint_cov_prior_i_j"]));
    const auto fused = map.fuse(std::array<Vec<2>, 2>{i.mean, j.mean});
    // The vectors have no ridge: its 1e-7 is what is left.
    EXPECT_LT(relative_error(fused.state.mean, vector_of(c["map_x"])), 1e-5);
    EXPECT_LT(relative_error(fused.state.cov, matrix_of(c["map_P"])), 1e-5);
  }
}

TEST(FederatedFilter, Vectors) {
  DOWNRANGE_VECTOR_CASES(cases, "federated_step.json");
  for (const auto& c : cases) {
    const Mat<2, 4> H = matrix_of(c["H"]);
    FederatedFilter<4, 2> filter({vector_of(c["x"]), matrix_of(c["P"])},
                                 {c["beta"][0].get<double>(), c["beta"][1].get<double>()});
    filter.predict(matrix_of(c["F"]), matrix_of(c["Q"]));
    for (int i = 0; i < 2; ++i) {
      const double beta = c["beta"][static_cast<std::size_t>(i)];
      EXPECT_LT(relative_error(filter.local(i).mean, vector_of(c["xp"])), 1e-12);
      EXPECT_LT(relative_error(filter.local(i).cov, beta * matrix_of(c["Pp"])), 1e-12);
      const auto s = static_cast<std::size_t>(i);
      const Vec<2> nu = vector_of(c["z"][s]) - H * filter.local(i).mean;
      (void)filter.update<2>(i, nu, H, matrix_of(c["R"][s]), infinity);
      EXPECT_LT(relative_error(filter.local(i).mean, vector_of(c["local_x"][s])), 1e-12);
      EXPECT_LT(relative_error(filter.local(i).cov, matrix_of(c["local_P"][s])), 1e-12);
    }
    const auto fused = filter.fuse();
    EXPECT_LT(relative_error(fused.state.mean, vector_of(c["x_fused"])), 1e-12);
    EXPECT_LT(relative_error(fused.state.cov, matrix_of(c["P_fused"])), 1e-12);
    EXPECT_LT(relative_error(filter.local(1).cov, c["beta"][1].get<double>() * matrix_of(c["P_fused"])), 1e-12);
  }
}

/// Two sensors, one target in one axis: position and velocity, white acceleration.
struct Pair {
  static constexpr double T = 1;
  Mat<2, 2> F = (Mat<2, 2>() << 1, T, 0, 1).finished();
  Mat<2, 2> Q = 0.04 * (Mat<2, 2>() << T * T * T / 3, T* T / 2, T* T / 2, T).finished();
  Mat<1, 2> H = Mat<1, 2>(1, 0);
  std::array<double, 2> r{1, 4};  ///< variances
  Mat<2, 2> P0 = Vec<2>(9, 1).asDiagonal();

  [[nodiscard]] Gaussian<2> predicted(const Gaussian<2>& x) const {
    return {F * x.mean, symmetric<2>(F * x.cov * F.transpose() + Q)};
  }
  [[nodiscard]] Vec<2> gain(const Gaussian<2>& prior, int sensor) const {
    return prior.cov * H.transpose() / ((H * prior.cov * H.transpose())(0, 0) + r[static_cast<std::size_t>(sensor)]);
  }
  [[nodiscard]] Gaussian<2> updated(const Gaussian<2>& prior, double z, int sensor) const {
    return kalman_update<2, 1>(prior, Vec<1>(z) - H * prior.mean, H, Mat<1, 1>(r[static_cast<std::size_t>(sensor)]),
                               infinity)
        .posterior;
  }
};

struct Truth {
  Vec<2> x;
  std::mt19937_64 rng;
  std::normal_distribution<double> normal;

  Truth(std::uint64_t seed, const Pair& pair) : rng(seed) {
    x = pair.P0.diagonal().cwiseSqrt().cwiseProduct(Vec<2>::NullaryExpr([&] { return normal(rng); }));
  }
  void step(const Pair& pair) {
    const Mat<2, 2> root = pair.Q.llt().matrixL();
    x = pair.F * x + root * Vec<2>::NullaryExpr([&] { return normal(rng); });
  }
  double measure(const Pair& pair, std::size_t sensor) { return x[0] + std::sqrt(pair.r[sensor]) * normal(rng); }
};

TEST(TrackFusion, InformationAndFederatedEqualTheCentralisedFilter) {
  const Pair pair;
  Truth truth(3, pair);
  Gaussian<2> centralised{Vec<2>::Zero(), pair.P0};
  Gaussian<2> informed = centralised;
  FederatedFilter<2, 2> federated(centralised, {1.25, 5});
  // Local tracks may start from anything: what they learn is the same.
  std::array<Gaussian<2>, 2> local{Gaussian<2>{Vec<2>(3, 1), pair.P0 * 2}, Gaussian<2>{Vec<2>(-1, 0), pair.P0 / 2}};
  for (int k = 0; k < 200; ++k) {
    truth.step(pair);
    centralised = pair.predicted(centralised);
    informed = pair.predicted(informed);
    federated.predict(pair.F, pair.Q);
    std::array<TrackReport<2>, 2> reports;
    for (int i = 0; i < 2; ++i) {
      const auto s = static_cast<std::size_t>(i);
      const double z = truth.measure(pair, s);
      centralised = pair.updated(centralised, z, i);
      reports[s].predicted = pair.predicted(local[s]);
      reports[s].updated = local[s] = pair.updated(reports[s].predicted, z, i);
      (void)federated.update<1>(i, Vec<1>(z) - pair.H * federated.local(i).mean, pair.H, Mat<1, 1>(pair.r[s]),
                                infinity);
    }
    informed = fuse_information<2>(informed, reports).state;
    (void)federated.fuse();
    const Vec<2> sigma = centralised.cov.diagonal().cwiseSqrt();
    for (const Gaussian<2>& other : {informed, federated.state()}) {
      EXPECT_LT((other.mean - centralised.mean).cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 1e-9) << k;
      EXPECT_LT(relative_error(other.cov, centralised.cov), 1e-9) << k;
    }
  }
}

TEST(TrackFusion, EvidenceOfInformationIsThatOfTheMeasurement) {
  const Pair pair;
  const Gaussian<2> prior = pair.predicted({Vec<2>(1, 2), pair.P0});
  const auto u = kalman_update<2, 1>(prior, Vec<1>(2.5), pair.H, Mat<1, 1>(1.0), infinity);
  const TrackReport<2> report{prior, u.posterior};
  const auto fused = fuse_information<2>(prior, std::span(&report, 1));
  EXPECT_EQ(fused.dof, 1);
  EXPECT_NEAR(fused.nis, u.nis, 1e-9);
}

/// What each rule made of many runs at their last step.
struct Scores {
  double square = 0;
  double nees = 0;
  double nis = 0;
};

TEST(TrackFusion, RulesThatKnowTheCrossCovarianceAreHonest) {
  // 2000 runs of 30 steps; the bands have 1e-4 false alarms each.
  const Pair pair;
  constexpr int runs = 2000;
  Scores convex, campo, map, information;
  for (int run = 0; run < runs; ++run) {
    Truth truth(static_cast<std::uint64_t>(run) + 100, pair);
    const Gaussian<2> start{Vec<2>::Zero(), pair.P0};
    std::array<Gaussian<2>, 2> local{start, start};
    Mat<2, 2> cross = pair.P0;
    MapFusion<2, 2> mapped(start);
    Gaussian<2> informed = start;
    FusedTrack<2> of_convex, of_campo, of_map, of_information;
    for (int k = 0; k < 30; ++k) {
      truth.step(pair);
      mapped.predict(pair.F, pair.Q);
      cross = cross_covariance_predicted<2>(cross, pair.F, pair.Q);
      std::array<Mat<2, 2>, 2> ImKH;
      std::array<TrackReport<2>, 2> reports;
      for (int i = 0; i < 2; ++i) {
        const auto s = static_cast<std::size_t>(i);
        reports[s].predicted = pair.predicted(local[s]);
        const Vec<2> K = pair.gain(reports[s].predicted, i);
        ImKH[s] = Mat<2, 2>::Identity() - K * pair.H;
        reports[s].updated = local[s] = pair.updated(reports[s].predicted, truth.measure(pair, s), i);
        mapped.updated<1>(i, K, pair.H, Mat<1, 1>(pair.r[s]));
      }
      cross = cross_covariance_updated<2>(ImKH[0], cross, ImKH[1]);
      of_convex = fuse_convex<2>(local);
      of_campo = fuse_bar_shalom_campo<2>(local[0], local[1], cross);
      of_map = mapped.fuse(std::array<Vec<2>, 2>{local[0].mean, local[1].mean});
      of_information = fuse_information<2>(pair.predicted(informed), reports);
      informed = of_information.state;
    }
    const auto score = [&](Scores& s, const FusedTrack<2>& fused) {
      const Vec<2> e = fused.state.mean - truth.x;
      s.square += e[0] * e[0] / runs;
      s.nees += normalised_square<2>(e, fused.state.cov) / 2 / runs;
      s.nis += fused.nis / fused.dof / runs;
    };
    score(convex, of_convex);
    score(campo, of_campo);
    score(map, of_map);
    score(information, of_information);
  }
  const Band nees = average_chi2_band(2, runs, 1e-4);
  EXPECT_FALSE(nees.contains(convex.nees)) << convex.nees;  // over-confident: it ignores the common noise
  EXPECT_TRUE(nees.contains(campo.nees)) << campo.nees;
  EXPECT_TRUE(nees.contains(map.nees)) << map.nees;
  EXPECT_TRUE(nees.contains(information.nees)) << information.nees;
  EXPECT_TRUE(average_chi2_band(2, runs, 1e-4).contains(campo.nis)) << campo.nis;
  EXPECT_TRUE(average_chi2_band(2, runs, 1e-4).contains(information.nis)) << information.nis;
  EXPECT_LT(map.square, campo.square);
  EXPECT_LT(campo.square, convex.square);
  EXPECT_LT(information.square, 1.001 * map.square);
}

/// A track that starts anew from the fused one makes that one's error. With its next measurement it is then all there
/// is to know, and so the fused track; the ridge pretends 1e-7 of the variance more.
template <class Fusion>
void expect_all_in_a_designated_track() {
  const Pair pair;
  const Gaussian<2> start{Vec<2>::Zero(), pair.P0};
  Fusion fusion(start, 2);
  std::array<Gaussian<2>, 2> local{start, start};
  for (int k = 0; k < 5; ++k) {
    fusion.predict(pair.F, pair.Q);
    for (int i = 0; i < 2; ++i) {
      const auto s = static_cast<std::size_t>(i);
      local[s] = pair.predicted(local[s]);
      fusion.template updated<1>(i, pair.gain(local[s], i), pair.H, Mat<1, 1>(pair.r[s]));
      local[s] = pair.updated(local[s], 0.3 * k + i, i);
    }
  }
  const FusedTrack<2> before = fusion.fuse(std::array<Vec<2>, 2>{local[0].mean, local[1].mean}, 0b11);
  ASSERT_GT(test::relative_error(before.state.mean, local[0].mean), 0.01);  // both tracks count
  fusion.designated(1);
  local[1] = before.state;
  fusion.predict(pair.F, pair.Q);
  for (Gaussian<2>& x : local) x = pair.predicted(x);
  fusion.template updated<1>(1, pair.gain(local[1], 1), pair.H, Mat<1, 1>(pair.r[1]));
  local[1] = pair.updated(local[1], 4, 1);
  const FusedTrack<2> after = fusion.fuse(std::array<Vec<2>, 2>{local[0].mean, local[1].mean}, 0b11);
  EXPECT_LT(test::relative_error(after.state.mean, local[1].mean), 1e-5);
  EXPECT_LT(test::relative_error(after.state.cov, local[1].cov), 1e-5);
}

TEST(CorrelatedTracks, ADesignatedTrackIsTheFusedOneAndWhatItLearnsNext) {
  expect_all_in_a_designated_track<CampoFusion<2>>();
  expect_all_in_a_designated_track<MapFusion<2, 2>>();
}

TEST(MapFusion, HandComputed) {
  // Prior variance 4, track 2, cross 1: P_xz = 4 - 1, P_zz = 4 - 2 + 2, gain 3/4; the ridge leaves 1e-7.
  MapFusion<1, 1>::Joint joint;
  joint << 4, 1, 1, 2;
  MapFusion<1, 1> map(Vec<1>(0), joint);
  const auto fused = map.fuse(std::array<Vec<1>, 1>{Vec<1>(2)});
  EXPECT_NEAR(fused.state.mean[0], 1.5, 1e-6);
  EXPECT_NEAR(fused.state.cov(0, 0), 1.75, 1e-6);
  EXPECT_NEAR(fused.nis, 1, 1e-6);
}

TEST(MapFusion, RefusesAnIndependentPrior) {
  MapFusion<1, 2>::Joint joint;
  joint << 4, 0.5, 0.5, 0.5, 2, 0.3, 0.5, 0.3, 3;
  EXPECT_NO_THROW((MapFusion<1, 2>(Vec<1>(0), joint)));
  joint(0, 2) = joint(2, 0) = 0;
  EXPECT_THROW((MapFusion<1, 2>(Vec<1>(0), joint)), std::invalid_argument);
}

TEST(MapFusion, StaysDefiniteOverManySteps) {
  // Sensors of very different quality: the fused track is nearly the better track, the joint covariance nearly
  // singular.
  Pair pair;
  pair.r = {1, 1e6};
  MapFusion<2, 2> map(Gaussian<2>{Vec<2>::Zero(), pair.P0});
  std::array<Gaussian<2>, 2> local{Gaussian<2>{Vec<2>::Zero(), pair.P0}, Gaussian<2>{Vec<2>::Zero(), pair.P0}};
  for (int k = 0; k < 20000; ++k) {
    map.predict(pair.F, pair.Q);
    for (int i = 0; i < 2; ++i) {
      const auto s = static_cast<std::size_t>(i);
      const Gaussian<2> prior = pair.predicted(local[s]);
      map.updated<1>(i, pair.gain(prior, i), pair.H, Mat<1, 1>(pair.r[s]));
      local[s] = pair.updated(prior, 0, i);
    }
    const auto fused = map.fuse(std::array<Vec<2>, 2>{local[0].mean, local[1].mean});
    ASSERT_EQ(fused.verdict, Verdict::Accepted) << k;
    ASSERT_GT((Eigen::SelfAdjointEigenSolver<Mat<2, 2>>(fused.state.cov).eigenvalues().minCoeff()), 0) << k;
    ASSERT_LE(fused.state.cov(0, 0), local[0].cov(0, 0) * (1 + 1e-6)) << k;
  }
}

TEST(FederatedFilter, RefusesSharesThatDoNotAddUp) {
  const Gaussian<2> start;
  EXPECT_NO_THROW((FederatedFilter<2, 2>(start, {2, 2})));
  EXPECT_THROW((FederatedFilter<2, 2>(start, {1, 1})), std::invalid_argument);
  EXPECT_THROW((FederatedFilter<2, 2>(start, {0.5, -1})), std::invalid_argument);
  EXPECT_THROW((FederatedFilter<2, 2>(start, {std::nan(""), 2})), std::invalid_argument);
}

TEST(BarShalomCampo, TwoTracksThatAreOneStayOne) {
  const Gaussian<2> x{Vec<2>(1, 2), Mat<2, 2>::Identity() * 3};
  const auto fused = fuse_bar_shalom_campo<2>(x, x, x.cov);
  EXPECT_EQ(fused.verdict, Verdict::Singular);
  EXPECT_EQ(fused.state.mean, x.mean);
  EXPECT_EQ(fused.state.cov, x.cov);
}

}  // namespace
}  // namespace downrange
