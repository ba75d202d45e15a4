/// The parts that joint, schmidt and the bound are made of, each against the same in dense matrices.
#include <gtest/gtest.h>

#include <Eigen/LU>

#include <downrange/est/filter/hypothesis.hpp>
#include <downrange/est/filter/imm.hpp>
#include <numbers>
#include <random>

namespace downrange {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// Draws of unit size.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : rng_(seed) {}

  [[nodiscard]] Matrix matrix(Eigen::Index rows, Eigen::Index columns) {
    return Matrix::NullaryExpr(rows, columns, [this] { return normal_(rng_); });
  }
  [[nodiscard]] Matrix covariance(Eigen::Index n) {
    const Matrix A = matrix(n, n + 2);
    const Matrix P = A * A.transpose();
    return (P + P.transpose()) / 2;
  }
  [[nodiscard]] Hypothesis hypothesis(Eigen::Index n) { return {.x = matrix(n, 1), .P = covariance(n)}; }

 private:
  std::mt19937_64 rng_;
  std::normal_distribution<double> normal_;
};

constexpr double rounding = 1e-12;  // relative, of sums of some hundred products

void expect_near(const Matrix& actual, const Matrix& expected) {
  EXPECT_LT((actual - expected).norm(), rounding * expected.norm());
}
void expect_symmetric(const Matrix& P) { EXPECT_EQ(P, P.transpose().eval()); }

/// Position, velocity, acceleration of three axes from `at` on, others stay; white jerk or white acceleration of
/// density q (Bar-Shalom, Li, Kirubarajan 2001, section 6.2).
TEST(Hypothesis, MotionIsPredictedByFPFAndQ) {
  constexpr double dt = 0.7;
  constexpr double q = 3;
  constexpr int n = 26;
  Draw draw(1);
  for (const int at : {0, 9, n - 9}) {
    for (const auto noise : {MotionModel::Noise::WhiteJerk, MotionModel::Noise::WhiteAcceleration}) {
      Hypothesis h = draw.hypothesis(n);
      Matrix F = Matrix::Identity(n, n);
      Matrix Q = Matrix::Zero(n, n);
      for (int axis = at; axis < at + 3; ++axis) {
        F(axis, axis + 3) = F(axis + 3, axis + 6) = dt;
        F(axis, axis + 6) = dt * dt / 2;
        const bool jerk = noise == MotionModel::Noise::WhiteJerk;
        const double pp = jerk ? std::pow(dt, 5) / 20 : std::pow(dt, 3) / 3;
        const double pv = jerk ? std::pow(dt, 4) / 8 : std::pow(dt, 2) / 2;
        const double vv = jerk ? std::pow(dt, 3) / 3 : dt;
        Q(axis, axis) = q * pp;
        Q(axis + 3, axis + 3) = q * vv;
        Q(axis, axis + 3) = Q(axis + 3, axis) = q * pv;
        if (!jerk) continue;
        Q(axis, axis + 6) = Q(axis + 6, axis) = q * std::pow(dt, 3) / 6;
        Q(axis + 3, axis + 6) = Q(axis + 6, axis + 3) = q * std::pow(dt, 2) / 2;
        Q(axis + 6, axis + 6) = q * dt;
      }
      const Vector x = F * h.x;
      const Matrix P = F * h.P * F.transpose() + Q;
      predict_motion(h, at, {.noise = noise, .q = q, .gravity_aware = false}, dt);
      expect_near(h.x, x);
      expect_near(h.P, P);
      expect_symmetric(h.P);
    }
  }
}

