/// Method ts: one target's joint filter, many targets' honest biases without GPS, order irrelevant.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <array>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/est/filter/model_set.hpp>
#include <downrange/est/method/ts.hpp>
#include <downrange/est/model/plot_model.hpp>

#include "../support/drawn_flight.hpp"

namespace downrange {
namespace {

using test::deg;
using test::draw_flight;
using test::Flight;

TEST(Ts, IsTheJointFilterOfOneTarget) {
  Flight f = draw_flight(3, 40, true);
  f.settings.motion.kinematics = Kinematics::Ca;
  f.settings.gps.no_gps.enabled = false;
  ASSERT_TRUE(is_fix(f.measurements[0]));  // from a plot the two start differently
  const auto ts = make_method("ts", f.settings);
  const auto joint = make_method("joint", f.settings);
  for (const Measurement& m : f.measurements) {
    const Outcome a = ts->process(m, m.epoch);
    const Outcome b = joint->process(m, m.epoch);
    ASSERT_EQ(a.verdict, b.verdict);
    ASSERT_NEAR(a.nis, b.nis, 1e-5 * (1 + b.nis));
    const auto x = ts->fused(0);
    const auto y = joint->fused(0);
    ASSERT_TRUE(x && y);
    // Positions of 6e6 m hold 1e-9 m, and the joint covariance comes down from (3000 m/s)^2 by differences.
    const Vec<9> sigma = y->cov.diagonal().cwiseSqrt();
    ASSERT_LT((x->mean - y->mean).cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 1e-5);
    ASSERT_LT((x->cov.diagonal().cwiseSqrt() - sigma).cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 1e-5);
  }
  for (int radar = 0; radar < 2; ++radar) {
    const BiasEstimate x = ts->bias(radar);
    const BiasEstimate y = joint->bias(radar);
    ASSERT_EQ(x.terms, y.terms);
    EXPECT_EQ(x.term, y.term);
    EXPECT_EQ(x.samples, y.samples);
    EXPECT_EQ(x.reference, BiasReference::Gps);
    for (int i = 0; i < x.terms; ++i) {
      EXPECT_NEAR(x.value[i], y.value[i], 1e-5 * std::sqrt(y.cov(i, i)));
      EXPECT_NEAR(x.cov(i, i), y.cov(i, i), 1e-5 * y.cov(i, i));
    }
  }
}

/// Two radars, targets moved by white jerk, biases drawn from the priors of the regime without GPS; no GPS.
struct Scene {
  MethodSettings settings;
  std::array<Vec<bias_term_count>, 2> bias;
  std::vector<Measurement> plots;
  std::vector<Vec<9>> truth;  ///< at the last epoch
};

Scene draw_scene(std::uint64_t seed, int targets, double duration_s) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  Scene s;
  const PolarSigma sigma{10, 0.02 * deg, 0.02 * deg};
  for (const Geodetic& at : {Geodetic{34.445 * deg, 127.52 * deg, 120}, Geodetic{34.0 * deg, 127.0 * deg, 350}}) {
    RadarModel radar{.site = Site(at), .sigma = sigma};
    radar.bias = bias_model({BiasBlock::Polar});
    s.settings.radars.push_back(radar);
  }
  s.settings.targets = targets;
  s.settings.motion.q_ca_m2_s5 = 0.1;
  s.settings.start.sigma_velocity_m_s = 300;
  s.settings.start.sigma_acceleration_m_s2 = 3;
  for (Vec<bias_term_count>& b : s.bias) {
    b.setZero();
    b.segment<6>(static_cast<int>(BiasTerm::OffsetRange)) << 25 * normal(rng),
        s.settings.gps.no_gps.angle_prior_rad * normal(rng), s.settings.gps.no_gps.angle_prior_rad * normal(rng),
        1e-4 / 4 * normal(rng), 1e-3 / 4 * normal(rng), 1e-3 / 4 * normal(rng);
  }
  const MotionModel motion{.noise = MotionModel::Noise::WhiteJerk, .q = 0.1, .gravity_aware = false};
  const double dt = 0.5;
  const Mat<3, 3> root_Q = process_noise(motion, dt).llt().matrixL();
  const Site centre({34.6 * deg, 127.2 * deg, 0});
  for (int t = 0; t < targets; ++t) {
    Vec<9> x = Vec<9>::Zero();
    x.head<3>() = centre.ecef_of({{20e3 * normal(rng), 80e3 + 15e3 * normal(rng), 9000 + 1000 * normal(rng)}}).m;
    for (int i = 3; i < 9; ++i) x[i] = (i < 6 ? 150 : 1) * normal(rng);
    s.truth.push_back(x);
  }
  for (int k = 0; k < static_cast<int>(duration_s / dt); ++k) {
    const auto radar = static_cast<std::size_t>(k % 2);
    for (int t = 0; t < targets; ++t) {
      Vec<9>& x = s.truth[static_cast<std::size_t>(t)];
      if (k > 0) x = predict_mean(motion, x, dt);
      for (int axis = 0; axis < 3 && k > 0; ++axis) {
        const Vec<3> w = root_Q * Vec<3>(normal(rng), normal(rng), normal(rng));
        for (int part = 0; part < 3; ++part) x[3 * part + axis] += w[part];
      }
      const Vec<3> q = predict_plot(s.settings.radars[radar], x, s.bias[radar]).q;
      Measurement m;
      m.epoch = Time{} + seconds(1000 + k * dt);
      m.source = static_cast<int>(radar);
      m.target = t;
      m.sequence = static_cast<std::uint64_t>(k);
      test::polar(m) = {q[0] + sigma.range_m * normal(rng), q[1] + sigma.azimuth_rad * normal(rng),
                        q[2] + sigma.elevation_rad * normal(rng)};
      s.plots.push_back(m);
    }
  }
  return s;
}

TEST(Ts, FindsBiasesFromManyTargetsAndIsHonestAboutThem) {
  constexpr int runs = 15;
  constexpr int targets = 12;
  double nees_bias = 0;
  double nees_position = 0;
  double azimuth_variance = 0;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    Scene s = draw_scene(seed, targets, 60);
    s.settings.arbitration.gate_probability = 1;
    const auto ts = make_method("ts", s.settings);
    for (const Measurement& m : s.plots) EXPECT_EQ(ts->process(m, m.epoch).verdict, Verdict::Accepted);
    const BiasEstimate b = ts->bias(0);
    ASSERT_EQ(b.terms, 6);
    EXPECT_EQ(b.reference, BiasReference::CrossRadar);
    const Vec<6> e = b.value.head<6>() - s.bias[0].segment<6>(static_cast<int>(BiasTerm::OffsetRange));
    nees_bias += e.dot(Mat<6, 6>(b.cov.topLeftCorner<6, 6>()).llt().solve(e));
    azimuth_variance += b.cov(1, 1) / runs;
    const auto x = ts->fused(5);
    ASSERT_TRUE(x);
    const Vec<3> e_x = x->mean.head<3>() - s.truth[5].head<3>();
    nees_position += e_x.dot(Mat<3, 3>(x->cov.topLeftCorner<3, 3>()).llt().solve(e_x));
  }
  // Bands that an honest filter leaves once in 10 000 such tests.
  EXPECT_GT(nees_bias, chi2_quantile(0.00005, 6 * runs));
  EXPECT_LT(nees_bias, chi2_quantile(0.99995, 6 * runs));
  EXPECT_GT(nees_position, chi2_quantile(0.00005, 3 * runs));
  EXPECT_LT(nees_position, chi2_quantile(0.99995, 3 * runs));
  EXPECT_LT(std::sqrt(azimuth_variance), 0.5 * NoGpsRegime{}.angle_prior_rad);
}

