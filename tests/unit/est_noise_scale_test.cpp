/// Noise learnt in flight: right where it is right, found where it is configured wrongly, not taught by outliers, liars
/// or an unknown track; and the same in a method.
#include <gtest/gtest.h>

#include <cmath>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/est/filter/noise_scale.hpp>

#include "../support/drawn_flight.hpp"

namespace downrange {
namespace {

/// A filter whose track is known to a constant variance, and its plots' range, azimuth and elevation; in units of the
/// configured sigma.
class World {
 public:
  explicit World(std::uint64_t seed, double angle_inflation = 1, bool wander_is_state = true)
      : rng_(seed),
        scale(NoiseScale::of_radar(angle_inflation, wander_is_state)),
        inflation_(1, angle_inflation, angle_inflation) {}

  /// `error`: of the plot, where it is not drawn.
  Verdict plot(double true_sigma, bool suspected = false, bool referenced = true, std::optional<double> error = {}) {
    t_ = t_ + milliseconds(100);
    const Vec<3> R = inflation_.cwiseProduct(scale.factors<3>(0));
    const Mat<3, 3> S = Mat<3, 3>((R + Vec<3>::Constant(track_variance)).asDiagonal());
    Vec<3> nu;
    for (double& x : nu) x = std::sqrt(track_variance) * normal_(rng_) + error.value_or(true_sigma * normal_(rng_));
    const Eigen::LLT<Mat<3, 3>> llt(S);
    const Vec<3> whitened = llt.matrixL().solve(nu);
    const Verdict verdict = whitened.squaredNorm() <= gate_ ? Verdict::Accepted : Verdict::Gated;
    if (scale.open(t_, suspected, referenced)) {
      const Mat<3, 3> excess =
          verdict == Verdict::Accepted ? noise_excess<3>(llt.matrixL(), whitened) : Mat<3, 3>(nu * nu.transpose() - S);
      scale.update_scale<3>(0, R, {.verdict = verdict, .excess = excess});
    }
    return verdict;
  }
  void plots(int count, double true_sigma) {
    for (int i = 0; i < count; ++i) (void)plot(true_sigma);
  }
  [[nodiscard]] double ratio(int component) const { return scale.sigma_ratio(component); }

 private:
  static constexpr double track_variance = 0.2;
  std::mt19937_64 rng_;
  std::normal_distribution<double> normal_;
  double gate_ = chi2_quantile(0.9999, 3);
  Time t_;

 public:
  NoiseScale scale;