/// x(after) = F2 x + w2, x = F1 x(before) + w1: the bridge's error is what of w1 cannot be told from x(after).
TEST(Kinematics, ABridgeIsTheConditionalMotion) {
  const auto F = [](double dt) {
    Mat<3, 3> transition;
    transition << 1, dt, dt * dt / 2, 0, 1, dt, 0, 0, 1;
    return transition;
  };
  const MotionModel jerk{.noise = MotionModel::Noise::WhiteJerk, .q = 7, .gravity_aware = false};
  for (const double first : {0.0, 0.013, 0.5, 0.99, 1.0}) {
    const double second = 1 - first;
    const Bridge b = bridge(jerk, first, second);
    const Mat<3, 3> Q1 = process_noise(jerk, first);
    const Mat<3, 3> S = F(second) * Q1 * F(second).transpose() + process_noise(jerk, second);
    // Unbiased, uncorrelated with x(after), and of the covariance that is left.
    EXPECT_LT((b.from + b.to * F(second) * F(first) - F(first)).norm(), 1e-9);
    EXPECT_LT((Q1 * F(second).transpose() - b.to * S).norm(), 1e-9 * S.norm());
    EXPECT_LT((b.noise - (Q1 - b.to * S * b.to.transpose())).norm(), 1e-9 * S.norm());
  }
  EXPECT_LT((bridge(jerk, 0, 1).from - Mat<3, 3>::Identity()).norm(), 1e-9);
  EXPECT_LT((bridge(jerk, 1, 0).to - Mat<3, 3>::Identity()).norm(), 1e-6);
}

/// What a radar may be off by without GPS: what is larger is brought down, what an earlier flight has found stays.
TEST(Hypothesis, WithoutGpsPriorsAreTightButNoTighterThanTheyWere) {
  RadarModel wide{.site = Site({0.6, 2.2, 100}), .sigma = {10, 1e-4, 1e-4}};
  RadarModel known = wide;
  for (const BiasTerm term : known.bias.terms) {
    const auto k = static_cast<Eigen::Index>(term);
    known.bias.prior_cov(k, k) *= 1e-4;
  }
  const NoGpsRegime regime;
  const BiasLayout layout = bias_layout_without_gps({wide, known}, regime, 0);
  const auto sigma = [&](std::size_t radar, BiasTerm term) {
    const auto k = static_cast<Eigen::Index>(term);
    return std::sqrt(layout.radars[radar].model.prior_cov(k, k));
  };
  EXPECT_DOUBLE_EQ(sigma(0, BiasTerm::OffsetRange), regime.offset_prior_m);
  EXPECT_DOUBLE_EQ(sigma(0, BiasTerm::OffsetAzimuth), regime.angle_prior_rad);
  EXPECT_DOUBLE_EQ(sigma(0, BiasTerm::ScaleRange), 1e-4 / 4);
  EXPECT_DOUBLE_EQ(sigma(0, BiasTerm::ScaleAzimuth), 1e-3 / 4);
  EXPECT_DOUBLE_EQ(sigma(0, BiasTerm::ScaleElevation), 1e-3 / 4);
  for (const BiasTerm term : layout.radars[1].model.terms) {
    const auto k = static_cast<Eigen::Index>(term);
    EXPECT_DOUBLE_EQ(sigma(1, term), std::sqrt(known.bias.prior_cov(k, k)));
  }
}

/// A mount that wanders by an angle on the sky reports an azimuth that is off by that over cos(elevation).
TEST(Hypothesis, PointingErrorsAreOnTheSky) {
  constexpr double deg = std::numbers::pi / 180;
  for (const double elevation : {5 * deg, 60 * deg, 83 * deg}) {
    RadarModel radar{.site = Site({34 * deg, 127 * deg, 100}), .sigma = {10, 1e-4, 1e-4}};
    radar.wander = {.sigma_rad = 3e-4, .tau_s = 30};
    const BiasLayout layout = bias_layout({radar}, 9);
    const RadarBlock& block = layout.radars[0];
    Vector x = Vector::Zero(9 + layout.size);
    x.head<3>() = radar.site.ecef_of(enu_from_polar({400e3, 1.2, elevation})).m;
    const auto linearised = [&] { return linearise_plot(Vec<9>(x.head<9>()), 0, x, radar, block, {400e3, 1.2, 0}); };
    const PlotLinearisation l = linearised();
    for (int axis = 0; axis < 2; ++axis) {
      constexpr double off = 1e-5;
      x[block.at + block.terms + axis] = off;
      const Vec<3> change = l.nu - linearised().nu;
      x[block.at + block.terms + axis] = 0;
      EXPECT_NEAR(change[1], axis == 0 ? off / std::cos(elevation) : 0, 1e-9 * off);
      EXPECT_NEAR(change[2], axis == 1 ? off : 0, 1e-9 * off);
      EXPECT_LT((l.H.of_radar.col(block.terms + axis) - change / off).norm(), 1e-9);
    }
  }
}

