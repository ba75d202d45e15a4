/// Health of a source: why it is not qualified, one case per reason; the mismatch alarm is passed on.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "../support/small_range.hpp"
#include "stage/source_monitor.hpp"

namespace downrange {
namespace {

using test::Collector;
using test::liftoff;
using test::small_range;

/// A method whose accounts the test writes.
class Accounts final : public Method {
 public:
  explicit Accounts(const RangeConfig& range) : accounts(range.radars.size() + range.telemetry.size()) {}

  void start(int, Time, const Gaussian<9>&) override {}
  Outcome process(const Measurement&, Time) override { return {}; }
  std::optional<TrackEstimate> fused(int, std::optional<Time>) const override { return {}; }
  std::optional<TrackEstimate> gps_track(int, Time) const override { return {}; }
  BiasEstimate bias(int) const override { return {}; }
  const SourceAccount& account(int source) const override { return accounts[static_cast<std::size_t>(source)]; }

  std::vector<SourceAccount> accounts;
};

Observation observed(const Name& sensor, const Measured& measured, double t, Reason verdict = Reason::Accepted) {
  Observation o;
  o.measured = measured;
  o.verdict = verdict;
  o.sensor = sensor;
  o.target = "kslv";
  o.epoch = liftoff + seconds(t);
  o.received = o.epoch;
  return o;
}

Observation plot(double t, Reason verdict = Reason::Accepted) { return observed("goheung", Plot{}, t, verdict); }
Observation fix(double t, Reason verdict = Reason::Accepted) { return observed("goheung-tgs", Fix{}, t, verdict); }

/// The record of one source at `t`.
SourceHealth health_of(SourceMonitor& monitor, const Name& sensor, double t, const Method* method = nullptr) {
  Collector out;
  monitor.report(liftoff + seconds(t), {.method = method}, out);
  for (const SourceHealth& health : out.of<SourceHealth>()) {
    if (health.sensor == sensor) return health;
  }
  ADD_FAILURE() << "no health of " << sensor.view();
  return {};
}

/// Of the source that has sent anything, there being one.
SourceHealth health_at(SourceMonitor& monitor, double t, const Method* method = nullptr) {
  Collector out;
  monitor.report(liftoff + seconds(t), {.method = method}, out);
  std::vector<SourceHealth> heard = out.of<SourceHealth>();
  std::erase_if(heard, [](const SourceHealth& health) {
    return std::ranges::all_of(health.count, [](std::uint64_t n) { return n == 0; });
  });
  EXPECT_EQ(heard.size(), 1u);
  return heard.empty() ? SourceHealth{} : heard.front();
}

/// "qualified", or why not.
std::string state_of(const SourceHealth& health) {
  EXPECT_EQ(health.qualified, health.why == Disqualification::None);
  return health.qualified ? "qualified" : std::string(why_not_qualified(health));
}

TEST(SourceMonitor, SilentAfterThreePeriodsOrASecond) {
  RangeConfig range = small_range();
  SourceMonitor monitor(range);  // goheung: 10 Hz
  monitor.count(plot(1));
  EXPECT_EQ(state_of(health_at(monitor, 2)), "qualified");
  EXPECT_EQ(state_of(health_at(monitor, 3)), "silent");
  monitor.count(plot(3.5));
  EXPECT_EQ(state_of(health_at(monitor, 4)), "qualified");

  range.radars[0].rate_hz = 0.5;
  SourceMonitor slow(range);
  slow.count(plot(1));
  EXPECT_EQ(state_of(health_at(slow, 7)), "qualified");
  EXPECT_EQ(state_of(health_at(slow, 8)), "silent");

  SourceMonitor gps(range);
  gps.count(fix(1));
  EXPECT_EQ(state_of(health_at(gps, 4)), "qualified");
  EXPECT_EQ(state_of(health_at(gps, 5)), "silent");
}

TEST(SourceMonitor, RejectedByIngestForTwoSecondsWithTheNewestReason) {
  SourceMonitor monitor(small_range());
  monitor.count(plot(0.9));
  for (int i = 0; i < 19; ++i) monitor.count(plot(1 + 0.1 * i, Reason::NotTracking));
  EXPECT_EQ(state_of(health_at(monitor, 2.9)), "qualified") << "for 1.9 s";
  monitor.count(plot(3, Reason::OutOfLimits));
  const SourceHealth health = health_at(monitor, 3);
  EXPECT_EQ(state_of(health), "out_of_limits");
  EXPECT_EQ(health.since, liftoff + seconds(1)) << "since the first of them";
  monitor.count(plot(3));
  EXPECT_EQ(state_of(health_at(monitor, 4)), "qualified");
}

TEST(SourceMonitor, TheSameSecondsForEverySource) {
  for (const double rate_hz : {50.0, 10.0, 2.0}) {
    RangeConfig range = small_range();
    range.radars[0].rate_hz = rate_hz;
    SourceMonitor monitor(range);
    monitor.count(plot(1));
    for (double t = 1 + 1 / rate_hz; t <= 2.5; t += 1 / rate_hz) monitor.count(plot(t, Reason::OutOfLimits));
    EXPECT_EQ(state_of(health_at(monitor, 2.5)), "qualified") << rate_hz;
    for (double t = 2.5 + 1 / rate_hz; t <= 4; t += 1 / rate_hz) monitor.count(plot(t, Reason::OutOfLimits));
    EXPECT_EQ(state_of(health_at(monitor, 4)), "out_of_limits") << rate_hz;
  }
  SourceMonitor gps(small_range());
  gps.count(fix(0));
  for (int i = 0; i < 2; ++i) gps.count(fix(1 + i, Reason::OutOfLimits));
  EXPECT_EQ(state_of(health_at(gps, 3)), "qualified") << "two are not enough, whatever the time";
  gps.count(fix(3, Reason::OutOfLimits));
  EXPECT_EQ(state_of(health_at(gps, 3)), "out_of_limits");
}

TEST(SourceMonitor, AStationThatRelaysWhatAnotherRelayedFirstIsQualified) {
  SourceMonitor monitor(small_range());
  for (int i = 0; i < 20; ++i) monitor.count(fix(i, Reason::Duplicate));
  EXPECT_EQ(state_of(health_at(monitor, 20)), "qualified");
  // A radar has no second sender.
  SourceMonitor radar(small_range());
  for (int i = 0; i < 20; ++i) radar.count(plot(17.5 + 0.1 * i, Reason::Duplicate));
  EXPECT_EQ(state_of(health_at(radar, 20)), "duplicate");
}

TEST(SourceMonitor, GatedForTwoSeconds) {
  const RangeConfig range = small_range();
  SourceMonitor monitor(range);
  Accounts method(range);
  SourceAccount& account = method.accounts[0];
  account.accepted = 5;
  const auto state = [&](double t) {
    monitor.count(plot(t));
    return state_of(health_at(monitor, t, &method));
  };
  EXPECT_EQ(state(1), "qualified");
  account.rejected_in_row = 10;
  EXPECT_EQ(state(2), "qualified") << "for a second at most";
  account.rejected_in_row = 20;
  EXPECT_EQ(state(3), "gated");
  account.accepted = 6;
  account.rejected_in_row = 9;
  EXPECT_EQ(state(4), "qualified") << "one was accepted in between";
  account.rejected_in_row = 0;
  EXPECT_EQ(state(5), "qualified");
  account.rejected_in_row = 2;
  EXPECT_EQ(state(6), "qualified");
  EXPECT_EQ(state(9), "qualified") << "two are not enough, whatever the time";
}

TEST(SourceMonitor, AFrozenReceiverIsNamedAtOnceAndUntilAFixIsAccepted) {
  const RangeConfig range = small_range();
  SourceMonitor monitor(range);
  Accounts method(range);
  SourceAccount& account = method.accounts[range.radars.size()];
  monitor.count(fix(1));
  account = {
      .accepted = 5, .frozen = 1, .rejected_in_row = 1, .residual = {}, .mismatch = MismatchAlarm(), .noise = {}};
  EXPECT_EQ(state_of(health_at(monitor, 2, &method)), "frozen");
  EXPECT_EQ(state_of(health_at(monitor, 3, &method)), "frozen");  // no fix within this second
  account.rejected_in_row = 0;
  EXPECT_EQ(state_of(health_at(monitor, 4, &method)), "qualified");
  account.gated = 1;
  account.rejected_in_row = 1;
  EXPECT_EQ(state_of(health_at(monitor, 4, &method)), "qualified");
}

TEST(SourceMonitor, ASourceOfWhichNothingWasAcceptedYetIsNotQualified) {
  SourceMonitor monitor(small_range());
  monitor.count(plot(1, Reason::TooLate));
  EXPECT_EQ(state_of(health_at(monitor, 1.1)), "too_late");
  monitor.count(plot(1.2));
  EXPECT_EQ(state_of(health_at(monitor, 1.3)), "qualified");
}

/// Run again without an excluded source the method forgets what it had refused of it; that counts on.
TEST(SourceMonitor, WhatTheMethodRefusedStaysCounted) {
  const RangeConfig range = small_range();
  SourceMonitor monitor(range);
  Accounts method(range);
  SourceAccount& account = method.accounts[0];
  for (int i = 0; i < 50; ++i) monitor.count(plot(1 + 0.1 * i));
  const auto gated = [&](double t, std::uint64_t now) {
    account.gated = now;
    return health_at(monitor, t, &method).count[static_cast<std::size_t>(Reason::Gated)];
  };
  EXPECT_EQ(gated(6, 12), 12U);
  EXPECT_EQ(gated(6.1, 11), 11U) << "a late plot explained another";
  Integrity excluded;
  excluded.target = "kslv";
  excluded.sources.push_back({.sensor = "goheung", .verdict = IntegrityVerdict::Excluded});
  monitor.note(excluded);
  EXPECT_EQ(gated(6.2, 2), 11U);
  excluded.sources.back().verdict = IntegrityVerdict::Agrees;
  monitor.note(excluded);
  EXPECT_EQ(gated(7, 3), 12U);
}

TEST(SourceMonitor, WhoeverIsNotConfiguredIsUnknown) {
  SourceMonitor monitor(small_range());
  monitor.count(observed("stranger", Plot{}, 1, Reason::UnknownSource));
  EXPECT_EQ(state_of(health_at(monitor, 2)), "unknown_source");
  // A station that calls itself as a radar does is not that radar.
  monitor.count(observed("goheung", Fix{}, 2, Reason::UnknownSource));
  EXPECT_EQ(health_of(monitor, "(not configured)", 3).count[static_cast<std::size_t>(Reason::UnknownSource)], 2u);
}

TEST(SourceMonitor, EverySourceHasHealthBeforeItIsHeard) {
  RangeConfig range = small_range();
  range.angle_sensors.push_back(test::small_tracker());
  SourceMonitor monitor(range);
  Collector out;
  monitor.report(liftoff, {}, out);
  std::vector<Name> sensors;
  for (const SourceHealth& health : out.of<SourceHealth>()) {
    sensors.push_back(health.sensor);
    EXPECT_EQ(state_of(health), "silent since start") << health.sensor.view();
  }
  EXPECT_EQ(sensors, (std::vector<Name>{"goheung", "jeju", "optical", "goheung-tgs", "jeju-tgs"}));
  monitor.count(plot(1));
  EXPECT_EQ(state_of(health_of(monitor, "goheung", 2)), "qualified");
  EXPECT_EQ(state_of(health_of(monitor, "goheung", 9)), "silent");
  EXPECT_EQ(state_of(health_of(monitor, "jeju", 9)), "silent since start");
}

TEST(SourceMonitor, PassesTheMethodsAlarmOnWhichDisqualifiesNothing) {
  const RangeConfig range = small_range();
  SourceMonitor monitor(range);
  Accounts method(range);
  monitor.count(plot(1));
  EXPECT_EQ(health_at(monitor, 2, &method).nis_count, 0);
  // 7.81 is the 95 % point of chi2(3): one in ten is outside.
  for (int i = 0; i < 1000; ++i) method.accounts[0].mismatch.add(i % 10 == 0 ? 7.82 : 7.81, 3);
  const SourceHealth health = health_at(monitor, 2, &method);
  EXPECT_EQ(health.nis_count, 1000);
  EXPECT_EQ(health.nis_inside_95, 0.9);
  EXPECT_TRUE(health.mismatch);
  EXPECT_EQ(state_of(health), "qualified");
}

TEST(SourceMonitor, TellsTheNoiseThatTheMethodHasLearnt) {
  const RangeConfig range = small_range();
  SourceMonitor monitor(range);
  Accounts method(range);
  monitor.count(plot(1));
  EXPECT_EQ(health_at(monitor, 2, &method).sigma_ratio, SigmaRatios{});
  NoiseScale& noise = method.accounts[0].noise;
  ASSERT_TRUE(noise.open(liftoff, false, true));
  noise.update_scale<1>(0, Vec<1>(1), {.verdict = Verdict::Accepted, .excess = Mat<1, 1>(20)});
  const SourceHealth health = health_at(monitor, 3, &method);
  EXPECT_EQ(health.sigma_ratio[0], noise.sigma_ratio(0));
  EXPECT_GT(health.sigma_ratio[0], 1);
  EXPECT_EQ(health.sigma_ratio[1], 0);
  EXPECT_EQ(learnt_noise(SourceKind::Radar, {1.02, 0, 0.999, 10}), "range 1.02, elevation 1.00, range rate 10.00");
  EXPECT_EQ(learnt_noise(SourceKind::Telemetry, {1, 0.05, 2.5, 0}), "horizontal 1.00, vertical 0.05, velocity 2.50");
  EXPECT_EQ(learnt_noise(SourceKind::Telemetry, {}), "");
}

TEST(FigureOfMerit, IsOneAsConfiguredAndZeroNotToBeUsed) {
  SourceHealth health;
  EXPECT_EQ(figure_of_merit(health), 0);  // not qualified
  health.qualified = true;
  EXPECT_EQ(figure_of_merit(health), 1);  // nothing weighed yet
  health.nis_count = 200;
  health.nis_inside_95 = 0.97;
  health.sigma_ratio = {1, 0.5, 0.5, 0};
  EXPECT_EQ(figure_of_merit(health), 1);
  health.nis_inside_95 = 0.76;
  EXPECT_NEAR(figure_of_merit(health), 0.8, 1e-12);
  health.sigma_ratio[1] = 2;
  EXPECT_NEAR(figure_of_merit(health), 0.4, 1e-12);
}

TEST(SourceMonitor, KnowsWhomIntegrityDoubts) {
  SourceMonitor monitor(small_range());
  EXPECT_FALSE(monitor.doubted(plot(1)));
  Integrity record;
  record.target = "kslv";
  record.sources = {{.sensor = "goheung", .verdict = IntegrityVerdict::Suspect}, {.sensor = "goheung-tgs"}};
  monitor.note(record);
  EXPECT_TRUE(monitor.doubted(plot(1)));
  EXPECT_FALSE(monitor.doubted(fix(1)));
  EXPECT_FALSE(monitor.doubted(observed("nobody", Plot{}, 1)));
  record.sources[0].verdict = IntegrityVerdict::Agrees;
  monitor.note(record);
  EXPECT_FALSE(monitor.doubted(plot(1)));
}

/// The health of goheung under these orders.
SourceHealth health_under(SourceMonitor& monitor, const Orders& orders, double t) {
  Collector out;
  monitor.report(liftoff + seconds(t), {.orders = &orders}, out);
  return out.of<SourceHealth>().front();
}

OperatorCommand order(OperatorOrder what, double t) {
  OperatorCommand command;
  command.operator_id = "kim";
  command.order = what;
  command.subject = "goheung";
  command.reason = "spent stage in the beam";
  command.epoch = command.received = liftoff + seconds(t);
  command.simulated = true;
  return command;
}

TEST(SourceMonitor, AnOperatorsOrderIsToldWithNameReasonAndTime) {
  SourceMonitor monitor(small_range());
  Orders orders(small_range());
  monitor.count(plot(1));
  EXPECT_EQ(health_under(monitor, orders, 1).by, Name());
  orders.note(order(OperatorOrder::Inhibit, 1.25));
  const SourceHealth inhibited = health_under(monitor, orders, 2);
  EXPECT_EQ(state_of(inhibited), "inhibited");
  EXPECT_EQ(inhibited.by, Name("kim"));
  EXPECT_EQ(inhibited.reason, Remark("spent stage in the beam"));
  EXPECT_EQ(inhibited.since, liftoff + seconds(1.25));
  orders.note(order(OperatorOrder::Force, 2.5));
  monitor.count(plot(2.75));
  const SourceHealth forced = health_under(monitor, orders, 3);
  EXPECT_TRUE(forced.qualified && forced.forced);
  EXPECT_EQ(forced.by, Name("kim"));
  orders.note(order(OperatorOrder::Release, 3.5));
  monitor.count(plot(3.75));
  const SourceHealth released = health_under(monitor, orders, 4);
  EXPECT_TRUE(released.qualified && !released.forced);
  EXPECT_TRUE(released.by.empty() && released.reason.empty());
  EXPECT_EQ(released.since, liftoff + seconds(4));
}

TEST(SourceMonitor, AnAlarmThatWasSeenSaysByWhomUntilItEndsOrAnotherRings) {
  SourceMonitor monitor(small_range());
  Orders orders(small_range());
  Integrity record;
  record.target = "kslv";
  record.sources = {{.sensor = "goheung", .verdict = IntegrityVerdict::Suspect}};
  const auto at = [&](double t) {
    monitor.count(plot(t - 0.25));
    return health_under(monitor, orders, t);
  };
  orders.note(order(OperatorOrder::AcknowledgeAlarm, 0.5));
  EXPECT_TRUE(at(1).acknowledged_by.empty()) << "nothing rings";
  monitor.note(record);
  EXPECT_TRUE(at(2).acknowledged_by.empty()) << "seen before it rang";
  orders.note(order(OperatorOrder::AcknowledgeAlarm, 2.5));
  EXPECT_EQ(at(3).acknowledged_by, Name("kim"));
  EXPECT_EQ(at(4).acknowledged_by, Name("kim"));
  record.sources[0].verdict = IntegrityVerdict::Excluded;
  monitor.note(record);
  EXPECT_TRUE(at(5).acknowledged_by.empty()) << "another one";
  record.sources[0].verdict = IntegrityVerdict::Agrees;
  monitor.note(record);
  EXPECT_TRUE(at(6).acknowledged_by.empty());
  record.sources[0].verdict = IntegrityVerdict::Suspect;
  monitor.note(record);
  EXPECT_TRUE(at(7).acknowledged_by.empty()) << "it rings anew";
}

TEST(SourceMonitor, TheWorstThatIntegritySaysOfAnyTarget) {
  RangeConfig range = small_range();
  range.targets.push_back({"booster"});
  SourceMonitor monitor(range);
  const auto judge = [&](const char* target, IntegrityVerdict verdict, double since) {
    Integrity record;
    record.target = target;
    record.sources = {{.sensor = "goheung", .verdict = verdict, .since = liftoff + seconds(since), .by = "integrity"},
                      {.sensor = "nobody", .verdict = IntegrityVerdict::Excluded, .by = "integrity"}};
    monitor.note(record);
  };
  const Orders orders(range);
  monitor.count(plot(1));
  judge("kslv", IntegrityVerdict::Suspect, 0.5);
  SourceHealth health = health_under(monitor, orders, 1);
  EXPECT_TRUE(health.qualified && health.suspect);
  EXPECT_EQ(health.since, liftoff + seconds(0.5));
  EXPECT_EQ(health.by, Name("integrity"));
  judge("booster", IntegrityVerdict::Excluded, 0.75);
  health = health_under(monitor, orders, 1.5);
  EXPECT_EQ(state_of(health), "excluded");
  EXPECT_FALSE(health.suspect);
  EXPECT_EQ(health.since, liftoff + seconds(0.75));
  judge("booster", IntegrityVerdict::Agrees, 1.6);
  EXPECT_TRUE(health_under(monitor, orders, 1.7).suspect) << "still of kslv";
  judge("kslv", IntegrityVerdict::Agrees, 1.75);
  health = health_under(monitor, orders, 1.75);
  EXPECT_TRUE(health.qualified && !health.suspect);
  judge("kslv", IntegrityVerdict::Excluded, 1.8);
  EXPECT_EQ(state_of(health_under(monitor, orders, 9)), "silent") << "nothing comes of it: that is the nearer cause";
}

}  // namespace
}  // namespace downrange