 private:
  Vec<3> inflation_;
};

/// It averages over some 500 plots: sigma scatters by 2 to 3 %, the mean of 16 x 3 by half a percent.
double mean_ratio(double true_sigma, int plots, double angle_inflation = 1) {
  double sum = 0;
  constexpr int runs = 16;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    World world(seed, angle_inflation);
    world.plots(plots, true_sigma);
    for (int i = 0; i < 3; ++i) sum += world.ratio(i) / (3 * runs);
  }
  return sum;
}

TEST(NoiseScale, RightSigmasStay) { EXPECT_NEAR(mean_ratio(1, 5000), 1, 0.02); }

TEST(NoiseScale, ThirdAndThreefoldAreFound) {
  EXPECT_NEAR(mean_ratio(3, 2000), 3, 0.06);
  // Where the track is known to 0.45 sigma, a sigma of 0.33 shows slowly.
  EXPECT_NEAR(mean_ratio(1.0 / 3, 8000), 1.0 / 3, 0.03);
}

TEST(NoiseScale, IsToldBesideTheConfiguredWhateverTheInflation) { EXPECT_NEAR(mean_ratio(1, 4000, 4), 1, 0.02); }

/// Slow pointing errors do not show as white noise: where nothing else stands for them, the inflation stays.
TEST(NoiseScale, InflationThatStandsForWanderIsNotUnlearnt) {
  World world(1, 4, false);
  world.plots(4000, 1);
  EXPECT_NEAR(world.ratio(0), 1, 0.15);
  EXPECT_NEAR(world.ratio(1), 2, 1e-9);
  world.plots(4000, 3);
  EXPECT_NEAR(world.ratio(1), 3, 0.3);
}

/// However many they are.
TEST(NoiseScale, WhatNoNoiseCouldDoTeachesNothing) {
  World world(1);
  world.plots(1000, 1);
  const double before = world.ratio(0);
  for (int i = 0; i < 1000; ++i) (void)world.plot(1, false, true, 6000);
  EXPECT_EQ(world.ratio(0), before);
}

TEST(NoiseScale, WaitsForThePlotsThatFindTheBiases) {
  World world(1);
  world.plots(NoiseScale::plots_before - 1, 3);
  EXPECT_EQ(world.ratio(0), 0);
  EXPECT_EQ(world.scale.factor(0), 1);
  world.plots(10, 3);
  EXPECT_GT(world.ratio(0), 1);
}

TEST(NoiseScale, OutliersTeachNothing) {
  double with = 0;
  double without = 0;
  for (std::uint64_t seed = 1; seed <= 16; ++seed) {
    World clean(seed);
    World spoilt(seed);
    for (int i = 0; i < 4000; ++i) {
      (void)clean.plot(1);
      (void)spoilt.plot(1);
      if (i % 20 == 0) {
        EXPECT_EQ(spoilt.plot(1, false, true, 30.0), Verdict::Gated);
      }
    }
    for (int k = 0; k < 3; ++k) {
      with += spoilt.ratio(k) / 48;
      without += clean.ratio(k) / 48;
    }
  }
  EXPECT_NEAR(with, without, 0.02);
}

TEST(NoiseScale, IsHeldWithoutReference) {
  World world(3);
  world.plots(1000, 1);
  const double before = world.ratio(0);
  for (int i = 0; i < 1000; ++i) (void)world.plot(3, false, false);
  EXPECT_EQ(world.ratio(0), before);
}

/// A source lies for five seconds before it is suspected, so much that most of it is rejected.
TEST(NoiseScale, ASuspectedSourceHasWhatItHadBefore) {
  World world(4);
  world.plots(1995, 1);  // to the plot before a value is kept, every ten seconds from 0.1 s on
  const double before = world.ratio(0);
  for (int i = 0; i < 50; ++i) (void)world.plot(1, false, true, 20.0);
  EXPECT_GT(world.ratio(0), 1.2 * before);
  (void)world.plot(1, true);
  const double held = world.ratio(0);
  EXPECT_NEAR(held, before, 0.05);
  for (int i = 0; i < 500; ++i) (void)world.plot(3, true);
  EXPECT_EQ(world.ratio(0), held);
  world.plots(1500, 3);
  EXPECT_NEAR(world.ratio(0), 3, 0.3) << "believed again it teaches again";
}

TEST(NoiseScale, NothingWindsUp) {
  World world(5);
  world.plots(1000, 1);
  for (int i = 0; i < 5000; ++i) (void)world.plot(1, false, true, i < 100 ? 30 : 100);
  EXPECT_LE(world.ratio(0), std::sqrt(NoiseScale::most) * (1 + 1e-9));
  world.plots(4500, 1);  // 100 exp(-4500 / 500) is left
  EXPECT_NEAR(world.ratio(0), 1, 0.1);
}

TEST(NoiseScale, NotANumberTeachesNothing) {
  World world(6);
  world.plots(1000, 1);
  for (int i = 0; i < 200; ++i) (void)world.plot(1, false, true, std::nan(""));
  EXPECT_TRUE(std::isfinite(world.ratio(0)));
  EXPECT_GT(world.scale.factor(0), 0);
}

/// Fixes anywhere on the Earth whose height alone is three times as noisy as stated.
TEST(NoiseScale, OfFixesInEastNorthUp) {
  std::mt19937_64 rng(7);
  std::normal_distribution<double> normal;
  NoiseScale scale;
  for (int i = 0; i < 2000; ++i) {
    const Geodetic place{std::asin(2.0 * i / 2000 - 1) * 0.99, 0.37 * i, 1e5};
    Fix stated{.position = ecef_from_geodetic(place), .velocity_valid = true};
    stated.sigma_horizontal_m = 2;
    stated.sigma_vertical_m = 3;
    stated.sigma_velocity_m_s = 0.1;
    const Fix used = scale.believed(stated);
    const Mat<3, 3> R_ecef_enu = enu_from_ecef_at(geodetic_from_ecef(used.position)).R.transpose();
    Mat<6, 6> S = 0.01 * 0.01 * Mat<6, 6>::Identity();
    S.topLeftCorner<3, 3>() += fix_covariance(used);
    S.bottomRightCorner<3, 3>() += used.sigma_velocity_m_s * used.sigma_velocity_m_s * Mat<3, 3>::Identity();
    Vec<6> nu;
    nu << R_ecef_enu * Vec<3>(2 * normal(rng), 2 * normal(rng), 9 * normal(rng)),
        0.05 * Vec<3>(normal(rng), normal(rng), normal(rng));
    const Eigen::LLT<Mat<6, 6>> llt(S);
    ASSERT_TRUE(scale.open(Time{} + seconds(1.0 * i), false, true));
    scale.update_scale<6>(
        used, {.verdict = Verdict::Accepted, .excess = noise_excess<6>(llt.matrixL(), llt.matrixL().solve(nu))});
  }
  EXPECT_NEAR(scale.sigma_ratio(0), 1, 0.15);
  EXPECT_NEAR(scale.sigma_ratio(1), 3, 0.6);
  EXPECT_NEAR(scale.sigma_ratio(2), 0.5, 0.07);
  EXPECT_EQ(scale.sigma_ratio(3), 0);
}

class LearningMethod : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Methods, LearningMethod, testing::Values("joint", "schmidt", "ts"));