/// A radar two kilometres from the target, whose place may be wrong by a hundred metres: some plots, with everything
/// drawn from what the filter assumes. Mean squared error of all states in units of their covariance; 1 is right.
template <class Linearise>
double error_in_units_of_covariance(int plots, const Linearise& linearise) {
  RadarModel radar;
  radar.site = Site({0.6, 2.2, 100});
  radar.sigma = {25, 1.7e-4, 1.7e-4};
  const RadarBlock block = bias_layout({radar}, 9).radars[0];
  const int n = 9 + block.size();
  constexpr int draws = 200;
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= draws; ++seed) {
    Draw draw(seed);
    Hypothesis h{.x = Vector::Zero(n), .P = Matrix::Zero(n, n)};
    h.x.head<3>() = radar.site.ecef_of(Displacement<Enu>{{1500, -1200, 800}}).m;
    h.P.diagonal().head<9>() << 9, 9, 9, 1, 1, 1, 1, 1, 1;
    reset_bias(h, block);
    const Vector truth = h.x + h.P.llt().matrixL() * draw.matrix(n, 1);
    const Vec<3> variance = plot_variance(radar, Plot{});
    for (int i = 0; i < plots; ++i) {
      const PlotLinearisation seen = linearise_plot(truth.head<9>(), 0, truth, radar, block, Polar{});
      const Vec<3> z = -seen.nu + Vec<3>(variance.cwiseSqrt().cwiseProduct(draw.matrix(3, 1)));
      const Linearisation<3> l = linearise(h, radar, block, Polar{z[0], z[1], z[2]}, variance);
      apply_evidence<3>(h, evidence_of<3>(h, l.H, l.nu, variance.asDiagonal()));
    }
    const Vector error = h.x - truth;
    sum += error.dot(h.P.ldlt().solve(error)) / n;
  }
  return sum / draws;
}

TEST(Hypothesis, ABiasSeenFromNearByIsNoSurerThanItIs) {
  const auto once = [](const Hypothesis& h, const RadarModel& radar, const RadarBlock& block, const Polar& plot,
                       const Vec<3>&) { return linearise_plot(h, 0, MotionModel{}, radar, block, plot); };
  const auto where_they_agree = [](const Hypothesis& h, const RadarModel& radar, const RadarBlock& block,
                                   const Polar& plot, const Vec<3>& variance) {
    return linearise_components<0, 3>(h, 0, MotionModel{}, radar, block, plot, variance);
  };
  EXPECT_GT(error_in_units_of_covariance(1, once), 10);
  EXPECT_NEAR(error_in_units_of_covariance(1, where_they_agree), 1, 0.2);
  EXPECT_LT(error_in_units_of_covariance(30, where_they_agree), error_in_units_of_covariance(30, once) / 5);
}

