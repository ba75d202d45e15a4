// Go and no-go, each for its reason, from events alone.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "../support/small_range.hpp"
#include "app/downrange/preflight.hpp"

namespace downrange::app {
namespace {

using test::deg;
using test::liftoff;

/// Ten seconds on the pad that a test may spoil.
class PreflightTest : public testing::Test {
 protected:
  PreflightTest() {
    range.pad = PadConfig{.site = test::pad()};
    range.antennas.resize(1);
    for (RadarConfig& radar : range.radars) radar.elevation_min_rad = -5 * deg;  // the pad is below their horizontal
  }

  RadarTspi pad_plot(const RadarConfig& radar, double t) {
    RadarTspi plot = test::plot_at(radar, t, ++sequence);
    plot.measured = polar_from_enu(radar.site.enu_of(test::pad().ecef()));
    return plot;
  }
  GpsFix pad_fix(const Name& station, double t) {
    GpsFix fix = test::fix_at(station, t, ++sequence);
    fix.position = test::pad().ecef();
    fix.velocity.m_s.setZero();
    return fix;
  }
  /// From T-12 to T-1.
  std::vector<Event> events() {
    std::vector<Event> all;
    for (const RadarConfig& radar : range.radars)
      for (double t = -12; t < -1.01; t += 1 / radar.rate_hz) all.emplace_back(pad_plot(radar, t));
    for (const TelemetryConfig& station : range.telemetry)
      for (double t = -12; t < -1; t += 1) all.emplace_back(pad_fix(station.id, t));
    return all;
  }
  /// `change` is applied to every message of type Message.
  template <class Message, class Change>
  PreflightReport judge(Change change, std::vector<Event> extra = {}) {
    Preflight preflight(range, {});
    std::vector<Event> all = events();
    for (Event& event : all) {
      if (auto* message = std::get_if<Message>(&event)) change(*message);
    }
    all.insert(all.end(), extra.begin(), extra.end());
    std::ranges::stable_sort(all, {}, [](const Event& e) { return received_of(e); });
    for (const Event& event : all) preflight.note(event);
    return preflight.report();
  }
  PreflightReport judge() {
    return judge<MissionEvent>([](MissionEvent&) {});
  }
  static const SourcePreflight& line(const PreflightReport& report, const std::string& name) {
    return *std::ranges::find(report.sources, name, &SourcePreflight::name);
  }
  static bool says(const PreflightLine& line, const std::string& text) {
    return std::ranges::any_of(line.against, [&](const std::string& a) { return a.find(text) != std::string::npos; });
  }

