/// One cross-radar pseudo-measurement step (kim2011 as corrected: pseudo measurement, bias update, track update with
/// its sensitivity, compensation) through the shared update, against vectors computed elsewhere.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <downrange/est/gaussian.hpp>
#include <limits>

#include "../support/vectors.hpp"

namespace downrange {
namespace {

using test::matrix_of;
using test::relative_error;
using test::vector_of;

constexpr double no_gate = std::numeric_limits<double>::infinity();

TEST(BiasStepVectors, PseudoMeasurementUpdateAndCompensation) {
  DOWNRANGE_VECTOR_CASES(cases, "bias2d_step.json");
  for (const auto& c : cases) {
    const Mat<2, 8> Hb = matrix_of(c["Hb"]);
    const Mat<2, 2> Rb = matrix_of(c["Rb"]);
    const Mat<2, 2> R = matrix_of(c["R"]);
    const Mat<2, 4> BC = matrix_of(c["BC"]);
    const Vec<2> z = vector_of(c["z_cart"]);
    const Vec<4> x_j = vector_of(c["x_j_pred"]);
    const Mat<4, 4> P_j = matrix_of(c["P_j_pred"]);
    const Mat<2, 4> H = (Mat<2, 4>() << Mat<2, 2>::Identity(), Mat<2, 2>::Zero()).finished();

    // Pseudo measurement against the other radar's track, its matrix [-H G_j, B C] and noise H P_j H' + R.
    EXPECT_LT(relative_error(z - H * x_j, vector_of(c["zb"])), 1e-9);
    EXPECT_LT(relative_error(H * P_j * H.transpose() + R, Rb), 1e-9);
    EXPECT_LT(relative_error(BC, Hb.rightCols<4>()), 1e-9);

    // The vectors' prior: mean zero, 1-sigma 100 m, 0.2 rad and scales 0.01, 0.1 for each radar.
    const Mat<8, 8> Sigma = matrix_of(c["Sigma"]);
    Vec<8> sigma;
    sigma << 100, 0.2, 0.01, 0.1, 100, 0.2, 0.01, 0.1;
    const Mat<8, 8> prior = sigma.cwiseAbs2().asDiagonal();
    const auto u = kalman_update<8, 2>({Vec<8>::Zero(), prior}, z - H * x_j, Hb, Rb, no_gate);
    EXPECT_LT(relative_error(u.posterior.mean, vector_of(c["bias"])), 1e-9);
    EXPECT_LT(relative_error(u.posterior.cov, Sigma), 1e-9);

    // The measuring radar's own track, predicted over dt with the paper's process noise, q = 6 m^2/s^3, its sensitivity
    // G+ = (I - K H) Phi G + K B C and the compensation x - G b.
    const double dt = c["dt"];
    const double q = 6;
    Mat<4, 4> Phi = Mat<4, 4>::Identity();
    Phi.topRightCorner<2, 2>().diagonal().setConstant(dt);
    Mat<4, 4> Q = Mat<4, 4>::Zero();
    Q.topLeftCorner<2, 2>().diagonal().setConstant(q * dt * dt * dt / 3);
    Q.topRightCorner<2, 2>().diagonal().setConstant(q * dt * dt / 2);
    Q.bottomLeftCorner<2, 2>().diagonal().setConstant(q * dt * dt / 2);
    Q.bottomRightCorner<2, 2>().diagonal().setConstant(q * dt);
    const Gaussian<4> predicted{Phi * Vec<4>(vector_of(c["x_i_prior"])),
                                Phi * Mat<4, 4>(matrix_of(c["P_i_prior"])) * Phi.transpose() + Q};
    const auto track = kalman_update<4, 2>(predicted, z - H * predicted.mean, H, R, no_gate);
    EXPECT_LT(relative_error(track.posterior.mean, vector_of(c["x_i"])), 1e-9);
    EXPECT_LT(relative_error(track.posterior.cov, matrix_of(c["P_i"])), 1e-9);
    const Mat<4, 2> K = predicted.cov * H.transpose() * track.S.inverse();
    EXPECT_LT(relative_error(K, matrix_of(c["K_i"])), 1e-9);
    const Mat<4, 4> G = (Mat<4, 4>::Identity() - K * H) * Phi * Mat<4, 4>(matrix_of(c["G_i_prior"])) + K * BC;
    EXPECT_LT(relative_error(G, matrix_of(c["G_i"])), 1e-9);
    EXPECT_LT(relative_error(track.posterior.mean - G * u.posterior.mean.tail<4>(), vector_of(c["x_free"])), 1e-9);
    EXPECT_LT(relative_error(track.posterior.cov + G * u.posterior.cov.bottomRightCorner<4, 4>() * G.transpose(),
                             matrix_of(c["P_free"])),
              1e-9);
  }
}

}  // namespace
}  // namespace downrange
