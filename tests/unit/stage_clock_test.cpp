/// INTEGRITY's clock test: a witness that is on the path, but at another time. Times are after lift-off.

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "../support/judged_flight.hpp"

namespace downrange::test {
namespace {

constexpr SourceId first_station = 2;
constexpr SourceSet gps = set_of(first_station) | set_of(3);
constexpr double never = 1e9;

struct WrongClock {
  const char* name;
  SourceId liar;
  SourceSet sources;  ///< of the liar
  Name radar;         ///< empty: the receiver
  double fast_s;
  double from_s;
  double to_s;
  double told_by_s;  ///< excluded no later, by its clock
};

void PrintTo(const WrongClock& clock, std::ostream* out) { *out << clock.name; }

std::vector<WrongClock> wrong_clocks() {
  // The radars acquire at 20 and 48 s; until then nobody tells which of two is right.
  return {{"receiver_1_s_from_the_pad_on", first_station, gps, {}, -1, -20, never, 60},
          {"receiver_0_3_s_from_the_pad_on", first_station, gps, {}, -0.3, -20, never, 76},
          {"radar_1_s_from_its_first_plot_on", jeju, set_of(jeju), "jeju", -1, -20, never, 68},
          {"radar_0_3_s_from_its_first_plot_on", goheung, set_of(goheung), "goheung", -0.3, -20, never, 79},
          {"radar_0_3_s_for_a_while", goheung, set_of(goheung), "goheung", -0.3, 70, 110, 77},
          {"radar_0_1_s_for_a_while", goheung, set_of(goheung), "goheung", -0.1, 100, 165, 160}};
}

Fault fault_of(const WrongClock& clock) {
  return [clock](Event& event, double t_s) {
    if (t_s < clock.from_s || t_s >= clock.to_s) return;
    auto* plot = std::get_if<RadarTspi>(&event);
    auto* fix = std::get_if<GpsFix>(&event);
    if (plot != nullptr && plot->sensor == clock.radar) plot->epoch = plot->epoch + seconds(clock.fast_s);
    if (fix != nullptr && clock.radar.empty()) fix->epoch = fix->epoch + seconds(clock.fast_s);
  };
}

class JudgeOnClocks : public testing::TestWithParam<WrongClock> {};

TEST_P(JudgeOnClocks, SaysWhoseItIsAndByHowMuch) {
  const WrongClock& clock = GetParam();
  const RangeConfig range = judged_range();
  const sim::Simulation flight(judged_launch(range, 180), 3);
  const JudgedFlight f = judged(range, with_fault(flight, fault_of(clock)), clock.sources);
  const auto excluded = f.first(clock.liar, IntegrityVerdict::Excluded);
  ASSERT_TRUE(excluded) << described(f);
  EXPECT_GE(*excluded, clock.from_s) << described(f);
  EXPECT_LE(*excluded, clock.told_by_s) << described(f);
  for (const Said& s : f.said) {
    if (!contains(clock.sources, s.source)) {
      EXPECT_NE(s.judgement.verdict, IntegrityVerdict::Excluded) << described(f);
      continue;
    }
    if (s.judgement.verdict != IntegrityVerdict::Excluded) continue;
    EXPECT_EQ(s.judgement.why, Finding::Clock) << described(f);
    EXPECT_NEAR(s.judgement.apart_m, std::abs(clock.fast_s), 0.1 + 0.2 * std::abs(clock.fast_s)) << described(f);
    // What it taught was wrong as long as anybody can tell.
    if (clock.from_s < 0) {
      EXPECT_LT(s.judgement.undone_from, liftoff) << described(f);
    }
  }
  const auto back = f.first(clock.liar, IntegrityVerdict::Agrees, *excluded);
  if (clock.to_s < never) {
    ASSERT_TRUE(back) << described(f);
    EXPECT_LE(*back, clock.to_s + 12) << described(f);
  } else {
    EXPECT_FALSE(back) << described(f);
  }
}

/// From far a radar's biases are hundreds of metres where a tracker beside the pad sees the vehicle a few kilometres
/// off.
TEST(JudgeOnTrackers, HasNoClockInDoubtWhereNoneIsWrong) {
  RangeConfig range = judged_range();
  AngleSensorConfig tracker = small_tracker();
  tracker.sigma_azimuth_rad = tracker.sigma_elevation_rad = 0.02 * deg;
  range.angle_sensors = {tracker};
  for (const std::uint64_t seed : {1, 2}) {
    sim::Scenario scenario = judged_launch(range, 180);
    sim::RadarScenario angles = scenario.radars[0];
    angles.id = tracker.id;
    angles.site = tracker.site;
    angles.sigma = {0, tracker.sigma_azimuth_rad, tracker.sigma_elevation_rad};
    angles.outlier_probability = 0;
    angles.bias = {};
    angles.bias.offset = {0, 0.2 * deg, -0.1 * deg};
    angles.bias_sigma = {};
    angles.measures.range = false;
    scenario.angle_sensors = {angles};
    const sim::Simulation flight(scenario, seed);
    const JudgedFlight f = judged(range, flight.events(), 0);
    for (const Said& s : f.said)
      EXPECT_EQ(s.judgement.verdict, IntegrityVerdict::Agrees) << seed << '\n' << described(f);
  }
}

INSTANTIATE_TEST_SUITE_P(Clocks, JudgeOnClocks, testing::ValuesIn(wrong_clocks()),
                         [](const auto& clock) { return clock.param.name; });

}  // namespace
}  // namespace downrange::test
