/// What every method must hold, whatever its mathematics: order of arrival, honest covariance, bad input, geometry.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <downrange/est/method/joint.hpp>
#include <functional>
#include <limits>
#include <map>
#include <random>
#include <string>

#include "../support/drawn_flight.hpp"
#include "../support/method_cases.hpp"

namespace downrange {
namespace {

using test::deg;
using test::draw_flight;
using test::Flight;

using Contestant = test::MethodCase;

class EveryMethod : public testing::TestWithParam<Contestant> {
 protected:
  [[nodiscard]] std::unique_ptr<Method> make(MethodSettings settings) const {
    settings.motion.kinematics = GetParam().kinematics;
    settings.gps.alignment.smooth = GetParam().smooth;
    return make_method(GetParam().method, settings);
  }
};

INSTANTIATE_TEST_SUITE_P(Methods, EveryMethod, testing::ValuesIn(test::method_cases()),
                         [](const auto& contestant) { return contestant.param.label; });

/// Symmetric, positive definite in units of its own sigma, finite.
void expect_honest(const TrackEstimate& e, const std::string& when) {
  const Eigen::MatrixXd P = e.cov.topLeftCorner(6, 6);
  ASSERT_TRUE(e.mean.allFinite() && P.allFinite()) << when;
  EXPECT_LE((P - P.transpose()).cwiseAbs().maxCoeff(), 1e-12 * P.cwiseAbs().maxCoeff()) << when;
  const Eigen::VectorXd sigma = P.diagonal().cwiseSqrt();
  const Eigen::MatrixXd correlation = sigma.cwiseInverse().asDiagonal() * P * sigma.cwiseInverse().asDiagonal();
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(correlation).eigenvalues().minCoeff(), 0) << when;
}

/// Noise-free plots of a target that moves as `truth`, both radars of `settings` in turn every 50 ms, and fixes at 1
/// Hz.
Flight clean_flight(const MethodSettings& settings, double from_s, double to_s,
                    const std::function<Position<Ecef>(double)>& truth) {
  Flight f;
  f.settings = settings;
  std::uint64_t sequence = 0;
  for (int i = 0; from_s + 0.05 * i < to_s; ++i) {
    const double t = from_s + 0.05 * i;
    Measurement m;
    m.epoch = Time{} + seconds(t);
    m.sequence = ++sequence;
    if (i % 20 == 0) {
      Measurement fix = m;
      fix.source = static_cast<int>(settings.radars.size());
      fix.measured = Fix{};
      test::fix(fix).position = truth(t);
      test::fix(fix).velocity.m_s = (truth(t + 0.01).m - truth(t - 0.01).m) / 0.02;
      test::fix(fix).velocity_valid = true;
      test::fix(fix).sigma_horizontal_m = test::fix(fix).sigma_vertical_m = 5;
      test::fix(fix).sigma_velocity_m_s = 0.2;
      f.measurements.push_back(fix);
    }
    m.source = i % static_cast<int>(settings.radars.size());
    test::polar(m) = polar_from_enu(settings.radars[static_cast<std::size_t>(m.source)].site.enu_of(truth(t)));
    f.measurements.push_back(m);
  }
  std::sort(f.measurements.begin(), f.measurements.end(), processed_before);
  return f;
}

double distance_m(const Method& method, const Flight& f, const std::function<Position<Ecef>(double)>& truth) {
  const auto e = method.fused(0, f.measurements.back().epoch);
  return e ? (e->mean.head<3>() - truth((e->epoch - Time{}).seconds()).m).norm() : 1e9;
}

TEST_P(EveryMethod, ShuffledArrivalGivesTheInOrderBits) {
  for (const auto& [sources, f] : test::flights_of_all_kinds(4, 15)) {
    SCOPED_TRACE(sources);
    const auto in_order = make(f.settings);
    for (const Measurement& m : f.measurements) (void)in_order->process(m, m.epoch);
    std::mt19937_64 rng(99);
    std::vector<std::pair<Time, std::size_t>> arrival;
    for (std::size_t i = 0; i < f.measurements.size(); ++i)
      arrival.push_back({f.measurements[i].epoch + milliseconds(static_cast<std::int64_t>(rng() % 2000)), i});
    std::sort(arrival.begin(), arrival.end());
    const auto shuffled = make(f.settings);
    for (const auto& [received, i] : arrival) (void)shuffled->process(f.measurements[i], received);
    ASSERT_EQ(in_order->fused(0).has_value(), shuffled->fused(0).has_value());
    if (in_order->fused(0)) {
      EXPECT_EQ(in_order->fused(0)->mean, shuffled->fused(0)->mean);
      EXPECT_EQ(in_order->fused(0)->cov, shuffled->fused(0)->cov);
    }
    for (int radar = 0; radar < static_cast<int>(f.settings.radars.size()); ++radar)
      EXPECT_EQ(in_order->bias(radar).value, shuffled->bias(radar).value);
  }
}

TEST_P(EveryMethod, CovarianceIsHonestlyAMatrixOfCovariances) {
  for (const auto& [sources, f] : test::flights_of_all_kinds(5, 60)) {
    SCOPED_TRACE(sources);
    const auto method = make(f.settings);
    int n = 0;
    for (const Measurement& m : f.measurements) {
      (void)method->process(m, m.epoch);
      if (const auto e = method->fused(0); e && ++n % 50 == 0) expect_honest(*e, "after " + std::to_string(n));
    }
  }
}

/// A method that has no use for a range or a direction alone is what it would be without it; another one is not.
TEST_P(EveryMethod, PlotsThatLackAPartAreUsedOrPassedOver) {
  const Flight f = test::with_partial_plots(draw_flight(6, 40, true));
  const auto with = make(f.settings);
  const auto without = make(f.settings);
  for (const Measurement& m : f.measurements) {
    (void)with->process(m, m.epoch);
    if (tells_position(m.measured)) (void)without->process(m, m.epoch);
  }
  const Time end = f.measurements.back().epoch;
  const TrackEstimate a = *with->fused(0, end);
  const TrackEstimate b = *without->fused(0, end);
  if (GetParam().partial_plots) {
    EXPECT_LT((a.cov.topLeftCorner<3, 3>().trace()), (b.cov.topLeftCorner<3, 3>().trace()));
    EXPECT_GT(with->account(2).accepted, 600u);
  } else {
    EXPECT_EQ(a.mean, b.mean);
    EXPECT_EQ(a.cov, b.cov);
    EXPECT_EQ(with->bias(1).value, without->bias(1).value);
  }
}

TEST_P(EveryMethod, NotANumberChangesNothingButACounter) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Flight all = draw_flight(6, 15, true);
  for (const Flight& f : {all, test::with_partial_plots(all), test::without_radars(all)}) {
    SCOPED_TRACE(f.settings.radars.size());
    const auto method = make(f.settings);
    std::map<int, Measurement> last;  // of each source
    for (const Measurement& m : f.measurements) {
      (void)method->process(m, m.epoch);
      last[m.source] = m;
    }
    const auto before = method->fused(0);
    for (auto& [source, bad] : last) {
      if (before) bad.epoch = before->epoch;
      bad.sequence += 1000;
      if (auto* plot = std::get_if<Plot>(&bad.measured))
        (plot->range_valid ? plot->measured.range_m : plot->measured.azimuth_rad) = nan;
      if (auto* angles = std::get_if<Angles>(&bad.measured)) angles->azimuth_rad = nan;
      if (auto* wrong = std::get_if<Fix>(&bad.measured)) wrong->position.m.x() = nan;
      const Verdict verdict = method->process(bad, bad.epoch).verdict;
      const bool passed_over = (!tells_position(bad.measured) && !GetParam().partial_plots) ||
                               (is_fix(bad) && GetParam().method == "alpha-beta");  // it uses no receiver
      EXPECT_TRUE(passed_over || verdict != Verdict::Accepted) << "source " << source;
    }
    if (!before) continue;
    const auto after = method->fused(0, before->epoch);
    ASSERT_TRUE(after);
    EXPECT_LT((after->mean - before->mean).norm(), 1e-6);
  }
}

