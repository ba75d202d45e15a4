/// An operator takes a radar out of a flight and gives it back, pins, trims and stops antennas, lets a bias begin anew;
/// the archive replays to the same bits.

#include <gtest/gtest.h>

#include <algorithm>
#include <archive/compare.hpp>
#include <archive/replay.hpp>
#include <archive/writer.hpp>
#include <cmath>
#include <downrange/stage/engine.hpp>

#include "../support/small_range.hpp"
#include "../unit/archive_testing.hpp"

namespace downrange {
namespace {

using test::liftoff;

constexpr double inhibited_s = 20;
constexpr double released_s = 40;
constexpr double pinned_s = 44;
constexpr double stopped_s = 48;
constexpr double antennas_released_s = 52;
constexpr double reset_s = 55;
constexpr double end_s = 60;

OperatorCommand order(OperatorOrder what, double t, const Name& subject = "goheung", const Name& argument = {}) {
  OperatorCommand command;
  command.operator_id = "kim";
  command.order = what;
  command.subject = subject;
  command.argument = argument;
  command.reason = "spent stage in the beam";
  command.epoch = liftoff + seconds(t);
  command.received = command.epoch + milliseconds(5);
  command.simulated = true;
  return command;
}

std::vector<Event> flight(const RangeConfig& range) {
  std::vector<Event> events = test::small_flight(range, end_s, 7);
  events.emplace_back(order(OperatorOrder::Inhibit, inhibited_s));
  events.emplace_back(order(OperatorOrder::Release, released_s));
  events.emplace_back(order(OperatorOrder::PinAntennaSource, pinned_s, "goheung-tm", "only-jeju"));
  OperatorCommand trim = order(OperatorOrder::TrimAntenna, pinned_s, "jeju-tm");
  trim.azimuth_trim_rad = 0.25 * test::deg;
  events.emplace_back(trim);
  events.emplace_back(order(OperatorOrder::StopAntenna, stopped_s, "jeju-tm"));
  events.emplace_back(order(OperatorOrder::Release, antennas_released_s, "goheung-tm"));
  events.emplace_back(order(OperatorOrder::Release, antennas_released_s, "jeju-tm"));
  events.emplace_back(order(OperatorOrder::ResetBias, reset_s, "goheung"));
  std::ranges::stable_sort(events, {}, [](const Event& event) { return received_of(event); });
  return events;
}

/// Events and results into an archive, as the service records them.
class Recording final : public ResultSink {
 public:
  Recording(const std::filesystem::path& path, const RangeConfig& range) : writer_(path), engine_(range, {}, *this) {}

  void consume(const Event& event) {
    const Event admitted = engine_.admit(event);
    writer_.write(admitted);
    engine_.handle(admitted);
  }
  void finish(Time at) {
    engine_.advance_to(at);
    writer_.write_last_tick(engine_.last_tick());
    EXPECT_TRUE(writer_.close().ok());
  }
  [[nodiscard]] Time last_tick() const { return engine_.last_tick(); }
  [[nodiscard]] const test::Collector& results() const { return results_; }

 private:
  void emit(const Result& result) override {
    results_.emit(result);
    writer_.write(result);
  }

  archive::Writer writer_;
  test::Collector results_;
  Engine engine_;
};

class OperatorInFlight : public testing::Test {
 protected:
  OperatorInFlight() {
    range.fuse.methods = {"joint"};
    Recording recording(folder / "live.mcap", range);
    for (const Event& event : flight(range)) recording.consume(event);
    recording.finish(liftoff + seconds(end_s));
    results = recording.results();
  }

