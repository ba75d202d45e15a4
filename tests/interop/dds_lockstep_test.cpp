/// The range clock: nothing lost, nothing out of step, and every way in which a flight cannot go on. Domains 30 to
/// 38.

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "dds/convert.hpp"
#include "dds/entities.hpp"
#include "dds/inputs.hpp"
#include "dds/outputs.hpp"
#include "dds/range_clock.hpp"
#include "dds/topics.hpp"
#include "dds_inbox.hpp"
#include "dds_samples.hpp"

namespace downrange::dds {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// The events of one step of a flight: sources of different rates, several targets, sequences that repeat.
std::vector<Event> flight_events(std::uint64_t step) {
  std::vector<Event> events;
  const auto plot = [&](const char* sensor, const char* target, std::uint64_t sequence) {
    RadarTspi made = sample_plot(sequence);
    made.sensor = sensor;
    made.target = target;
    made.epoch = {static_cast<std::int64_t>(step)};
    events.emplace_back(made);
  };
  plot("radar-b", "stage-2", step);
  plot("radar-b", "stage-1", step);
  plot("radar-a", "stage-1", step / 3);  // a recorder that repeats sequences
  if (step % 4 == 0) {
    AngleTspi angles = sample_angles(step);
    angles.epoch = {static_cast<std::int64_t>(step)};
    events.emplace_back(angles);
  }
  if (step % 10 == 0) {
    GpsFix fix = sample_fix(step);
    fix.epoch = {static_cast<std::int64_t>(step)};
    events.emplace_back(fix);
    fix.station = "goheung-tm";
    events.emplace_back(fix);
  }
  if (step % 500 == 1) {
    events.emplace_back(sample_mark(step));
    Inputs::for_each([&]<class Input>() {
      if constexpr (!Measurements::contains<Input> && !std::is_same_v<Input, MissionEvent>)
        events.emplace_back(test::sample<Input>());
    });
  }
  return events;
}

Time flight_time(std::uint64_t step) { return {static_cast<std::int64_t>(step) * 22'000'000}; }

/// What a follower must hand out for that step.
std::vector<Event> expected_events(std::uint64_t step) {
  std::vector<Event> events = flight_events(step);
  for (Event& event : events) set_received(event, flight_time(step));
  std::stable_sort(events.begin(), events.end(), step_order_less);
  return events;
}

void expect_equal_events(const std::vector<Event>& a, const std::vector<Event>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].index(), b[i].index());
    EXPECT_EQ(received_of(a[i]), received_of(b[i]));
    EXPECT_TRUE(a[i] == b[i]) << "event " << i;
  }
}

/// Follows one run to its end on a thread of its own, and hands every step to `consume`.
class FollowingNode {
 public:
  using Consume = std::function<void(const RangeStep&)>;

  FollowingNode(int domain, const char* name, const FollowerOptions& options, bool observations, Consume consume = {})
      : participant_(test_participant(domain, name, ClockMode::Range)),
        outputs_(participant_, {100, observations, false}),
        follower_(participant_, options, &outputs_),
        consume_(std::move(consume)),
        thread_([this] { follow_steps(); }) {}
  ~FollowingNode() {
    stop_ = true;
    thread_.join();
  }

  /// After the run: the error it ended with, if any.
  std::string wait_for_end() {
    if (!wait_until(seconds(60), [this] { return ended_.load(); })) return "did not end";
    return error_;
  }
  OutputWriters& outputs() { return outputs_; }
  std::atomic<std::uint64_t> steps = 0;

 private:
  void follow_steps() {
    try {
      while (!stop_ && !ended_) {
        const std::optional<RangeStep> step = follower_.next(milliseconds(50));
        if (!step) continue;
        if (consume_) consume_(*step);
        follower_.acknowledge(*step);
        ++steps;
        ended_ = step->end;
      }
    } catch (const LockstepError& error) {
      error_ = error.what();
      ended_ = true;
    }
  }

  Participant participant_;
  OutputWriters outputs_;
  RangeClockFollower follower_;
  Consume consume_;
  std::string error_;
  std::atomic<bool> stop_ = false;
  std::atomic<bool> ended_ = false;
  std::thread thread_;
};