  RangeConfig range = test::small_range();
  std::uint64_t sequence = 0;
};

TEST_F(PreflightTest, EverythingInOrderIsGo) {
  const PreflightReport report = judge();
  EXPECT_TRUE(report.go()) << format_text(report);
  EXPECT_NEAR(line(report, "goheung").rate_hz, 10, 0.5);
  EXPECT_NEAR(line(report, "goheung").latency_mean_s, 0.04, 0.001);
  EXPECT_LT(line(report, "goheung").pad_sigmas.value_or(9), 0.1);
  EXPECT_LT(line(report, "jeju-tgs").pad_sigmas.value_or(9), 0.1) << "a copy is held against the pad too";
  EXPECT_NE(format_text(report).find("Range test: GO\n"), std::string::npos) << format_text(report);
}

TEST_F(PreflightTest, ASilentSourceIsNoGo) {
  Preflight preflight(range, {});
  for (const Event& event : events()) {
    if (source_of(event) != Name("jeju")) preflight.note(event);
  }
  const PreflightReport report = preflight.report();
  EXPECT_FALSE(report.go());
  EXPECT_TRUE(says(line(report, "jeju"), "nothing heard"));
  EXPECT_TRUE(line(report, "goheung").go());
}

TEST_F(PreflightTest, OfARangeWhereNothingIsHeardThereIsNoTime) {
  const PreflightReport report = Preflight(range, {}).report();
  EXPECT_FALSE(report.go());
  EXPECT_EQ(format_text(report).find("Preflight of range test, where nothing was heard\n"), 0U) << format_text(report);
}

TEST_F(PreflightTest, ASensorThatPointsAwayFromThePadIsNoGoInItsSigmas) {
  const auto turned = [](double offset) {
    return [offset](RadarTspi& plot) {
      if (plot.sensor == Name("jeju")) plot.measured.azimuth_rad += offset;
    };
  };
  EXPECT_TRUE(judge<RadarTspi>(turned(0.2 * deg)).go()) << "one sigma of the prior";
  const PreflightReport report = judge<RadarTspi>(turned(2 * deg));
  EXPECT_TRUE(says(line(report, "jeju"), "sigma away from the pad"));
  EXPECT_GT(line(report, "jeju").pad_sigmas.value_or(0), 4);
  EXPECT_TRUE(line(report, "goheung").go());
  const auto& component = line(report, "jeju").pad.at(1);
  EXPECT_EQ(component.name, "azimuth_rad");
  EXPECT_NEAR(component.mean, 2 * deg, 1e-6);
}

TEST_F(PreflightTest, AReceiverWithAWrongDatumIsNoGo) {
  for (const double up_m : {60.0, 5000.0}) {
    const PreflightReport report = judge<GpsFix>([&](GpsFix& fix) {
      fix.position = test::pad().ecef_of({{0, 0, up_m}});
    });
    EXPECT_TRUE(says(line(report, "goheung-tgs"), "sigma away from the pad")) << up_m;
    EXPECT_NEAR(line(report, "goheung-tgs").pad.at(2).mean, up_m, 1e-3);
  }
}

TEST_F(PreflightTest, ClocksAheadAndLateAreNoGo) {
  PreflightReport report = judge<GpsFix>([](GpsFix& fix) { fix.epoch = fix.received + milliseconds(60); });
  EXPECT_TRUE(says(line(report, "goheung-tgs"), "ahead of reception")) << format_text(report);
  report = judge<RadarTspi>([](RadarTspi& plot) { plot.received = plot.epoch + milliseconds(1500); });
  EXPECT_TRUE(says(line(report, "jeju"), "late by 1.50 s"));
}

TEST_F(PreflightTest, TooFewOrRejectedMessagesAreNoGo) {
  range.radars[0].rate_hz = 4;
  std::vector<Event> slow = events();
  range.radars[0].rate_hz = 10;
  Preflight preflight(range, {});
  for (const Event& event : slow) preflight.note(event);
  EXPECT_TRUE(says(line(preflight.report(), "goheung"), "4.0 messages a second of 10.0"));
  const PreflightReport report = judge<RadarTspi>([](RadarTspi& plot) { plot.measured.range_m = 5e6; });
  EXPECT_TRUE(says(line(report, "jeju"), "out_of_limits"));
}

TEST_F(PreflightTest, ARadarThatSearchesIsNotJudgedAgainstThePadAndIsGo) {
  const PreflightReport report = judge<RadarTspi>([](RadarTspi& plot) { plot.mode = TrackMode::Search; });
  EXPECT_TRUE(report.go()) << format_text(report);
  EXPECT_FALSE(line(report, "goheung").pad_sigmas);
  EXPECT_EQ(line(report, "goheung").notes.at(0), "does not track: residual not judged");
}

TEST_F(PreflightTest, WhatAnOperatorInhibitsIsNoGo) {
  OperatorCommand command;
  command.operator_id = "kim";
  command.order = OperatorOrder::Inhibit;
  command.subject = "jeju";
  command.reason = "maintenance";
  command.epoch = command.received = liftoff - seconds(11);
  command.simulated = true;
  const PreflightReport report = judge<MissionEvent>([](MissionEvent&) {}, {command});
  EXPECT_TRUE(says(line(report, "jeju"), "inhibited by kim: maintenance"));
}

TEST_F(PreflightTest, WhatComesAfterLiftoffIsNotHeldAgainstThePad) {
  MissionEvent mark;
  mark.kind = MissionEventKind::Liftoff;
  mark.epoch = mark.received = liftoff;
  mark.simulated = true;
  std::vector<Event> flight{mark};
  for (int i = 0; i < 60; ++i) flight.emplace_back(test::plot_at(range.radars[0], 1 + i, 10'000u + i));
  const PreflightReport report = judge<MissionEvent>([](MissionEvent&) {}, flight);
  EXPECT_TRUE(report.go()) << format_text(report);
  EXPECT_EQ(report.to, liftoff);
  EXPECT_EQ(report.t_plus_s, 0.0);
}

TEST_F(PreflightTest, AnAntennasLoopIsJudgedByItsReports) {
  const auto looped = [&](double off_rad, AntennaMode mode) {
    Preflight preflight(range, {});
    for (const Event& event : events()) preflight.note(event);
    for (int i = 0; i < 40; ++i) {
      SlavingCommand command;
      command.antenna = range.antennas[0].id;
      command.tick = liftoff - seconds(5 - 0.025 * i);
      command.apply_at = command.tick + milliseconds(50);
      command.azimuth_rad = 6.3 + 0.001 * i;
      command.azimuth_rate_rad_s = 0.04;
      command.elevation_rad = 0.5;
      preflight.note(command);
      AntennaReport report;
      report.antenna = command.antenna;
      report.epoch = command.apply_at + milliseconds(10);
      report.received = report.epoch + milliseconds(20);
      report.azimuth_rad = command.azimuth_rad + 0.0004 + off_rad - 2 * std::numbers::pi;
      report.elevation_rad = 0.5;
      report.mode = mode;
      report.command_tick = command.tick;
      report.simulated = true;
      preflight.note(Event(report));
    }
    return preflight.report().antennas.at(0);
  };
  const AntennaPreflight good = looped(0, AntennaMode::Slaved);
  EXPECT_TRUE(good.go());
  EXPECT_NEAR(good.pointing_rad.value_or(1), 0, 1e-9) << "unwrapped, at the report's own instant";
  EXPECT_NEAR(good.command_loop_s.value_or(0), 0.08, 1e-9);
  const AntennaPreflight off = looped(0.01, AntennaMode::Slaved);
  EXPECT_TRUE(says(off, "away from its commands"));
  EXPECT_NEAR(off.pointing_rad.value_or(0), 0.01 * std::cos(0.5), 1e-6);
  EXPECT_TRUE(looped(0.01, AntennaMode::Manual).go()) << "it was not told to follow";
}

TEST_F(PreflightTest, AMachineThatNobodySynchronisesIsNoGo) {
  const auto clock = [&](const dds::UtcState& state) {
    Preflight preflight(range, {});
    preflight.note_clock("this machine", state);
    return preflight.report().clocks.at(0);
  };
  EXPECT_TRUE(clock({true, true, 1e-5, 0.01}).go());
  EXPECT_TRUE(says(clock({true, false, 0, 16}), "not synchronised"));
  EXPECT_TRUE(says(clock({true, true, -0.02, 0.03}), "off by -0.0200 s"));
  EXPECT_TRUE(clock({}).go()) << "not known, and said so";
}

TEST_F(PreflightTest, TheJsonHasTheSameNumbers) {
  Preflight preflight(range, {});
  for (const Event& event : events()) preflight.note(event);
  preflight.note_clock("this machine", {true, false, 0, 16});
  const PreflightReport report = preflight.report();
  const auto json = nlohmann::json::parse(format_json(report));
  EXPECT_EQ(json["go"], false);
  EXPECT_EQ(json["sources"].size(), 4u);
  EXPECT_EQ(json["sources"][0]["name"], "goheung");
  EXPECT_EQ(json["sources"][0]["rate_hz"], report.sources[0].rate_hz);
  EXPECT_EQ(json["sources"][0]["pad"]["range_m"]["sigma"], report.sources[0].pad[0].sigma);
  EXPECT_EQ(json["clocks"][0]["go"], false);
  EXPECT_EQ(json["antennas"][0]["notes"][0], "does not report: loop not judged");
}

}  // namespace
}  // namespace downrange::app
