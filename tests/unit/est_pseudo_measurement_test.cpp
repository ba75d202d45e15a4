/// Biased tracks, pseudo measurements between radars and parity slots: identities and forms derived separately.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <downrange/est/filter/consistency.hpp>
#include <limits>
#include "experiment/exx.hpp"
#include "experiment/pseudo_measurement.hpp"

#include "../support/planar.hpp"

namespace downrange {
namespace {

using test::planar_noise;
using test::planar_position;
using test::planar_transition;
using test::RandomMatrices;

constexpr double no_gate = std::numeric_limits<double>::infinity();
constexpr double q = 6;
const Mat<2, 4> H = planar_position();

TEST(BiasedTrack, IsTheUnbiasedTrackPlusGBeta) {
  RandomMatrices random(21);
  for (const bool from_two_points : {false, true}) {
    const Vec<3> beta = random.matrix<3, 1>();
    const Mat<2, 2> R = random.covariance<2>();
    const auto position = [&](const Mat<2, 3>& BC, const Vec<2>& z) {
      return BiasedPosition<2, 3>{z + BC * beta, BC, R};
    };
    const auto unbiased = [](BiasedPosition<2, 3> p, const Vec<2>& z) {
      p.z = z;
      return p;
    };
    BiasedTrack<4, 3> biased;
    BiasedTrack<4, 3> free;
    if (from_two_points) {
      const Vec<2> z0 = random.matrix<2, 1>();
      const Vec<2> z1 = random.matrix<2, 1>();
      const auto p0 = position(random.matrix<2, 3>(), z0);
      const auto p1 = position(random.matrix<2, 3>(), z1);
      biased = two_point_start(p0, p1, 0.7, q);
      free = two_point_start(unbiased(p0, z0), unbiased(p1, z1), 0.7, q);
    } else {
      biased = free = {{random.matrix<4, 1>(), random.covariance<4>()}, Mat<4, 3>::Zero()};
    }
    for (int k = 0; k < 500; ++k) {
      const double dt = 0.1 + 0.01 * (k % 7);
      biased = predict(biased, planar_transition(dt), planar_noise(dt, q));
      free = predict(free, planar_transition(dt), planar_noise(dt, q));
      const Vec<2> z = random.matrix<2, 1>();
      const auto p = position(random.matrix<2, 3>(), z);
      biased = update(biased, p.z, H, p.BC, p.R, no_gate).track;
      free = update(free, z, H, p.BC, p.R, no_gate).track;
    }
    EXPECT_LT((biased.estimate.mean - free.estimate.mean - biased.G * beta).norm(), 1e-12 * (1 + biased.G.norm()));
    const Gaussian<4> compensated = compensate(biased, Gaussian<3>{beta, 1e-30 * Mat<3, 3>::Identity()});
    EXPECT_LT((compensated.mean - free.estimate.mean).norm(), 1e-12 * (1 + biased.G.norm()));
    EXPECT_EQ(biased.estimate.cov, free.estimate.cov);
    EXPECT_EQ(biased.estimate.cov, biased.estimate.cov.transpose().eval());
  }
}

TEST(BiasedTrack, ARejectedMeasurementChangesNothing) {
  RandomMatrices random(22);
  const BiasedTrack<4, 3> track{{random.matrix<4, 1>(), random.covariance<4>()}, random.matrix<4, 3>()};
  const auto u = update<4, 2, 3>(track, Vec<2>(1e6, 0), H, random.matrix<2, 3>(), random.covariance<2>(), 20);
  EXPECT_EQ(u.evidence.verdict, Verdict::Gated);
  EXPECT_EQ(u.track.estimate.mean, track.estimate.mean);
  EXPECT_EQ(u.track.G, track.G);
}

TEST(BiasedTrack, TwoPointStartIsTheFilterThatKnewNothingOfVelocity) {
  RandomMatrices random(23);
  const double T = 1.3;
  const BiasedPosition<2, 3> z0{random.matrix<2, 1>(), random.matrix<2, 3>(), random.covariance<2>()};
  const BiasedPosition<2, 3> z1{random.matrix<2, 1>(), random.matrix<2, 3>(), random.covariance<2>()};
  BiasedTrack<4, 3> filtered;
  filtered.estimate.mean << z0.z, 0, 0;
  filtered.estimate.cov.setZero();
  filtered.estimate.cov.topLeftCorner<2, 2>() = z0.R;
  filtered.estimate.cov.bottomRightCorner<2, 2>().diagonal().setConstant(1e9);
  filtered.G << z0.BC, Mat<2, 3>::Zero();
  filtered = predict(filtered, planar_transition(T), planar_noise(T, q));
  filtered = update(filtered, z1.z, H, z1.BC, z1.R, no_gate).track;
  const BiasedTrack<4, 3> started = two_point_start(z0, z1, T, q);
  // 1e9 against 10: both the prior's weight and the cancellation in P leave 1e-6 at most.
  EXPECT_LT((started.estimate.mean - filtered.estimate.mean).norm(), 1e-6);
  EXPECT_LT((started.estimate.cov - filtered.estimate.cov).norm(), 1e-5);
  EXPECT_LT((started.G - filtered.G).norm(), 1e-6);
}

/// Three radars and their tracks' errors in one state of twelve: what the stacked noise of pseudo measurements is.
TEST(PseudoMeasurement, NoiseOfThreeRadarsIsThatOfTheJointErrors) {
  constexpr int radars = 3;
  RandomMatrices random(24);
  LocalTracks<4, 2, radars> tracks;
  Mat<12, 12> E = Mat<12, 12>::Zero();  // covariance of the stacked track errors
  for (int s = 0; s < radars; ++s) {
    const Mat<4, 4> P = 10 * random.covariance<4>();
    tracks.start(s, {{random.matrix<4, 1>(), P}, Mat<4, 2>::Zero()});
    E.block<4, 4>(4 * s, 4 * s) = P;
  }
  double correlation = 0;
  for (int k = 0; k < 40; ++k) {
    const double dt = 0.3;
    const Mat<4, 4> Phi = planar_transition(dt);
    predict(tracks, Phi, planar_noise(dt, q));
    Mat<12, 12> F = Mat<12, 12>::Zero();
    for (int s = 0; s < radars; ++s) F.block<4, 4>(4 * s, 4 * s) = Phi;
    E = (F * E * F.transpose()).eval() +
        planar_noise(dt, q).replicate<radars, radars>();  // one target: one process noise

    const int i = k % radars;
    const Mat<2, 2> R = random.covariance<2>();
    const auto pm = pseudo_measurement<4, 2, 2, radars>(tracks, i, random.matrix<2, 1>(), H, random.matrix<2, 2>(), R);
    for (int row = 0; row < 2; ++row) {
      for (int column = 0; column < 2; ++column) {
        const int a = row < i ? row : row + 1;
        const int b = column < i ? column : column + 1;
        const Mat<2, 2> expected = R + E.block<2, 2>(4 * a, 4 * b);
        EXPECT_LT((pm.R.block<2, 2>(2 * row, 2 * column) - expected).norm(), 1e-9 * expected.norm());
        if (row != column) correlation = (expected - R).norm() / R.norm();
      }
    }
    const auto own = update<4, 2, 2, radars>(tracks, i, random.matrix<2, 1>(), H, random.matrix<2, 2>(), R, no_gate);
    Mat<12, 12> A = Mat<12, 12>::Identity();
    A.block<4, 4>(4 * i, 4 * i) -= own.K * H;
    E = (A * E * A.transpose()).eval();
    E.block<4, 4>(4 * i, 4 * i) += own.K * R * own.K.transpose();
  }
  EXPECT_GT(correlation, 0.01);  // the tracks do have errors in common
}

TEST(PseudoMeasurement, ARadarWithoutATrackTellsNothing) {
  RandomMatrices random(25);
  const Gaussian<6> prior{random.matrix<6, 1>(), random.covariance<6>()};
  const BiasedTrack<4, 2> track{{random.matrix<4, 1>(), random.covariance<4>()}, random.matrix<4, 2>()};
  const Vec<2> z = random.matrix<2, 1>();
  const Mat<2, 2> BC = random.matrix<2, 2>();
  const Mat<2, 2> R = random.covariance<2>();
  LocalTracks<4, 2, 3> three;
  three.start(0, track);
  const auto of_three = estimate_bias(prior, pseudo_measurement(three, 1, z, H, BC, R), 1, no_gate);
  LocalTracks<4, 2, 2> two;
  two.start(0, track);
  const Gaussian<4> of_two_prior{prior.mean.head<4>(), prior.cov.topLeftCorner<4, 4>()};
  const auto of_two = estimate_bias(of_two_prior, pseudo_measurement(two, 1, z, H, BC, R), 1, no_gate);
  EXPECT_LT((of_three.posterior.mean.head<4>() - of_two.posterior.mean).norm(), 1e-12);
  EXPECT_LT((of_three.posterior.cov.topLeftCorner<4, 4>() - of_two.posterior.cov).norm(), 1e-12);
}

using Slot = ParitySlot<4, 2, 3, 2, 4>;

TEST(ParitySlot, IsTheFilterThatKnewNothingOfTheTarget) {
  RandomMatrices random(26);
  for (int run = 0; run < 20; ++run) {
    Slot slot;
    // State and biases in one filter; the target unknown by more than anything measured.
    Gaussian<10> x{Vec<10>::Zero(), Mat<10, 10>::Identity()};
    x.cov.topLeftCorner<4, 4>() *= 1e8;
    const Gaussian<6> prior{x.mean.tail<6>(), x.cov.bottomRightCorner<6, 6>()};
    for (int k = 0; k < 4; ++k) {
      const double dt = 0.2 + 0.3 * k;
      const Mat<4, 4> Phi = planar_transition(dt);
      const Mat<4, 4> Q = planar_noise(dt, q);
      const int radar = k % 2;
      const Vec<2> z = random.matrix<2, 1>();
      const Mat<2, 3> BC = random.matrix<2, 3>();
      const Mat<2, 2> R = random.covariance<2>();
      slot.add(Phi, Q, radar, z, H, BC, R);
      if (k > 0) {
        Mat<10, 10> F = Mat<10, 10>::Identity();
        F.topLeftCorner<4, 4>() = Phi;
        x.mean = F * x.mean;
        x.cov = (F * x.cov * F.transpose()).eval();
        x.cov.topLeftCorner<4, 4>() += Q;
      }
      Mat<2, 10> H_x = Mat<2, 10>::Zero();
      H_x.leftCols<4>() = H;
      H_x.block<2, 3>(0, 4 + 3 * radar) = BC;
      x = kalman_update<10, 2>(x, z - H_x * x.mean, H_x, R, no_gate).posterior;
    }
    ASSERT_TRUE(slot.complete());
    const auto p = slot.parity();
    const auto beta = kalman_update<6, Slot::rows>(prior, p.z - p.J * prior.mean, p.J, p.R, no_gate).posterior;
    // 1e8 against 1: the weight of the target's prior and rounding in its covariance.
    EXPECT_LT((beta.mean - x.mean.tail<6>()).norm(), 1e-5);
    EXPECT_LT((beta.cov - x.cov.bottomRightCorner<6, 6>()).norm(), 1e-5);
  }
}

TEST(ParitySlot, NoMotionOfTheTargetShows) {
  RandomMatrices random(27);
  const Vec<4> x0 = 1e5 * random.matrix<4, 1>();
  Slot still;
  Slot moving;
  Vec<4> x = x0;
  for (int k = 0; k < 4; ++k) {
    const Mat<4, 4> Phi = planar_transition(0.5);
    if (k > 0) x = Phi * x;
    const Vec<2> z = random.matrix<2, 1>();
    const Mat<2, 3> BC = random.matrix<2, 3>();
    const Mat<2, 2> R = random.covariance<2>();
    still.add(Phi, planar_noise(0.5, q), k % 2, z, H, BC, R);
    moving.add(Phi, planar_noise(0.5, q), k % 2, z + H * x, H, BC, R);
  }
  EXPECT_LT((still.parity().z - moving.parity().z).norm(), 1e-14 * x0.norm() * 100);
}

}  // namespace
}  // namespace downrange