TEST(Ts, OneRadarAloneLearnsNothingAndSaysSo) {
  Scene s = draw_scene(20, 4, 30);
  std::erase_if(s.plots, [](const Measurement& m) { return m.source == 1; });
  const auto ts = make_method("ts", s.settings);
  for (const Measurement& m : s.plots) (void)ts->process(m, m.epoch);
  const BiasEstimate b = ts->bias(0);
  EXPECT_EQ(b.reference, BiasReference::None);
  // An offset that all plots share is the place of all targets; range and its scale are seen by nobody else either.
  for (int i = 0; i < b.terms; ++i) EXPECT_EQ(b.state[static_cast<std::size_t>(i)], BiasState::NotObservable) << i;
}

TEST(Ts, ShuffledArrivalGivesTheInOrderBits) {
  const Scene s = draw_scene(21, 3, 20);
  const auto in_order = make_method("ts", s.settings);
  for (const Measurement& m : s.plots) (void)in_order->process(m, m.epoch);
  std::mt19937_64 rng(5);
  std::vector<std::pair<Time, std::size_t>> arrival;
  for (std::size_t i = 0; i < s.plots.size(); ++i)
    arrival.push_back({s.plots[i].epoch + milliseconds(static_cast<std::int64_t>(rng() % 2000)), i});
  std::sort(arrival.begin(), arrival.end());
  const auto shuffled = make_method("ts", s.settings);
  for (const auto& [at, i] : arrival) (void)shuffled->process(s.plots[i], at);
  for (int t = 0; t < 3; ++t) {
    EXPECT_EQ(in_order->fused(t)->mean, shuffled->fused(t)->mean);
    EXPECT_EQ(in_order->fused(t)->cov, shuffled->fused(t)->cov);
  }
  EXPECT_EQ(in_order->bias(1).value, shuffled->bias(1).value);
}

