/// Range rate as a measurement, and noise by the signal: Jacobians, consistency, gates of their own.
#include <gtest/gtest.h>

#include <cmath>
#include <downrange/est/filter/hypothesis.hpp>

#include "../support/drawn_flight.hpp"
#include "../support/method_cases.hpp"

namespace downrange {
namespace {

using test::deg;
using test::Flight;

const Site pad({34.43 * deg, 127.53 * deg, 100});

/// Position, velocity, acceleration of the drawn flight.
Vec<9> motion_at(double t) {
  constexpr double h = 0.01;
  const Vec<3> p = test::truth_at(pad, t).m;
  const Vec<3> before = test::truth_at(pad, t - h).m;
  const Vec<3> after = test::truth_at(pad, t + h).m;
  Vec<9> motion;
  motion << p, (after - before) / (2 * h), (after - 2 * p + before) / (h * h);
  return motion;
}

Vec<bias_term_count> some_bias(std::mt19937_64& rng) {
  std::normal_distribution<double> normal;
  Vec<bias_term_count> bias = Vec<bias_term_count>::Zero();
  const BiasModel model = bias_model({BiasBlock::Polar, BiasBlock::SezOffset, BiasBlock::SezScale, BiasBlock::Time});
  for (int i = 0; i < bias_term_count; ++i) bias[i] = std::sqrt(model.prior_cov(i, i)) * normal(rng);
  return bias;
}

TEST(RangeRate, IsTheRateOfTheRange) {
  const RadarModel radar{.site = Site({34.0 * deg, 127.0 * deg, 100}), .sigma = {25, 1e-4, 1e-4}};
  const auto air = std::make_shared<RefractionTable>(atmosphere_over(radar.site.geodetic(), 330));
  std::mt19937_64 rng(1);
  for (const bool refracted : {false, true}) {
    RadarModel seen = radar;
    if (refracted) seen.refraction = air;
    Vec<bias_term_count> bias = some_bias(rng);
    bias.segment<6>(static_cast<Eigen::Index>(BiasTerm::OffsetRange)).setZero();
    for (const double t : {20.0, 45.0, 90.0}) {
      const double h = 0.05;
      const double rate =
          (predict_plot(seen, motion_at(t + h), bias).q[0] - predict_plot(seen, motion_at(t - h), bias).q[0]) / (2 * h);
      EXPECT_NEAR(predict_range_rate(seen, motion_at(t), bias).m_s, rate, 2e-3) << t << ' ' << refracted;
    }
  }
}

/// Central differences at random states.
TEST(RangeRate, JacobiansAreItsDerivatives) {
  const RadarModel radar{.site = Site({34.0 * deg, 127.0 * deg, 100}), .sigma = {25, 1e-4, 1e-4}};
  std::mt19937_64 rng(2);
  std::normal_distribution<double> normal;
  const BiasModel model = bias_model({BiasBlock::Polar, BiasBlock::SezOffset, BiasBlock::SezScale, BiasBlock::Time});
  for (int run = 0; run < 50; ++run) {
    Vec<9> motion = motion_at(60);
    for (int i = 0; i < 9; ++i) motion[i] += (i < 3 ? 3e4 : i < 6 ? 500 : 20) * normal(rng);
    const Vec<bias_term_count> bias = some_bias(rng);
    const PredictedRangeRate at = predict_range_rate(radar, motion, bias);
    for (int i = 0; i < 9; ++i) {
      const double step = i < 3 ? 1 : i < 6 ? 0.1 : 0.1;
      Vec<9> more = motion;
      Vec<9> less = motion;
      more[i] += step;
      less[i] -= step;
      const double slope =
          (predict_range_rate(radar, more, bias).m_s - predict_range_rate(radar, less, bias).m_s) / (2 * step);
      EXPECT_NEAR(at.d_motion[i], slope, 1e-6 + 1e-5 * std::abs(slope)) << run << " motion " << i;
    }
    for (int i = 0; i < bias_term_count; ++i) {
      const double step = 1e-3 * std::sqrt(model.prior_cov(i, i));
      Vec<bias_term_count> more = bias;
      Vec<bias_term_count> less = bias;
      more[i] += step;
      less[i] -= step;
      const double slope =
          (predict_range_rate(radar, motion, more).m_s - predict_range_rate(radar, motion, less).m_s) / (2 * step);
      EXPECT_NEAR(at.d_bias[i], slope, 1e-5 + 1e-4 * std::abs(slope))
          << run << ' ' << to_string(static_cast<BiasTerm>(i));
    }
  }
}

TEST(Noise, GrowsAsTheSignalFades) {
  RadarModel radar;
  radar.sigma = {3, 1e-4, 2e-4};
  radar.sigma_range_rate_m_s = 0.3;
  radar.snr = {.ref_db = 20, .at_ref = {4, 0, 3e-4}, .range_rate_at_ref_m_s = 0.4};
  Plot plot;
  const auto expect = [&](double faded) {
    const Vec<3> variance = plot_variance(radar, plot);
    EXPECT_NEAR(variance[0], 9 + 16 * faded, 1e-9 * faded);
    EXPECT_NEAR(variance[1], 1e-8, 1e-20);
    EXPECT_NEAR(variance[2], 4e-8 + 9e-8 * faded, 1e-15 * faded);
    EXPECT_NEAR(range_rate_variance(radar, plot), 0.09 + 0.16 * faded, 1e-9 * faded);
  };
  expect(1);  // not told: that of the reference
  plot.snr_valid = true;
  plot.snr_db = 20;
  expect(1);
  plot.snr_db = 0;
  expect(100);
  plot.snr_db = 40;
  expect(0.01);
  plot.snr_db = -1e300;
  EXPECT_TRUE(plot_variance(radar, plot).allFinite());
}

class RangeRateOf : public testing::TestWithParam<test::MethodCase> {
 protected:
  static constexpr double sigma_m_s = 0.5;