TEST(Hypothesis, GaussMarkovStatesKeepTheirStationaryVariance) {
  constexpr int n = 12;
  constexpr double sigma = 3;
  constexpr double tau = 40;
  constexpr double dt = 15;
  Draw draw(2);
  Hypothesis h = draw.hypothesis(n);
  const double phi = std::exp(-dt / tau);
  Matrix F = Matrix::Identity(n, n);
  Matrix Q = Matrix::Zero(n, n);
  for (int i = 4; i < 7; ++i) {
    F(i, i) = phi;
    Q(i, i) = sigma * sigma * (1 - phi * phi);
  }
  const Vector x = F * h.x;
  const Matrix P = F * h.P * F.transpose() + Q;
  predict_gauss_markov(h, 4, 3, sigma, tau, dt);
  expect_near(h.x, x);
  expect_near(h.P, P);
  for (int i = 0; i < 1000; ++i) predict_gauss_markov(h, 4, 3, sigma, tau, dt);
  EXPECT_NEAR(h.P(5, 5), sigma * sigma, 1e-9);
}

TEST(Hypothesis, BiasesDriftByTheirVarianceAndNothingElse) {
  RadarModel radar;
  radar.bias = bias_model({BiasBlock::Polar, BiasBlock::Time});
  radar.bias.drift[static_cast<Eigen::Index>(BiasTerm::OffsetAzimuth)] = 0.02;
  radar.bias.drift[static_cast<Eigen::Index>(BiasTerm::TimeTag)] = 0.5;
  const BiasLayout layout = bias_layout({radar, radar}, 3);
  ASSERT_EQ(layout.size, 14);
  Hypothesis h = Draw(3).hypothesis(17);
  Matrix P = h.P;
  for (const int at : {3, 10}) {
    P(at + 1, at + 1) += 0.02 * 0.02 * 2.5;
    P(at + 6, at + 6) += 0.5 * 0.5 * 2.5;
  }
  predict_bias(h, layout, 2.5);
  expect_near(h.P, P);
}

/// Weighing and taking a measurement of M rows: the textbook's S, NIS and posterior, for a Jacobian of two blocks.
template <int M>
void expect_textbook_update(std::uint64_t seed, int motion_size) {
  constexpr int n = 40;
  Draw draw(seed);
  Hypothesis h = draw.hypothesis(n);
  BlockJacobian<M> H{.motion_at = 9, .motion_size = motion_size, .radar_at = 25, .radar_size = 10};
  H.of_motion = draw.matrix(M, 12);
  H.of_radar = draw.matrix(M, RadarBlock::max_size);
  const Mat<M, M> R = draw.covariance(M);
  const Vec<M> nu = draw.matrix(M, 1);
  Matrix dense = Matrix::Zero(M, n);
  dense.middleCols(9, motion_size) = H.of_motion.leftCols(motion_size);
  dense.middleCols(25, 10) = H.of_radar.leftCols(10);

  const Evidence<M> e = evidence_of<M>(h, H, nu, R);
  const Matrix S = dense * h.P * dense.transpose() + R;
  const Matrix K = h.P * dense.transpose() * S.inverse();
  ASSERT_FALSE(e.singular);
  expect_near(e.S, S);
  EXPECT_NEAR(e.nis, nu.dot(S.inverse() * nu), 1e-9);
  EXPECT_NEAR(e.log_likelihood, -e.nis / 2 - std::log(S.determinant()) / 2, 1e-9);
  EXPECT_LT((gain(e) - K).norm(), 1e-9 * K.norm());
  EXPECT_LT((observe(H, Matrix(h.P)) - dense * h.P).norm(), rounding * h.P.norm());

  const Vector x = h.x + K * nu;
  const Matrix P = (h.P.inverse() + dense.transpose() * R.inverse() * dense).inverse();
  apply_evidence<M>(h, e);
  EXPECT_LT((h.x - x).norm(), 1e-9 * x.norm());
  EXPECT_LT((h.P - P).norm(), 1e-9 * P.norm());
  expect_symmetric(h.P);
}

TEST(Hypothesis, UpdatesAreTheInformationFilters) {
  expect_textbook_update<2>(4, 9);
  expect_textbook_update<3>(5, 9);
  expect_textbook_update<3>(6, 12);
  expect_textbook_update<6>(7, 12);
}

