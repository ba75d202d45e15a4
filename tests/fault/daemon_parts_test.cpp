/// The service's own parts at their limits.

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <downrange/stage/catalogue.hpp>
#include <filesystem>
#include <mutex>

#include "../support/samples.hpp"
#include "app/downranged/acknowledgements.hpp"
#include "app/downranged/event_queue.hpp"
#include "app/downranged/health_notes.hpp"
#include "app/downranged/latency.hpp"
#include "app/downranged/notify.hpp"
#include "app/downranged/service.hpp"
#include "app/downranged/utc_watch.hpp"
#include "config/load.hpp"
#include "dds/inputs.hpp"
#include "dds/outputs.hpp"
#include "stage/integrity_notes.hpp"

#define DOWNRANGED ""
#include "daemon_process.hpp"

namespace downrange::app {
namespace {

Event plot(const char* sensor, std::uint64_t sequence) {
  RadarTspi tspi;
  tspi.sensor = sensor;
  tspi.sequence = sequence;
  return tspi;
}

std::string drain(EventQueue& queue) {
  std::string text;
  while (const auto event = queue.pop()) {
    text += std::string(source_of(*event).view()) + std::to_string(std::get<RadarTspi>(*event).sequence) + ' ';
  }
  return text;
}

TEST(Queue, KeepsTheOrderOfArrivalAcrossSources) {
  EventQueue queue({"a", "b"}, 16);
  for (const auto& event : {plot("b", 1), plot("a", 1), plot("b", 2), plot("a", 2)}) queue.push(event);
  EXPECT_EQ(queue.depth(), 4u);
  EXPECT_EQ(drain(queue), "b1 a1 b2 a2 ");
  EXPECT_EQ(queue.depth(), 0u);
}

TEST(Queue, AFloodPushesOutItsOwnOldestOnly) {
  EventQueue queue({"a", "b"}, 16);
  queue.push(plot("b", 1));
  for (std::uint64_t n = 1; n <= 20; ++n) queue.push(plot("a", n));
  EXPECT_EQ(queue.losses().dropped, 4u);
  EXPECT_EQ(queue.losses().worst, "a");
  EXPECT_EQ(queue.losses().worst_dropped, 4u);
  EXPECT_EQ(queue.depth(), 17u);
  EXPECT_TRUE(drain(queue).starts_with("b1 a5 a6 "));
}

TEST(Queue, StrangersAreRefusedAndPushOutNoMissionEvent) {
  EventQueue queue({"a"}, 16);
  queue.push(MissionEvent{});
  for (std::uint64_t n = 1; n <= 100; ++n) queue.push(plot(("stranger" + std::to_string(n)).c_str(), n));
  EXPECT_EQ(queue.depth(), 1u);
  EXPECT_EQ(queue.losses().refused, 100u);
  EXPECT_EQ(queue.losses().dropped, 0u);
  EXPECT_TRUE(std::holds_alternative<MissionEvent>(queue.pop().value()));
}

TEST(Queue, NamesTheWorstRing) {
  EventQueue queue({"a"}, 16);
  for (std::uint64_t n = 1; n <= 17; ++n) queue.push(plot("a", n));
  for (int n = 1; n <= 20; ++n) queue.push(MissionEvent{});
  EXPECT_EQ(queue.losses().dropped, 5u);
  EXPECT_EQ(queue.losses().worst, "orders");
  EXPECT_EQ(queue.losses().worst_dropped, 4u);
}

TEST(Queue, AnOperatorsOrderIsNoStrangers) {
  EventQueue queue({"a"}, 16);
  OperatorCommand command;
  command.operator_id = "kim";
  queue.push(command);
  EXPECT_EQ(queue.losses().refused, 0u);
  EXPECT_EQ(std::get<OperatorCommand>(queue.pop().value()).operator_id, Name("kim"));
}

TEST(Queue, OfNobodyConfiguredOnlyMeasurementsAreRefused) {
  Inputs::for_each([]<class Input>() {
    EventQueue queue({"somebody-else"}, 16);
    queue.push(test::sample<Input>());
    EXPECT_EQ(queue.losses().refused, Measurements::contains<Input> ? 1u : 0u) << MessageInfo<Input>::topic;
    EXPECT_EQ(queue.depth(), Measurements::contains<Input> ? 0u : 1u) << MessageInfo<Input>::topic;
  });
}

TEST(AcknowledgementsTest, OrdersAndMarksAreAnsweredAndLogged) {
  const config::ServiceConfig config = config::load(test::naro);
  Acknowledgements acknowledgements(config.range);
  const Time now{1'800'000'000'000'000'000};
  OperatorCommand command;
  command.operator_id = "kim";
  command.order = OperatorOrder::Inhibit;
  command.subject = "goheung";
  command.reason = "spent stage";
  command.sequence = 7;
  command.epoch = command.received = now;
  EXPECT_EQ(acknowledgements.note(command), "operator kim: inhibit goheung (spent stage)");
  command.subject = "gohung";
  command.sequence = 8;
  EXPECT_EQ(acknowledgements.note(command).value_or("").find(
                "operator kim: inhibit gohung REFUSED: no source is named 'gohung': there are goheung, jeju"),
            0u);
  MissionEvent mark;
  mark.mission = "naro-3";
  mark.kind = MissionEventKind::Hold;
  mark.sequence = 9;
  mark.epoch = mark.received = now;
  EXPECT_EQ(acknowledgements.note(mark), "mission naro-3: hold");
  EXPECT_EQ(acknowledgements.note(plot("goheung", 1)), std::nullopt);

  const auto& newest = acknowledgements.newest();
  ASSERT_EQ(newest.size(), 3u);
  EXPECT_EQ(newest[0], (dds::Acknowledgement{input_index<MissionEvent>, "naro-3", 9, ""}));
  EXPECT_EQ(newest[1].sequence, 8u);
  EXPECT_FALSE(newest[1].refusal.empty());
  EXPECT_EQ(newest[2], (dds::Acknowledgement{input_index<OperatorCommand>, "kim", 7, ""}));

  const Time stepped_back = now - seconds(3600);
  const std::vector<Event> in_force = acknowledgements.in_force(stepped_back);
  ASSERT_EQ(in_force.size(), 2u) << "what was refused is not in force";
  Orders orders(config.range);
  orders.note(std::get<OperatorCommand>(in_force[0]));
  EXPECT_TRUE(orders.inhibited(0)) << "not refused for being dated in the future";
  for (const Event& event : in_force) EXPECT_EQ(received_of(event), stepped_back);

  for (std::uint64_t n = 0; n < 20; ++n) static_cast<void>(acknowledgements.note(mark));
  EXPECT_EQ(acknowledgements.newest().size(), 8u) << "as many as a status holds";
}

TEST(AcknowledgementsTest, WhatStandsIsKeptHoweverMuchWasOrderedSince) {
  const config::ServiceConfig config = config::load(test::naro);
  Acknowledgements acknowledgements(config.range);
  const Time begin{1'800'000'000'000'000'000};
  std::uint64_t sequence = 0;
  const auto order = [&](OperatorOrder what, const Name& subject) {
    OperatorCommand command;
    command.operator_id = "kim";
    command.order = what;
    command.subject = subject;
    command.reason = "wind";
    command.sequence = ++sequence;
    command.epoch = command.received = begin + seconds(static_cast<double>(sequence));
    return command;
  };
  const OperatorCommand stop = order(OperatorOrder::StopAntenna, "goheung-tm");
  EXPECT_EQ(acknowledgements.note(stop), "operator kim: stop goheung-tm (wind)");
  EXPECT_EQ(acknowledgements.note(stop), std::nullopt) << "told once more";
  EXPECT_EQ(acknowledgements.newest().size(), 1u);
  for (int i = 0; i < 400; ++i) {
    const bool inhibits = i % 2 == 0;
    EXPECT_TRUE(acknowledgements.note(order(inhibits ? OperatorOrder::Inhibit : OperatorOrder::Release, "jeju")));
  }
  const Time now = begin + seconds(1000);
  const std::vector<Event> in_force = acknowledgements.in_force(now);
  EXPECT_EQ(in_force.size(), 2u) << "the stop, and the last release of jeju";
  Orders orders(config.range);
  for (const Event& event : in_force) orders.note(std::get<OperatorCommand>(event));
  EXPECT_EQ(words_of(orders.of_antenna(0)).view(), "stopped by kim (wind)");
  EXPECT_FALSE(orders.inhibited(1));
}

TEST(IntegrityNotesTest, EachChangeOnce) {
  IntegrityNotes notes;
  Integrity record;
  record.target = "kslv";
  record.bound_valid = true;
  record.bound_m = 60;
  record.sources = {{.sensor = "goheung"}, {.sensor = "jeju-tgs"}};
  EXPECT_EQ(notes.changes(record), std::vector<std::string>{"kslv follows all sources, bound 60 m"});
  EXPECT_TRUE(notes.changes(record).empty());
  record.sources[1].verdict = IntegrityVerdict::Excluded;
  record.sources[1].by = "integrity";
  record.chain = "without-GPS";
  record.bound_m = 80;
  EXPECT_EQ(notes.changes(record), (std::vector<std::string>{"kslv: jeju-tgs excluded by integrity",
                                                             "kslv follows chain without-GPS, bound 80 m"}));
  record.bound_m = 90;
  EXPECT_TRUE(notes.changes(record).empty()) << "a bound that moves is no news";
  record.sources[1].verdict = IntegrityVerdict::Agrees;
  EXPECT_EQ(notes.changes(record), std::vector<std::string>{"kslv: jeju-tgs agrees"});
}

TEST(HealthNotes, EachChangeOnceAndBySource) {
  HealthNotes notes;
  SourceHealth health;
  health.sensor = "a";
  health.qualified = true;
  EXPECT_EQ(notes.changes(health), "");
  health.qualified = false;
  health.why = Disqualification::Silent;
  health.count[0] = 1;
  EXPECT_EQ(notes.changes(health), "source a: NOT qualified: silent");
  EXPECT_EQ(notes.changes(health), "");
  health.why = Disqualification::Rejected;
  health.rejected_for = Reason::NotTracking;
  EXPECT_EQ(notes.changes(health), "");
  SourceHealth other = health;
  other.sensor = "b";
  EXPECT_EQ(notes.changes(other), "source b: NOT qualified: not_tracking");
  SourceHealth inhibited = health;
  inhibited.sensor = "d";
  inhibited.why = Disqualification::Inhibited;
  inhibited.by = "kim";
  EXPECT_EQ(notes.changes(inhibited), "source d: NOT qualified: inhibited by kim");
  SourceHealth unheard;
  unheard.sensor = "c";
  unheard.why = Disqualification::Silent;
  EXPECT_EQ(notes.changes(unheard), "source c: NOT qualified: silent since start");
  unheard.qualified = true;
  EXPECT_EQ(notes.changes(unheard), "source c: qualified");
  health.qualified = true;
  health.mismatch = true;
  health.nis_inside_95 = 0.9;
  health.nis_count = 1000;
  EXPECT_EQ(notes.changes(health),
            "source a: qualified again; MISMATCH: 90.0 % of its last 1000 NIS inside 95 %: what is configured of it "
            "(bias_blocks, sigmas, angle_inflation) does not fit");
  EXPECT_EQ(notes.changes(health), "");
  health.mismatch = false;
  EXPECT_EQ(notes.changes(health), "source a: fits again: mismatch alarm over");
}

TEST(Queue, CloseEndsAWait) {
  EventQueue queue({"a"}, 16);
  std::thread waiter([&] { queue.wait(std::chrono::hours(1)); });
  queue.close();
  waiter.join();
}

TEST(UtcWatchTest, TellsStepsFromTimeThatPassed) {
  UtcWatch watch;
  const UtcWatch::Steady steady{};
  const Time utc{1'800'000'000'000'000'000};
  using std::chrono::seconds;
  EXPECT_FALSE(watch.look(utc, steady));
  EXPECT_FALSE(watch.look(utc + downrange::seconds(100), steady + seconds(100)));
  EXPECT_FALSE(watch.look(utc + milliseconds(100'600), steady + std::chrono::milliseconds(100'200)));  // slewed
  EXPECT_EQ(watch.look(utc + downrange::seconds(90), steady + seconds(101)), -milliseconds(11'400));
  EXPECT_FALSE(watch.look(utc + downrange::seconds(91), steady + seconds(102)));
  EXPECT_EQ(watch.look(utc + downrange::seconds(100), steady + seconds(103)), downrange::seconds(8));
}

// Domain 156.
TEST(ServiceTest, UtcSteppedBackBeginsANewFlightThatTicksAtOnce) {
  const test::Folder folder;
  config::ServiceConfig config = config::load(test::naro);
  config.dds.domain = 156;
  config.archive.enabled = true;
  config.archive.directory = (folder.path() / "flight.mcap").string();
  std::atomic<std::int64_t> offset_ns = 0;
  const auto utc = [&] { return utc_now() + Duration{offset_ns}; };

  dds::Participant site({156, config.dds.profiles, "test-site", dds::ClockMode::Wall});
  std::mutex mutex;
  dds::ServiceStatus last;
  dds::OutputSelection selection;
  selection.results = selection.health = false;
  const dds::OutputReaders readers(site, selection, {{}, [&](const dds::ServiceStatus& status) {
                                                       const std::lock_guard lock(mutex);
                                                       last = status;
                                                     }});
  const auto status = [&] {
    const std::lock_guard lock(mutex);
    return last;
  };
  dds::InputWriters writers(site);
  const auto tracking = [&](const std::string& state) {
    return test::eventually([&] {
      RadarTspi tspi;
      tspi.sensor = config.range.radars[0].id;
      tspi.epoch = utc();
      static_cast<void>(writers.write(tspi));
      const dds::ServiceStatus s = status();
      const Duration age = s.time - s.last_tick;
      return s.state.starts_with(state) && s.consumed > 0 && s.last_tick <= s.time && age < seconds(60);
    });
  };

  Service service(
      config, [] {}, utc);
  ASSERT_TRUE(tracking("running"));
  offset_ns = -seconds(3600).ns;
  EXPECT_TRUE(tracking("UTC back 3")) << status().state;
  EXPECT_EQ(status().archive_state, "recording");
  service.stop();
  EXPECT_FALSE(service.failure());
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "flight-2.mcap"));
}

TEST(Latency, QuantilesAreUpperBoundsWithinTenPercent) {
  LatencyHistogram histogram;
  EXPECT_EQ(histogram.quantile_us(0.99), 0);
  for (std::int64_t us = 1; us <= 1000; ++us) histogram.add({us * 1000});
  for (const double share : {0.5, 0.95, 0.99, 1.0}) {
    EXPECT_GE(histogram.quantile_us(share), 1000 * share);
    EXPECT_LE(histogram.quantile_us(share), 1000 * share * 1.1006);  // 24 bins a decade: 10^(1/24) = 1.1006
  }
  EXPECT_EQ(histogram.max_us(), 1000);
  histogram.add(seconds(5000));
  histogram.add(-seconds(1));
  EXPECT_EQ(histogram.max_us(), 5e9);
}

// The alarm must ring: no progress, no food.
TEST(WatchdogTest, StarvesWithoutProgress) {
  const test::Folder folder;
  test::NotifySocket manager(folder.path() / "notify");
  setenv("NOTIFY_SOCKET", manager.path().c_str(), 1);
  setenv("WATCHDOG_USEC", "30000", 1);
  std::atomic<std::uint64_t> progress = 0;
  {
    const Watchdog watchdog(progress);
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    EXPECT_EQ(manager.count("WATCHDOG=1"), 0);
    EXPECT_TRUE(test::eventually([&] {
      ++progress;
      return manager.count("WATCHDOG=1") > 2;
    }));
  }
  unsetenv("WATCHDOG_USEC");
  unsetenv("NOTIFY_SOCKET");
}

}  // namespace
}  // namespace downrange::app
