/// Bands against closed forms and published values, and against what right and wrong filters give.
#include <gtest/gtest.h>

#include <cmath>
#include <downrange/est/filter/consistency.hpp>
#include <random>

namespace downrange {
namespace {

TEST(NormalisedSquare, HandComputed) {
  const Mat<2, 2> P = (Mat<2, 2>() << 4, 1, 1, 3).finished();
  EXPECT_NEAR(normalised_square<2>(Vec<2>(1, -2), P), 23.0 / 11, 1e-14);
  EXPECT_TRUE(std::isnan(normalised_square<1>(Vec<1>(1), Mat<1, 1>(-1.0))));
}

TEST(Bands, AverageChiSquareHasAClosedFormForTwoDegrees) {
  // chi2(2) is exponential: P(x > h) = e^(-h/2); one value, 10 % false alarms.
  const Band one = average_chi2_band(2, 1, 0.1);
  EXPECT_NEAR(one.low, -2 * std::log(0.95) / 2, 1e-12);
  EXPECT_NEAR(one.high, -2 * std::log(0.05) / 2, 1e-12);
  // Bar-Shalom, Li, Kirubarajan 2001, section 5.4.2: 50 runs of 2 degrees, 95 %: 1.5 to 2.6 of 2.
  const Band fifty = average_chi2_band(2, 50, 0.05);
  EXPECT_NEAR(2 * fifty.low, 1.5, 0.05);
  EXPECT_NEAR(2 * fifty.high, 2.6, 0.05);
}

TEST(Bands, ShareBandCountsExactly) {
  // 10 trials of probability 1/2: P(<= 1) = 11/1024 = 0.0107, P(<= 2) = 56/1024 = 0.0547.
  const Band tight = share_band(0.5, 10, 0.05);  // 0.025 a side: 2 to 8
  EXPECT_DOUBLE_EQ(tight.low, 0.2);
  EXPECT_DOUBLE_EQ(tight.high, 0.8);
  const Band wide = share_band(0.5, 10, 0.02);  // 0.01 a side: 1 to 9
  EXPECT_DOUBLE_EQ(wide.low, 0.1);
  EXPECT_DOUBLE_EQ(wide.high, 0.9);
  const Band loose = share_band(0.5, 10, 0.12);  // 0.06 a side: 3 to 7
  EXPECT_DOUBLE_EQ(loose.low, 0.3);
  EXPECT_DOUBLE_EQ(loose.high, 0.7);
  EXPECT_DOUBLE_EQ(share_band(0.999, 5, 0.05).high, 1.0);
}

TEST(Bands, ClopperPearsonClosedForms) {
  // No success: high = 1 - (a/2)^(1/n); all: low = (a/2)^(1/n).
  EXPECT_EQ(clopper_pearson(0, 10, 0.05).low, 0);
  EXPECT_NEAR(clopper_pearson(0, 10, 0.05).high, 1 - std::pow(0.025, 0.1), 1e-12);
  EXPECT_NEAR(clopper_pearson(10, 10, 0.05).low, std::pow(0.025, 0.1), 1e-12);
  EXPECT_EQ(clopper_pearson(10, 10, 0.05).high, 1);
  // One of two, exact: low solves 1 - (1-p)^2 = a/2, high solves 1 - p^2 = a/2.
  EXPECT_NEAR(clopper_pearson(1, 2, 0.05).low, 1 - std::sqrt(0.975), 1e-12);
  EXPECT_NEAR(clopper_pearson(1, 2, 0.05).high, std::sqrt(0.975), 1e-12);
}

TEST(Bands, NanIsOutside) {
  EXPECT_FALSE((Band{0, 1}.contains(std::nan(""))));
  InsideShare share;
  EXPECT_EQ(share.share(), 1);
  share.add(std::nan(""), 3);
  share.add(7.8, 3);
  EXPECT_EQ(share.share(), 0.5);
}

/// A scalar random walk filter whose R is `claimed` times the true one.
struct ScalarFilter {
  double claimed = 1;
  double x = 0;
  double P = 1;

  /// NIS of one step.
  template <class Random>
  double step(Random& normal, double& truth) {
    truth += 0.5 * normal();
    P += 0.25;
    const double S = P + claimed;
    const double nu = truth + normal() - x;
    x += P / S * nu;
    P -= P * P / S;
    return nu * nu / S;
  }
};

TEST(Bands, ARightFilterStaysInsideAWrongOneDoesNot) {
  // False-alarm rate of each of the three checks: 1e-4, with one fixed seed.
  constexpr double false_alarm = 1e-4;
  constexpr int n = 4000;
  for (const double claimed : {1.0, 0.5}) {
    std::mt19937_64 rng(17);
    std::normal_distribution<double> distribution;
    const auto normal = [&] { return distribution(rng); };
    double truth = normal();
    ScalarFilter filter{.claimed = claimed};
    MismatchAlarm alarm;
    InsideShare share;
    double sum = 0;
    for (int i = 0; i < n; ++i) {
      const double nis = filter.step(normal, truth);
      sum += nis;
      share.add(nis, 1);
      alarm.add(nis, 1);
    }
    const bool right = claimed == 1;
    EXPECT_EQ(average_chi2_band(1, n, false_alarm).contains(sum / n), right);
    EXPECT_EQ(share_band(0.95, n, false_alarm).contains(share.share()), right);
    EXPECT_EQ(clopper_pearson(share.inside, share.total, false_alarm).contains(0.95), right);
    EXPECT_EQ(alarm.rings(), !right);
  }
}

TEST(MismatchAlarm, BeforeTheWindowIsFullRingsWhereChanceDoesNot) {
  MismatchAlarm alarm;
  for (int i = 0; i < 49; ++i) alarm.add(100, 3);
  EXPECT_FALSE(alarm.rings());  // too few to say anything
  alarm.add(100, 3);
  EXPECT_TRUE(alarm.rings());

  // P(at most 85 of 100 inside) is 1.4e-4 for a right filter, P(at most 84) is 3.7e-5: the binomial sum, term by term.
  for (const int inside : {84, 85}) {
    MismatchAlarm of_hundred;
    for (int i = 0; i < 100; ++i) of_hundred.add(i < inside ? 1 : 100, 3);
    EXPECT_EQ(of_hundred.rings(), inside == 84);
  }
}

TEST(MismatchAlarm, Forgets) {
  MismatchAlarm alarm(100);
  for (int i = 0; i < 100; ++i) alarm.add(100, 3);
  EXPECT_TRUE(alarm.rings());
  for (int i = 0; i < 93; ++i) alarm.add(1, 3);
  EXPECT_FALSE(alarm.rings());  // 93 of 100: not below
  EXPECT_DOUBLE_EQ(alarm.share(), 0.93);
  alarm.add(std::nan(""), 3);  // an outside one leaves, an outside one comes
  EXPECT_DOUBLE_EQ(alarm.share(), 0.93);
  for (int i = 0; i < 7; ++i) alarm.add(100, 3);
  EXPECT_TRUE(alarm.rings());
}

TEST(MismatchAlarm, FalseAlarmRate) {
  // Window 20: rings at 18 or fewer inside (0.93 * 20 = 18.6): 1 - .95^20 - 20 * .05 * .95^19.
  EXPECT_NEAR(MismatchAlarm(20).false_alarm_rate(), 1 - std::pow(.95, 20) - std::pow(.95, 19), 1e-12);
  EXPECT_NEAR(MismatchAlarm().false_alarm_rate(), 0.00233, 1e-5);  // the binomial sum, term by term
}

}  // namespace
}  // namespace downrange