TEST(Hypothesis, AMeasurementOfNegativeVarianceIsSingularAndNaNIsNeverInsideAGate) {
  Hypothesis h = Draw(8).hypothesis(20);
  BlockJacobian<3> H;
  H.of_motion.setRandom();
  EXPECT_TRUE(evidence_of<3>(h, H, Vec<3>::Zero(), -1e6 * Mat<3, 3>::Identity()).singular);
  const Evidence<3> e = evidence_of<3>(h, H, Vec<3>(0, std::nan(""), 0), Mat<3, 3>::Identity());
  EXPECT_FALSE(e.nis <= std::numeric_limits<double>::infinity());
}

/// Of kinematics launch a phase lasts as long as the settings say, and each model is the one it is meant to be.
TEST(ModelSet, ALaunchIsAsItsSettingsSay) {
  KinematicsSettings settings;
  settings.launch = {.q_ballistic_m2_s5 = 1e-4,
                     .ballistic_sigma_m_s2 = 0.3,
                     .q_thrust_m2_s5 = 2,
                     .q_event_m2_s5 = 70,
                     .phase_s = 40,
                     .event_s = 5,
                     .initial_ballistic = 0.2,
                     .initial_event = 0.1};
  const ModelSet set = model_set(settings);
  ASSERT_EQ(set.count, 3);
  EXPECT_EQ(set.ballistic, 0);
  EXPECT_EQ(set.ballistic_sigma_m_s2, 0.3);
  EXPECT_EQ(set.model[0].q, 1e-4);
  EXPECT_EQ(set.model[1].q, 2);
  EXPECT_EQ(set.model[2].q, 70);
  const std::array<double, 3> lasts{40, 40, 5};
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(set.model[static_cast<std::size_t>(i)].gravity_aware);
    EXPECT_NEAR(-1 / set.rates(i, i), lasts[static_cast<std::size_t>(i)], 1e-12);
    EXPECT_NEAR(set.rates.row(i).sum(), 0, 1e-15);
  }
  EXPECT_NEAR(set.initial_probability[0], 0.2, 1e-15);
  EXPECT_NEAR(set.initial_probability[1], 0.7, 1e-15);
  EXPECT_NEAR(set.initial_probability[2], 0.1, 1e-15);
  // From thrust, over 0.2 s of a mean of 40 s, and shared between the two others.
  EXPECT_NEAR(set.switching(1, 0) + set.switching(1, 2), 0.2 / 40, 2e-4);
}

/// The interaction of the models is the moment matching of imm.hpp over all states; only a ballistic model keeps its
/// own specific force, and where the models disagree on the force the position is known less.
TEST(Hypothesis, MixingIsMomentMatching) {
  constexpr int n = 14;
  constexpr int at = 2;
  Draw draw(9);
  ModelSet set;
  set.count = 3;
  set.ballistic = 0;
  Mat<3, 3> switching;
  switching << 0.9, 0.06, 0.04, 0.05, 0.85, 0.1, 0.2, 0.3, 0.5;
  Bank bank;
  bank.count = 3;
  bank.probability = Vec<3>(0.2, 0.5, 0.3);
  imm::Bank<n, 3> modes;
  for (std::size_t i = 0; i < 3; ++i) {
    bank.mode[i] = draw.hypothesis(n);
    modes[i] = {bank.mode[i].x, bank.mode[i].P};
  }
  const auto mixing = imm::mixing_weights<3>(bank.probability, switching);
  auto expected = imm::mix(modes, mixing);
  for (std::size_t to = 0; to < 3; ++to) {
    for (std::size_t from = 0; from < 3; ++from) {
      const Vec<3> apart = modes[from].mean.segment<3>(at + 6) - expected[to].mean.segment<3>(at + 6);
      expected[to].cov.block<3, 3>(at, at) +=
          2.0 / 144 * mixing.weights(static_cast<int>(from), static_cast<int>(to)) * apart * apart.transpose();
    }
  }
  const Hypothesis ballistic = bank.mode[0];
  Bank scratch;
  mix(bank, set, switching, at, scratch);

  expect_near(bank.probability, mixing.predicted);
  for (std::size_t i = 1; i < 3; ++i) {
    expect_near(bank.mode[i].x, expected[i].mean);
    expect_near(bank.mode[i].P, expected[i].cov);
    expect_symmetric(bank.mode[i].P);
  }
  const Hypothesis& mixed = bank.mode[0];
  const double own = mixing.weights(0, 0);
  for (int i = 0; i < n; ++i) {
    const bool force = i >= at + 6 && i < at + 9;
    EXPECT_NEAR(mixed.x[i], force ? own * ballistic.x[i] : expected[0].mean[i], 1e-12);
    for (int j = 0; j < n; ++j) {
      if (force || (j >= at + 6 && j < at + 9)) {
        const double prior = i == j ? (1 - own) * std::pow(set.ballistic_sigma_m_s2, 2) : 0;
        EXPECT_NEAR(mixed.P(i, j), own * ballistic.P(i, j) + prior, 1e-10);
      } else {
        EXPECT_NEAR(mixed.P(i, j), expected[0].cov(i, j), 1e-10);
      }
    }
  }
}