TEST_P(LearningMethod, FindsTheNoiseOfPlotsAndFixes) {
  for (const double factor : {1.0 / 3, 1.0, 3.0}) {
    test::Flight f = test::draw_flight(8, 150, true);
    for (RadarModel& radar : f.settings.radars)
      radar.sigma = {factor * radar.sigma.range_m, factor * radar.sigma.azimuth_rad,
                     factor * radar.sigma.elevation_rad};
    const auto method = make_method(GetParam(), f.settings);
    for (const Measurement& m : f.measurements) (void)method->process(m, m.epoch);
    for (int radar = 0; radar < 2; ++radar) {
      for (int i = 0; i < 3; ++i)
        EXPECT_NEAR(factor * method->account(radar).noise.sigma_ratio(i), 1, 0.2) << factor << ' ' << radar << ' ' << i;
    }
    EXPECT_NEAR(method->account(2).noise.sigma_ratio(0), 1, 0.4) << factor;
  }
}

TEST_P(LearningMethod, KeepsWhatIsConfiguredWhereItMustNotLearn) {
  test::Flight f = test::draw_flight(8, 60, true);
  f.settings.noise.enabled = false;
  const auto method = make_method(GetParam(), f.settings);
  for (const Measurement& m : f.measurements) (void)method->process(m, m.epoch);
  for (int source = 0; source < 3; ++source) EXPECT_EQ(method->account(source).noise.sigma_ratio(0), 0);
}

TEST_P(LearningMethod, IsNotTaughtBySuspects) {
  test::Flight f = test::draw_flight(8, 60, true);
  for (Measurement& m : f.measurements) m.noise_held = m.source == 1;
  const auto method = make_method(GetParam(), f.settings);
  for (const Measurement& m : f.measurements) (void)method->process(m, m.epoch);
  EXPECT_GT(method->account(0).noise.sigma_ratio(0), 0);
  EXPECT_EQ(method->account(1).noise.sigma_ratio(0), 0);
}

/// To the bit, whatever the order of arrival.
TEST_P(LearningMethod, LearnsTheSameOfShuffledData) {
  test::Flight f = test::draw_flight(4, 40, true);
  for (RadarModel& radar : f.settings.radars) radar.sigma.range_m /= 3;
  const auto in_order = make_method(GetParam(), f.settings);
  for (const Measurement& m : f.measurements) (void)in_order->process(m, m.epoch);
  std::mt19937_64 rng(99);
  std::vector<std::pair<Time, std::size_t>> arrival;
  for (std::size_t i = 0; i < f.measurements.size(); ++i)
    arrival.emplace_back(f.measurements[i].epoch + milliseconds(static_cast<std::int64_t>(rng() % 2000)), i);
  std::ranges::sort(arrival);
  const auto shuffled = make_method(GetParam(), f.settings);
  for (const auto& [received, i] : arrival) (void)shuffled->process(f.measurements[i], received);
  for (int source = 0; source < 3; ++source) {
    for (int i = 0; i < NoiseScale::max_components; ++i)
      EXPECT_EQ(in_order->account(source).noise.sigma_ratio(i), shuffled->account(source).noise.sigma_ratio(i));
  }
  EXPECT_EQ(in_order->fused(0)->mean, shuffled->fused(0)->mean);
}

}  // namespace
}  // namespace downrange