TEST(Ts, ARadarThatStepsIsFoundAgain) {
  Scene s = draw_scene(22, 6, 120);
  const Time step = Time{} + seconds(1060);
  for (Measurement& m : s.plots)
    if (m.source == 1 && m.epoch > step) test::polar(m).range_m += 400;  // four sigma of what it can be
  s.settings.gps.no_gps.enabled = false;
  s.settings.arbitration.reopen_after = 20;
  const auto ts = make_method("ts", s.settings);
  Verdict last = Verdict::Accepted;
  int rejected = 0;
  for (const Measurement& m : s.plots) {
    const Outcome outcome = ts->process(m, m.epoch);
    if (m.source == 1) last = outcome.verdict;
    rejected += outcome.verdict != Verdict::Accepted;
  }
  EXPECT_GT(rejected, 10);
  EXPECT_EQ(last, Verdict::Accepted);
}

/// An engine is cut off between two fixes. A receiver that jumps by 300 m is refused as ever, and leaves the track as
/// it was.
TEST(Ts, ACutOffIsNoFaultOfTheReceiver) {
  for (const double jump_m : {0.0, 300.0}) {
    MethodSettings settings = draw_flight(1, 1, false).settings;
    settings.radars.clear();
    const auto ts = make_method("ts", settings);
    const Vec<3> start(-3.2e6, 4.2e6, 3.7e6);
    const Vec<3> up = start.normalized();
    double sigma_before_m = 0;
    for (int t = 0; t < 40; ++t) {
      const double burning = std::min(t, 20);
      Measurement m;
      m.epoch = Time{} + seconds(100.0 + t);
      m.sequence = static_cast<std::uint64_t>(t) + 1;
      m.measured = Fix{};
      Fix& fix = test::fix(m);
      fix.position.m = start + (2000 * t + 15 * burning * burning + 30 * burning * (t - burning)) * up;
      fix.velocity.m_s = (2000 + 30 * burning) * up;
      fix.velocity_valid = true;
      fix.sigma_horizontal_m = fix.sigma_vertical_m = 5;
      fix.sigma_velocity_m_s = 0.2;
      const bool jumps = t == 30 && jump_m > 0;
      if (jumps) fix.position.m += jump_m * up;
      EXPECT_EQ(ts->process(m, m.epoch).verdict, jumps ? Verdict::Gated : Verdict::Accepted) << t;
      const double sigma_m = std::sqrt(ts->fused(0, m.epoch)->cov.topLeftCorner<3, 3>().trace());
      if (jumps) {
        EXPECT_LT(sigma_m, 3 * sigma_before_m);
      }
      sigma_before_m = sigma_m;
    }
  }
}

TEST(Ts, DriftKeepsBiasesOpen) {
  Scene s = draw_scene(23, 4, 60);
  const auto still = make_method("ts", s.settings);
  for (RadarModel& radar : s.settings.radars)
    radar.bias.drift[static_cast<int>(BiasTerm::OffsetRange)] = 5;  // m per root second
  const auto drifting = make_method("ts", s.settings);
  for (const Measurement& m : s.plots) {
    (void)still->process(m, m.epoch);
    (void)drifting->process(m, m.epoch);
  }
  EXPECT_GT(drifting->bias(0).cov(0, 0), still->bias(0).cov(0, 0) + 5 * 5);
}

}  // namespace
}  // namespace downrange