  /// Plots with range rate, every radar's noise as configured.
  [[nodiscard]] static Flight drawn(std::uint64_t seed) {
    Flight f = test::draw_flight(seed, 50, true);
    std::mt19937_64 rng(seed + 100);
    std::normal_distribution<double> normal;
    for (RadarModel& radar : f.settings.radars) radar.sigma_range_rate_m_s = sigma_m_s;
    for (Measurement& m : f.measurements) {
      if (is_fix(m)) continue;
      const RadarModel& radar = f.settings.radars[static_cast<std::size_t>(m.source)];
      Plot& plot = std::get<Plot>(m.measured);
      plot.range_rate_valid = true;
      plot.range_rate_m_s =
          predict_range_rate(radar, motion_at((m.epoch - Time{}).seconds()), Vec<bias_term_count>::Zero()).m_s +
          sigma_m_s * normal(rng);
    }
    return f;
  }
  [[nodiscard]] static std::unique_ptr<Method> make(MethodSettings settings) {
    settings.motion.kinematics = GetParam().kinematics;
    settings.gps.alignment.smooth = GetParam().smooth;
    return make_method(GetParam().method, settings);
  }
  /// Rms of the velocity after 30 s.
  [[nodiscard]] static double velocity_error(Method& method, const Flight& f) {
    double sum = 0;
    int n = 0;
    for (const Measurement& m : f.measurements) {
      (void)method.process(m, m.epoch);
      const auto e = method.fused(0);
      if (!e || m.epoch < Time{} + seconds(30)) continue;
      sum += (e->mean.segment<3>(3) - motion_at((e->epoch - Time{}).seconds()).segment<3>(3)).squaredNorm();
      ++n;
    }
    return std::sqrt(sum / n);
  }
};

std::vector<test::MethodCase> users() {
  std::vector<test::MethodCase> cases = test::method_cases();
  std::erase_if(cases, [](const test::MethodCase& c) { return !c.range_rate; });
  return cases;
}

INSTANTIATE_TEST_SUITE_P(Methods, RangeRateOf, testing::ValuesIn(users()),
                         [](const auto& method_case) { return method_case.param.label; });

TEST_P(RangeRateOf, MakesTheVelocityBetter) {
  const Flight f = drawn(1);
  Flight without = f;
  for (RadarModel& radar : without.settings.radars) radar.sigma_range_rate_m_s = 0;
  EXPECT_LT(velocity_error(*make(f.settings), f), velocity_error(*make(without.settings), without));
}

/// Each plot tells two NIS, its own and that of its range rate: both inside what they should be.
TEST_P(RangeRateOf, InnovationsAreAsTheFilterThinks) {
  const Flight f = drawn(2);
  const auto method = make(f.settings);
  for (const Measurement& m : f.measurements) (void)method->process(m, m.epoch);
  for (int radar = 0; radar < 2; ++radar) {
    EXPECT_GT(method->account(radar).mismatch.share(), 0.93) << radar;
    EXPECT_FALSE(method->account(radar).mismatch.rings()) << radar;
    EXPECT_LT(method->account(radar).gated, 4u) << radar;
  }
}

TEST_P(RangeRateOf, AWrongOneLeavesThePositionInUse) {
  Flight f = drawn(3);
  const Flight clean = f;
  for (Measurement& m : f.measurements)
    if (!is_fix(m) && m.epoch > Time{} + seconds(35)) std::get<Plot>(m.measured).range_rate_m_s += 300;
  Flight never = clean;
  for (Measurement& m : never.measurements)
    if (!is_fix(m) && m.epoch > Time{} + seconds(35)) std::get<Plot>(m.measured).range_rate_valid = false;
  const auto spoilt = make(f.settings);
  const auto without = make(never.settings);
  for (std::size_t i = 0; i < f.measurements.size(); ++i) {
    (void)spoilt->process(f.measurements[i], f.measurements[i].epoch);
    (void)without->process(never.measurements[i], never.measurements[i].epoch);
  }
  EXPECT_EQ(spoilt->fused(0)->mean, without->fused(0)->mean);
  EXPECT_EQ(spoilt->account(0).gated, without->account(0).gated);
}

TEST_P(RangeRateOf, IsUsedWhereThePositionIsWrong) {
  Flight f = drawn(4);
  const Time end = f.measurements.back().epoch;
  const auto method = make(f.settings);
  for (const Measurement& m : f.measurements) (void)method->process(m, m.epoch);
  const auto before = method->fused(0, end + milliseconds(20));
  Measurement off = f.measurements.back();
  off.source = 1;
  off.epoch = end + milliseconds(20);
  Plot plot{.measured = {1e5, 1, 0.2}, .range_rate_valid = true};
  plot.range_rate_m_s = predict_range_rate(f.settings.radars[1], before->mean, Vec<bias_term_count>::Zero()).m_s + 1;
  off.measured = plot;
  EXPECT_EQ(method->process(off, off.epoch).verdict, Verdict::Gated);
  EXPECT_LT(method->fused(0, off.epoch)->cov(3, 3) + method->fused(0, off.epoch)->cov(4, 4),
            before->cov(3, 3) + before->cov(4, 4));
}

}  // namespace
}  // namespace downrange
