/// Faults as data: each kind does what it says to the messages it names, while it lasts, and to nothing else; a
/// catalogue that is wrong is complained about with its line.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <source_dir.hpp>

#include "../support/small_range.hpp"
#include "sim/faults.hpp"
#include "sim/launch_trajectory.hpp"

namespace downrange::sim {
namespace {

using test::liftoff;
using test::small_range;
using test::vehicle_at;

/// Of the small range from 0 to 100 s: each radar's plots and each station's fixes, once a second.
std::vector<Event> flight() {
  const RangeConfig range = small_range();
  std::vector<Event> events;
  MissionEvent plan;
  plan.mission = "m";
  plan.label = "planned lift-off";
  plan.kind = MissionEventKind::PlannedLiftoff;
  plan.sequence = 1;
  plan.epoch = liftoff;
  plan.received = liftoff - seconds(900);
  events.emplace_back(plan);
  for (int t = 0; t <= 100; ++t) {
    const auto sequence = static_cast<std::uint64_t>(t) + 1;
    for (const RadarConfig& radar : range.radars) events.emplace_back(test::plot_at(radar, t, sequence));
    for (const TelemetryConfig& station : range.telemetry) {
      GpsFix fix;
      fix.target = "kslv";
      fix.station = station.id;
      fix.sequence = sequence;
      fix.epoch = liftoff + seconds(t);
      fix.received = fix.epoch + seconds(0.3);
      fix.position = vehicle_at(t);
      fix.velocity = {vehicle_at(t + 0.5).m - vehicle_at(t - 0.5).m};
      fix.velocity_valid = true;
      events.emplace_back(fix);
    }
  }
  return events;
}

class FaultFile : public ::testing::Test {
 protected:
  FaultFile()
      : folder_(std::filesystem::temp_directory_path() /
                ("downrange-faults-" + std::to_string(::getpid()) + "-" +
                 ::testing::UnitTest::GetInstance()->current_test_info()->name())) {
    std::filesystem::create_directories(folder_);
  }
  ~FaultFile() override { std::filesystem::remove_all(folder_); }

  FaultCatalogue load(const std::string& text) {
    std::ofstream(folder_ / "f.toml") << text;
    return load_faults(folder_ / "f.toml");
  }
  /// What load() or playing it complains about, the folder's name taken off.
  std::string complaint(const std::string& text) {
    try {
      (void)play(text);
    } catch (const ScenarioError& error) {
      return std::string(error.what()).substr(folder_.string().size() + 1);
    }
    return "none";
  }
  /// A fault of this one action, from 40 s for 20 s, on flight().
  Injected play(const std::string& text, const RangeConfig& range = small_range()) {
    const FaultCatalogue catalogue = load(text);
    const Fault& fault = catalogue.faults.front();
    return inject(catalogue, fault, {.range = range, .liftoff = liftoff, .begin_s = fault.begin_s.front(), .seed = 3},
                  flight());
  }
  Injected play_action(const std::string& action, const RangeConfig& range = small_range()) {
    return play(head + "[[fault.do]]\n" + action, range);
  }

