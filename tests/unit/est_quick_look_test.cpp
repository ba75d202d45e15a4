/// Method alpha-beta: it is the tracker at each site, it chooses among them, it starts anew, air is taken out.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/est/method/quick_look.hpp>
#include <memory>

#include "../support/drawn_flight.hpp"

namespace downrange {
namespace {

using test::deg;
using test::draw_flight;
using test::Flight;

const Site pad({34.43 * deg, 127.53 * deg, 100});

Flight of_radar(Flight f, int radar) {
  std::erase_if(f.measurements, [radar](const Measurement& m) { return is_fix(m) || m.source != radar; });
  return f;
}

double error_m(const Method& method, double t) {
  return (method.fused(0, Time{} + seconds(t))->mean.head<3>() - test::truth_at(pad, t).m).norm();
}

TEST(QuickLook, IsTheTrackerAtTheSite) {
  const Flight f = of_radar(draw_flight(2, 20, false), 0);
  const Site& site = f.settings.radars[0].site;
  const auto method = make_method("alpha-beta", f.settings);
  std::optional<AlphaBetaTracker<3>> tracker;
  const AlphaBetaSettings settings{.sigma_acceleration = f.settings.quick_look.acceleration_m_s2,
                                   .initial_sigma_velocity = f.settings.start.sigma_velocity_m_s,
                                   .gate = chi2_quantile(f.settings.arbitration.gate_probability, 3)};
  Time last;
  for (const Measurement& m : f.measurements) {
    EXPECT_EQ(method->process(m, m.epoch).verdict, Verdict::Accepted);
    const PolarSigma& s = f.settings.radars[0].sigma;
    const double across = test::polar(m).range_m * s.azimuth_rad;
    const Vec<3> sigma(s.range_m, across * std::cos(test::polar(m).elevation_rad), across);
    const Vec<3> z = enu_from_polar(test::polar(m)).m;
    if (!tracker) {
      tracker.emplace(settings, z, sigma);
    } else {
      (void)tracker->scan(z, sigma, (m.epoch - last).seconds());
    }
    last = m.epoch;
    const TrackEstimate e = method->fused(0).value();
    EXPECT_EQ(e.epoch, m.epoch);
    // The debiased conversion differs by sigma_angle^2 of the range, 3e-8: millimetres at 50 km.
    EXPECT_LT((e.mean.head<3>() - site.ecef_of({tracker->position()}).m).norm(), 0.01);
    const Vec<3> v_enu = site.R_enu_ecef().R * e.mean.segment<3>(3);
    EXPECT_LT((v_enu - tracker->velocity()).norm(), 0.1);
  }
  const TrackEstimate e = method->fused(0).value();
  double trace = 0;
  for (int axis = 0; axis < 3; ++axis) trace += tracker->covariance(axis)(0, 0);
  EXPECT_NEAR((e.cov.topLeftCorner<3, 3>().trace()), trace, 1e-4 * trace);
  EXPECT_EQ(e.sources, 1u);
  EXPECT_EQ(method->bias(0).terms, 0);
  EXPECT_FALSE(method->gps_track(0, e.epoch));
}

TEST(QuickLook, GivesTheTrackOfTheBetterRadarWhileItIsFresh) {
  // Radar 1 is a hundred kilometres away: its angles say less. Radar 0 stops at 25 s.
  Flight f = draw_flight(5, 30, false, false);
  std::erase_if(f.measurements, [](const Measurement& m) { return m.source == 0 && m.epoch > Time{} + seconds(25); });
  const auto method = make_method("alpha-beta", f.settings);
  for (const Measurement& m : f.measurements) {
    (void)method->process(m, m.epoch);
    const double t = (m.epoch - Time{}).seconds();
    if (t < 12 || (t > 25.9 && t < 26.1)) continue;
    EXPECT_EQ(method->fused(0)->sources, t < 26 ? 1u : 2u) << t;
  }
}

TEST(QuickLook, IsHonestWhereRadarsHaveNoBias) {
  const Flight f = draw_flight(9, 60, false, false);
  const test::Flown flown = test::fly(*make_method("alpha-beta", f.settings), f, 15);
  EXPECT_GT(flown.inside95, 0.9);
  EXPECT_LT(flown.rms_m, 30);  // a plot of radar 0 is off by 25 m in range alone
}

TEST(QuickLook, ATrackOfWhichNoPlotIsAcceptedStartsAnew) {
  Flight f = of_radar(draw_flight(6, 40, false), 0);
  for (Measurement& m : f.measurements)
    if (m.epoch > Time{} + seconds(30)) test::polar(m).range_m += 5000;
  f.settings.arbitration.restart_after = milliseconds(2000);
  const auto method = make_method("alpha-beta", f.settings);
  for (const Measurement& m : f.measurements) (void)method->process(m, m.epoch);
  EXPECT_EQ(method->account(0).gated, 21u);  // 10 a second
  EXPECT_EQ(method->account(0).rejected_in_row, 0);
  EXPECT_NEAR(error_m(*method, 49.9), 5000, 100);
}

TEST(QuickLook, OfTwoPlotsOfOneInstantTheSecondIsRefused) {
  const Flight f = of_radar(draw_flight(6, 5, false), 0);
  const auto method = make_method("alpha-beta", f.settings);
  for (const Measurement& m : f.measurements) (void)method->process(m, m.epoch);
  const TrackEstimate before = method->fused(0).value();
  Measurement twin = f.measurements.back();
  ++twin.sequence;
  EXPECT_EQ(method->process(twin, twin.epoch).verdict, Verdict::Singular);
  EXPECT_EQ(method->fused(0)->mean, before.mean);
  EXPECT_EQ(method->account(0).gated, 1u);
}

/// Targets do not know of each other: with a hundred of them each has the bits it has alone.
TEST(QuickLook, ManyTargetsAreManyTimesOne) {
  const Flight f = draw_flight(8, 5, true, false);
  const auto alone = make_method("alpha-beta", f.settings);
  for (const Measurement& m : f.measurements) (void)alone->process(m, m.epoch);
  MethodSettings settings = f.settings;
  settings.targets = 100;
  const auto many = make_method("alpha-beta", settings);
  for (Measurement m : f.measurements) {
    for (m.target = 0; m.target < settings.targets; ++m.target) (void)many->process(m, m.epoch);
  }
  for (int target = 0; target < settings.targets; ++target) {
    EXPECT_EQ(many->fused(target)->mean, alone->fused(0)->mean);
    EXPECT_EQ(many->fused(target)->cov, alone->fused(0)->cov);
  }
}

TEST(QuickLook, TakesTheAirOut) {
  Flight f = of_radar(draw_flight(8, 30, false), 0);
  RadarModel& radar = f.settings.radars[0];
  const auto air = std::make_shared<const RefractionTable>(atmosphere_over(radar.site.geodetic(), 320));
  for (Measurement& m : f.measurements) {
    const double t = (m.epoch - Time{}).seconds();
    test::polar(m) = polar_from_enu(radar.site.enu_of(test::truth_at(pad, t)));
    const Refraction bent = air->at_true(test::polar(m).range_m, test::polar(m).elevation_rad).refraction;
    test::polar(m).range_m += bent.range_m;
    test::polar(m).elevation_rad += bent.elevation_rad;
  }
  const auto fly_to_end = [&f] {
    const auto method = make_method("alpha-beta", f.settings);
    for (const Measurement& m : f.measurements) (void)method->process(m, m.epoch);
    return error_m(*method, (f.measurements.back().epoch - Time{}).seconds());
  };
  const double with_air = fly_to_end();
  radar.refraction = air;
  EXPECT_LT(fly_to_end(), with_air - 3);
}

}  // namespace
}  // namespace downrange
