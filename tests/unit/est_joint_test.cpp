/// The joint filter: nearer to the truth than the two-stage method and honest about it, time tags found, order
/// irrelevant.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <downrange/est/joint.hpp>
#include <downrange/est/rewind.hpp>

#include "../support/drawn_flight.hpp"

namespace downrange {
namespace {

using test::draw_flight;
using test::Flight;
using test::fly;

TEST(Joint, IsNearerToTheTruthThanTwoStagesAndHonest) {
  double joint_square = 0;
  double song_square = 0;
  double inside = 0;
  constexpr int runs = 8;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    const Flight f = draw_flight(seed, 40, true);
    const auto joint = fly(*make_method("joint", f.settings), f, 20);
    joint_square += joint.rms_m * joint.rms_m / runs;
    inside += joint.inside95 / runs;
    const auto song = fly(*make_method("song2015", f.settings), f, 20);
    song_square += song.rms_m * song.rms_m / runs;
  }
  EXPECT_LT(joint_square, 0.5 * song_square);
  EXPECT_GT(inside, 0.93);  // the GPS error states and the jerk are wider than this flight: too wide is allowed here
}

TEST(Joint, FindsAClockThatIsFast) {
  Flight f = draw_flight(9, 60, true);
  const Duration fast = milliseconds(50);  // 2.5 sigma of the prior
  for (Measurement& m : f.measurements)
    if (m.kind == Measurement::Kind::Radar && m.source == 0) m.epoch = m.epoch + fast;
  std::sort(f.measurements.begin(), f.measurements.end(), processed_before);
  const auto method = make_method("joint", f.settings);
  for (const Measurement& m : f.measurements) (void)method->process(m, m.epoch);
  for (int radar = 0; radar < 2; ++radar) {
    const BiasEstimate b = method->bias(radar);
    ASSERT_EQ(b.term[9], BiasTerm::TimeTag);
    const double truth = radar == 0 ? fast.seconds() : 0;
    const double sigma = std::sqrt(b.cov(9, 9));
    EXPECT_LT(sigma, 0.018);  // learnt a little: on so slow a flight 20 ms are a few metres
    EXPECT_LT(std::abs(b.value[9] - truth), 3 * sigma);
  }
}

TEST(Joint, ShuffledArrivalGivesTheInOrderBits) {
  const Flight f = draw_flight(4, 20, true);
  const auto in_order = make_method("joint", f.settings);
  for (const Measurement& m : f.measurements) (void)in_order->process(m, m.epoch);
  std::mt19937_64 rng(99);
  std::vector<std::pair<Time, std::size_t>> arrival;
  for (std::size_t i = 0; i < f.measurements.size(); ++i)
    arrival.push_back({f.measurements[i].epoch + milliseconds(static_cast<std::int64_t>(rng() % 2000)), i});
  std::sort(arrival.begin(), arrival.end());
  const auto shuffled = make_method("joint", f.settings);
  for (const auto& [received, i] : arrival) (void)shuffled->process(f.measurements[i], received);
  EXPECT_EQ(in_order->fused(0)->mean, shuffled->fused(0)->mean);
  EXPECT_EQ(in_order->fused(0)->cov, shuffled->fused(0)->cov);
  EXPECT_EQ(in_order->bias(1).value, shuffled->bias(1).value);
}

TEST(Joint, CovarianceStaysSymmetricAndPositiveDefinite) {
  const Flight f = draw_flight(5, 120, true);
  const Joint joint(f.settings);
  Joint::State state = joint.initial();
  for (const Measurement& m : f.measurements) (void)joint.apply(state, m);
  EXPECT_EQ(state.P, state.P.transpose().eval());
  // States of 1e6 m beside scales of 1e-5: positive definite in units of their own sigma.
  const Eigen::VectorXd sigma = state.P.diagonal().cwiseSqrt();
  const Eigen::MatrixXd correlation = sigma.cwiseInverse().asDiagonal() * state.P * sigma.cwiseInverse().asDiagonal();
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(correlation).eigenvalues().minCoeff(), 0);
}

/// The Jacobian of a plot, seen through the filter: the innovation's change with each state, by central differences.
TEST(Joint, GainFollowsTheMeasurementModel) {
  const Flight f = draw_flight(6, 12, true);
  const Joint joint(f.settings);
  Joint::State state = joint.initial();
  for (const Measurement& m : f.measurements) (void)joint.apply(state, m);
  // A plot that agrees with the state moves nothing; one moved by what a state's change explains moves that state.
  const auto expected_plot = [&](const Eigen::VectorXd& x, int radar) {
    const int r = joint.radar_at(radar);
    const double tau = x[r + 9];
    const Eigen::Vector3d p = x.head<3>() - tau * x.segment<3>(3) + tau * tau / 2 * x.segment<3>(6);
    const Site& site = f.settings.radars[static_cast<std::size_t>(radar)].site;
    Displacement<Enu> d = site.enu_of({p});
    d.m += Eigen::Vector3d(x[r + 7], -x[r + 6], x[r + 8]);
    const Polar q = polar_from_enu(d);
    return Polar{q.range_m * (1 + x[r + 3]) + x[r],
                 wrap_two_pi(q.azimuth_rad + x[r + 1] + x[r + 4] * wrap_pi(q.azimuth_rad - std::numbers::pi)),
                 q.elevation_rad * (1 + x[r + 5]) + x[r + 2]};
  };
  const int n = static_cast<int>(state.x.size());
  for (int radar = 0; radar < 2; ++radar) {
    Measurement m;
    m.epoch = state.epoch;
    m.source = radar;
    m.plot = expected_plot(state.x, radar);
    const PolarSigma& s = f.settings.radars[static_cast<std::size_t>(radar)].sigma;
    const Eigen::Vector3d sigma(s.range_m, s.azimuth_rad, s.elevation_rad);
    Joint::State agreed = state;
    ASSERT_EQ(joint.apply(agreed, m).verdict, Verdict::Accepted);
    EXPECT_LT((agreed.x - state.x).cwiseQuotient(state.P.diagonal().cwiseSqrt().cwiseMax(1e-300)).cwiseAbs().maxCoeff(),
              1e-6);

    // H by central differences, then the textbook's posterior covariance with it.
    Eigen::MatrixXd H(3, n);
    for (int i = 0; i < n; ++i) {
      const double h = 1e-3 * std::sqrt(state.P(i, i)) + 1e-12;
      Eigen::VectorXd plus = state.x;
      Eigen::VectorXd minus = state.x;
      plus[i] += h;
      minus[i] -= h;
      const Polar a = expected_plot(plus, radar);
      const Polar b = expected_plot(minus, radar);
      H.col(i) = Eigen::Vector3d(a.range_m - b.range_m, wrap_pi(a.azimuth_rad - b.azimuth_rad),
                                 a.elevation_rad - b.elevation_rad) /
                 (2 * h);
    }
    const Eigen::MatrixXd S = H * state.P * H.transpose() + Eigen::MatrixXd(sigma.cwiseAbs2().asDiagonal());
    const Eigen::MatrixXd P = state.P - state.P * H.transpose() * S.llt().solve(H * state.P);
    const Eigen::VectorXd scale = state.P.diagonal().cwiseSqrt();
    const Eigen::MatrixXd difference =
        scale.cwiseInverse().asDiagonal() * (agreed.P - P) * scale.cwiseInverse().asDiagonal();
    EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-5);  // differences of step 1e-3 sigma: second order below 1e-6
  }
}

}  // namespace
}  // namespace downrange
