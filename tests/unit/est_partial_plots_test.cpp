/// Radars of range alone and of angles alone: what they start, what they tell, what they are worth.
#include <gtest/gtest.h>

#include <cmath>

#include "../support/drawn_flight.hpp"
#include "../support/method_cases.hpp"

namespace downrange {
namespace {

using test::deg;
using test::Flight;

const Site pad({34.43 * deg, 127.53 * deg, 100});

/// Three radars around the vehicle's path that measure range alone, 10 Hz each, and fixes at 1 Hz before `gps_until_s`.
Flight trilateration(double duration_s, double gps_until_s) {
  constexpr double sigma_m = 5;
  Flight f;
  f.settings.targets = 1;
  f.settings.stations = 1;
  for (const auto& [latitude, longitude] : {std::pair(34.9, 127.0), std::pair(34.2, 128.3), std::pair(33.6, 127.2)}) {
    RadarModel radar{.site = Site({latitude * deg, longitude * deg, 50}), .sigma = {sigma_m, 0, 0}};
    radar.bias.terms = {BiasTerm::OffsetRange};
    radar.bias.prior_cov.setIdentity();
    radar.bias.prior_cov *= 20 * 20;
    f.settings.radars.push_back(radar);
  }
  std::mt19937_64 rng(5);
  std::normal_distribution<double> normal;
  std::uint64_t sequence = 0;
  for (int i = 0; i < static_cast<int>(10 * duration_s); ++i) {
    for (int radar = 0; radar < 3; ++radar) {
      const double t = 10 + 0.1 * i + 0.013 * radar;
      const Site& site = f.settings.radars[static_cast<std::size_t>(radar)].site;
      Measurement m;
      m.epoch = Time{} + seconds(t);
      m.source = radar;
      m.sequence = ++sequence;
      const double range_m = polar_from_enu(site.enu_of(test::truth_at(pad, t))).range_m + sigma_m * normal(rng);
      m.measured = Plot{.measured = {range_m, 0, 0}, .angles_valid = false};
      f.measurements.push_back(m);
    }
    if (i % 10 != 0 || 10 + 0.1 * i > gps_until_s) continue;
    const double t = 10 + 0.1 * i;
    Fix fix{.position = test::truth_at(pad, t), .sigma_horizontal_m = 5, .sigma_vertical_m = 8};
    for (int k = 0; k < 3; ++k) fix.position.m[k] += 5 * normal(rng);
    Measurement m;
    m.epoch = Time{} + seconds(t);
    m.source = 3;
    m.sequence = ++sequence;
    m.measured = fix;
    f.measurements.push_back(m);
  }
  std::sort(f.measurements.begin(), f.measurements.end(), processed_before);
  return f;
}

class PartialPlots : public testing::TestWithParam<test::MethodCase> {
 protected:
  [[nodiscard]] static std::unique_ptr<Method> make(MethodSettings settings) {
    settings.motion.kinematics = GetParam().kinematics;
    settings.gps.alignment.smooth = GetParam().smooth;
    return make_method(GetParam().method, settings);
  }
};

std::vector<test::MethodCase> users() {
  std::vector<test::MethodCase> cases = test::method_cases();
  std::erase_if(cases, [](const test::MethodCase& c) { return !c.partial_plots; });
  return cases;
}

INSTANTIATE_TEST_SUITE_P(Methods, PartialPlots, testing::ValuesIn(users()),
                         [](const auto& method_case) { return method_case.param.label; });

TEST_P(PartialPlots, ThreeRangesKeepATrackThatGpsHasStarted) {
  const Flight f = trilateration(50, 35);
  const auto method = make(f.settings);
  double sum = 0;
  int n = 0;
  for (const Measurement& m : f.measurements) {
    (void)method->process(m, m.epoch);
    const auto e = method->fused(0);
    if (m.epoch < Time{} + seconds(40) || !e) continue;  // GPS is gone
    sum += (e->mean.head<3>() - test::truth_at(pad, (e->epoch - Time{}).seconds()).m).squaredNorm();
    ++n;
  }
  ASSERT_GT(n, 500);
  EXPECT_LT(std::sqrt(sum / n), 10);
  for (int radar = 0; radar < 3; ++radar) EXPECT_LE(method->account(radar).gated, 3u) << radar;
}

TEST_P(PartialPlots, StartNothingByThemselves) {
  Flight f = trilateration(10, 0);
  const auto method = make(f.settings);
  for (const Measurement& m : f.measurements) EXPECT_EQ(method->process(m, m.epoch).verdict, Verdict::Accepted);
  EXPECT_FALSE(method->fused(0));
}

/// One instrument, two messages.
TEST_P(PartialPlots, ARadarOfAnglesIsATracker) {
  const Flight f = test::with_partial_plots(test::draw_flight(9, 30, true));
  const auto by_tracker = make(f.settings);
  const auto by_radar = make(f.settings);
  for (Measurement m : f.measurements) {
    (void)by_tracker->process(m, m.epoch);
    if (!is_fix(m)) m.measured = plot_of(m.measured);
    (void)by_radar->process(m, m.epoch);
  }
  EXPECT_EQ(by_tracker->fused(0)->mean, by_radar->fused(0)->mean);
  EXPECT_EQ(by_tracker->fused(0)->cov, by_radar->fused(0)->cov);
}

TEST_P(PartialPlots, WhatAPlotLacksMayBeAnything) {
  const Flight f = test::with_partial_plots(test::draw_flight(10, 30, true));
  const auto clean = make(f.settings);
  const auto spoilt = make(f.settings);
  for (Measurement m : f.measurements) {
    (void)clean->process(m, m.epoch);
    if (auto* plot = std::get_if<Plot>(&m.measured)) {
      if (!plot->range_valid) plot->measured.range_m = -1e9;
      if (!plot->angles_valid) plot->measured.azimuth_rad = plot->measured.elevation_rad = 3;
    }
    (void)spoilt->process(m, m.epoch);
  }
  EXPECT_EQ(clean->fused(0)->mean, spoilt->fused(0)->mean);
  EXPECT_EQ(clean->fused(0)->cov, spoilt->fused(0)->cov);
}

/// A range that is 5 km wrong in every plot of one radar.
TEST_P(PartialPlots, ALyingRangeIsGated) {
  Flight f = trilateration(50, 60);
  for (Measurement& m : f.measurements)
    if (m.source == 1 && m.epoch > Time{} + seconds(30)) test::polar(m).range_m += 5000;
  const auto method = make(f.settings);
  double worst = 0;
  for (const Measurement& m : f.measurements) {
    (void)method->process(m, m.epoch);
    const auto e = method->fused(0);
    if (m.epoch < Time{} + seconds(25) || !e) continue;
    worst = std::max(worst, (e->mean.head<3>() - test::truth_at(pad, (e->epoch - Time{}).seconds()).m).norm());
  }
  // The two ranges that are left do not hold a track without GPS: schmidt's drifts along their circle. 150 m is what
  // joint's may drift in half a minute; of the 5 km any part that was believed would show.
  if (GetParam().method != "schmidt") {
    EXPECT_LT(worst, 150);
  }
  EXPECT_GT(method->account(1).gated, 200u);
}

}  // namespace
}  // namespace downrange