void fly(RangeClockDriver& driver, std::uint64_t steps) {
  for (std::uint64_t step = 1; step <= steps; ++step) driver.step(flight_time(step), flight_events(step));
  driver.finish();
}

TEST(DdsLockstep, EveryStepOfAFlightArrivesWholeAndInOrder) {
  constexpr std::uint64_t flight_steps = 2000;
  std::uint64_t expected_step = 1;
  FollowingNode node(30, "service", {}, false, [&](const RangeStep& step) {
    EXPECT_EQ(step.step, expected_step++);
    if (step.end) return;
    EXPECT_EQ(step.time, flight_time(step.step));
    expect_equal_events(step.events, expected_events(step.step));
  });
  Participant participant(test_participant(30, "simulator", ClockMode::Range));
  RangeClockDriver driver(participant, {{"service"}});
  driver.wait_for_nodes(seconds(30));
  fly(driver, flight_steps);
  EXPECT_EQ(driver.acknowledged(), flight_steps + 1);
  EXPECT_EQ(node.wait_for_end(), "");
  EXPECT_EQ(node.steps, flight_steps + 1);
}

TEST(DdsLockstep, AsManyStepsAreOutstandingAsTheWindowAllows) {
  std::atomic<bool> go = false;
  FollowingNode node(31, "service", {}, false,
                     [&](const RangeStep&) { EXPECT_TRUE(wait_until(seconds(30), [&] { return go.load(); })); });
  Participant participant(test_participant(31, "simulator", ClockMode::Range));
  DriverOptions options{{"service"}, 4, milliseconds(200)};
  RangeClockDriver driver(participant, options);
  driver.wait_for_nodes(seconds(30));
  for (std::uint64_t step = 1; step <= 4; ++step) driver.step(flight_time(step), {});
  try {
    driver.step(flight_time(5), {});
    FAIL() << "the node has acknowledged nothing";
  } catch (const LockstepError& error) {
    EXPECT_STREQ(error.what(), "node 'service' has acknowledged step 0 of 4 and nothing more for 200 ms");
  }
  go = true;
}

TEST(DdsLockstep, AbsentNodesAreNamed) {
  FollowingNode node(32, "service", {}, false);
  Participant participant(test_participant(32, "simulator", ClockMode::Range));
  RangeClockDriver driver(participant, {{"service", "ingest-jeju"}});
  EXPECT_TRUE(wait_until(seconds(30), [&] {
    try {
      driver.wait_for_nodes(milliseconds(50));
      return false;
    } catch (const LockstepError& error) {
      return std::string(error.what()) == "not ready within 50 ms: node 'ingest-jeju'";
    }
  }));
}

TEST(DdsLockstep, ALostSampleStopsTheFlightByName) {
  FollowerOptions options;
  options.timeout = milliseconds(300);
  FollowingNode node(33, "service", options, false);
  Participant participant(test_participant(33, "simulator", ClockMode::Range));
  RangeClockDriver driver(participant, {{"service"}});
  driver.wait_for_nodes(seconds(30));
  // A clock beside the driver's, which announces one plot more than there is.
  Tally<WriteCounts> tally;
  TopicWriter<wire::RangeClockV2PubSubType> clock(participant, topics::clock, tally);
  InputWriters inputs(participant);
  ASSERT_TRUE(wait_until(seconds(30), [&] { return clock.readers().count() == 1; }));
  ASSERT_TRUE(inputs.wait_for_matched(1, seconds(30)));
  ASSERT_TRUE(inputs.write(sample_plot(), {77, 1}));
  wire::RangeClockV2 sample;
  sample.run_id(77);
  sample.step(1);
  wire::SourceCountV2 count;
  count.topic(wire::INPUT_RADAR_TSPI);
  count.source_id() = "goheung-radar";
  count.last_sequence_number(2);
  sample.counts().push_back(count);
  ASSERT_TRUE(clock.write(sample));
  EXPECT_EQ(node.wait_for_end(),
            "step 1 of run 77 is not complete after 300 ms: topic range/radar_tspi, source goheung-radar: expected 2, "
            "received 1");
}

