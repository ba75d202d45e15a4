/// Every reason of ingest rings, once, and nothing else does.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "../support/small_range.hpp"
#include "stage/ingest.hpp"

namespace downrange {
namespace {

using test::angles_at;
using test::deg;
using test::fix_at;
using test::plot_at;

struct RadarCase {
  const char* what;
  std::function<void(RadarTspi&)> change;
  Reason expected;
};

TEST(Ingest, NoReceiverIsBetterThanConfiguredWhateverItStates) {
  const RangeConfig range = test::small_range();
  Ingest ingest(range);
  GpsFix message = fix_at(range.telemetry[0].id, 30, 1);
  message.sigma_horizontal_m = 0.1;
  message.sigma_vertical_m = 0;  // not stated
  message.sigma_velocity_m_s = 3;
  const auto fix = std::get<Fix>(ingest.judge(message).measured);
  EXPECT_EQ(fix.sigma_horizontal_m, range.gps.sigma_horizontal_m);
  EXPECT_EQ(fix.sigma_vertical_m, range.gps.sigma_vertical_m);
  EXPECT_EQ(fix.sigma_velocity_m_s, 3);
}

TEST(Ingest, NoTargetIsForgottenHoweverManyThereAre) {
  RangeConfig range = test::small_range();
  for (int i = 0; i < 1000; ++i) {
    range.targets.emplace_back();
    range.targets.back().id = std::string_view("t" + std::to_string(i));
  }
  Ingest ingest(range);
  for (const Reason expected : {Reason::Accepted, Reason::Duplicate}) {
    for (const RadarConfig& radar : range.radars) {
      RadarTspi plot = plot_at(radar, 30, 1);
      for (const TargetConfig& target : range.targets) {
        plot.target = target.id;
        ASSERT_EQ(ingest.judge(plot).verdict, expected) << target.id.view();
      }
    }
  }
}

TEST(Ingest, ReceiversThatNobodyKnowsPushOutTheQuietest) {
  const RangeConfig range = test::small_range();
  Ingest ingest(range);
  GpsFix fix = fix_at(range.telemetry[0].id, 30, 1);
  RadarTspi plot = plot_at(range.radars[0], 30, 1);
  ASSERT_EQ(ingest.judge(plot).verdict, Reason::Accepted);
  for (int i = 0; i < 100'000; ++i) {
    const std::string name = "r" + std::to_string(i);
    fix.receiver = std::string_view(name);
    fix.received = fix.received + Duration{1};
    (void)ingest.judge(fix);
    if (i % 100 != 0) continue;
    plot.received = fix.received;  // the radar is heard all the time, and remembered
    ASSERT_EQ(ingest.judge(plot).verdict, Reason::Duplicate) << i;
  }
}

TEST(Ingest, RadarReasons) {
  const RangeConfig range = test::small_range();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<RadarCase> cases{
      {"good", [](RadarTspi&) {}, Reason::Accepted},
      {"sensor", [](RadarTspi& p) { p.sensor = "nobody"; }, Reason::UnknownSource},
      {"target", [](RadarTspi& p) { p.target = "nobody"; }, Reason::UnknownSource},
      {"live input to a simulated node", [](RadarTspi& p) { p.simulated = false; }, Reason::SimulatedMismatch},
      {"mode", [](RadarTspi& p) { p.mode = TrackMode::Coast; }, Reason::NotTracking},
      {"NaN range", [&](RadarTspi& p) { p.measured.range_m = nan; }, Reason::NotFinite},
      {"infinite azimuth", [](RadarTspi& p) { p.measured.azimuth_rad = INFINITY; }, Reason::NotFinite},
      {"range too long", [](RadarTspi& p) { p.measured.range_m = 5e6; }, Reason::OutOfLimits},
      {"slaved", [](RadarTspi& p) { p.mode = TrackMode::Slaved; }, Reason::Slaved},
      {"nothing valid", [](RadarTspi& p) { p.range_valid = p.azimuth_valid = false; }, Reason::NotTracking},
      {"no range", [&](RadarTspi& p) { p.range_valid = false, p.measured.range_m = nan; }, Reason::Accepted},
      {"no elevation", [&](RadarTspi& p) { p.elevation_valid = false, p.measured.elevation_rad = nan; },
       Reason::Accepted},
      {"range alone, too long", [](RadarTspi& p) { p.azimuth_valid = false, p.measured.range_m = 5e6; },
       Reason::OutOfLimits},
      {"angles alone, below the horizon", [](RadarTspi& p) { p.range_valid = false, p.measured.elevation_rad = -0.01; },
       Reason::OutOfLimits},
      {"NaN range rate", [&](RadarTspi& p) { p.range_rate_valid = true, p.range_rate_m_s = nan; }, Reason::NotFinite},
      {"NaN range rate that is not valid", [&](RadarTspi& p) { p.range_rate_m_s = nan; }, Reason::Accepted},
      {"range rate of no vehicle", [](RadarTspi& p) { p.range_rate_valid = true, p.range_rate_m_s = 3e4; },
       Reason::OutOfLimits},
      {"negative range", [](RadarTspi& p) { p.measured.range_m = -1; }, Reason::OutOfLimits},
      {"below the horizon", [](RadarTspi& p) { p.measured.elevation_rad = -0.01; }, Reason::OutOfLimits},
      {"too late", [](RadarTspi& p) { p.received = p.epoch + milliseconds(5001); }, Reason::TooLate},
      {"just in time", [](RadarTspi& p) { p.received = p.epoch + milliseconds(4999); }, Reason::Accepted},
      {"from the future", [](RadarTspi& p) { p.received = p.epoch - milliseconds(101); }, Reason::FromFuture},
      {"a little early", [](RadarTspi& p) { p.received = p.epoch - milliseconds(99); }, Reason::Accepted},
  };
  for (const RadarCase& c : cases) {
    Ingest ingest(range);
    RadarTspi p = plot_at(range.radars[0], 30, 1);
    c.change(p);
    EXPECT_EQ(ingest.judge(p).verdict, c.expected) << c.what;
  }
}

struct FixCase {
  const char* what;
  std::function<void(GpsFix&)> change;
  Reason expected;
};

/// What a plot lacks, or its radar is not configured to measure, leaves nothing behind.
TEST(Ingest, APlotHasThePartsThatItsRadarMeasures) {
  RangeConfig range = test::small_range();
  RadarTspi whole = test::plot_at(range.radars[0], 30, 1);
  const auto plot_of_it = [&] { return std::get<Plot>(Ingest(range).judge(whole).measured); };
  const Polar measured = plot_of_it().measured;
  range.radars[0].measures = {.range = true, .angles = false};
  EXPECT_EQ(plot_of_it(), (Plot{.measured = {measured.range_m, 0, 0}, .angles_valid = false}));
  range.radars[0].measures = {.range = false, .angles = true};
  EXPECT_EQ(plot_of_it(), (Plot{.measured = {0, measured.azimuth_rad, measured.elevation_rad}, .range_valid = false}));
  whole.azimuth_valid = false;
  EXPECT_EQ(Ingest(range).judge(whole).verdict, Reason::NotTracking);
  range.radars[0].measures = {};
  EXPECT_EQ(plot_of_it(), (Plot{.measured = {measured.range_m, 0, 0}, .angles_valid = false}));
}

TEST(Ingest, GpsReasons) {
  const RangeConfig range = test::small_range();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<FixCase> cases{
      {"good", [](GpsFix&) {}, Reason::Accepted},
      {"station", [](GpsFix& f) { f.station = "nobody"; }, Reason::UnknownSource},
      {"two dimensions", [](GpsFix& f) { f.fix = FixType::TwoDimensional; }, Reason::NotTracking},
      {"three satellites", [](GpsFix& f) { f.satellites = 3, f.satellites_valid = true; }, Reason::NotTracking},
      {"NaN", [&](GpsFix& f) { f.position.m[1] = nan; }, Reason::NotFinite},
      {"NaN velocity", [&](GpsFix& f) { f.velocity.m_s[1] = nan; }, Reason::NotFinite},
      {"NaN velocity that is not valid",
       [&](GpsFix& f) {
         f.velocity.m_s[1] = nan;
         f.velocity_valid = false;
       },
       Reason::Accepted},
      {"NaN sigma", [&](GpsFix& f) { f.sigma_vertical_m = nan; }, Reason::NotFinite},
      {"absurd sigma", [](GpsFix& f) { f.sigma_horizontal_m = 1e200; }, Reason::OutOfLimits},
      {"epoch before all time", [](GpsFix& f) { f.epoch = Time{std::numeric_limits<std::int64_t>::min()}; },
       Reason::OutOfLimits},
      {"no satellites, not stated", [](GpsFix& f) { f.satellites = 0; }, Reason::Accepted},
      {"no satellites, stated",
       [](GpsFix& f) {
         f.satellites = 0;
         f.satellites_valid = true;
       },
       Reason::NotTracking},
      {"the Earth's centre", [](GpsFix& f) { f.position.m.setZero(); }, Reason::NoPosition},
      {"latitude and longitude 0",
       [](GpsFix& f) {
         f.position = ecef_from_geodetic({0, 0, 0});
       },
       Reason::NoPosition},
      {"latitude and longitude 0, at some height",
       [](GpsFix& f) {
         f.position = ecef_from_geodetic({0, 0, 3000});
       },
       Reason::NoPosition},
      {"on the equator beside them",
       [](GpsFix& f) {
         f.position = ecef_from_geodetic({0, 0.01 * deg, 3000});
       },
       Reason::Accepted},
      {"inside the Earth", [](GpsFix& f) { f.position.m *= 0.9; }, Reason::OutOfLimits},
      {"as fast as light", [](GpsFix& f) { f.velocity.m_s[0] = 3e8; }, Reason::OutOfLimits},
  };
  for (const FixCase& c : cases) {
    Ingest ingest(range);
    GpsFix f = fix_at("goheung-tgs", 30, 1);
    c.change(f);
    EXPECT_EQ(ingest.judge(f).verdict, c.expected) << c.what;
  }
}

/// Fixes before lift-off are held against the pad, which `range` has.
class BeforeLiftoff : public testing::Test {
 protected:
  static RangeConfig with_pad() {
    RangeConfig range = test::small_range();
    range.pad = {.site = test::pad(), .radius_m = 2000};
    return range;
  }
  /// At rest, `east_m` beside the pad.
  Reason judge_at_rest(double t, double east_m, Name station = "goheung-tgs", double delay_s = 0.5) {
    GpsFix f = fix_at(station, t, ++sequence, delay_s);
    f.position = test::pad().ecef_of({{east_m, 0.0, 0.0}});
    f.velocity.m_s.setZero();
    return ingest.judge(f).verdict;
  }
  Reason judge_in_flight(double t, bool with_velocity = true) {
    GpsFix f = fix_at("goheung-tgs", t, ++sequence);
    f.velocity_valid = with_velocity;
    return ingest.judge(f).verdict;
  }
  static MissionEvent lift_off(double t, bool simulated = true) {
    MissionEvent event;
    event.kind = MissionEventKind::Liftoff;
    event.epoch = event.received = test::liftoff + seconds(t);
    event.simulated = simulated;
    return event;
  }