  const std::string head = "[[fault]]\nname = \"f\"\nwhat = \"w\"\nbegin_s = [40.0]\nlasts_s = 20\n";
  const std::filesystem::path folder_;
};

template <class Message>
std::vector<Message> all_of(const std::vector<Event>& events, const Name& source) {
  std::vector<Message> found;
  for (const Event& event : events)
    if (const auto* message = std::get_if<Message>(&event))
      if (source_of(event) == source) found.push_back(*message);
  return found;
}

double second_of(const auto& message) { return (message.epoch - liftoff).seconds(); }

/// The messages that are not in flight() to the bit.
std::vector<Event> changed(const std::vector<Event>& events) {
  const std::vector<Event> healthy = flight();
  std::vector<Event> out;
  std::ranges::copy_if(events, std::back_inserter(out),
                       [&](const Event& event) { return std::ranges::find(healthy, event) == healthy.end(); });
  return out;
}

TEST_F(FaultFile, SilenceTakesTheNamedSourceAndItsWindowAlone) {
  const Injected out = play_action("kind = \"silence\"\nsources = [\"goheung\"]\n");
  EXPECT_EQ(out.touched, 20u);
  EXPECT_EQ(out.events.size(), flight().size() - 20);
  EXPECT_TRUE(changed(out.events).empty());
  for (const RadarTspi& plot : all_of<RadarTspi>(out.events, "goheung"))
    EXPECT_FALSE(second_of(plot) >= 40 && second_of(plot) < 60);
  EXPECT_EQ(all_of<RadarTspi>(out.events, "jeju").size(), 101u);
}

TEST_F(FaultFile, SourcesAreMeantByNumberAndByKind) {
  EXPECT_EQ(play_action("kind = \"silence\"\nsources = [\"radar:2\"]\n").touched, 20u);
  EXPECT_EQ(play_action("kind = \"silence\"\nsources = [\"radars\"]\n").touched, 40u);
  EXPECT_EQ(play_action("kind = \"silence\"\nsources = [\"gps\"]\n").touched, 40u);
  EXPECT_EQ(play_action("kind = \"silence\"\nsources = [\"all\"]\n").touched, 80u);
  EXPECT_EQ(play_action("kind = \"silence\"\nsources = [\"radar:3\"]\n").touched, 0u);  // this range has none
}

TEST_F(FaultFile, APlotAndAFixAreDisplacedToTheSamePlace) {
  const std::string how = "east_m = 300\ndrift_up_m_s = 10\n";
  const Injected radar = play_action("kind = \"displace\"\nsources = [\"goheung\"]\n" + how);
  const Injected gps = play_action("kind = \"displace\"\nsources = [\"gps\"]\n" + how);
  const Site site = small_range().radars[0].site;
  const RadarTspi plot = all_of<RadarTspi>(radar.events, "goheung")[50];
  const GpsFix fix = all_of<GpsFix>(gps.events, "jeju-tgs")[50];
  const Position<Ecef> seen = site.ecef_of(enu_from_polar(plot.measured));
  EXPECT_LT((seen.m - fix.position.m).norm(), 1e-3);
  EXPECT_NEAR((fix.position.m - vehicle_at(50).m).norm(), std::hypot(300, 100), 1e-6);
  EXPECT_EQ(changed(gps.events).size(), 40u);
}

TEST_F(FaultFile, VelocityAgreesWithADriftWhereItShall) {
  const std::string how = "kind = \"displace\"\nsources = [\"gps\"]\ndrift_east_m_s = 20\n";
  const GpsFix healthy = all_of<GpsFix>(flight(), "jeju-tgs")[50];
  EXPECT_EQ(all_of<GpsFix>(play_action(how).events, "jeju-tgs")[50].velocity, healthy.velocity);
  const GpsFix drawn = all_of<GpsFix>(play_action(how + "velocity_too = true\n").events, "jeju-tgs")[50];
  EXPECT_NEAR((drawn.velocity.m_s - healthy.velocity.m_s).norm(), 20, 1e-9);
}

TEST_F(FaultFile, UnitsSignsAndFolds) {
  const RadarTspi healthy = all_of<RadarTspi>(flight(), "goheung")[50];
  const auto told = [&](const std::string& how) {
    return all_of<RadarTspi>(play_action("kind = \"distort\"\nsources = [\"goheung\"]\n" + how).events, "goheung")[50]
        .measured;
  };
  EXPECT_NEAR(told("azimuth_factor = -1\n").azimuth_rad, 2 * std::numbers::pi - healthy.measured.azimuth_rad, 1e-12);
  EXPECT_NEAR(told("range_factor = 3.28084\n").range_m, 3.28084 * healthy.measured.range_m, 1e-6);
  EXPECT_NEAR(told("range_fold_m = 10e3\n").range_m, std::fmod(healthy.measured.range_m, 10e3), 1e-9);
  EXPECT_NEAR(told("elevation_offset_deg = 0.1\n").elevation_rad,
              healthy.measured.elevation_rad + 0.1 * std::numbers::pi / 180, 1e-12);
}

TEST_F(FaultFile, AClockShiftsStampsAndNothingElse) {
  const Injected out = play_action("kind = \"clock\"\nsources = [\"goheung\"]\noffset_s = -1\ndrift = 0.01\n");
  std::vector<RadarTspi> plots = all_of<RadarTspi>(out.events, "goheung");
  EXPECT_NEAR(second_of(plots[50]), 50 - 1 + 0.1, 1e-9);
  plots[50].epoch = liftoff + seconds(50);
  EXPECT_EQ(plots[50], all_of<RadarTspi>(flight(), "goheung")[50]);
}

TEST_F(FaultFile, AFrozenReceiverRepeatsWhatItSaidBefore) {
  const std::string how = "kind = \"freeze\"\nsources = [\"gps\"]\n";
  const GpsFix last = all_of<GpsFix>(flight(), "goheung-tgs")[39];
  for (const GpsFix& fix : all_of<GpsFix>(play_action(how).events, "goheung-tgs")) {
    if (second_of(fix) < 40 || second_of(fix) >= 60) continue;
    EXPECT_EQ(fix.position, last.position);
    EXPECT_EQ(fix.velocity, last.velocity);
  }
  const Injected lives = play_action(how + "velocity_lives = true\n");
  EXPECT_NE(all_of<GpsFix>(lives.events, "goheung-tgs")[50].velocity, last.velocity);
  // Noise is the receiver's: every station relays the same.
  const Injected noisy = play_action(how + "noise_m = 5\n");
  const GpsFix one = all_of<GpsFix>(noisy.events, "goheung-tgs")[50];
  EXPECT_NE(one.position, last.position);
  EXPECT_EQ(one.position, all_of<GpsFix>(noisy.events, "jeju-tgs")[50].position);
}

TEST_F(FaultFile, DeadReckoningCarriesTheLastFixOn) {
  const GpsFix last = all_of<GpsFix>(flight(), "goheung-tgs")[39];
  const Injected out = play_action("kind = \"dead_reckon\"\nsources = [\"gps\"]\n");
  const GpsFix fix = all_of<GpsFix>(out.events, "goheung-tgs")[50];
  EXPECT_LT((fix.position.m - last.position.m - 11 * last.velocity.m_s).norm(), 1e-6);
}

TEST_F(FaultFile, ASecondReceiverSpeaksBesideTheFirst) {
  const Injected out = play_action("kind = \"second_receiver\"\nsources = [\"gps\"]\nreceiver = \"b\"\neast_m = 60\n");
  EXPECT_EQ(out.events.size(), flight().size() + 40);
  EXPECT_EQ(changed(out.events).size(), 40u);
  EXPECT_TRUE(std::ranges::is_sorted(out.events, {}, [](const Event& event) { return received_of(event); }));
}

TEST_F(FaultFile, PlotsOfASecondTargetAreSwapped) {
  RangeConfig range = small_range();
  range.targets.push_back({"stage1"});
  const std::string second =
      head +
      "[[fault.do]]\nkind = \"second_target\"\nsources = [\"radars\"]\ntarget = \"target:2\"\ndrift_north_m_s = 20\n";
  const Injected two = play(second, range);
  EXPECT_EQ(two.events.size(), flight().size() + 40);
  const Injected swapped = play(
      second + "[[fault.do]]\nkind = \"swap_targets\"\nsources = [\"goheung\"]\ntarget = \"kslv\"\nwith = \"stage1\"\n",
      range);
  const auto of_stage = [](const std::vector<Event>& events, double t_s) {
    std::vector<Polar> seen;
    for (const RadarTspi& plot : all_of<RadarTspi>(events, "goheung"))
      if (plot.target == Name("stage1") && second_of(plot) == t_s) seen.push_back(plot.measured);
    return seen.at(0);
  };
  EXPECT_NE(of_stage(two.events, 50), all_of<RadarTspi>(flight(), "goheung")[50].measured);
  EXPECT_EQ(of_stage(swapped.events, 50), all_of<RadarTspi>(flight(), "goheung")[50].measured);
}

TEST_F(FaultFile, RadarsThatSayTheyAreEachOther) {
  const std::string how = "kind = \"swap_sensors\"\nsources = [\"goheung\"]\nwith = \"jeju\"\n";
  EXPECT_EQ(all_of<RadarTspi>(play_action(how).events, "jeju").size(), 121u);
  const Injected mutual = play_action(how + "mutual = true\n");
  EXPECT_EQ(all_of<RadarTspi>(mutual.events, "jeju").size(), 101u);
  EXPECT_EQ(mutual.touched, 40u);
}

TEST_F(FaultFile, ARecycleTellsAnEarlierPlanFirst) {
  const Injected out = play_action("kind = \"recycle\"\ndelay_s = 600\n");
  std::vector<MissionEvent> marks;
  for (const Event& event : out.events)
    if (const auto* mark = std::get_if<MissionEvent>(&event)) marks.push_back(*mark);
  ASSERT_EQ(marks.size(), 4u);
  EXPECT_EQ(marks[0].epoch, liftoff - seconds(600));
  EXPECT_EQ(marks[1].kind, MissionEventKind::Hold);
  EXPECT_EQ(marks[2].kind, MissionEventKind::Recycle);
  EXPECT_EQ(marks[3].epoch, liftoff);
  for (std::size_t i = 0; i < marks.size(); ++i) EXPECT_EQ(marks[i].sequence, i + 1);
}

TEST_F(FaultFile, WhatIsDrawnDependsOnTheSeedAlone) {
  const std::string text = head +
                           "[[fault.do]]\nkind = \"bursts\"\nsources = [\"goheung\"]\nprobability = 0.5\nevery_s = "
                           "5\nburst_s = 2\nrange_m = 1000\n";
  EXPECT_EQ(play(text).events, play(text).events);
  const FaultCatalogue catalogue = load(text);
  const RangeConfig range = small_range();
  const auto with_seed = [&](std::uint64_t seed) {
    return inject(catalogue, catalogue.faults[0], {.range = range, .liftoff = liftoff, .begin_s = 40, .seed = seed},
                  flight())
        .events;
  };
  EXPECT_NE(with_seed(1), with_seed(2));
  for (const Event& event : changed(with_seed(1))) {
    const double since_s = second_of(std::get<RadarTspi>(event)) - 40;
    EXPECT_LT(std::fmod(since_s, 5), 2);
  }
}

TEST_F(FaultFile, SaysWhatIsWrongAndWhere) {
  EXPECT_EQ(complaint("x = 1\n"), "f.toml:1: fault: is missing: a [[fault]] for each");
  EXPECT_EQ(complaint(head), "f.toml:1: fault.do: is missing: [[fault.do]], or a flight of its own");
  EXPECT_NE(complaint(head + "[[fault.do]]\nkind = \"explode\"\nsources = [\"all\"]\n")
                .find("f.toml:7: fault.do.kind: \"explode\" is no fault; allowed: silence, displace"),
            std::string::npos);
  EXPECT_EQ(complaint(head + "[[fault.do]]\nkind = \"silence\"\n"), "f.toml:6: fault.do.sources: must name a source");
  EXPECT_NE(complaint(head + "[[fault.do]]\nkind = \"silence\"\nsources = [\"all\"]\neast_m = 3\n")
                .find("f.toml:9: fault.do.east_m: is not a key of this table"),
            std::string::npos);
  EXPECT_NE(complaint(head + "[[fault.do]]\nkind = \"silence\"\nsources = [\"nobody\"]\n")
                .find("f.toml:6: \"nobody\" is no source of this range"),
            std::string::npos);
  EXPECT_NE(complaint(head + "[[fault.do]]\nkind = \"second_target\"\nsources = [\"radars\"]\ntarget = \"target:2\"\n")
                .find("f.toml:6: \"target:2\" is no target of this range"),
            std::string::npos);
  EXPECT_EQ(
      complaint(head + "[[fault.do]]\nkind = \"silence\"\nsources = [\"all\"]\n[fault.expect]\naccusation_s = 3\n"),
      "f.toml:10: fault.expect.accusation_s: is of somebody who lies: name liars");
  EXPECT_EQ(
      complaint(head + "[[fault.do]]\nkind = \"silence\"\nsources = [\"all\"]\n[fault.expect]\non_target_share = 99\n"),
      "f.toml:10: fault.expect.on_target_share: 99 is not allowed: 0 to 1");
  EXPECT_EQ(complaint(head + "flight = \"mars\"\n"), "f.toml:6: fault.flight: \"mars\" is no [[flight]] of this file");
  EXPECT_EQ(complaint("begin_s = 3\n" + head),
            "f.toml:1: begin_s: must be a list of numbers, each -86400 to 86400, such as [150.0, 290.0]");
}

TEST_F(FaultFile, SaysWhatIsExpectedAtTheAntennas) {
  const std::string fault = head + "[[fault.do]]\nkind = \"silence\"\nsources = [\"all\"]\n";
  const auto expected = [&](const std::string& text) { return load(text).faults.front().expected; };
  EXPECT_FALSE(expected(fault).on_target_share);
  EXPECT_FALSE(expected(fault).excursion_rad);
  const score::FaultLimits told = expected(fault + "[fault.expect]\non_target_share = 0.9\nexcursion_deg = 3\n");
  EXPECT_EQ(told.on_target_share, 0.9);
  ASSERT_TRUE(told.excursion_rad);
  EXPECT_NEAR(*told.excursion_rad, 3 * std::numbers::pi / 180, 1e-12);
  // What the file says of all of them, but of a majority that lies.
  const std::string all = "on_target_share = 0.99\n";
  EXPECT_EQ(expected(all + fault).on_target_share, 0.99);
  EXPECT_EQ(expected(all + fault + "[fault.expect]\nerror_m = 1\n").on_target_share, 0.99);
  EXPECT_EQ(expected(all + fault + "[fault.expect]\non_target_share = 0.5\n").on_target_share, 0.5);
  EXPECT_FALSE(expected(all + fault + "[fault.expect]\nmajority_lies = true\n").on_target_share);
}

TEST(ShippedFaults, AreReadAndSayWhatTheyExpect) {
  const std::filesystem::path file =
      std::filesystem::path(DOWNRANGE_SOURCE_DIR) / "tools" / "scenarios" / "faults" / "catalogue.toml";
  const FaultCatalogue catalogue = load_faults(file);
  EXPECT_GE(catalogue.faults.size(), 70u);
  for (const Fault& fault : catalogue.faults) {
    EXPECT_FALSE(fault.radars.empty()) << fault.name;
    EXPECT_EQ(&catalogue.find(fault.name), &fault);
  }
  EXPECT_THROW((void)catalogue.find("absent"), ScenarioError);
  EXPECT_THROW((void)catalogue.find(""), ScenarioError);
}

TEST(FlownAs, ACutOffEndsTheBurnAndAPushTurnsTheVehicle) {
  Scenario scenario;
  scenario.profile = naro_launch_profile();
  scenario.end_s = 300;
  const Scenario early = flown_as(scenario, {.name = "v", .cutoff_s = 180}, {});
  ASSERT_EQ(early.profile.burns.size(), 1u);
  EXPECT_EQ(early.profile.burns[0].to_s, 180);
  const LaunchTrajectory cut(early.profile, liftoff, 300);
  EXPECT_LT(cut.acceleration(liftoff + seconds(200))->norm(), 11);

  const Scenario turned =
      flown_as(scenario, {.name = "v", .pushes = {{.from_s = 150, .to_s = 160, .right_m_s2 = 30}}}, {});
  const LaunchTrajectory straight(scenario.profile, liftoff, 300);
  const LaunchTrajectory turn(turned.profile, liftoff, 300);
  EXPECT_EQ(straight.at(liftoff + seconds(149))->position.m, turn.at(liftoff + seconds(149))->position.m);
  const Eigen::Vector3d gained =
      turn.at(liftoff + seconds(160))->velocity.m_s - straight.at(liftoff + seconds(160))->velocity.m_s;
  EXPECT_NEAR(gained.norm(), 300, 10);

  const Scenario falling = flown_as(scenario, {.name = "v", .ballistic_kg_m2 = 1500}, {});
  const LaunchTrajectory drag(falling.profile, liftoff, 300);
  EXPECT_LT(drag.at(liftoff + seconds(60))->velocity.m_s.norm(),
            straight.at(liftoff + seconds(60))->velocity.m_s.norm());
}

TEST(FlownAs, AHopEndsAtRestWhereItShallAndMovesAsItsVelocitySays) {
  Scenario scenario;
  scenario.profile = naro_launch_profile();
  const Scenario flown = flown_as(scenario, {.name = "v", .hop = Hop{}}, {});
  const LaunchTrajectory hop(flown.profile, liftoff, 400);
  const Site pad(flown.profile.pad);
  const auto at = [&](double t_s) { return *hop.at(liftoff + seconds(t_s)); };
  EXPECT_LT((at(0).position.m - pad.ecef().m).norm(), 1e-6);
  EXPECT_NEAR(pad.enu_of(at(150).position).m.z(), 30e3, 1e-6);
  EXPECT_NEAR(pad.enu_of(at(310).position).m.head<2>().norm(), 15e3, 1e-6);
  EXPECT_NEAR(pad.enu_of(at(310).position).m.z(), 0, 1e-6);
  EXPECT_EQ(at(310).velocity.m_s.norm(), 0);
  constexpr double h = 1e-2;
  for (const double t_s : {20.0, 75.0, 149.0, 200.0, 290.0}) {
    const Eigen::Vector3d v = (at(t_s + h).position.m - at(t_s - h).position.m) / (2 * h);
    const Eigen::Vector3d a = (at(t_s + h).velocity.m_s - at(t_s - h).velocity.m_s) / (2 * h);
    EXPECT_LT((v - at(t_s).velocity.m_s).norm(), 1e-3) << t_s;
    EXPECT_LT((a - *hop.acceleration(liftoff + seconds(t_s))).norm(), 1e-3) << t_s;
  }
}

TEST(FlownAs, AnEarlierStartHoldsForWhoWasThereFromTheStart) {
  Scenario scenario;
  scenario.start_s = -10;
  scenario.end_s = 100;
  const RangeConfig range = small_range();
  for (const RadarConfig& radar : range.radars) {
    RadarScenario r;
    r.id = radar.id;
    r.track = {radar.id == Name("jeju") ? 48.0 : -10.0, 100.0};
    scenario.radars.push_back(r);
  }
  scenario.gps.active = {-10, 100};
  const Scenario flown = flown_as(scenario, {.name = "v", .start_s = -900, .track_from_s = {{"radar:2", 20.0}}}, range);
  EXPECT_EQ(flown.start_s, -900);
  EXPECT_EQ(flown.radars[0].track.first, -900);
  EXPECT_EQ(flown.radars[1].track.first, 20);
  EXPECT_EQ(flown.gps.active.first, -900);
  Scenario shorter = flown;
  end_at(shorter, 60);
  EXPECT_EQ(shorter.radars[0].track.second, 60);
  EXPECT_EQ(shorter.end_s, 60);
}

TEST(FlownAs, ATrackerMayBeginLaterToo) {
  RangeConfig range = small_range();
  AngleSensorConfig optical;
  optical.id = "optical";
  range.angle_sensors.push_back(optical);
  Scenario scenario;
  RadarScenario tracker;
  tracker.id = Name("optical");
  tracker.track = {0, 100};
  scenario.angle_sensors.push_back(tracker);
  const Scenario flown = flown_as(scenario, {.name = "v", .track_from_s = {{"tracker:1", 20.0}}}, range);
  EXPECT_EQ(flown.angle_sensors[0].track.first, 20);
  EXPECT_THROW((void)flown_as(scenario, {.name = "v", .track_from_s = {{"gps", 20.0}}}, range), ScenarioError);
}

}  // namespace
}  // namespace downrange::sim