/// A degree beside a track that is known to metres.
TEST_P(EveryMethod, AnOutlierIsGatedAndChangesNothing) {
  const Flight f = draw_flight(11, 40, true);
  const auto method = make(f.settings);
  const Measurement* plot = nullptr;
  for (const Measurement& m : f.measurements) {
    (void)method->process(m, m.epoch);
    if (!is_fix(m) && m.source == 1) plot = &m;
  }
  Measurement outlier = *plot;
  outlier.epoch = f.measurements.back().epoch + milliseconds(10);
  outlier.sequence += 1000;
  test::polar(outlier).elevation_rad += 1 * deg;
  const TrackEstimate before = *method->fused(0, outlier.epoch);
  const bool gates = GetParam().method != "uncorrected";
  EXPECT_EQ(method->process(outlier, outlier.epoch).verdict, gates ? Verdict::Gated : Verdict::Accepted);
  EXPECT_EQ(method->account(1).gated, gates ? 1u : 0u);
  const double moved = (method->fused(0, outlier.epoch)->mean - before.mean).head<3>().norm();
  if (gates) {
    EXPECT_LT(moved, 1e-6);
  } else {
    EXPECT_GT(moved, 1);
  }
}

/// Straight over radar 0: elevation through the zenith, azimuth jumps by half a turn and its noise says nothing there.
TEST_P(EveryMethod, PassesThroughTheZenith) {
  const MethodSettings settings = draw_flight(1, 1, false).settings;
  const Site under = settings.radars[0].site;
  const auto truth = [&](double t) { return under.ecef_of({{0.0, 800 * (t - 60), 25'000.0}}); };
  const Flight f = clean_flight(settings, 10, 110, truth);
  const auto method = make(settings);
  for (const Measurement& m : f.measurements) {
    (void)method->process(m, m.epoch);
    if (const auto e = method->fused(0)) expect_honest(*e, "t " + std::to_string((m.epoch - Time{}).seconds()));
  }
  EXPECT_LT(distance_m(*method, f, truth), 60);
}

/// Azimuth through north (0/360 degrees) for radar 0, through south (+-180 of the azimuth scale) for radar 1.
TEST_P(EveryMethod, PassesThroughNorthAndSouth) {
  MethodSettings settings = draw_flight(1, 1, false).settings;
  const Site pad({34.43 * deg, 127.53 * deg, 100});
  settings.radars[0].site = Site({34.0 * deg, 127.53 * deg, 0});
  settings.radars[1].site = Site({34.9 * deg, 127.53 * deg, 0});
  const auto truth = [&](double t) { return pad.ecef_of({{600 * (t - 40), 0.0, 20'000.0}}); };
  const Flight f = clean_flight(settings, 10, 70, truth);
  const auto method = make(settings);
  std::uint64_t refused = 0;
  for (const Measurement& m : f.measurements) refused += method->process(m, m.epoch).verdict != Verdict::Accepted;
  EXPECT_EQ(refused, 0u);
  EXPECT_LT(distance_m(*method, f, truth), 30);
}

/// A minute without anything, then everything again.
TEST_P(EveryMethod, SurvivesAGapOfAMinute) {
  const Flight whole = draw_flight(7, 110, false);
  Flight f = whole;
  std::erase_if(f.measurements,
                [](const Measurement& m) { return m.epoch > Time{} + seconds(40) && m.epoch < Time{} + seconds(100); });
  const auto method = make(f.settings);
  for (const Measurement& m : f.measurements) (void)method->process(m, m.epoch);
  const Site pad({34.43 * deg, 127.53 * deg, 100});
  EXPECT_LT(distance_m(*method, f, [&](double t) { return test::truth_at(pad, t); }), 120);
  expect_honest(*method->fused(0), "after the gap");
}

/// Radar 1 appears 60 s late, with its bias, and must not drag a converged track away.
TEST_P(EveryMethod, TakesARadarThatAppearsLate) {
  Flight f = draw_flight(8, 90, true);
  std::erase_if(f.measurements,
                [](const Measurement& m) { return !is_fix(m) && m.source == 1 && m.epoch < Time{} + seconds(70); });
  const auto method = make(f.settings);
  const Site pad({34.43 * deg, 127.53 * deg, 100});
  double worst = 0;
  for (const Measurement& m : f.measurements) {
    (void)method->process(m, m.epoch);
    if (m.epoch < Time{} + seconds(60)) continue;
    const auto e = method->fused(0);
    worst = std::max(worst, (e->mean.head<3>() - test::truth_at(pad, (e->epoch - Time{}).seconds()).m).norm());
  }
  const bool corrects = GetParam().method != "uncorrected" && GetParam().method != "alpha-beta";
  EXPECT_LT(worst, corrects ? 100 : 400);
  EXPECT_GT(method->account(1).accepted, 300u);
}

/// Plots of both radars and a fix with one epoch, in any order of arrival.
/// An operator's order; what was learnt of the other radar stays.
TEST_P(EveryMethod, ABiasThatIsOrderedToBeginAnewDoes) {
  Flight f = draw_flight(3, 60, true);
  const auto sigmas = [](const Method& method, int radar) {
    const BiasEstimate bias = method.bias(radar);
    return Eigen::VectorXd(bias.cov.diagonal().head(bias.terms).cwiseSqrt());
  };
  const auto method = make(f.settings);
  const Eigen::VectorXd at_first = sigmas(*method, 0);
  if (at_first.size() == 0) GTEST_SKIP() << "estimates no bias";
  for (const Measurement& m : f.measurements) (void)method->process(m, m.epoch);
  const Eigen::VectorXd learnt = sigmas(*method, 0);
  const Eigen::VectorXd others = sigmas(*method, 1);
  Measurement ordered =
      *std::find_if(f.measurements.rbegin(), f.measurements.rend(), [](const Measurement& m) { return m.source == 0; });
  ordered.epoch = f.measurements.back().epoch + milliseconds(1);
  ordered.sequence += 1000;
  ordered.reset_bias = true;
  (void)method->process(ordered, ordered.epoch);
  const Eigen::VectorXd after = sigmas(*method, 0);
  // The best known term: that which a measurement alone does not teach at once.
  Eigen::Index best = 0;
  (learnt.array() / at_first.array()).minCoeff(&best);
  EXPECT_LT(learnt[best], 0.3 * at_first[best]);
  EXPECT_GT(after[best], 1.5 * learnt[best]) << "of " << at_first[best];
  EXPECT_LT((sigmas(*method, 1) - others).cwiseQuotient(others).maxCoeff(), 0.5) << "the other radar's";
}

TEST_P(EveryMethod, SimultaneousMeasurementsCommute) {
  Flight f = draw_flight(9, 10, true);
  for (Measurement& m : f.measurements)
    m.epoch = Time{} + milliseconds((m.epoch.ns / 1'000'000 + 50) / 100 * 100);  // all on a grid of 0.1 s
  std::vector<Measurement> backwards = f.measurements;
  std::stable_sort(backwards.begin(), backwards.end(), [](const Measurement& a, const Measurement& b) {
    return a.epoch < b.epoch || (a.epoch == b.epoch && processed_before(b, a));
  });
  const auto one = make(f.settings);
  const auto other = make(f.settings);
  std::sort(f.measurements.begin(), f.measurements.end(), processed_before);
  for (const Measurement& m : f.measurements) (void)one->process(m, m.epoch);
  for (const Measurement& m : backwards) (void)other->process(m, m.epoch);
  EXPECT_EQ(one->fused(0)->mean, other->fused(0)->mean);
}

/// A drawn flight of which something is wrong: `fault` changes a measurement of t seconds, or says that there is none.
Flight with_fault(Flight f, const std::function<bool(double t, Measurement&)>& fault) {
  std::erase_if(f.measurements, [&](Measurement& m) { return !fault((m.epoch - Time{}).seconds(), m); });
  return f;
}

/// Largest error of the fused track in [from, to), at the measurements that it is made of.
double worst_m(Method& method, const Flight& f, double from_s, double to_s) {
  const Site pad({34.43 * deg, 127.53 * deg, 100});
  double worst = 0;
  for (const Measurement& m : f.measurements) {
    const double t = (m.epoch - Time{}).seconds();
    const bool used = method.process(m, m.epoch).verdict == Verdict::Accepted;
    const auto e = method.fused(0);
    if (!used || !e || e->data_epoch != m.epoch || t < from_s || t >= to_s) continue;
    worst = std::max(worst, (e->mean.head<3>() - test::truth_at(pad, (e->epoch - Time{}).seconds()).m).norm());
  }
  return worst;
}

/// Ranges in feet from t = 40 s on, and no other radar.
TEST_P(EveryMethod, TheOnlyRadarDoesNotTakeTheTrackFromAHealthyReceiver) {
  if (GetParam().method == "uncorrected" || GetParam().method == "alpha-beta") GTEST_SKIP() << "does not know of GPS";
  const Flight f = with_fault(draw_flight(21, 60, false), [](double t, Measurement& m) {
    if (!is_fix(m) && t > 40) test::polar(m).range_m /= 0.3048;
    return is_fix(m) || m.source == 0;
  });
  const auto method = make(f.settings);
  EXPECT_LT(worst_m(*method, f, 20, 70), 100);
  EXPECT_GT(method->account(0).gated, 250u);
  EXPECT_EQ(method->account(2).gated, 0u);
}

/// One of two radars has its azimuth's sign wrong from the start.
TEST_P(EveryMethod, ALyingRadarDoesNotTakeTheTrackFromTheOthers) {
  if (GetParam().method == "uncorrected" || GetParam().method == "alpha-beta") GTEST_SKIP() << "does not know of GPS";
  const Flight f = with_fault(draw_flight(22, 60, true), [](double, Measurement& m) {
    if (!is_fix(m) && m.source == 1) test::polar(m).azimuth_rad = wrap_two_pi(-test::polar(m).azimuth_rad);
    return true;
  });
  const auto method = make(f.settings);
  EXPECT_LT(worst_m(*method, f, 30, 70), 150);
  EXPECT_EQ(method->account(2).gated, 0u);
}

/// The receiver is 5 km off for half a minute.
TEST_P(EveryMethod, ALyingReceiverDoesNotTakeTheTrackFromTwoRadars) {
  const Flight f = with_fault(draw_flight(23, 80, false), [](double t, Measurement& m) {
    if (is_fix(m) && t > 40 && t < 70) test::fix(m).position.m.x() += 5000;
    return true;
  });
  const auto method = make(f.settings);
  EXPECT_LT(worst_m(*method, f, 30, 90), 100);
  if (GetParam().method != "alpha-beta" && GetParam().method != "uncorrected") {
    EXPECT_EQ(method->account(2).gated, 29u);  // and believed again at once
  }
}

/// A receiver that was silent for a minute is used again with its third fix at the latest.
TEST_P(EveryMethod, AReceiverThatReturnsIsUsed) {
  const Flight f =
      with_fault(draw_flight(24, 90, true), [](double t, Measurement& m) { return !is_fix(m) || t < 25 || t > 84.5; });
  const auto method = make(f.settings);
  EXPECT_LT(worst_m(*method, f, 87, 100), GetParam().method == "alpha-beta" ? 400 : 120);
  EXPECT_LE(method->account(2).gated, 2u);
}

/// Position to the bit, velocity alive: the third is no fix any more.
TEST_P(EveryMethod, TheThirdEqualFixOfAMovingVehicleIsFrozen) {
  if (GetParam().method == "alpha-beta") GTEST_SKIP() << "has no receiver";
  std::optional<Position<Ecef>> held;
  const Flight f = with_fault(draw_flight(25, 40, false), [&](double t, Measurement& m) {
    if (!is_fix(m)) return true;
    if (t < 12) held = test::fix(m).position;  // from the first fixes on
    test::fix(m).position = *held;
    return true;
  });
  const auto method = make(f.settings);
  EXPECT_LT(worst_m(*method, f, 20, 50), 150);
  EXPECT_GE(method->account(2).frozen, 36u);
}

/// All of that at once, as it comes and late.
TEST_P(EveryMethod, WhoIsBelievedDoesNotDependOnTheOrderOfArrival) {
  const Flight f = with_fault(draw_flight(26, 60, true), [](double t, Measurement& m) {
    if (is_fix(m) && t > 25 && t < 40) return false;
    if (is_fix(m) && t > 60) test::fix(m).position.m.x() += 5000;
    if (!is_fix(m) && m.source == 1 && t > 45) test::polar(m).range_m += 600;
    if (!is_fix(m) && m.source == 0 && t > 62) test::polar(m).range_m /= 0.3048;
    return true;
  });
  const auto in_order = make(f.settings);
  for (const Measurement& m : f.measurements) (void)in_order->process(m, m.epoch);
  std::mt19937_64 rng(7);
  std::vector<std::pair<Time, std::size_t>> arrival;
  for (std::size_t i = 0; i < f.measurements.size(); ++i)
    arrival.push_back({f.measurements[i].epoch + milliseconds(static_cast<std::int64_t>(rng() % 3000)), i});
  std::sort(arrival.begin(), arrival.end());
  const auto late = make(f.settings);
  for (const auto& [received, i] : arrival) (void)late->process(f.measurements[i], received);
  EXPECT_EQ(in_order->fused(0)->mean, late->fused(0)->mean);
  EXPECT_EQ(in_order->fused(0)->cov, late->fused(0)->cov);
  EXPECT_EQ(in_order->bias(1).value, late->bias(1).value);
}

/// A target that circles both radars at 90 km for as long as asked for: plots every 50 ms, a fix every two seconds.
class Circling {
 public:
  explicit Circling(const MethodSettings& settings) : settings_(settings) {}

  [[nodiscard]] static Position<Ecef> truth(double t) {
    static const Site centre({34.4 * deg, 127.0 * deg, 0});
    return centre.ecef_of({{9e4 * std::sin(t / 300), 9e4 * std::cos(t / 300), 2e4 + 5e3 * std::sin(t / 170)}});
  }
  [[nodiscard]] Measurement next() {
    const double t = 0.05 * count_;
    Measurement m;
    m.epoch = Time{} + seconds(t);
    m.sequence = static_cast<std::uint64_t>(count_);
    if (count_ % 40 == 0) {
      m.source = static_cast<int>(settings_.radars.size());
      m.measured = Fix{};
      test::fix(m).position = truth(t);
      for (int k = 0; k < 3; ++k) test::fix(m).position.m[k] += 5 * normal_(rng_);
      test::fix(m).sigma_horizontal_m = test::fix(m).sigma_vertical_m = 5;
    } else {
      m.source = count_ % 2;
      const RadarModel& radar = settings_.radars[static_cast<std::size_t>(m.source)];
      test::polar(m) = polar_from_enu(radar.site.enu_of(truth(t)));
      test::polar(m).range_m += radar.sigma.range_m * normal_(rng_);
      test::polar(m).azimuth_rad = wrap_two_pi(test::polar(m).azimuth_rad + radar.sigma.azimuth_rad * normal_(rng_));
      test::polar(m).elevation_rad += radar.sigma.elevation_rad * normal_(rng_);
    }
    ++count_;
    return m;
  }

 private:
  const MethodSettings& settings_;
  std::mt19937_64 rng_{1};
  std::normal_distribution<double> normal_;
  int count_ = 0;
};

TEST_P(EveryMethod, StaysHonestOverThirtyThousandUpdates) {
  const MethodSettings settings = draw_flight(1, 1, false).settings;
  const auto method = make(settings);
  Circling target(settings);
  constexpr int updates = 30'000;
  for (int i = 0; i < updates; ++i) {
    const Measurement m = target.next();
    (void)method->process(m, m.epoch);
  }
  const auto e = method->fused(0);
  expect_honest(*e, "at the end");
  EXPECT_LT((e->mean.head<3>() - Circling::truth((e->epoch - Time{}).seconds()).m).norm(), 150);
  EXPECT_LT(method->account(0).gated + method->account(1).gated, updates / 500u);
}

/// A million updates of a filter whose biases are known ever better: symmetric and positive definite to the end.
TEST(Numerics, AMillionUpdatesKeepTheCovarianceWhatItIs) {
  Flight f = draw_flight(1, 1, false);
  f.settings.motion.kinematics = Kinematics::Ca;
  const Joint joint(f.settings);
  Joint::State state = joint.initial();
  Circling target(f.settings);
  constexpr int updates = 1'000'000;
  for (int i = 0; i < updates; ++i) {
    (void)joint.apply(state, target.next());
    if (i % 100'000 != 99'999) continue;
    const Eigen::MatrixXd& P = state.targets[0].bank.mode[0].P;
    ASSERT_EQ(P, P.transpose().eval()) << i;
    const Eigen::VectorXd sigma = P.diagonal().cwiseSqrt();
    const Eigen::MatrixXd correlation = sigma.cwiseInverse().asDiagonal() * P * sigma.cwiseInverse().asDiagonal();
    ASSERT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(correlation).eigenvalues().minCoeff(), 0) << i;
  }
  const auto e = joint.fused(state, 0, {});
  EXPECT_LT((e->mean.head<3>() - Circling::truth(0.05 * (updates - 1)).m).norm(), 50);
  EXPECT_LT(state.accounts[0].gated, updates / 1000u);
}

}  // namespace
}  // namespace downrange
