/// Every type over DDS, field by field; many instances. Domains 20 to 27.

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "dds/convert.hpp"
#include "dds/entities.hpp"
#include "dds/inputs.hpp"
#include "dds/outputs.hpp"
#include "dds/topics.hpp"
#include "dds_inbox.hpp"
#include "dds_samples.hpp"

namespace downrange::dds {
namespace {

using std::chrono::seconds;

template <class T, class Items>
const T* find(const Items& items) {
  for (const auto& item : items) {
    if (const T* found = std::get_if<T>(&item)) return found;
  }
  return nullptr;
}

/// Compares the one record of type T among the items. An input's `received` is the reader's.
template <class T, class Items>
void expect_record(const Items& items, const T& sent) {
  const T* found_record = find<T>(items);
  ASSERT_NE(found_record, nullptr) << MessageInfo<T>::topic;
  T received = *found_record;
  if constexpr (Inputs::contains<T>) received.received = sent.received;
  EXPECT_TRUE(received == sent) << MessageInfo<T>::topic;
}

TEST(DdsLoopback, EveryInputArrivesAsItWasSent) {
  Participant sensor(test_participant(20, "sensor", ClockMode::Wall));
  Participant service(test_participant(20, "service", ClockMode::Wall));
  Inbox<Event> inbox;
  InputReader reader(service, {}, [&](const Event& event, const RangeStamp& stamp, const Name&) {
    EXPECT_EQ(stamp.run_id, 0U);
    inbox.add(event);
  });
  InputWriters writers(sensor);
  ASSERT_TRUE(writers.wait_for_matched(1, seconds(30)));
  ASSERT_TRUE(reader.wait_for_matched(1, seconds(30)));

  Inputs::for_each([&]<class Input>() { EXPECT_TRUE(writers.write(test::sample<Input>())); });
  EXPECT_FALSE(writers.write(sample_observation())) << "an observation is no input of the range";

  ASSERT_TRUE(inbox.wait_for_size(Inputs::size));
  Inputs::for_each([&]<class Input>() { expect_record(inbox.items(), test::sample<Input>()); });
  for (const Event& event : inbox.items()) EXPECT_GT(received_of(event).ns, 1'500'000'000'000'000'000);
  EXPECT_TRUE(
      wait_until(seconds(30), [&] { return reader.counts().samples == Inputs::size; }));  // counted after the callback
  EXPECT_EQ(reader.counts().malformed, 0U);
  EXPECT_EQ(writers.counts().failures, 0U);
}

TEST(DdsLoopback, NotFiniteNumbersAreLeftToIngest) {
  Participant node(test_participant(21, "node", ClockMode::Wall));
  Inbox<Event> inbox;
  InputReader reader(node, {}, [&](const Event& event, const RangeStamp&, const Name&) { inbox.add(event); });
  InputWriters writers(node);
  ASSERT_TRUE(writers.wait_for_matched(1, seconds(30)));
  RadarTspi plot = sample_plot();
  plot.measured.range_m = std::nan("");
  plot.sensor = Name();
  ASSERT_TRUE(writers.write(plot));
  ASSERT_TRUE(inbox.wait_for_size(1));
  EXPECT_TRUE(std::isnan(std::get<RadarTspi>(inbox.items()[0]).measured.range_m));
}

TEST(DdsLoopback, EveryResultArrivesAsItWasEmitted) {
  Participant service(test_participant(22, "service", ClockMode::Wall));
  Participant consumer(test_participant(22, "consumer", ClockMode::Wall));
  Inbox<Result> results;
  Inbox<ServiceStatus> statuses;
  OutputSelection all;
  all.observations = true;
  OutputReaders readers(
      consumer, all,
      {[&](const Result& result) { results.add(result); }, [&](const ServiceStatus& status) { statuses.add(status); }});
  OutputWriters writers(service, {});
  ASSERT_TRUE(writers.wait_for_matched(1, seconds(30)));
  ASSERT_TRUE(readers.wait_for_matched(1, seconds(30)));

  ServiceStatus status;
  status.node = "service";
  status.stages = {true, false, true, false};
  status.version = "0.1.0";
  status.configuration_hash = std::string(64, 'f');
  status.clock = ClockMode::Range;
  status.time = {1};
  status.last_tick = {2};
  status.queue_depth = 3;
  status.consumed = 4;
  status.consumed_per_s = 2.5;
  status.emitted_per_s = 40;
  status.emitted = 5;
  status.dropped = 6;
  status.write_failures = 7;
  status.latency_us = {8, 9, 10, 11};
  status.archive_state = "recording";
  status.mismatch = "1 of others: range/gps";
  status.state = "running";
  status.utc = {true, true, -1e-6, 2e-3};
  status.acknowledgements = {{input_index<OperatorCommand>, "kim", 12, "no source is named 'x'"},
                             {input_index<MissionEvent>, "flight-3", 13, ""}};
  Outputs::for_each([&]<class Output>() { writers.emit(test::sample<Output>()); });
  writers.publish(status);

  ASSERT_TRUE(results.wait_for_size(Outputs::size));
  Outputs::for_each([&]<class Output>() { expect_record(results.items(), test::sample<Output>()); });
  ASSERT_TRUE(statuses.wait_for_size(1));
  const ServiceStatus received = statuses.items()[0];
  EXPECT_EQ(received.node, status.node);
  EXPECT_TRUE(received.stages.ingest && !received.stages.align && received.stages.fuse && !received.stages.slave);
  EXPECT_EQ(received.version, status.version);
  EXPECT_EQ(received.configuration_hash, status.configuration_hash);
  EXPECT_EQ(received.clock, status.clock);
  EXPECT_EQ(received.time, status.time);
  EXPECT_EQ(received.last_tick, status.last_tick);
  EXPECT_EQ(received.queue_depth, status.queue_depth);
  EXPECT_EQ(received.consumed, status.consumed);
  EXPECT_EQ(received.consumed_per_s, status.consumed_per_s);
  EXPECT_EQ(received.emitted_per_s, status.emitted_per_s);
  EXPECT_EQ(received.emitted, status.emitted);
  EXPECT_EQ(received.dropped, status.dropped);
  EXPECT_EQ(received.write_failures, status.write_failures);
  EXPECT_EQ(received.latency_us, status.latency_us);
  EXPECT_EQ(received.archive_state, status.archive_state);
  EXPECT_EQ(received.mismatch, status.mismatch);
  EXPECT_EQ(received.state, status.state);
  EXPECT_EQ(received.utc, status.utc);
  EXPECT_EQ(received.acknowledgements, status.acknowledgements);
  EXPECT_EQ(writers.counts().failures, 0U);
}

TEST(DdsLoopback, ObservationsOfOtherNodesAreLeftAlone) {
  Participant ingest(test_participant(23, "ingest-a", ClockMode::Wall));
  Participant stranger(test_participant(23, "ingest-b", ClockMode::Wall));
  Participant centre(test_participant(23, "centre", ClockMode::Wall));
  Inbox<Event> inbox;
  InputReader reader(centre, {false, false, {"ingest-a"}},
                     [&](const Event& event, const RangeStamp&, const Name& node) {
                       EXPECT_EQ(node, Name("ingest-a"));
                       inbox.add(event);
                     });
  OutputWriters writers(ingest, {100, true, false});
  OutputWriters strange_writers(stranger, {100, true, false});
  ASSERT_TRUE(writers.wait_for_matched(1, seconds(30)));
  ASSERT_TRUE(strange_writers.wait_for_matched(1, seconds(30)));
  strange_writers.emit(sample_observation(1));
  writers.emit(sample_observation(2));
  ASSERT_TRUE(inbox.wait_for_size(1));
  Observation arrived = std::get<Observation>(inbox.items()[0]);
  EXPECT_GT(arrived.received.ns, 1'500'000'000'000'000'000) << "the centre's time of arrival, not the ingest node's";
  arrived.received = sample_observation().received;
  EXPECT_TRUE(arrived == sample_observation(2));
}

/// An observation for and one against the centre's clock mode: the first is malformed, the second arrives.
void expect_only_own_mode(int domain, ClockMode mode) {
  const std::uint64_t run_id = mode == ClockMode::Range ? 5 : 0;
  Participant ingest(test_participant(domain, "ingest", mode));
  Participant centre(test_participant(domain, "centre", mode));
  Inbox<RangeStamp> inbox;
  InputReader reader(centre, {false, false, {"ingest"}},
                     [&](const Event&, const RangeStamp& stamp, const Name&) { inbox.add(stamp); });
  Tally<WriteCounts> tally;
  TopicWriter<wire::ObservationV2PubSubType> writer(ingest, topic_of<Observation>, tally);
  ASSERT_TRUE(reader.wait_for_matched(1, seconds(30)));
  ASSERT_TRUE(wait_until(seconds(30), [&] { return writer.readers().count() == 1; }));
  wire::ObservationV2 sample;
  to_wire(sample_observation(), sample);
  sample.node_id() = "ingest";
  to_wire(RangeStamp{5 - run_id, 1}, sample.stamp());
  ASSERT_TRUE(writer.write(sample));
  to_wire(RangeStamp{run_id, 1}, sample.stamp());
  ASSERT_TRUE(writer.write(sample));
  ASSERT_TRUE(wait_until(seconds(30), [&] { return reader.counts().samples + reader.counts().malformed == 2; }));
  EXPECT_EQ(reader.counts().malformed, 1U);
  ASSERT_EQ(inbox.items().size(), 1U);
  EXPECT_EQ(inbox.items()[0].run_id, run_id);
}

TEST(DdsLoopback, AnObservationOfARunIsNoneOfAWallClockCentre) { expect_only_own_mode(105, ClockMode::Wall); }
TEST(DdsLoopback, ALiveObservationIsNoneOfARangeClockCentre) { expect_only_own_mode(106, ClockMode::Range); }

TEST(DdsLoopback, AccountsOfOneSourceAreToldApartByTheirNode) {
  Participant first(test_participant(27, "ingest-a", ClockMode::Wall));
  Participant second(test_participant(27, "centre", ClockMode::Wall));
  Participant consumer(test_participant(27, "consumer", ClockMode::Wall));
  Inbox<Result> results;
  Inbox<std::pair<Name, SourceHealth>> accounts;
  OutputCallbacks callbacks;
  callbacks.result = [&](const Result& result) { results.add(result); };
  callbacks.health = [&](const SourceHealth& health, const Name& node) { accounts.add({node, health}); };
  const OutputSelection only_health{.results = false, .status = false};
  OutputReaders readers(consumer, only_health, callbacks);
  OutputWriters first_writers(first, {});
  OutputWriters second_writers(second, {});
  ASSERT_TRUE(readers.wait_for_matched(2, seconds(30)));
  first_writers.emit(test::sample<SourceHealth>());
  second_writers.emit(test::sample<SourceHealth>());
  std::set<Name> nodes;
  ASSERT_TRUE(accounts.wait([&](const auto& items) {
    for (const auto& [node, health] : items) nodes.insert(node);
    return nodes.size() == 2;
  }));
  EXPECT_EQ(nodes, (std::set<Name>{"ingest-a", "centre"}));
  for (const auto& [node, health] : accounts.items()) EXPECT_TRUE(health == test::sample<SourceHealth>());
  EXPECT_TRUE(results.items().empty());
}

TEST(DdsLoopback, AHundredAntennas) {
  Participant service(test_participant(24, "service", ClockMode::Wall));
  Participant consumer(test_participant(24, "consumer", ClockMode::Wall));
  Inbox<Result> results;
  OutputReaders readers(consumer, {}, {[&](const Result& result) { results.add(result); }, {}});
  OutputWriters writers(service, {});
  ASSERT_TRUE(writers.wait_for_matched(1, seconds(30)));
  for (int i = 0; i < 100; ++i) writers.emit(sample_command(Name("antenna-" + std::to_string(i))));
  EXPECT_EQ(writers.counts().failures, 0U) << writers.counts().last_failure;
  ASSERT_TRUE(results.wait_for_size(100));
  std::set<Name> antennas;
  for (const Result& result : results.items()) antennas.insert(std::get<SlavingCommand>(result).antenna);
  EXPECT_EQ(antennas.size(), 100U);
}

}  // namespace
}  // namespace downrange::dds
