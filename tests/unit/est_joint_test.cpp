/// The joint filter: nearer to the truth than the two-stage method and honest about it, time tags found, order
/// irrelevant.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <downrange/est/method/joint.hpp>
#include <downrange/est/method/rewind.hpp>
#include <tuple>

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
    if (!is_fix(m) && m.source == 0) m.epoch = m.epoch + fast;
  std::sort(f.measurements.begin(), f.measurements.end(), processed_before);
  const auto method = make_method("joint", f.settings);
  for (const Measurement& m : f.measurements) (void)method->process(m, m.epoch);
  for (int radar = 0; radar < 2; ++radar) {
    const BiasEstimate b = method->bias(radar);
    const int tag = b.terms - 1;
    ASSERT_EQ(b.term[static_cast<std::size_t>(tag)], BiasTerm::TimeTag);
    const double truth = radar == 0 ? fast.seconds() : 0;
    const double sigma = std::sqrt(b.cov(tag, tag));
    EXPECT_LT(sigma, 0.018);  // learnt a little: on so slow a flight 20 ms are a few metres
    EXPECT_LT(std::abs(b.value[tag] - truth), 3 * sigma);
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

/// Pointing that wanders by twice the plots' noise over ten seconds: as states it is told from the biases and the track
/// is honest; taken for white noise the same plots promise too much.
TEST(Joint, PointingThatWandersIsAState) {
  constexpr double tau = 10;
  constexpr double sigma = 0.02 * test::deg;
  double inside_with = 0;
  double inside_without = 0;
  double square_with = 0;
  double square_without = 0;
  constexpr int runs = 32;
  for (std::uint64_t seed = 40; seed < 40 + runs; ++seed) {
    Flight f = draw_flight(seed, 60, true);
    f.settings.motion.kinematics = Kinematics::Ca;
    f.settings.motion.q_ca_m2_s5 = 0.1;  // the flight's acceleration is constant
    f.settings.gps.no_gps.enabled = false;
    f.settings.gps.error.enabled = false;
    f.settings.noise.enabled = false;  // it would be taken for noise, and partly be found
    std::mt19937_64 rng(seed);
    std::normal_distribution<double> normal;
    Vec<2> error[2] = {};
    Time last[2];
    for (Measurement& m : f.measurements) {
      if (is_fix(m)) continue;
      Vec<2>& e = error[m.source];
      const double phi = last[m.source] == Time{} ? 0 : std::exp(-(m.epoch - last[m.source]).seconds() / tau);
      e = phi * e + sigma * std::sqrt(1 - phi * phi) * Vec<2>(normal(rng), normal(rng));
      last[m.source] = m.epoch;
      test::polar(m).azimuth_rad += e[0];
      test::polar(m).elevation_rad += e[1];
    }
    const auto without = fly(*make_method("joint", f.settings), f, 30);
    for (RadarModel& radar : f.settings.radars) radar.wander = {.sigma_rad = sigma, .tau_s = tau};
    const auto with = fly(*make_method("joint", f.settings), f, 30);
    inside_with += with.inside95 / runs;
    inside_without += without.inside95 / runs;
    square_with += with.rms_m * with.rms_m / runs;
    square_without += without.rms_m * without.rms_m / runs;
  }
  // Errors that last ten seconds make a run little more than one draw.
  const double least = share_band(0.95, runs, 0.001).low;
  EXPECT_GT(inside_with, least);
  EXPECT_LT(inside_without, least);
  EXPECT_LT(square_with, 0.7 * square_without);
}

/// A track that was dead-reckoned while the receiver's slow error took up the difference: 40 m are no receiver's.
TEST(Joint, WhatNoReceiverErrsByIsTheMotions) {
  for (const double carried_m : {10.0, 40.0}) {
    Flight f = draw_flight(6, 12, true);
    f.settings.motion.kinematics = Kinematics::Ca;
    const Joint joint(f.settings);
    Joint::State state = joint.initial();
    for (const Measurement& m : f.measurements) (void)joint.apply(state, m);
    Hypothesis& h = state.targets[0].bank.mode[0];
    const Vec<3> there = h.x.head<3>();
    const Vec<3> carried(0, carried_m, 0);
    h.x.head<3>() -= carried;
    h.x.segment<3>(Joint::gps_error_at) = carried;
    Measurement m;
    m.source = static_cast<int>(f.settings.radars.size());
    m.epoch = state.targets[0].epoch;
    m.measured = Fix{};
    test::fix(m).position.m = there;
    test::fix(m).sigma_horizontal_m = test::fix(m).sigma_vertical_m = 5;
    ASSERT_EQ(joint.apply(state, m).verdict, Verdict::Accepted);
    const double off_m = (h.x.head<3>() - there).norm();
    EXPECT_LT(off_m, carried_m > 20 ? 5 : 11) << carried_m;
    if (carried_m < 20) {
      EXPECT_GT(off_m, 5);  // may well be the receiver's
    }
  }
}

/// A radar alone, without GPS, never knows the target's range better than its own offset of range: a start that took
/// the plot's error as noise would claim to have learnt it.
TEST(EveryMethodOfBiases, ARadarAloneKnowsNoRangeBetterThanItsOffset) {
  for (const char* name : {"joint", "schmidt", "ts"}) {
    const Flight f = draw_flight(10, 20, true, false);
    const auto method = make_method(name, f.settings);
    for (const Measurement& m : f.measurements) {
      if (m.source == 1) (void)method->process(m, m.epoch);
    }
    const TrackEstimate e = *method->fused(0);
    const Vec<3> line_of_sight = (e.mean.head<3>() - f.settings.radars[1].site.ecef().m).normalized();
    const double sigma = std::sqrt(line_of_sight.dot(e.cov.topLeftCorner<3, 3>() * line_of_sight));
    EXPECT_GT(sigma, 0.98 * f.settings.gps.no_gps.offset_prior_m) << name;
    EXPECT_LT(sigma, 3 * f.settings.gps.no_gps.offset_prior_m) << name;  // the range's scale adds to it
  }
}

/// The track is 3 km off and sure of itself, and the only radar's bias was bent to it: a second radar that comes is
/// neither refused for ever nor given the 3 km as its own bias.
TEST(EveryMethodOfBiases, ARadarThatReturnsBringsBackATrackThatWasLedAstray) {
  for (const char* name : {"joint", "schmidt", "ts"}) {
    Flight f = draw_flight(12, 80, true, false);
    f.settings.gps.no_gps.enabled = false;
    auto& prior = f.settings.radars[0].bias.prior_cov;
    const auto open = [&](BiasTerm term, double sigma) {
      prior(static_cast<int>(term), static_cast<int>(term)) = sigma * sigma;
    };
    open(BiasTerm::OffsetRange, 5000);
    open(BiasTerm::OffsetAzimuth, 5 * test::deg);
    open(BiasTerm::OffsetElevation, 5 * test::deg);
    const Site pad({34.43 * test::deg, 127.53 * test::deg, 100});
    const auto truth = [&](Time t) { return test::truth_at(pad, (t - Time{}).seconds()).m; };
    const Time start = Time{} + seconds(60);
    const Time second_from = start + seconds(10);
    const auto method = make_method(name, f.settings);
    Gaussian<9> wrong{.mean = Vec<9>::Zero(), .cov = Mat<9, 9>::Identity()};
    wrong.mean << truth(start) + 3000 * truth(start).normalized(),
        truth(start + seconds(0.5)) - truth(start - seconds(0.5)), Vec<3>::Zero();
    wrong.cov.diagonal() << Vec<3>::Constant(100), Vec<3>::Constant(1), Vec<3>::Constant(100);
    method->start(0, start, wrong);
    const auto error = [&] {
      const TrackEstimate e = *method->fused(0);
      return (e.mean.head<3>() - truth(e.epoch)).norm();
    };
    for (const Measurement& m : f.measurements) {
      if (m.epoch <= start || (m.source == 1 && m.epoch < second_from)) continue;
      if (m.epoch >= second_from && m.epoch < second_from + seconds(0.04)) {
        EXPECT_GT(error(), 2000) << name;
      }
      if (m.epoch > second_from + seconds(2)) break;
      (void)method->process(m, m.epoch);
    }
    EXPECT_LT(error(), 500) << name;
  }
}

/// Stamps that are late by 20 ms cannot be told from a target that is elsewhere on its path: with one radar and no GPS
/// nothing is learnt of them, and the second radar's plots find the difference of both.
TEST(EveryMethodWithTheRegimeWithoutGps, LooksForTimeTagsOnlyWhereTwoRadarsBearOnThem) {
  for (const char* name : {"joint", "schmidt"}) {
    const Flight f = draw_flight(10, 60, false, false);
    const auto method = make_method(name, f.settings);
    const auto tag_of = [&](int radar) {
      const BiasEstimate b = method->bias(radar);
      const int tag = b.terms - 1;
      EXPECT_EQ(b.term[static_cast<std::size_t>(tag)], BiasTerm::TimeTag);
      return std::tuple(b.value[tag], std::sqrt(b.cov(tag, tag)), b.state[static_cast<std::size_t>(tag)]);
    };
    const Time second_radar_from = Time{} + seconds(40);
    for (const Measurement& m : f.measurements) {
      if (m.source == 0 && m.epoch < second_radar_from) continue;
      if (m.source == 0 && m.epoch < second_radar_from + seconds(0.1)) {
        const auto [value, sigma, state] = tag_of(1);
        EXPECT_EQ(value, 0) << name;
        EXPECT_NEAR(sigma, 0.02, 1e-9) << name;
        EXPECT_EQ(state, BiasState::NotObservable) << name;
      }
      (void)method->process(m, m.epoch);
    }
    for (int radar = 0; radar < 2; ++radar) {
      const auto [value, sigma, state] = tag_of(radar);
      EXPECT_LT(sigma, 0.0199) << name;
      EXPECT_LT(std::abs(value), 3 * sigma) << name;
    }
  }
}

/// All stamps late alike are no different from a target elsewhere on its path: their mean is never known better than
/// before any plot, and what the motion owes to it is that mean times velocity.
TEST(Joint, NeverLearnsWithoutGpsWhatAllTimeTagsHaveInCommon) {
  const Site pad({34.43 * test::deg, 127.53 * test::deg, 100});
  Flight f = draw_flight(10, 100, false, false);
  const Joint joint(f.settings);
  Joint::State state = joint.initial();
  for (Measurement& m : f.measurements) {
    // As fast as a satellite, and as smooth.
    const double t = (m.epoch - Time{}).seconds();
    const Site& site = f.settings.radars[static_cast<std::size_t>(m.source)].site;
    const Polar at_drawn = polar_from_enu(site.enu_of(test::truth_at(pad, t)));
    const Polar at_there = polar_from_enu(site.enu_of(pad.ecef_of({{7500 * t - 4e5, 3e5, 4e5}})));
    test::polar(m).range_m += at_there.range_m - at_drawn.range_m;
    test::polar(m).azimuth_rad += at_there.azimuth_rad - at_drawn.azimuth_rad;
    test::polar(m).elevation_rad += at_there.elevation_rad - at_drawn.elevation_rad;
    (void)joint.apply(state, m);
    if (t < 20 || m.sequence % 50 != 0) continue;
    const Joint::Target& target = state.targets[0];
    const auto& tags = joint.layout(target).time_tags;
    ASSERT_EQ(tags.size(), 2u);
    const Hypothesis& h = target.bank.mode[0];
    const int first = tags[0].at;
    const int second = tags[1].at;
    const double of_mean = (h.P(first, first) + 2 * h.P(first, second) + h.P(second, second)) / 4;
    const double prior = tags[0].variance / 2;
    EXPECT_NEAR(of_mean / prior, 1, 1e-6) << t;
    const Vec<3> v = h.x.segment<3>(Joint::motion_at + 3);
    const Vec<3> with_motion =
        (h.P.block<3, 1>(Joint::motion_at, first) + h.P.block<3, 1>(Joint::motion_at, second)) / 2;
    EXPECT_NEAR(with_motion.dot(v) / v.squaredNorm() / prior, 1, 0.1) << t;
  }
}

/// In units of their own sigma: states of 1e6 m stand beside scales of 1e-5.
double least_eigenvalue(const Eigen::MatrixXd& P) {
  const Eigen::VectorXd sigma = P.diagonal().cwiseSqrt();
  const Eigen::MatrixXd correlation = sigma.cwiseInverse().asDiagonal() * P * sigma.cwiseInverse().asDiagonal();
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(correlation).eigenvalues().minCoeff();
}

TEST(Joint, CovarianceStaysSymmetricAndPositiveDefinite) {
  for (const Kinematics kinematics : {Kinematics::Ca, Kinematics::Launch}) {
    Flight f = draw_flight(5, 120, true);
    f.settings.motion.kinematics = kinematics;
    const Joint joint(f.settings);
    Joint::State state = joint.initial();
    for (const Measurement& m : f.measurements) (void)joint.apply(state, m);
    const Bank& bank = state.targets[0].bank;
    for (int i = 0; i < bank.count; ++i) {
      const Eigen::MatrixXd& P = bank.mode[static_cast<std::size_t>(i)].P;
      EXPECT_EQ(P, P.transpose().eval());
      EXPECT_GT(least_eigenvalue(P), 0);
    }
  }
}

/// The measurement model's Jacobians against central differences, every bias term in play.
TEST(PlotModel, JacobiansAreThoseOfCentralDifferences) {
  std::mt19937_64 rng(3);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto air = std::make_shared<RefractionTable>(atmosphere_over(Geodetic{}, 320));
  for (int n = 0; n < 200; ++n) {
    RadarModel radar;
    radar.site = Site({0.6 * uniform(rng), 3 * uniform(rng), 200});
    if (n % 2 == 0) radar.refraction = air;
    const double range = std::pow(10, 4.5 + 1.5 * uniform(rng));
    Polar q{range, 3 * uniform(rng), 0.7 + 0.6 * uniform(rng)};
    Vec<9> motion;
    motion << radar.site.ecef_of(enu_from_polar(q)).m, 3000 * uniform(rng), 3000 * uniform(rng), 3000 * uniform(rng),
        30 * uniform(rng), 30 * uniform(rng), 30 * uniform(rng);
    Vec<bias_term_count> bias;
    const BiasModel all = bias_model({BiasBlock::Polar, BiasBlock::SezOffset, BiasBlock::SezScale, BiasBlock::Time});
    for (int i = 0; i < bias_term_count; ++i) bias[i] = std::sqrt(all.prior_cov(i, i)) * normal(rng);
    const PredictedPlot plot = predict_plot(radar, motion, bias);
    const auto difference = [&](const Vec<9>& dm, const Vec<bias_term_count>& db) -> Vec<3> {
      const Vec<3> a = predict_plot(radar, motion + dm, bias + db).q;
      const Vec<3> b = predict_plot(radar, motion - dm, bias - db).q;
      return {(a[0] - b[0]) / 2, wrap_pi(a[1] - b[1]) / 2, (a[2] - b[2]) / 2};
    };
    const Vec<3> unit(1, 1 / range, 1 / range);  // a metre across is this angle
    const auto expect_column = [&](const Vec<3>& column, const Vec<3>& by_difference, double step, const char* what,
                                   int i) {
      const Vec<3> error = (column * step - by_difference).cwiseQuotient(unit) / std::cos(q.elevation_rad);
      // The second derivative over the step, and rounding of 6e6 m.
      const double size = (column * step).cwiseQuotient(unit).norm();
      EXPECT_LT(error.cwiseAbs().maxCoeff(), 2e-4 * size + 1e-6) << what << " " << i << " case " << n;
    };
    const double steps[3] = {range * 1e-5, range * 1e-5 / 0.02, range * 1e-5 / 2e-4};  // tau is 20 ms
    for (int i = 0; i < 9; ++i) {
      Vec<9> dm = Vec<9>::Zero();
      dm[i] = steps[i / 3];
      expect_column(plot.d_motion.col(i), difference(dm, Vec<bias_term_count>::Zero()), dm[i], "motion", i);
    }
    for (int i = 0; i < bias_term_count; ++i) {
      Vec<bias_term_count> db = Vec<bias_term_count>::Zero();
      db[i] = 1e-3 * std::sqrt(all.prior_cov(i, i));
      expect_column(plot.d_bias.col(i), difference(Vec<9>::Zero(), db), db[i], "bias", i);
    }
  }
}

/// The filter against the textbook: H by central differences of the model, the posterior by the information form, which
/// shares no step with the filter's own: only this catches a gain that is wrong and consistent.
TEST(Joint, UpdateIsTheInformationFilters) {
  Flight f = draw_flight(6, 12, true);
  f.settings.motion.kinematics = Kinematics::Ca;
  f.settings.noise.enabled = false;
  const Joint joint(f.settings);
  Joint::State state = joint.initial();
  for (const Measurement& m : f.measurements) (void)joint.apply(state, m);
  const Hypothesis prior = state.targets[0].bank.mode[0];
  const int n = static_cast<int>(prior.x.size());
  for (int radar = 0; radar < 2; ++radar) {
    const RadarModel& model = f.settings.radars[static_cast<std::size_t>(radar)];
    const RadarBlock& block = joint.layout(state.targets[0]).radars[static_cast<std::size_t>(radar)];
    const auto predicted = [&](const Eigen::VectorXd& x) { return predict_plot(model, x.head<9>(), block.bias(x)).q; };
    const Vec<3> sigma = plot_variance(model, Plot{.measured = {0, 0, 0.5}}).cwiseSqrt();
    const Vec<3> q = predicted(prior.x) + sigma.cwiseProduct(Vec<3>(0.7, -0.4, 1.1));
    Measurement m;
    m.epoch = state.targets[0].epoch;
    m.source = radar;
    test::polar(m) = {q[0], wrap_two_pi(q[1]), q[2]};
    Joint::State updated = state;
    ASSERT_EQ(joint.apply(updated, m).verdict, Verdict::Accepted);
    const Hypothesis& posterior = updated.targets[0].bank.mode[0];

    const Eigen::VectorXd scale = prior.P.diagonal().cwiseSqrt();
    Eigen::MatrixXd H(3, n);  // in units of the states' sigma and the noise's sigma
    for (int i = 0; i < n; ++i) {
      Eigen::VectorXd plus = prior.x;
      Eigen::VectorXd minus = prior.x;
      plus[i] += 1e-3 * scale[i];
      minus[i] -= 1e-3 * scale[i];
      const Vec<3> a = predicted(plus);
      const Vec<3> b = predicted(minus);
      H.col(i) = Vec<3>(a[0] - b[0], wrap_pi(a[1] - b[1]), a[2] - b[2]).cwiseQuotient(sigma) / 2e-3;
    }
    const Eigen::MatrixXd P = scale.cwiseInverse().asDiagonal() * prior.P * scale.cwiseInverse().asDiagonal();
    const Eigen::MatrixXd information = P.inverse() + H.transpose() * H;
    const Eigen::MatrixXd P_expected = information.inverse();
    const Eigen::VectorXd x_expected = P_expected * H.transpose() * Vec<3>(0.7, -0.4, 1.1);
    const Eigen::MatrixXd P_actual =
        scale.cwiseInverse().asDiagonal() * posterior.P * scale.cwiseInverse().asDiagonal();
    const Eigen::VectorXd x_actual = (posterior.x - prior.x).cwiseQuotient(scale);
    // Differences over 1e-3 sigma are right to 1e-6; the inverse of a prior of condition 1e7 costs the rest.
    EXPECT_LT((P_actual - P_expected).cwiseAbs().maxCoeff(), 1e-5);
    EXPECT_LT((x_actual - x_expected).cwiseAbs().maxCoeff(), 1e-5);
  }
}

}  // namespace
}  // namespace downrange