TEST(DdsLockstep, TheDriverHearsWhyANodeGaveUp) {
  Participant node(test_participant(34, "service", ClockMode::Range));
  Tally<WriteCounts> tally;
  TopicWriter<wire::ClockAckV3PubSubType> ack(node, topics::clock_ack, tally);
  Participant participant(test_participant(34, "simulator", ClockMode::Range));
  RangeClockDriver driver(participant, {{"service"}, 1, seconds(60)});
  driver.step(flight_time(1), {});
  wire::ClockAckV3 sample;
  sample.node_id() = "service";
  sample.run_id(driver.run_id());
  sample.failure() = "lost something";
  ASSERT_TRUE(ack.write(sample));
  try {
    driver.finish();
    FAIL();
  } catch (const LockstepError& error) {
    EXPECT_STREQ(error.what(), "node 'service': lost something");
  }
}

TEST(DdsLockstep, ARunUnderWayIsNotJoinedTheNextOneIs) {
  Participant participant(test_participant(35, "simulator", ClockMode::Range));
  FollowingNode early(35, "early", {}, false);
  std::optional<RangeClockDriver> driver(std::in_place, participant, DriverOptions{{"early"}});
  driver->wait_for_nodes(seconds(30));
  for (std::uint64_t step = 1; step <= 10; ++step) driver->step(flight_time(step), flight_events(step));

  Participant late_participant(test_participant(35, "late", ClockMode::Range));
  RangeClockFollower late(late_participant, {}, nullptr);
  std::string notice;
  std::uint64_t step = 10;
  EXPECT_TRUE(wait_until(seconds(30), [&] {
    driver->step(flight_time(step + 1), flight_events(step + 1));
    ++step;
    EXPECT_FALSE(late.next(milliseconds(1)));
    notice = late.notice().value_or("");
    return !notice.empty();
  }));
  EXPECT_TRUE(
      notice.starts_with("run " + std::to_string(driver->run_id()) + " is under way already (first step seen: "))
      << notice;
  driver->finish();
  EXPECT_EQ(early.wait_for_end(), "");
  EXPECT_FALSE(late.next(milliseconds(100))) << "nothing of a run that was not joined";

  driver.emplace(participant, DriverOptions{{"late"}});
  std::thread flight([&] {
    driver->wait_for_nodes(seconds(30));
    fly(*driver, 20);
  });
  std::optional<RangeStep> last;
  for (int i = 0; i < 1000 && !(last && last->end); ++i) {
    if (auto next = late.next(milliseconds(100))) {
      EXPECT_EQ(next->step, last ? last->step + 1 : 1);
      late.acknowledge(*next);
      last = next;
    }
  }
  flight.join();
  ASSERT_TRUE(last);
  EXPECT_EQ(last->step, 21U);
}

TEST(DdsLockstep, ANewRunReplacesOneThatWasBrokenOff) {
  Participant participant(test_participant(36, "simulator", ClockMode::Range));
  Participant node(test_participant(36, "service", ClockMode::Range));
  RangeClockFollower follower(node, {}, nullptr);
  for (int run = 0; run < 2; ++run) {
    RangeClockDriver driver(participant, {{"service"}});
    std::thread waiting([&] { driver.wait_for_nodes(seconds(30)); });
    EXPECT_FALSE(follower.next(milliseconds(500)));
    waiting.join();
    driver.step(flight_time(1), flight_events(1));
    std::optional<RangeStep> step;
    ASSERT_TRUE(wait_until(seconds(30), [&] { return (step = follower.next(milliseconds(10))).has_value(); }));
    EXPECT_EQ(step->run_id, driver.run_id());
    EXPECT_EQ(step->step, 1U);
    expect_equal_events(step->events, expected_events(1));
    follower.acknowledge(*step);
  }
  EXPECT_TRUE(follower.notice().value_or("").ends_with(" was broken off at step 1: a new run begins"));
}

