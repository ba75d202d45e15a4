/// The Judge on simulated flights: who is named, how soon, and that nobody is named who is right. Times are after
/// lift-off; messages of the receiver arrive 0.4 s late, those of the radars 0.06 s.

#include <gtest/gtest.h>

#include "../support/judged_flight.hpp"
#include "sim/faults.hpp"

namespace downrange::test {
namespace {

constexpr SourceId first_station = 2;
constexpr SourceId second_station = 3;
constexpr SourceSet gps = set_of(first_station) | set_of(second_station);
constexpr double begin_s = 150;
constexpr double end_s = 180;

struct Lie {
  const char* name;
  SourceId liar;
  SourceSet without;
  double within_s;  ///< excluded so soon after it began
  std::function<void(Event&, double t_s)> fault;
};

void PrintTo(const Lie& lie, std::ostream* out) { *out << lie.name; }

Fault of_receiver(const std::function<void(GpsFix&, double since_s)>& fault) {
  return [fault](Event& event, double t_s) {
    if (auto* fix = std::get_if<GpsFix>(&event); fix != nullptr && t_s >= begin_s && t_s < end_s)
      fault(*fix, t_s - begin_s);
  };
}

Fault of_radar(const Name& id, const std::function<void(RadarTspi&, double since_s)>& fault) {
  return [id, fault](Event& event, double t_s) {
    auto* plot = std::get_if<RadarTspi>(&event);
    if (plot != nullptr && plot->sensor == id && t_s >= begin_s && t_s < end_s) fault(*plot, t_s - begin_s);
  };
}

Fault displaced_fix(const Eigen::Vector3d& step_enu_m, const Eigen::Vector3d& drift_enu_m_s) {
  return of_receiver([=](GpsFix& fix, double since_s) {
    const auto R = enu_from_ecef_at(geodetic_from_ecef(fix.position)).inverse();
    fix.position = fix.position + R * Displacement<Enu>{step_enu_m + since_s * drift_enu_m_s};
    fix.velocity.m_s += (R * Displacement<Enu>{drift_enu_m_s}).m;
  });
}

/// The radar follows another object that leaves the vehicle at a constant velocity.
Fault follows_another(SourceId radar, const Eigen::Vector3d& velocity_enu_m_s) {
  const RangeConfig range = judged_range();
  const RadarConfig config = range.radars[static_cast<std::size_t>(radar)];
  return of_radar(config.id, [=](RadarTspi& plot, double since_s) {
    const Position<Ecef> seen = config.site.ecef_of(enu_from_polar(plot.measured));
    const auto R = enu_from_ecef_at(geodetic_from_ecef(seen)).inverse();
    plot.measured = polar_from_enu(config.site.enu_of(seen + R * Displacement<Enu>{since_s * velocity_enu_m_s}));
  });
}

/// The flight that was flown, as it was planned.
NominalTrajectory plan_of(const sim::Simulation& flight) {
  std::vector<NominalSample> samples;
  for (int t = 0; t <= static_cast<int>(end_s); ++t) {
    const auto state = flight.truth(liftoff + seconds(t));
    samples.push_back({.t_s = static_cast<double>(t), .state = {state->position, state->velocity}});
  }
  return NominalTrajectory(samples);
}

std::vector<Lie> lies() {
  return {
      {"gps_200_m", first_station, gps, 3, displaced_fix({200, 0, 0}, {0, 0, 0})},
      {"gps_5_km", first_station, gps, 1.6, displaced_fix({0, 5000, 0}, {0, 0, 0})},
      {"gps_ramp_20_m_s", first_station, gps, 12, displaced_fix({0, 0, 0}, {20, 0, 0})},
      {"gps_ramp_10_m_s_up", first_station, gps, 25, displaced_fix({0, 0, 0}, {0, 0, 10})},
      {"gps_velocity_sign", first_station, gps, 4, of_receiver([](GpsFix& fix, double) { fix.velocity.m_s *= -1; })},
      {"radar_azimuth_step", goheung, set_of(goheung), 5,
       of_radar("goheung",
                [](RadarTspi& plot, double) {
                  plot.measured.azimuth_rad += 0.1 * deg / std::cos(plot.measured.elevation_rad);
                })},
      {"radar_elevation_step", jeju, set_of(jeju), 5,
       of_radar("jeju", [](RadarTspi& plot, double) { plot.measured.elevation_rad += 0.1 * deg; })},
      {"radar_on_spent_stage_20_m_s", goheung, set_of(goheung), 10, follows_another(goheung, {0, 20, 0})},
      {"radar_on_spent_stage_100_m_s", jeju, set_of(jeju), 5, follows_another(jeju, {0, 0, -100})},
      {"radar_azimuth_sign", goheung, set_of(goheung), 1.5,
       of_radar("goheung",
                [](RadarTspi& plot, double) { plot.measured.azimuth_rad = wrap_two_pi(-plot.measured.azimuth_rad); })},
      {"radar_feet", jeju, set_of(jeju), 1.5,
       of_radar("jeju", [](RadarTspi& plot, double) { plot.measured.range_m *= 3.28084; })},
      {"radar_fold", goheung, set_of(goheung), 1.5,
       of_radar("goheung", [](RadarTspi& plot, double) { plot.measured.range_m += 150e3; })},
      {"radar_clock_1_s", jeju, set_of(jeju), 2.5,
       of_radar("jeju", [](RadarTspi& plot, double) { plot.epoch = plot.epoch - seconds(1); })},
  };
}

class JudgeOnLies : public testing::TestWithParam<Lie> {};

TEST_P(JudgeOnLies, NamesTheLiarInTimeAndNobodyElse) {
  const Lie& lie = GetParam();
  const RangeConfig range = judged_range();
  const sim::Simulation flight(judged_launch(range, end_s), 3);
  const JudgedFlight f = judged(range, with_fault(flight, lie.fault), lie.without);
  const auto excluded = f.first(lie.liar, IntegrityVerdict::Excluded);
  ASSERT_TRUE(excluded) << described(f);
  EXPECT_GE(*excluded, begin_s) << described(f);
  EXPECT_LE(*excluded, begin_s + lie.within_s) << described(f);
  for (const Said& s : f.said) {
    if (contains(lie.without, s.source)) continue;
    EXPECT_EQ(s.judgement.verdict, IntegrityVerdict::Agrees) << described(f);
  }
}

INSTANTIATE_TEST_SUITE_P(Lies, JudgeOnLies, testing::ValuesIn(lies()), [](const auto& lie) { return lie.param.name; });

TEST(Judge, NobodyIsAccusedInAFaultFreeFlight) {
  const RangeConfig range = judged_range();
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    sim::Scenario scenario = judged_launch(range, 480);
    if (seed == 2) {  // every twentieth plot an outlier, thrust cut off early, outages
      for (sim::RadarScenario& radar : scenario.radars) radar.outlier_probability = 0.05;
      scenario.profile.burns[0].to_s = 180;
      scenario.radars[1].outages = {{200, 260}};
      scenario.gps.outages = {{300, 370}};
    }
    const sim::Simulation flight(scenario, seed);
    const JudgedFlight f = judged(range, flight.events());
    EXPECT_TRUE(f.said.empty()) << "seed " << seed << "\n" << described(f);
    EXPECT_GT(f.largest_value, 0) << "nothing was compared";
  }
}

/// The scale of azimuth counts from south: what it does jumps by a full turn where the target crosses north, and where
/// that is the radar's own place, biased, decides.
TEST(Judge, ARadarThatSeesTheTargetCrossNorthIsNotAccused) {
  RangeConfig range = judged_range();
  range.radars[jeju].site = Site({33.6 * deg, 127.58 * deg, 50});
  sim::Scenario scenario = judged_launch(range, 170);
  sim::RadarScenario& radar = scenario.radars[jeju];
  radar.bias_sigma = {};
  for (const double sign : {-1.0, 1.0}) {
    radar.bias.sez_offset_m = {-154, sign * 117, -174};
    radar.bias.offset = {-2, -0.008, -0.003};
    radar.bias.scale = {-2e-5, sign * 0.002, 0.0012};
    const JudgedFlight f = judged(range, sim::Simulation(scenario, 1).events());
    EXPECT_TRUE(f.said.empty()) << described(f);
    EXPECT_GT(f.largest_value, 0) << "nothing was compared";
  }
}

TEST(Judge, AReceiverIsBelievedAgainAfterTenSecondsOfAgreement) {
  const RangeConfig range = judged_range();
  sim::Scenario scenario = judged_launch(range, 190);
  scenario.gps.faults.push_back({{150, 170}, {200, 0, 0}, {0, 0, 0}});
  const JudgedFlight f = judged(range, sim::Simulation(scenario, 1).events(), gps);
  const auto excluded = f.first(first_station, IntegrityVerdict::Excluded);
  ASSERT_TRUE(excluded) << described(f);
  const auto back = f.first(first_station, IntegrityVerdict::Agrees, *excluded);
  ASSERT_TRUE(back) << described(f);
  EXPECT_GE(*back, 180);
  EXPECT_LE(*back, 182);
  for (const Said& s : f.said) {
    if (s.judgement.verdict != IntegrityVerdict::Excluded) continue;
    EXPECT_LE((s.judgement.onset - liftoff).seconds(), 150);
    EXPECT_GE((s.judgement.onset - liftoff).seconds(), 140);
  }
}

/// A receiver that repeats its fix is said to do so from the third equal one on, but not excluded: the methods refuse
/// such fixes, and its first true one is good again.
TEST(Judge, AReceiverThatRepeatsItsFixIsSuspectUntilItMoves) {
  const RangeConfig range = judged_range();
  const sim::Simulation flight(judged_launch(range, 60), 1);
  for (const double from_s : {2.0, 30.0}) {
    sim::Fault frozen;
    frozen.lasts_s = 18;
    frozen.actions = {{.sources = {"gps"}, .effect = sim::Freeze{}}};
    const std::vector<Event> events =
        sim::inject({}, frozen, {.range = range, .liftoff = liftoff, .begin_s = from_s}, flight.events()).events;
    const JudgedFlight f = judged(range, events, gps);
    const auto suspect = f.first(first_station, IntegrityVerdict::Suspect);
    ASSERT_TRUE(suspect) << described(f);
    EXPECT_LE(*suspect, from_s + 3) << described(f);
    const auto back = f.first(first_station, IntegrityVerdict::Agrees, *suspect);
    ASSERT_TRUE(back) << described(f);
    EXPECT_NEAR(*back, from_s + 18.5, 0.7);
    for (const Said& s : f.said) {
      EXPECT_TRUE(contains(gps, s.source)) << described(f);
      EXPECT_NE(s.judgement.verdict, IntegrityVerdict::Excluded) << described(f);
      if (s.judgement.verdict == IntegrityVerdict::Suspect) {
        EXPECT_EQ(s.judgement.why, Finding::Impossible);
      }
    }
  }
}

/// Before any radar hears the vehicle nobody can contradict a receiver but its own past.
TEST(Judge, AReceiverThatLeapsWhileItIsAloneIsExcludedUntilItLeapsBack) {
  const RangeConfig range = judged_range();
  sim::Scenario scenario = judged_launch(range, 60);
  for (sim::RadarScenario& radar : scenario.radars) radar.track.first = 55;
  scenario.gps.faults.push_back({{2, 20}, {0, 200, 0}, {0, 0, 0}});
  const JudgedFlight f = judged(range, sim::Simulation(scenario, 1).events(), gps);
  ASSERT_FALSE(f.said.empty());
  EXPECT_EQ(f.said.front().judgement.why, Finding::Impossible);
  EXPECT_NEAR(f.said.front().judgement.apart_m, 200, 30);
  const auto excluded = f.first(first_station, IntegrityVerdict::Excluded);
  ASSERT_TRUE(excluded) << described(f);
  EXPECT_LE(*excluded, 4.5) << described(f);
  const auto back = f.first(first_station, IntegrityVerdict::Agrees, *excluded);
  ASSERT_TRUE(back) << described(f);
  EXPECT_NEAR(*back, 20.7, 0.7) << described(f);
  EXPECT_FALSE(f.first(first_station, IntegrityVerdict::Excluded, *back)) << described(f);
}

/// With nobody to ask for good, a range that has this receiver only is not left without any.
TEST(Judge, AReceiverThatStaysWhereItLeaptIsBelievedAgainAfterHalfAMinute) {
  const RangeConfig range = judged_range();
  sim::Scenario scenario = judged_launch(range, 80);
  scenario.radars.clear();
  scenario.gps.faults.push_back({{20, 1000}, {0, 200, 0}, {0, 0, 0}});
  const JudgedFlight f = judged(range, sim::Simulation(scenario, 1).events(), gps);
  const auto excluded = f.first(first_station, IntegrityVerdict::Excluded);
  ASSERT_TRUE(excluded) << described(f);
  const auto back = f.first(first_station, IntegrityVerdict::Agrees, *excluded);
  ASSERT_TRUE(back) << described(f);
  EXPECT_NEAR(*back, 51, 2) << described(f);
}

/// A radar that is first heard while the receiver lies has no earlier measure of how they differ: what it compares
/// later begins where the receiver told the truth again.
TEST(Judge, WhatAReceiverSaidWhileItWasExcludedIsNoMeasureForARadarThatCameMeanwhile) {
  const RangeConfig range = judged_range();
  sim::Scenario scenario = judged_launch(range, 120);
  scenario.gps.faults.push_back({{40, 60}, {200, 0, 0}, {0, 0, 0}});
  const JudgedFlight f = judged(range, sim::Simulation(scenario, 1).events(), gps);
  const auto excluded = f.first(first_station, IntegrityVerdict::Excluded);
  ASSERT_TRUE(excluded) << described(f);
  EXPECT_LE(*excluded, 43) << described(f);
  const auto back = f.first(first_station, IntegrityVerdict::Agrees, *excluded);
  ASSERT_TRUE(back) << described(f);
  EXPECT_LE(*back, 72) << described(f);
  for (const Said& s : f.said) {
    if (s.t_s > *back) {
      EXPECT_EQ(s.judgement.verdict, IntegrityVerdict::Agrees) << described(f);
    }
  }
}

/// Drawn off from lift-off on, and true again as the first radar acquires: what it taught until then is undone.
TEST(Judge, AReceiverThatIsTrueAgainAsTheFirstRadarComesIsBelievedFromThen) {
  const RangeConfig range = judged_range();
  sim::Scenario scenario = judged_launch(range, 29);  // the chains of this test do not undo anything
  for (sim::RadarScenario& radar : scenario.radars) radar.track.first = 20.2;
  const Fault drawn_off = [](Event& event, double t_s) {
    auto* fix = std::get_if<GpsFix>(&event);
    if (fix == nullptr || t_s < 2 || t_s >= 20) return;
    const double since_s = t_s - 2;
    const auto R = enu_from_ecef_at(geodetic_from_ecef(fix->position)).inverse();
    fix->position = fix->position + R * Displacement<Enu>{{0, 1.5 * since_s * since_s, 0}};
    fix->velocity.m_s += (R * Displacement<Enu>{{0, 3 * since_s, 0}}).m;
  };
  const JudgedFlight f = judged(range, with_fault(sim::Simulation(scenario, 1), drawn_off));
  std::vector<double> from_s;
  for (const Said& s : f.said) {
    if (s.judgement.true_from) from_s.push_back((*s.judgement.true_from - liftoff).seconds());
    EXPECT_TRUE(contains(gps, s.source)) << described(f);
    EXPECT_NE(s.judgement.verdict, IntegrityVerdict::Excluded) << described(f);
  }
  EXPECT_EQ(from_s, (std::vector<double>{20, 20})) << "once for each station\n" << described(f);
  const auto suspect = f.first(first_station, IntegrityVerdict::Suspect);
  ASSERT_TRUE(suspect) << described(f);
  EXPECT_LE(*suspect, 24) << described(f);
}

TEST(Judge, AFirstFixFarOffThePadIsNotWaitedFor) {
  const RangeConfig range = judged_range();
  sim::Scenario scenario = judged_launch(range, 2);
  scenario.gps.faults.push_back({{-60, 1000}, {0, 0, 500}, {0, 0, 0}});
  const sim::Simulation flight(scenario, 1);
  const JudgedFlight f = judged(range, flight.events(), gps);
  const auto excluded = f.first(first_station, IntegrityVerdict::Excluded);
  ASSERT_TRUE(excluded) << described(f);
  EXPECT_LE(*excluded, scenario.gps.active.first + 1) << described(f);
  EXPECT_EQ(f.said.front().judgement.why, Finding::OffPad);
}

TEST(Judge, ADatumIsSeenOnThePad) {
  const RangeConfig range = judged_range();
  sim::Scenario scenario = judged_launch(range, 2);
  scenario.start_s = -60;
  scenario.gps.active.first = -60;
  EXPECT_TRUE(judged(range, sim::Simulation(scenario, 1).events()).said.empty());
  scenario.gps.faults.push_back({{-60, 1000}, {0, 0, 28}, {0, 0, 0}});
  const JudgedFlight f = judged(range, sim::Simulation(scenario, 1).events(), gps);
  const auto excluded = f.first(first_station, IntegrityVerdict::Excluded);
  ASSERT_TRUE(excluded) << described(f);
  EXPECT_LT(*excluded, 0);
  EXPECT_EQ(f.said.front().judgement.why, Finding::OffPad);
  EXPECT_NEAR(f.said.front().judgement.apart_m, 28, 10);
}

/// Of an hour on the beacon the filter believes to know biases better than one place in the sky allows.
TEST(Judge, WhatWasTaughtOnThePadIsNoMeasureJustAfterLiftOff) {
  RangeConfig range = judged_range();
  range.radars[goheung].elevation_min_rad = -5 * deg;
  sim::Scenario scenario = judged_launch(range, 60);
  scenario.start_s = -3600;
  scenario.gps.active.first = -3600;
  scenario.radars[goheung].track.first = -3600;
  scenario.radars[goheung].elevation_min_rad = -5 * deg;
  const JudgedFlight f = judged(range, sim::Simulation(scenario, 1).events());
  EXPECT_TRUE(f.said.empty()) << described(f);
  EXPECT_GT(f.largest_value, 0) << "nothing was compared";
}

TEST(Judge, ARadarThatTellsAnglesAloneIsAWitness) {
  RangeConfig range = judged_range();
  range.radars[jeju].measures.range = false;
  const sim::Simulation flight(judged_launch(range, end_s), 3);
  const Fault angles_alone = [&](Event& event, double t_s) {
    auto* plot = std::get_if<RadarTspi>(&event);
    if (plot == nullptr || plot->sensor != range.radars[jeju].id) return;
    plot->range_valid = false;
    if (t_s >= begin_s) plot->measured.azimuth_rad += 0.5 * deg;
  };
  const JudgedFlight f = judged(range, with_fault(flight, angles_alone), set_of(jeju));
  const auto excluded = f.first(jeju, IntegrityVerdict::Excluded);
  ASSERT_TRUE(excluded) << described(f);
  EXPECT_GE(*excluded, begin_s) << described(f);
  EXPECT_LE(*excluded, begin_s + 5) << described(f);
}

TEST(Judge, OneStationsWrongCopiesAreTheStationsNotTheReceivers) {
  const RangeConfig range = judged_range();
  const sim::Simulation flight(judged_launch(range, 170), 1);
  const Fault wrong_copy = [](Event& event, double t_s) {
    auto* fix = std::get_if<GpsFix>(&event);
    if (fix != nullptr && fix->station == Name("jeju-tgs") && t_s >= begin_s) fix->position.m.x() += 5000;
  };
  const JudgedFlight f = judged(range, with_fault(flight, wrong_copy), set_of(second_station));
  const auto excluded = f.first(second_station, IntegrityVerdict::Excluded);
  ASSERT_TRUE(excluded) << described(f);
  EXPECT_LE(*excluded, begin_s + 4);
  EXPECT_FALSE(f.first(first_station, IntegrityVerdict::Excluded)) << described(f);
  EXPECT_EQ(f.said.back().judgement.why, Finding::DifferingCopy);
}

TEST(Judge, OneRadarAgainstTheReceiverIsAmbiguousUnlessTrustIsConfigured) {
  RangeConfig range = judged_range();
  range.radars.pop_back();
  const sim::Simulation flight(judged_launch(range, end_s), 1);
  const std::vector<Event> events = with_fault(flight, follows_another(goheung, {0, 50, 0}));
  const JudgedFlight tie = judged(range, events, set_of(goheung));
  EXPECT_TRUE(tie.first(goheung, IntegrityVerdict::Ambiguous)) << described(tie);
  EXPECT_TRUE(tie.first(1, IntegrityVerdict::Ambiguous)) << described(tie);
  EXPECT_FALSE(tie.first(goheung, IntegrityVerdict::Excluded)) << described(tie);
  range.targets[0].nominal = plan_of(flight);
  const JudgedFlight planned = judged(range, events, set_of(goheung));
  EXPECT_TRUE(planned.first(goheung, IntegrityVerdict::Ambiguous)) << "too near to its plan to tell\n"
                                                                   << described(planned);
  const JudgedFlight lost = judged(range, with_fault(flight, follows_another(goheung, {0, 400, 0})), set_of(goheung));
  EXPECT_TRUE(lost.first(goheung, IntegrityVerdict::Excluded)) << described(lost);
  EXPECT_FALSE(lost.first(1, IntegrityVerdict::Excluded)) << described(lost);
  range.targets[0].nominal = {};
  range.integrity.trust = {"goheung-tgs", "goheung"};
  const JudgedFlight trusted = judged(range, events, set_of(goheung));
  EXPECT_TRUE(trusted.first(goheung, IntegrityVerdict::Excluded)) << described(trusted);
  EXPECT_FALSE(trusted.first(1, IntegrityVerdict::Excluded)) << described(trusted);
}

TEST(Judge, TwoRadarsThatFoldAtOnceAreNoMajorityAgainstTheReceiver) {
  const RangeConfig range = judged_range();
  const sim::Simulation flight(judged_launch(range, end_s), 1);
  const Fault both_fold = [](Event& event, double t_s) {
    auto* plot = std::get_if<RadarTspi>(&event);
    if (plot != nullptr && t_s >= begin_s) plot->measured.range_m += 150e3;
  };
  const JudgedFlight f = judged(range, with_fault(flight, both_fold), set_of(goheung) | set_of(jeju));
  for (const SourceId radar : {goheung, jeju}) {
    const auto excluded = f.first(radar, IntegrityVerdict::Excluded);
    ASSERT_TRUE(excluded) << described(f);
    EXPECT_LE(*excluded, begin_s + 2.5) << described(f);
  }
  EXPECT_FALSE(f.first(first_station, IntegrityVerdict::Excluded)) << described(f);
}

/// Ranges that fold where each radar reaches the fold: whose break belongs to which disagreement is asked of each.
TEST(Judge, TwoRadarsThatFoldOneAfterTheOtherAreBothNamedAndTheReceiverIsNot) {
  const RangeConfig range = judged_range();
  const sim::Simulation flight(judged_launch(range, end_s), 3);
  struct Case {
    double later_s;
    double unseen_s;  ///< the second, before it folds
  };
  for (const Case c : {Case{3, 0}, Case{8, 0}, Case{15, 0}, Case{12, 10}}) {
    const double later_s = c.later_s;
    const double unseen_s = c.unseen_s;
    const Fault fold_in_turn = [later_s, unseen_s](Event& event, double t_s) {
      auto* plot = std::get_if<RadarTspi>(&event);
      if (plot == nullptr) return;
      const bool second = plot->sensor == Name("goheung");
      const double from_s = second ? begin_s + later_s : begin_s;
      if (t_s >= from_s) plot->measured.range_m += 150e3;
      if (second && t_s < from_s && t_s >= from_s - unseen_s) plot->mode = TrackMode::Search;
    };
    const JudgedFlight f = judged(range, with_fault(flight, fold_in_turn), set_of(goheung) | set_of(jeju));
    for (const SourceId radar : {jeju, goheung}) {
      const double from_s = radar == jeju ? begin_s : begin_s + later_s;
      const auto excluded = f.first(radar, IntegrityVerdict::Excluded);
      ASSERT_TRUE(excluded) << later_s << "\n" << described(f);
      EXPECT_LE(*excluded, from_s + 4.5) << described(f);
    }
    for (const Said& s : f.said) {
      if (!contains(gps, s.source)) {
        EXPECT_GE((s.judgement.onset - liftoff).seconds(), begin_s - 0.1) << "it was a step\n" << described(f);
      } else {
        EXPECT_NE(s.judgement.verdict, IntegrityVerdict::Excluded) << described(f);
      }
    }
  }
}

TEST(Judge, AReceiversClockASecondOffFromTheStartIsNotTheRadars) {
  const RangeConfig range = judged_range();
  const sim::Simulation flight(judged_launch(range, 100), 1);
  const Fault early = [&](Event& event, double) {
    auto* fix = std::get_if<GpsFix>(&event);
    if (fix == nullptr) return;
    const auto said = flight.truth(fix->epoch + seconds(1));
    const auto true_state = flight.truth(fix->epoch);
    fix->position.m += said->position.m - true_state->position.m;
    fix->velocity.m_s += said->velocity.m_s - true_state->velocity.m_s;
  };
  const JudgedFlight f = judged(range, with_fault(flight, early), gps);
  EXPECT_TRUE(f.first(first_station, IntegrityVerdict::Excluded)) << described(f);
  for (const Said& s : f.said) {
    if (s.judgement.verdict == IntegrityVerdict::Excluded) {
      EXPECT_LT(s.judgement.undone_from, liftoff) << "nobody had agreed with it in flight\n" << described(f);
    }
  }
  EXPECT_FALSE(f.first(goheung, IntegrityVerdict::Excluded)) << described(f);
  EXPECT_FALSE(f.first(jeju, IntegrityVerdict::Excluded)) << described(f);
}

TEST(Judge, OfTwoReceiversThatDifferThePadTellsWhich) {
  for (const bool surveyed : {false, true}) {
    RangeConfig range = judged_range();
    if (!surveyed) range.pad.reset();
    const sim::Simulation flight(judged_launch(range, 100), 1);
    std::vector<Event> events;
    for (const Event& event : flight.events()) {
      events.push_back(event);
      const auto* fix = std::get_if<GpsFix>(&event);
      if (fix == nullptr) continue;
      GpsFix other = *fix;  // half a second later
      other.receiver = "upper";
      other.epoch = other.epoch + milliseconds(500);
      other.received = other.received + milliseconds(500);
      const auto state = flight.truth(other.epoch);
      const auto R = enu_from_ecef_at(geodetic_from_ecef(state->position)).inverse();
      other.position = state->position + R * Displacement<Enu>{{2, -3, 50}};
      other.velocity = state->velocity;
      events.emplace_back(other);
    }
    std::stable_sort(events.begin(), events.end(),
                     [](const Event& a, const Event& b) { return received_of(a) < received_of(b); });
    const JudgedFlight f = judged(range, events);
    ASSERT_FALSE(f.said.empty());
    // Both come by the same station: it is doubted, not excluded.
    EXPECT_EQ(f.said.front().judgement.verdict, surveyed ? IntegrityVerdict::Suspect : IntegrityVerdict::Ambiguous)
        << described(f);
    EXPECT_LT(f.said.front().t_s, 0) << described(f);
    EXPECT_EQ(surveyed, f.said.back().judgement.why == Finding::OffPad) << described(f);
    EXPECT_EQ(surveyed, f.said.back().judgement.receiver == Name("upper")) << described(f);
    EXPECT_FALSE(f.first(first_station, IntegrityVerdict::Excluded)) << "the other receiver comes by the same station";
    EXPECT_FALSE(f.first(goheung, IntegrityVerdict::Excluded)) << described(f);
  }
}

TEST(Judge, SaysTheSameAgainAndAllocatesNothing) {
  const RangeConfig range = judged_range();
  sim::Scenario scenario = judged_launch(range, 160);
  scenario.gps.faults.push_back({{150, 170}, {200, 0, 0}, {0, 0, 0}});
  const std::vector<Event> events = sim::Simulation(scenario, 1).events();
  const JudgedFlight a = judged(range, events, gps);
  const JudgedFlight b = judged(range, events, gps);
  EXPECT_EQ(described(a), described(b));
  EXPECT_EQ(a.largest_value, b.largest_value);
  EXPECT_EQ(a.allocations, 0u);
}

}  // namespace
}  // namespace downrange::test
