/// The Schmidt filter against the textbook: H by central differences of the model, the posterior by Joseph's form with
/// the gain of the rows that a measurement may correct, in dense matrices. And what the method promises: GPS untouched
/// by radar, the fused track untouched by GPS.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <downrange/est/method/schmidt.hpp>

#include "../support/drawn_flight.hpp"

namespace downrange {
namespace {

using test::deg;
using test::draw_flight;
using test::Flight;

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// Everything known: a flight of 12 s in which fused track, GPS track and biases have become correlated.
struct Flown {
  Schmidt schmidt;
  Schmidt::State state;

  [[nodiscard]] const Hypothesis& mode() const { return state.targets[0].bank.mode[0]; }
  [[nodiscard]] Time epoch() const { return state.targets[0].epoch; }
};

Flown fly_schmidt(bool with_gps = true) {
  Flight f = draw_flight(6, 12, true, with_gps);
  f.settings.motion.kinematics = Kinematics::Ca;
  f.settings.noise.enabled = false;
  Schmidt schmidt(f.settings);
  Schmidt::State state = schmidt.initial();
  for (const Measurement& m : f.measurements) (void)schmidt.apply(state, m);
  return {std::move(schmidt), std::move(state)};
}

/// What radar `source` would measure of the motion that stands at `motion_at` of `x`.
Vec<3> predicted(const Flown& f, int source, int motion_at, const Vector& x) {
  const auto layout = bias_layout(f.schmidt.settings().radars, f.schmidt.first_radar_at());
  const auto radar = static_cast<std::size_t>(source);
  return predict_plot(f.schmidt.settings().radars[radar], x.segment<9>(motion_at), layout.radars[radar].bias(x)).q;
}

Vec<3> predicted_without_gps(const Flown& f, int source) {
  const MethodSettings& settings = f.schmidt.settings();
  const auto layout = bias_layout_without_gps(settings.radars, settings.gps.no_gps, f.schmidt.first_radar_at());
  const auto radar = static_cast<std::size_t>(source);
  return predict_plot(settings.radars[radar], f.mode().x.head<9>(), layout.radars[radar].bias(f.mode().x)).q;
}

Matrix jacobian(const Flown& f, int source, int motion_at) {
  const Hypothesis& h = f.mode();
  Matrix H(3, h.x.size());
  for (Eigen::Index i = 0; i < h.x.size(); ++i) {
    const double step = 1e-3 * std::sqrt(h.P(i, i));
    Vector plus = h.x;
    Vector minus = h.x;
    plus[i] += step;
    minus[i] -= step;
    const Vec<3> a = predicted(f, source, motion_at, plus);
    const Vec<3> b = predicted(f, source, motion_at, minus);
    H.col(i) = Vec<3>(a[0] - b[0], wrap_pi(a[1] - b[1]), a[2] - b[2]) / (2 * step);
  }
  return H;
}

/// P H' S^-1 in rows [at, at + size), zero elsewhere.
Matrix gain_of_rows(const Matrix& P, const Matrix& H, const Matrix& R, Eigen::Index at, Eigen::Index size) {
  const Matrix full = P * H.transpose() * Matrix(H * P * H.transpose() + R).inverse();
  Matrix K = Matrix::Zero(P.rows(), H.rows());
  K.middleRows(at, size) = full.middleRows(at, size);
  return K;
}

/// In units of the prior's sigma. Differences over 1e-3 sigma are right to 1e-6; correlations of 1 - 1e-6 cost the
/// rest.
void expect_posterior(const Flown& before, const Hypothesis& after, const Matrix& K, const Matrix& H, const Matrix& R,
                      const Vector& nu) {
  const Matrix& P = before.mode().P;
  const Matrix ImKH = Matrix::Identity(P.rows(), P.cols()) - K * H;
  const Matrix expected = ImKH * P * ImKH.transpose() + K * R * K.transpose();
  const Vector scale = P.diagonal().cwiseSqrt();
  EXPECT_LT(((after.x - before.mode().x - K * nu).array() / scale.array()).abs().maxCoeff(), 1e-5);
  EXPECT_LT(((after.P - expected).array() / (scale * scale.transpose()).array()).abs().maxCoeff(), 1e-5);
  EXPECT_EQ(after.P, after.P.transpose().eval());
}

TEST(Schmidt, APlotCorrectsTheFusedTrackAndTheBiasesAsTheConsiderFilterDoes) {
  const Flown f = fly_schmidt();
  const Eigen::Index n = f.mode().x.size();
  for (int source = 0; source < 2; ++source) {
    const RadarModel& radar = f.schmidt.settings().radars[static_cast<std::size_t>(source)];
    const Vec<3> sigma = plot_variance(radar, Plot{.measured = {0, 0, 0.5}}).cwiseSqrt();
    const Vec<3> q = predicted(f, source, Schmidt::fused_at, f.mode().x) + sigma.cwiseProduct(Vec<3>(0.7, -0.4, 1.1));
    Measurement m;
    m.epoch = f.epoch();
    m.source = source;
    test::polar(m) = {q[0], wrap_two_pi(q[1]), q[2]};
    Schmidt::State updated = f.state;
    ASSERT_EQ(f.schmidt.apply(updated, m).verdict, Verdict::Accepted);

    // The plot is used twice, with the same noise.
    const Matrix R = sigma.cwiseAbs2().asDiagonal();
    const Matrix H_f = jacobian(f, source, Schmidt::fused_at);
    const Matrix H_g = jacobian(f, source, Schmidt::gps_at);
    Matrix H(6, n), K(n, 6), R_both(6, 6);
    H << H_f, H_g;
    K << gain_of_rows(f.mode().P, H_f, R, Schmidt::fused_at, 9),
        gain_of_rows(f.mode().P, H_g, R, f.schmidt.first_radar_at(), n - f.schmidt.first_radar_at());
    R_both << R, R, R, R;
    Vector nu(6);
    nu << plot_residual(test::polar(m), predicted(f, source, Schmidt::fused_at, f.mode().x)),
        plot_residual(test::polar(m), predicted(f, source, Schmidt::gps_at, f.mode().x));
    const Hypothesis& after = updated.targets[0].bank.mode[0];
    expect_posterior(f, after, K, H, R_both, nu);

    // No radar touches the GPS track.
    EXPECT_EQ((after.x.segment<12>(Schmidt::gps_at)), (f.mode().x.segment<12>(Schmidt::gps_at)));
    EXPECT_EQ((after.P.block<12, 12>(Schmidt::gps_at, Schmidt::gps_at)),
              (f.mode().P.block<12, 12>(Schmidt::gps_at, Schmidt::gps_at)));
    EXPECT_NE(after.x.tail(n - f.schmidt.first_radar_at()), f.mode().x.tail(n - f.schmidt.first_radar_at()));
  }
}

TEST(Schmidt, AFixCorrectsTheGpsTrackAndTheBiasesAsTheConsiderFilterDoes) {
  const Flown f = fly_schmidt();
  const Eigen::Index n = f.mode().x.size();
  Measurement m;
  m.source = static_cast<int>(f.schmidt.settings().radars.size());
  m.measured = Fix{};
  m.epoch = f.epoch();
  test::fix(m).position.m = f.mode().x.segment<3>(Schmidt::gps_at) + Vec<3>(3, -4, 2);
  test::fix(m).sigma_horizontal_m = test::fix(m).sigma_vertical_m = 5;
  Schmidt::State updated = f.state;
  ASSERT_EQ(f.schmidt.apply(updated, m).verdict, Verdict::Accepted);

  Matrix H = Matrix::Zero(3, n);
  H.middleCols<3>(Schmidt::gps_at).setIdentity();
  H.middleCols<3>(Schmidt::gps_error_at).setIdentity();
  const Matrix R = 25 * Matrix::Identity(3, 3);
  const Matrix K = gain_of_rows(f.mode().P, H, R, Schmidt::gps_at, n - Schmidt::gps_at);
  const Vec<3> nu =
      test::fix(m).position.m - f.mode().x.segment<3>(Schmidt::gps_at) - f.mode().x.segment<3>(Schmidt::gps_error_at);
  const Hypothesis& after = updated.targets[0].bank.mode[0];
  expect_posterior(f, after, K, H, R, nu);

  // No fix touches the fused track.
  EXPECT_EQ(after.x.head<9>(), f.mode().x.head<9>());
  EXPECT_EQ((after.P.topLeftCorner<9, 9>()), (f.mode().P.topLeftCorner<9, 9>()));
}

/// An engine of 30 m/s^2 is lit between two fixes. A receiver that jumps by 300 m is refused as ever, and leaves the
/// GPS track as it was.
TEST(Schmidt, AnIgnitionIsNoFaultOfTheReceiver) {
  for (const double jump_m : {0.0, 300.0}) {
    MethodSettings settings = draw_flight(1, 1, false).settings;
    settings.radars.clear();
    settings.motion.kinematics = Kinematics::Ca;
    const Schmidt schmidt(settings);
    Schmidt::State state = schmidt.initial();
    const Vec<3> start(-3.2e6, 4.2e6, 3.7e6);
    const Vec<3> up = start.normalized();
    Mat<9, 9> before = Mat<9, 9>::Zero();
    for (int t = 0; t < 40; ++t) {
      const double burning = std::max(0.0, t - 20.0);
      Measurement m;
      m.epoch = Time{} + seconds(100.0 + t);
      m.sequence = static_cast<std::uint64_t>(t) + 1;
      m.measured = Fix{};
      Fix& fix = test::fix(m);
      fix.position.m = start + (2000 * t + 15 * burning * burning + (t == 30 ? jump_m : 0)) * up;
      fix.velocity.m_s = (2000 + 30 * burning) * up;
      fix.velocity_valid = true;
      fix.sigma_horizontal_m = fix.sigma_vertical_m = 5;
      fix.sigma_velocity_m_s = 0.2;
      const bool jumps = t == 30 && jump_m > 0;
      EXPECT_EQ(schmidt.apply(state, m).verdict, jumps ? Verdict::Gated : Verdict::Accepted) << t;
      const Mat<9, 9> P = state.targets[0].bank.mode[0].P.block<9, 9>(Schmidt::gps_at, Schmidt::gps_at);
      if (jumps) {
        EXPECT_LT(P.trace(), 10 * before.trace());
      }
      before = P;
    }
  }
}

/// There is nothing then that the two could do differently: radars find their biases against each other.
TEST(Schmidt, WithoutGpsIsTheJointFilter) {
  Flight f = draw_flight(8, 30, true, false);
  f.settings.motion.kinematics = Kinematics::Ca;
  const auto schmidt = make_method("schmidt", f.settings);
  const auto joint = make_method("joint", f.settings);
  for (const Measurement& m : f.measurements) {
    ASSERT_EQ(schmidt->process(m, m.epoch).verdict, joint->process(m, m.epoch).verdict);
    const TrackEstimate x = *schmidt->fused(0);
    const TrackEstimate y = *joint->fused(0);
    const Vec<9> sigma = y.cov.diagonal().cwiseSqrt();
    ASSERT_LT((x.mean - y.mean).cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 1e-6);
  }
  for (int radar = 0; radar < 2; ++radar) {
    const BiasEstimate x = schmidt->bias(radar);
    const BiasEstimate y = joint->bias(radar);
    EXPECT_EQ(x.reference, BiasReference::CrossRadar);
    EXPECT_LE(y.samples - x.samples, 1u);  // joint counts the plot that started the track
    EXPECT_EQ(x.state, y.state);
    for (int i = 0; i < y.terms; ++i) EXPECT_NEAR(x.value[i], y.value[i], 1e-6 * std::sqrt(y.cov(i, i)));
  }
}

/// Half a degree, or 500 m: no bias that a radar may have before any GPS.
TEST(Schmidt, WithoutGpsOutliersAreStillRejected) {
  Flown f = fly_schmidt(false);
  for (int kind = 0; kind < 2; ++kind) {
    for (int source = 0; source < 2; ++source) {
      const Vec<3> q = predicted_without_gps(f, source);
      Measurement m;
      m.epoch = f.epoch();
      m.source = source;
      test::polar(m) = {q[0] + (kind == 0 ? 500 : 0), q[1], q[2] + (kind == 1 ? 0.5 * deg : 0)};
      EXPECT_EQ(f.schmidt.apply(f.state, m).verdict, Verdict::Gated) << kind << " " << source;
    }
  }
}

/// What is left of the radars' systematic error at the end of a flight, in units of the plots' noise.
double left_of_bias(const Flight& f) {
  const auto method = make_method("schmidt", f.settings);
  for (const Measurement& m : f.measurements) (void)method->process(m, m.epoch);
  const Measurement& last = f.measurements.back();
  const Site pad({34.43 * deg, 127.53 * deg, 100});
  const Position<Ecef> truth = test::truth_at(pad, (last.epoch - Time{}).seconds());
  const Polar planted[2] = {{40, 0.04 * deg, -0.03 * deg}, {-35, -0.03 * deg, 0.02 * deg}};
  double square = 0;
  for (int radar = 0; radar < 2; ++radar) {
    const RadarModel& model = f.settings.radars[static_cast<std::size_t>(radar)];
    const BiasEstimate b = method->bias(radar);
    EXPECT_GT(b.samples, 100u);
    Vec<bias_term_count> bias = Vec<bias_term_count>::Zero();
    for (int i = 0; i < b.terms; ++i) bias[static_cast<Eigen::Index>(b.term[static_cast<std::size_t>(i)])] = b.value[i];
    bias[static_cast<Eigen::Index>(BiasTerm::TimeTag)] = 0;  // the target stands still here
    Vec<9> motion = Vec<9>::Zero();
    motion.head<3>() = truth.m;
    const Polar q = polar_from_enu(model.site.enu_of(truth));
    const Polar& p = planted[radar];
    const Polar biased{q.range_m + p.range_m, q.azimuth_rad + p.azimuth_rad, q.elevation_rad + p.elevation_rad};
    square += plot_residual(biased, predict_plot(model, motion, bias).q)
                  .cwiseQuotient(plot_variance(model, Plot{.measured = q}).cwiseSqrt())
                  .squaredNorm() /
              6;
  }
  return std::sqrt(square);
}

/// Later fixes correct the biases anyway, through the joint covariance: to smooth GPS first changes little, and nothing
/// for the worse.
TEST(Schmidt, SmoothedGpsFindsTheSameBiases) {
  double predicted_square = 0;
  double smoothed_square = 0;
  for (std::uint64_t seed = 20; seed < 28; ++seed) {
    Flight f = draw_flight(seed, 60, true);
    f.settings.motion.kinematics = Kinematics::Ca;
    predicted_square += std::pow(left_of_bias(f), 2) / 8;
    f.settings.gps.alignment = {.smooth = true, .fixes = 2};
    smoothed_square += std::pow(left_of_bias(f), 2) / 8;
  }
  EXPECT_LT(std::sqrt(predicted_square), 1.0);  // the planted bias is up to four sigma
  EXPECT_LT(std::sqrt(smoothed_square), 1.1 * std::sqrt(predicted_square));
  EXPECT_NE(smoothed_square, predicted_square);
}

/// The first fixes open the wide priors, and the fused track stays where it was.
TEST(Schmidt, GpsThatComesLaterOpensTheBiases) {
  const Flight f = draw_flight(7, 30, true);
  const auto method = make_method("schmidt", f.settings);
  const Site pad({34.43 * deg, 127.53 * deg, 100});
  for (const Measurement& m : f.measurements) {
    if (is_fix(m) && m.epoch < Time{} + seconds(20)) continue;
    (void)method->process(m, m.epoch);
    const auto e = method->fused(0, m.epoch);
    const double error = (e->mean.head<3>() - test::truth_at(pad, (m.epoch - Time{}).seconds()).m).norm();
    const double t = (m.epoch - Time{}).seconds();
    EXPECT_LT(error, t > 35 ? 40 : t > 15 ? 250 : 1000) << t;
  }
  EXPECT_EQ(method->bias(0).reference, BiasReference::Gps);
  EXPECT_EQ(method->bias(0).terms, 10);
}

}  // namespace
}  // namespace downrange