  RangeConfig range = test::small_range();
  archive::TemporaryFolder folder;
  test::Collector results;
};

TEST_F(OperatorInFlight, TheRadarIsNotUsedBetweenTheOrders) {
  for (const Observation& o : results.of<Observation>()) {
    if (o.sensor != Name("goheung")) continue;
    const double t = (o.received - liftoff).seconds();
    const bool inhibited = t >= inhibited_s + 0.005 && t < released_s + 0.005;
    EXPECT_EQ(o.verdict == Reason::Inhibited, inhibited) << t;
  }
  int with = 0;
  int without = 0;
  for (const Trajectory& trajectory : results.of<Trajectory>()) {
    const double t = (trajectory.epoch - liftoff).seconds();
    const bool used = (trajectory.sources & 1U) != 0;
    if (t > inhibited_s + 1.5 && t < released_s) {
      EXPECT_FALSE(used) << t;
      ++without;
    }
    if (t > released_s + 2) with += used ? 1 : 0;
  }
  EXPECT_GT(without, 100) << "the track goes on";
  EXPECT_GT(with, 100) << "and takes it in again";
}

TEST_F(OperatorInFlight, HealthSaysWhoAndWhy) {
  int told = 0;
  for (const SourceHealth& health : results.of<SourceHealth>()) {
    if (health.sensor != Name("goheung")) continue;
    const double t = (health.time - liftoff).seconds();
    const bool inhibited = t > inhibited_s + 0.01 && t < released_s + 0.01;  // a tick runs before its instant's events
    EXPECT_EQ(health.why == Disqualification::Inhibited, inhibited) << t;
    if (!inhibited) continue;
    EXPECT_EQ(health.by, Name("kim"));
    EXPECT_EQ(health.reason, Remark("spent stage in the beam"));
    EXPECT_EQ(health.since, liftoff + seconds(inhibited_s));
    ++told;
  }
  EXPECT_GE(told, 19);
}

TEST_F(OperatorInFlight, AntennasArePinnedAndStoppedBetweenTheOrders) {
  int pinned = 0;
  int stopped_late = 0;
  int after = 0;
  for (const SlavingCommand& c : results.of<SlavingCommand>()) {
    const double t = (c.tick - liftoff).seconds();
    const bool ordered = t > pinned_s + 0.01 && t <= antennas_released_s;
    if (c.antenna == Name("goheung-tm")) {
      EXPECT_EQ(c.chain == Name("only-jeju"), ordered) << t;
      pinned += ordered ? 1 : 0;
    } else {
      stopped_late += t > stopped_s + 0.01 && t <= antennas_released_s ? 1 : 0;
      after += t > antennas_released_s + 0.1 ? 1 : 0;
    }
  }
  EXPECT_GT(pinned, 300);
  EXPECT_EQ(stopped_late, 0);
  EXPECT_GT(after, 200);
}

TEST_F(OperatorInFlight, ABiasBeginsAnewWithThePlotAfterTheOrder) {
  double before = 0;
  double at_order = 0;
  for (const SensorBias& bias : results.of<SensorBias>()) {
    if (bias.sensor != Name("goheung")) continue;
    const double t = (bias.received - liftoff).seconds();
    const double sigma = std::sqrt(bias.covariance[0]);
    if (t < reset_s) before = sigma;
    if (t > reset_s + 0.01 && at_order == 0) at_order = sigma;
  }
  EXPECT_GT(before, 0);
  EXPECT_GT(at_order, 1.2 * before);
}

TEST_F(OperatorInFlight, TheArchiveReplaysToTheSameBits) {
  {
    archive::EventSource source(folder / "live.mcap");
    Recording replay(folder / "replay.mcap", range);
    while (const auto event = source.next()) replay.consume(*event);
    ASSERT_TRUE(source.last_tick());
    replay.finish(*source.last_tick());
  }
  const archive::CompareReport report = archive::compare(folder / "live.mcap", folder / "replay.mcap", {});
  EXPECT_TRUE(report.identical());

  // The orders are part of that: a replay that lost them is another flight.
  archive::EventSource source(folder / "live.mcap");
  Recording without(folder / "without.mcap", range);
  while (const auto event = source.next()) {
    if (!std::holds_alternative<OperatorCommand>(*event)) without.consume(*event);
  }
  without.finish(*source.last_tick());
  EXPECT_FALSE(archive::compare(folder / "live.mcap", folder / "without.mcap", {}).identical());
}

}  // namespace
}  // namespace downrange