  Ingest ingest{with_pad()};
  std::uint64_t sequence = 0;
};

TEST_F(BeforeLiftoff, AFixAwayFromThePadIsRejected) {
  EXPECT_EQ(judge_at_rest(-20, 0), Reason::Accepted);
  EXPECT_EQ(judge_at_rest(-19, 1990), Reason::Accepted);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(judge_at_rest(-18 + i, 2010), Reason::AwayFromPad);
  EXPECT_FALSE(ingest.left_pad("kslv", test::liftoff - seconds(8)));
}

TEST_F(BeforeLiftoff, AfterTheMissionsLiftoffItIsNot) {
  EXPECT_EQ(judge_in_flight(30), Reason::AwayFromPad);
  ingest.note(lift_off(29, false));  // a rehearsal's
  EXPECT_EQ(judge_in_flight(30.1), Reason::AwayFromPad);
  ingest.note(lift_off(0));
  EXPECT_EQ(judge_in_flight(31), Reason::Accepted);
  EXPECT_EQ(judge_at_rest(-1, 3000, "jeju-tgs", 4), Reason::AwayFromPad) << "late, of before";
}

TEST_F(BeforeLiftoff, AfterAnAnnouncedLiftoffOnlyWhereAVehicleCanHaveCome) {
  ingest.note(lift_off(0));
  EXPECT_EQ(judge_at_rest(1, 2140), Reason::Accepted);
  EXPECT_EQ(judge_at_rest(5, 30'000), Reason::AwayFromPad) << "2 km and 3.75 km";
  EXPECT_EQ(judge_at_rest(14, 30'000), Reason::Accepted) << "2 km and 29.4 km";
}

TEST_F(BeforeLiftoff, ALiftoffThatIsPutOffHoldsFromThenOn) {
  ingest.note(lift_off(0));
  EXPECT_TRUE(ingest.left_pad("kslv", test::liftoff + seconds(1)));
  ingest.note(lift_off(60));
  EXPECT_FALSE(ingest.left_pad("kslv", test::liftoff + seconds(1)));
}

TEST_F(BeforeLiftoff, TheFirstMotionWillDo) {
  for (int i = 0; i < 10; ++i) EXPECT_EQ(judge_at_rest(-10 + i, 0), Reason::Accepted);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(judge_in_flight(i), Reason::Accepted) << i;
  EXPECT_TRUE(ingest.left_pad("kslv", test::liftoff + seconds(1)));
  EXPECT_FALSE(ingest.left_pad("kslv", test::liftoff - seconds(2)));
  EXPECT_FALSE(ingest.left_pad("nobody", test::liftoff + seconds(1)));
}

TEST_F(BeforeLiftoff, ANodeThatStartsInFlightBelievesAfterThreeFixes) {
  for (const bool with_velocity : {true, false}) {
    Ingest fresh{with_pad()};
    std::swap(ingest, fresh);
    EXPECT_EQ(judge_in_flight(30, with_velocity), Reason::AwayFromPad);
    EXPECT_EQ(judge_in_flight(31, with_velocity), Reason::AwayFromPad);
    EXPECT_EQ(judge_in_flight(32, with_velocity), Reason::Accepted);
  }
}

TEST_F(BeforeLiftoff, AReceiverThatJumpsAboutDoesNotMove) {
  for (int i = 0; i < 20; ++i) {
    GpsFix f = fix_at("goheung-tgs", i, ++sequence);
    f.position = test::pad().ecef_of({{i % 2 == 0 ? 5000.0 : 9000.0, 0.0, 0.0}});
    f.velocity_valid = i >= 10;
    f.velocity.m_s.setZero();
    EXPECT_EQ(ingest.judge(f).verdict, Reason::AwayFromPad) << i;
  }
}

TEST_F(BeforeLiftoff, ACentreHoldsItAgainstThePadToo) {
  const Observation far = Ingest(test::small_range()).judge(fix_at("goheung-tgs", 30, 1));
  EXPECT_EQ(far.verdict, Reason::Accepted);
  EXPECT_EQ(ingest.judge(far).verdict, Reason::AwayFromPad);
}

TEST(Ingest, AngleReasons) {
  RangeConfig range = test::small_range();
  range.angle_sensors = {test::small_tracker()};
  struct Case {
    const char* what;
    std::function<void(AngleTspi&)> change;
    Reason expected;
  };
  const std::vector<Case> cases{
      {"good", [](AngleTspi&) {}, Reason::Accepted},
      {"sensor", [](AngleTspi& a) { a.sensor = "nobody"; }, Reason::UnknownSource},
      {"a radar's name", [](AngleTspi& a) { a.sensor = "goheung"; }, Reason::UnknownSource},
      {"target", [](AngleTspi& a) { a.target = "nobody"; }, Reason::UnknownSource},
      {"live input to a simulated node", [](AngleTspi& a) { a.simulated = false; }, Reason::SimulatedMismatch},
      {"mode", [](AngleTspi& a) { a.mode = TrackMode::Acquire; }, Reason::NotTracking},
      {"NaN azimuth", [](AngleTspi& a) { a.azimuth_rad = std::nan(""); }, Reason::NotFinite},
      {"slaved", [](AngleTspi& a) { a.mode = TrackMode::Slaved; }, Reason::Slaved},
      {"one angle alone", [](AngleTspi& a) { a.azimuth_valid = false; }, Reason::NotTracking},
      {"infinite elevation", [](AngleTspi& a) { a.elevation_rad = INFINITY; }, Reason::NotFinite},
      {"below the horizon", [](AngleTspi& a) { a.elevation_rad = -0.01; }, Reason::OutOfLimits},
      {"beyond the zenith", [](AngleTspi& a) { a.elevation_rad = 91 * deg; }, Reason::OutOfLimits},
      {"too late", [](AngleTspi& a) { a.received = a.epoch + milliseconds(5001); }, Reason::TooLate},
      {"from the future", [](AngleTspi& a) { a.received = a.epoch - milliseconds(101); }, Reason::FromFuture},
  };
  for (const Case& c : cases) {
    Ingest ingest(range);
    AngleTspi a = angles_at(range.angle_sensors[0], 30, 1);
    c.change(a);
    const Observation o = ingest.judge(a);
    EXPECT_EQ(o.verdict, c.expected) << c.what;
    EXPECT_EQ(kind_of(o.measured), SourceKind::AngleSensor);
  }
  Ingest ingest(range);
  AngleTspi west = angles_at(range.angle_sensors[0], 30, 1);
  west.azimuth_rad = -10 * deg;
  const Observation accepted = ingest.judge(west);
  EXPECT_NEAR(std::get<Angles>(accepted.measured).azimuth_rad, 350 * deg, 1e-12);
  EXPECT_EQ(ingest.judge(west).verdict, Reason::Duplicate);
  AngleTspi stepped = angles_at(range.angle_sensors[0], 29.5, 2, 0.6);
  EXPECT_EQ(ingest.judge(stepped).verdict, Reason::ClockStep);

  // At a centre, once more.
  EXPECT_EQ(Ingest(range).judge(accepted).verdict, Reason::Accepted);
  EXPECT_EQ(Ingest(test::small_range()).judge(accepted).verdict, Reason::UnknownSource);
  Observation broken = accepted;
  std::get<Angles>(broken.measured).elevation_rad = std::nan("");
  EXPECT_EQ(Ingest(range).judge(broken).verdict, Reason::NotFinite);
}

TEST(Ingest, WhatASensorOnASlavedMountReadsIsNoMeasurement) {
  RangeConfig range = test::small_range();
  range.angle_sensors.push_back(test::small_tracker());
  range.antennas[0].sensor = range.radars[0].id;
  range.antennas[1].sensor = range.angle_sensors[0].id;
  Ingest ingest(range);
  std::uint64_t sequence = 0;
  const auto radar = [&](double t) { return ingest.judge(plot_at(range.radars[0], t, ++sequence)).verdict; };
  const auto tracker = [&](double t) { return ingest.judge(angles_at(range.angle_sensors[0], t, ++sequence)).verdict; };
  const auto says = [&](int antenna, double t, AntennaMode mode, bool simulated = true) {
    AntennaReport report;
    report.antenna = range.antennas[static_cast<std::size_t>(antenna)].id;
    report.epoch = report.received = test::liftoff + seconds(t);
    report.mode = mode;
    report.simulated = simulated;
    ingest.note(report);
  };
  EXPECT_EQ(radar(30), Reason::Accepted);
  says(0, 31, AntennaMode::Slaved);
  EXPECT_EQ(radar(31.1), Reason::Slaved);
  EXPECT_EQ(tracker(31.1), Reason::Accepted) << "it is on another mount";
  EXPECT_EQ(ingest.judge(plot_at(range.radars[1], 31.1, ++sequence)).verdict, Reason::Accepted) << "on no mount";
  says(0, 30.5, AntennaMode::Autotrack);
  EXPECT_EQ(radar(31.2), Reason::Slaved) << "an older report came late";
  says(0, 31.3, AntennaMode::Autotrack, false);
  EXPECT_EQ(radar(31.3), Reason::Slaved) << "of another world";
  says(0, 31.4, AntennaMode::Autotrack);
  EXPECT_EQ(radar(31.5), Reason::Accepted);
  says(1, 32, AntennaMode::Slaved);
  EXPECT_EQ(tracker(36.9), Reason::Slaved);
  EXPECT_EQ(tracker(37.1), Reason::Accepted) << "it says no more of itself";
  says(1, 38, AntennaMode::Slaved);
  Observation of_another_node = ingest.judge(angles_at(range.angle_sensors[0], 38.1, ++sequence));
  of_another_node.verdict = Reason::Accepted;
  EXPECT_EQ(ingest.judge(of_another_node).verdict, Reason::Slaved);
}

TEST(Ingest, DoublesWhateverTheStation) {
  const RangeConfig range = test::small_range();
  Ingest ingest(range);
  EXPECT_EQ(ingest.judge(fix_at("goheung-tgs", 30, 1)).verdict, Reason::Accepted);
  GpsFix again = fix_at("jeju-tgs", 30, 77, 0.9);
  again.epoch = again.epoch + Duration{900'000};  // 0.9 ms: the same epoch
  EXPECT_EQ(ingest.judge(again).verdict, Reason::Duplicate);
  GpsFix other = fix_at("jeju-tgs", 30, 78, 0.9);
  other.receiver = "second-receiver";
  EXPECT_EQ(ingest.judge(other).verdict, Reason::Accepted);
}

TEST(Ingest, OnePlotByTwoNetworksIsOnePlot) {
  const RangeConfig range = test::small_range();
  const RadarConfig& radar = range.radars[0];
  Ingest ingest(range);
  const auto judge = [&](double t, std::uint64_t sequence, double delay_s = 0.1) {
    return ingest.judge(plot_at(radar, t, sequence, delay_s)).verdict;
  };
  EXPECT_EQ(judge(30.0, 1), Reason::Accepted);
  EXPECT_EQ(judge(30.1, 2), Reason::Accepted);
  EXPECT_EQ(judge(30.0, 1, 0.3), Reason::Duplicate) << "the slower network, same numbers";
  EXPECT_EQ(judge(30.2, 3), Reason::Accepted);
  EXPECT_EQ(judge(30.1, 5002, 0.3), Reason::Duplicate) << "the slower network, which counts by itself";
  EXPECT_EQ(judge(30.4, 5), Reason::Accepted);
  EXPECT_EQ(judge(30.3, 4, 0.3), Reason::Accepted) << "overtaken";
  EXPECT_EQ(judge(30.3, 5004, 0.5), Reason::Duplicate) << "no step of the clock";
  EXPECT_EQ(judge(30.6, 7), Reason::Accepted);
  EXPECT_EQ(judge(30.5, 5006, 0.5), Reason::Accepted) << "lost by the faster network, so the slower one's is used";
}

TEST(Ingest, AClockThatStepsBackIsNotLateData) {
  const RangeConfig range = test::small_range();
  Ingest ingest(range);
  EXPECT_EQ(ingest.judge(fix_at("goheung-tgs", 30.0, 10)).verdict, Reason::Accepted);
  EXPECT_EQ(ingest.judge(fix_at("goheung-tgs", 29.3, 11, 1.3)).verdict, Reason::ClockStep);
  // Late data: sent earlier, arrives later.
  EXPECT_EQ(ingest.judge(fix_at("goheung-tgs", 29.5, 9, 1.4)).verdict, Reason::Accepted);
  // Once the stepped clock has passed the last good epoch its fixes count again.
  EXPECT_EQ(ingest.judge(fix_at("goheung-tgs", 30.3, 12, 1.3)).verdict, Reason::Accepted);
  // A sender that restarts counts from one again: not a clock step.
  EXPECT_EQ(ingest.judge(fix_at("goheung-tgs", 31.0, 1)).verdict, Reason::Accepted);
}

TEST(Ingest, ACentreTrustsNoOtherNodeBlindly) {
  const RangeConfig range = test::small_range();
  const Observation good = Ingest(range).judge(plot_at(range.radars[0], 30, 1));
  Observation o = good;
  EXPECT_EQ(Ingest(range).judge(o).verdict, Reason::Accepted);
  o.sensor = "nobody";
  EXPECT_EQ(Ingest(range).judge(o).verdict, Reason::UnknownSource);
  o = good;
  std::get<Plot>(o.measured).measured.range_m = std::nan("");
  EXPECT_EQ(Ingest(range).judge(o).verdict, Reason::NotFinite);
  o = good;
  o.simulated = !o.simulated;  // a rehearsal at a site must not point the antennas of a live centre
  EXPECT_EQ(Ingest(range).judge(o).verdict, Reason::SimulatedMismatch);
  o = good;
  o.received = Time{std::numeric_limits<std::int64_t>::max()};
  EXPECT_EQ(Ingest(range).judge(o).verdict, Reason::OutOfLimits);
  o = good;
  o.verdict = Reason::NotTracking;
  EXPECT_EQ(Ingest(range).judge(o).verdict, Reason::NotTracking);
  Ingest twice(range);
  EXPECT_EQ(twice.judge(good).verdict, Reason::Accepted);
  EXPECT_EQ(twice.judge(good).verdict, Reason::Duplicate);
}

TEST_F(BeforeLiftoff, ACentreJudgesAnewWhatAnotherNodeHeldForAwayFromThePad) {
  Ingest node(with_pad());
  GpsFix f = fix_at("goheung-tgs", 1, 1);
  f.position = test::pad().ecef_of({{5000.0, 0.0, 0.0}});
  f.velocity.m_s.setZero();
  const Observation away = node.judge(f);
  ASSERT_EQ(away.verdict, Reason::AwayFromPad);
  EXPECT_EQ(Ingest(with_pad()).judge(away).verdict, Reason::AwayFromPad) << "as far as the centre knows";
  EXPECT_EQ(Ingest(test::small_range()).judge(away).verdict, Reason::Accepted) << "a centre without a pad";
  Observation broken = away;
  std::get<Fix>(broken.measured).position.m.setConstant(std::nan(""));
  EXPECT_EQ(Ingest(with_pad()).judge(broken).verdict, Reason::NotFinite);
  Observation stranger = away;
  stranger.target = "nobody";
  EXPECT_EQ(Ingest(with_pad()).judge(stranger).verdict, Reason::UnknownSource);
}

TEST(Ingest, AzimuthIsBroughtIntoOneTurn) {
  const RangeConfig range = test::small_range();
  Ingest ingest(range);
  RadarTspi p = plot_at(range.radars[0], 30, 1);
  p.measured.azimuth_rad = -10 * deg;
  EXPECT_NEAR(std::get<Plot>(ingest.judge(p).measured).measured.azimuth_rad, 350 * deg, 1e-12);
}

TEST(Reasons, EachHasItsOwnName) {
  for (std::size_t i = 0; i < reason_count; ++i)
    for (std::size_t j = 0; j < i; ++j) EXPECT_NE(to_string(static_cast<Reason>(i)), to_string(static_cast<Reason>(j)));
}

}  // namespace
}  // namespace downrange