/// An engine of 50 m/s^2 stops at the instant of a fix. The next fix, a second later, tells the velocity: the position
/// that follows from it must be as near as its covariance says, to be believed no more than it is worth.
TEST(Hypothesis, ACutOffBetweenTwoFixesIsWhereTheCovarianceSays) {
  const ModelSet set = model_set(KinematicsSettings{});
  const MotionModel& flown = set.model[1];
  Vec<9> truth;
  truth << 6'500'000, 0, 0, 2'000, 5'000, 0, 30, 40, 0;
  Bank bank;
  bank.count = 3;
  bank.probability = set.initial_probability;
  Matrix P = Matrix::Zero(9, 9);
  P.diagonal() << 9, 9, 9, 1, 1, 1, 1, 1, 1;
  for (std::size_t i = 0; i < 3; ++i) bank.mode[i] = {.x = truth, .P = P};
  bank.mode[0].x.tail<3>().setZero();
  Fix fix;
  fix.sigma_horizontal_m = fix.sigma_vertical_m = 5;
  fix.sigma_velocity_m_s = 0.2;
  fix.velocity_valid = true;
  Bank scratch;
  const auto fly_a_second = [&] {
    for (int i = 0; i < 5; ++i) {
      truth = predict_mean(flown, truth, 0.2);
      for (std::size_t k = 0; k < 3; ++k) predict_motion(bank.mode[k], 0, set.model[k], 0.2);
      mix(bank, set, set.switching, 0, scratch);
    }
    Vec<3> log_likelihoods;
    BlockJacobian<6> H;
    H.motion_size = 9;
    H.of_motion.leftCols<6>().setIdentity();
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec<6> nu = truth.head<6>() - bank.mode[k].x.head<6>();
      const Evidence<6> e = evidence_of<6>(bank.mode[k], H, nu, fix_noise<6>(fix));
      log_likelihoods[static_cast<Eigen::Index>(k)] = e.log_likelihood;
      apply_evidence<6>(bank.mode[k], e);
    }
    reweigh(bank, log_likelihoods);
  };
  for (int i = 0; i < 20; ++i) fly_a_second();
  truth.tail<3>().setZero();
  for (int after_s = 1; after_s <= 10; ++after_s) {
    fly_a_second();
    const Gaussian<9> track = combined_motion(bank, set, 0, 0);
    const Vec<3> off = track.mean.head<3>() - truth.head<3>();
    const double nees = off.dot(track.cov.topLeftCorner<3, 3>().llt().solve(off));
    EXPECT_LT(nees, 1.5) << after_s << " s after the cut-off, " << off.norm() << " m off";
  }
}

}  // namespace
}  // namespace downrange
