/// One cross-radar pseudo-measurement step (kim2011 as corrected: pseudo measurement, bias update, track update with
/// its sensitivity, compensation) against vectors computed elsewhere.
#include <gtest/gtest.h>

#include <limits>
#include "experiment/pseudo_measurement.hpp"

#include "../support/planar.hpp"
#include "../support/vectors.hpp"

namespace downrange {
namespace {

using test::matrix_of;
using test::planar_noise;
using test::planar_position;
using test::planar_transition;
using test::relative_error;
using test::vector_of;

constexpr double no_gate = std::numeric_limits<double>::infinity();

TEST(BiasStepVectors, PseudoMeasurementUpdateAndCompensation) {
  DOWNRANGE_VECTOR_CASES(cases, "bias2d_step.json");
  for (const auto& c : cases) {
    const Mat<2, 2> R = matrix_of(c["R"]);
    const Mat<2, 4> BC = matrix_of(c["BC"]);
    const Vec<2> z = vector_of(c["z_cart"]);
    const Mat<2, 4> H = planar_position();
    const double dt = c["dt"];

    // Radar 1 measures. The vectors give its track before the step, and radar 0's already predicted but for G.
    const BiasedTrack<4, 4> before{{vector_of(c["x_i_prior"]), matrix_of(c["P_i_prior"])}, matrix_of(c["G_i_prior"])};
    LocalTracks<4, 4, 2> tracks;
    tracks.start(0, {{vector_of(c["x_j_pred"]), matrix_of(c["P_j_pred"])},
                     planar_transition(dt) * Mat<4, 4>(matrix_of(c["G_j"]))});
    tracks.start(1, predict(before, planar_transition(dt), planar_noise(dt, 6)));

    const auto pm = pseudo_measurement(tracks, 1, z, H, BC, R);
    EXPECT_LT(relative_error(pm.zb, vector_of(c["zb"])), 1e-9);
    EXPECT_LT(relative_error(pm.Hb, matrix_of(c["Hb"])), 1e-9);
    EXPECT_LT(relative_error(pm.R, matrix_of(c["Rb"])), 1e-9);

    // The vectors' prior: mean zero, 1-sigma 100 m, 0.2 rad and scales 0.01, 0.1 for each radar.
    Vec<8> sigma;
    sigma << 100, 0.2, 0.01, 0.1, 100, 0.2, 0.01, 0.1;
    const auto bias = estimate_bias<2, 4, 2>({Vec<8>::Zero(), sigma.cwiseAbs2().asDiagonal()}, pm, 1, no_gate);
    EXPECT_LT(relative_error(bias.K, matrix_of(c["K"])), 1e-9);
    EXPECT_LT(relative_error(bias.posterior.mean, vector_of(c["bias"])), 1e-9);
    EXPECT_LT(relative_error(bias.posterior.cov, matrix_of(c["Sigma"])), 1e-9);

    const auto own = update(tracks, 1, z, H, BC, R, no_gate);
    const BiasedTrack<4, 4>& track = tracks.track[1];
    EXPECT_LT(relative_error(own.K, matrix_of(c["K_i"])), 1e-9);
    EXPECT_LT(relative_error(track.estimate.mean, vector_of(c["x_i"])), 1e-9);
    EXPECT_LT(relative_error(track.estimate.cov, matrix_of(c["P_i"])), 1e-9);
    EXPECT_LT(relative_error(track.G, matrix_of(c["G_i"])), 1e-9);
    const Gaussian<4> free =
        compensate(track, Gaussian<4>{bias.posterior.mean.tail<4>(), bias.posterior.cov.bottomRightCorner<4, 4>()});
    EXPECT_LT(relative_error(free.mean, vector_of(c["x_free"])), 1e-9);
    EXPECT_LT(relative_error(free.cov, matrix_of(c["P_free"])), 1e-9);
  }
}

}  // namespace
}  // namespace downrange