TEST(DdsLockstep, NoResultIsLostToASlowConsumerAtFullSpeed) {
  constexpr int commands = 5000;
  Participant service(test_participant(38, "service", ClockMode::Range));
  Participant consumer(test_participant(38, "consumer", ClockMode::Range));
  Inbox<std::int64_t> ticks;
  OutputReaders readers(consumer, {},
                        {[&](const Result& result) {
                           std::this_thread::sleep_for(std::chrono::microseconds(200));
                           ticks.add(std::get<SlavingCommand>(result).tick.ns);
                         },
                         {}});
  OutputWriters writers(service, {});
  ASSERT_TRUE(writers.wait_for_matched(1, seconds(30)));
  SlavingCommand command = sample_command();
  for (int i = 0; i < commands; ++i) {
    command.tick.ns = i;
    writers.emit(command);
  }
  EXPECT_EQ(writers.counts().failures, 0U) << writers.counts().last_failure;
  ASSERT_TRUE(ticks.wait_for_size(commands));
  const std::vector<std::int64_t> seen = ticks.items();
  for (int i = 0; i < commands; ++i) ASSERT_EQ(seen[static_cast<std::size_t>(i)], i);
}

/// An ingest node turns every plot and every pair of angles into one observation, every fix into two.
void ingest(const RangeStep& step, OutputWriters& outputs) {
  for (const Event& event : step.events) {
    Observation observation = sample_observation();
    observation.received = step.time;
    if (const auto* plot = std::get_if<RadarTspi>(&event)) {
      observation.measured = test::sample_measured_plot();
      observation.sensor = plot->sensor;
      observation.target = plot->target;
      observation.sequence = plot->sequence;
      outputs.emit(observation);
    } else if (const auto* angles = std::get_if<AngleTspi>(&event)) {
      observation.measured = Angles{};
      observation.sensor = angles->sensor;
      observation.target = angles->target;
      observation.sequence = angles->sequence;
      outputs.emit(observation);
    } else if (const auto* fix = std::get_if<GpsFix>(&event)) {
      observation.sensor = fix->station;
      observation.sequence = fix->sequence;
      outputs.emit(observation);
      outputs.emit(observation);
    }
  }
}

TEST(DdsLockstep, ACentreGetsTheStepsOfItsIngestNodes) {
  constexpr std::uint64_t flight_steps = 300;
  constexpr std::size_t unjudged = Inputs::size - Measurements::size;
  OutputWriters* outputs_a = nullptr;
  OutputWriters* outputs_b = nullptr;
  FollowingNode a(37, "ingest-a", {}, true, [&](const RangeStep& step) { ingest(step, *outputs_a); });
  FollowingNode b(37, "ingest-b", {}, true, [&](const RangeStep& step) { ingest(step, *outputs_b); });
  outputs_a = &a.outputs();
  outputs_b = &b.outputs();
  std::uint64_t observations = 0;
  std::uint64_t marks = 0;
  FollowerOptions centre_options;
  centre_options.sensors = false;
  centre_options.ingest_nodes = {"ingest-a", "ingest-b"};
  FollowingNode centre(37, "centre", centre_options, false, [&](const RangeStep& step) {
    const std::size_t fixes = step.step % 10 == 0 ? 2 : 0;
    const std::size_t angles = step.step % 4 == 0 ? 1 : 0;
    const std::size_t expected = step.end ? 0 : 2 * (3 + angles + 2 * fixes) + (step.step % 500 == 1 ? unjudged : 0);
    EXPECT_EQ(step.events.size(), expected) << "step " << step.step;
    for (const Event& event : step.events) {
      if (const auto* observation = std::get_if<Observation>(&event)) {
        ++observations;
        EXPECT_EQ(observation->step, step.step);
        EXPECT_EQ(observation->received, step.time);
      } else {
        ++marks;
      }
    }
    EXPECT_TRUE(std::is_sorted(step.events.begin(), step.events.end(), step_order_less));
  });
  Participant participant(test_participant(37, "simulator", ClockMode::Range));
  RangeClockDriver driver(participant, {{"ingest-a", "ingest-b", "centre"}});
  driver.wait_for_nodes(seconds(30));
  fly(driver, flight_steps);
  EXPECT_EQ(a.wait_for_end(), "");
  EXPECT_EQ(b.wait_for_end(), "");
  EXPECT_EQ(centre.wait_for_end(), "");
  EXPECT_EQ(observations, 2 * (3 * flight_steps + flight_steps / 4 + 4 * (flight_steps / 10)));
  EXPECT_EQ(marks, unjudged) << "what ingest does not judge reaches the centre as it is";
}

}  // namespace
}  // namespace downrange::dds
