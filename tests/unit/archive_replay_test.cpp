// What a replay gets out of an archive, and the comparison of two archives.

#include <archive/compare.hpp>
#include <archive/replay.hpp>

#include "archive_testing.hpp"

namespace downrange::archive {
namespace {

TEST(ArchiveReplay, StreamsTheEventsInOrderAndTheLastTick) {
  const TemporaryFolder folder;
  {
    Writer writer(folder / "a.mcap");
    write_all_kinds(writer);
  }
  EventSource source(folder / "a.mcap");
  std::vector<Truth> truths;
  source.on_truth([&](const Truth& truth) { truths.push_back(truth); });
  std::vector<Event> events;
  while (auto event = source.next()) events.push_back(*event);

  ASSERT_EQ(events.size(), 8u) << "the observation that the engine made is not an event";
  EXPECT_TRUE(std::holds_alternative<MissionEvent>(events[0]));
  EXPECT_TRUE(std::holds_alternative<RadarTspi>(events[1]));
  EXPECT_TRUE(std::holds_alternative<GpsFix>(events[2]));
  EXPECT_TRUE(std::holds_alternative<Observation>(events[3]));
  EXPECT_TRUE(std::holds_alternative<AngleTspi>(events[4]));
  EXPECT_TRUE(std::holds_alternative<OperatorCommand>(events[5]));
  EXPECT_TRUE(std::holds_alternative<AntennaReport>(events[6]));
  EXPECT_TRUE(std::holds_alternative<PlatformState>(events[7]));
  EXPECT_EQ(source.last_tick(), t0 + milliseconds(1000));
  EXPECT_EQ(truths.size(), 1u);
  EXPECT_FALSE(source.truncated());
  EXPECT_EQ(source.progress(), 1.0);
}

TEST(ArchiveReplay, EveryInputIsReplayedAndEveryOutputReadBack) {
  const TemporaryFolder folder;
  std::vector<Event> written;
  {
    Writer writer(folder / "all.mcap");
    Inputs::for_each([&]<class Input>() {
      written.emplace_back(sample_at<Input>(static_cast<std::int64_t>(10 * written.size())));
      writer.write(written.back());
    });
    Outputs::for_each([&]<class Output>() { writer.write(Result(test::sample<Output>())); });
  }
  EventSource source(folder / "all.mcap");
  for (const Event& event : written) EXPECT_EQ(source.next(), event) << "input " << event.index();
  EXPECT_FALSE(source.next());
  Reader reader(folder / "all.mcap");
  std::size_t outputs = 0;
  while (const auto entry = reader.next()) outputs += entry->role == Role::Output ? 1U : 0U;
  EXPECT_EQ(outputs, Outputs::size);
}

TEST(ArchiveReplay, GivesTheAttachedConfiguration) {
  const TemporaryFolder folder;
  {
    Writer writer(folder / "a.mcap");
    write_all_kinds(writer);
  }
  EXPECT_EQ(read_attachment(folder / "a.mcap", "config.toml"), "[range]\nname = \"naro\"\n");
  EXPECT_EQ(read_attachment(folder / "a.mcap", "other.toml"), std::nullopt);
}

TEST(ArchiveReplay, ChunksCloseBySizeAndByLogTime) {
  const TemporaryFolder folder;
  WriterOptions options;
  options.chunk_size = 4096;
  Writer small(folder / "small.mcap", options);
  for (std::uint64_t i = 0; i < 200; ++i) small.write(Event(some_radar(i)));
  EXPECT_GT(small.close().chunks_written, 4u);

  Writer timed(folder / "timed.mcap");  // 20 per second for ten seconds
  for (std::uint64_t i = 0; i < 200; ++i) timed.write(Event(some_radar(i)));
  EXPECT_EQ(timed.close().chunks_written, 10u);

  for (const char* name : {"small.mcap", "timed.mcap"}) {
    EventSource source(folder / name);
    std::uint64_t expected = 0;
    while (const auto event = source.next()) EXPECT_EQ(std::get<RadarTspi>(*event).sequence, expected++);
    EXPECT_EQ(expected, 200u);
  }
}

TEST(ArchiveReplay, TimesBefore1970AndNoTickSurvive) {
  const TemporaryFolder folder;
  RadarTspi radar = some_radar(1);
  radar.epoch = {-5};
  radar.received = {-4};
  {
    Writer writer(folder / "a.mcap");
    writer.write(Event(radar));
    writer.write_last_tick({std::numeric_limits<std::int64_t>::min()});
  }
  EventSource source(folder / "a.mcap");
  EXPECT_EQ(std::get<RadarTspi>(source.next().value()).epoch, Time{-5});
  EXPECT_FALSE(source.next());
  EXPECT_EQ(source.last_tick(), Time{std::numeric_limits<std::int64_t>::min()});
}

/// Plots by their number; `received` of number i is t0 + 50 i + 40 ms.
class ArchiveOrder : public testing::Test {
 protected:
  void write(std::initializer_list<std::uint64_t> plots, std::initializer_list<std::int64_t> truths_ms = {}) {
    Writer writer(folder_ / "a.mcap");
    for (const std::uint64_t i : plots) writer.write(Event(some_radar(i)));
    for (const std::int64_t ms : truths_ms) {
      Truth truth = some_truth();
      truth.epoch = t0 + milliseconds(ms);
      writer.write_truth(truth);
    }
    writer.write_last_tick(t0);
  }
  /// Numbers of the plots as they come out; truths as "t" and their time in ms.
  std::string read(EventOrder order) {
    EventSource source(folder_ / "a.mcap", order);
    std::string out;
    source.on_truth([&](const Truth& t) { out += "t" + std::to_string((t.epoch - t0).ns / 1'000'000) + " "; });
    while (const auto event = source.next()) out += std::to_string(std::get<RadarTspi>(*event).sequence) + " ";
    EXPECT_EQ(source.last_tick(), t0);
    return out;
  }
  TemporaryFolder folder_;
};

TEST_F(ArchiveOrder, WhatIsBehindByATickIsSaid) {
  write({1, 4, 3, 5});
  EXPECT_EQ(read({}), "1 4 3 5 ") << "threads that take messages may cross";
  EXPECT_EQ(read({.slack = milliseconds(51)}), "1 4 3 5 ");
  EXPECT_THROW(read({.slack = milliseconds(50)}), OrderError);
  EXPECT_THROW(read({.slack = Duration{0}}), OrderError);
}

TEST_F(ArchiveOrder, TopicAfterTopicIsSaidOrSorted) {
  write({100, 130, 160, 101, 102, 161}, {8090, 5039, 9000});
  try {
    read({});
    FAIL() << "a file out of order was not noticed";
  } catch (const OrderError& error) {
    EXPECT_NE(std::string(error.what()).find("a.mcap: not in the order of time: an event was received 2.950 s before"),
              std::string::npos)
        << error.what();
  }
  EXPECT_EQ(read({.sort = true}), "t5039 100 101 102 130 160 t8090 161 t9000 ");
}

TEST_F(ArchiveOrder, EqualTimesStayAsTheyWereConsumed) {
  Writer writer(folder_ / "a.mcap");
  for (const std::uint64_t sequence : {7, 3, 5}) {
    RadarTspi radar = some_radar(0);
    radar.sequence = sequence;
    writer.write(Event(radar));
  }
  writer.write_last_tick(t0);
  EXPECT_TRUE(writer.close().ok());
  EXPECT_EQ(read({.sort = true}), "7 3 5 ");
}

TEST_F(ArchiveOrder, ASilenceOfMonthsIsAWrongClock) {
  write({1, 60'000'000});  // 34.7 days
  EXPECT_THROW(read({}), ArchiveError);
  std::filesystem::remove(folder_ / "a.mcap");
  {
    Writer writer(folder_ / "a.mcap");
    writer.write(Event(some_radar(1)));
    writer.write_last_tick(t0 + Duration{std::int64_t{31} * 86'400'000'000'000});
  }
  EXPECT_THROW(read({}), ArchiveError);
}

TEST_F(ArchiveOrder, AnArchiveWithoutEventsSaysWhatItHolds) {
  {
    Writer writer(folder_ / "a.mcap");
    writer.write(Result(some_slaving()));
    writer.write_truth(some_truth());
  }
  try {
    require_events(folder_ / "a.mcap");
    FAIL() << "an archive without events passed";
  } catch (const ArchiveError& error) {
    EXPECT_NE(std::string(error.what()).find("it holds 2 results and truths"), std::string::npos) << error.what();
  }
  std::filesystem::remove(folder_ / "a.mcap");
  write({1});
  EXPECT_NO_THROW(require_events(folder_ / "a.mcap"));
}

TEST(ArchiveReplay, DoesNotRecordOverAFlight) {
  const TemporaryFolder folder;
  write_text(folder / "a.mcap", "precious");
  EXPECT_THROW(Writer(folder / "a.mcap"), ArchiveError);
  EXPECT_EQ(read_bytes(folder / "a.mcap").size(), 8u);
  EXPECT_THROW(Writer(folder / "no-such-folder/a.mcap"), ArchiveError);
}

TEST(ArchiveReplay, WritesAfterCloseAreLostAndCounted) {
  const TemporaryFolder folder;
  Writer writer(folder / "a.mcap");
  writer.write(Event(some_radar(1)));
  EXPECT_TRUE(writer.close().ok());
  writer.write(Event(some_radar(2)));
  EXPECT_EQ(writer.status().messages_lost, 1u);
  EXPECT_FALSE(writer.close().ok());
}

class ArchiveCompare : public testing::Test {
 protected:
  /// `events` first, so that two archives reach a result at different file positions.
  std::filesystem::path write(const std::string& name, int events, const std::vector<Result>& results) {
    Writer writer(folder_ / name);
    for (int i = 0; i < events; ++i) writer.write(Event(some_radar(1)));
    for (const Result& result : results) writer.write(result);
    EXPECT_TRUE(writer.close().ok());
    return folder_ / name;
  }
  TemporaryFolder folder_;
};

TEST_F(ArchiveCompare, SameResultsAreIdenticalWhateverCameBetween) {
  const auto a = write("a", 3, {some_trajectory(), some_slaving(), some_trajectory()});
  const auto b = write("b", 40, {some_slaving(), some_trajectory(), some_trajectory()});
  const CompareReport report = compare(a, b);
  EXPECT_TRUE(report.identical());
  EXPECT_FALSE(compare(a, b, {"range/radar_tspi"}).identical()) << "3 and 40 plots";
  EXPECT_FALSE(compare(a, b, {"no/such/topic"}).identical()) << "nothing compared is not identical";
}

TEST_F(ArchiveCompare, OneBitOfOneRecordIsFound) {
  Trajectory other = some_trajectory();
  other.state[4] = std::nextafter(other.state[4], 1e9);
  const auto a = write("a", 1, {some_trajectory(), some_trajectory(), some_slaving()});
  const auto b = write("b", 1, {some_trajectory(), other, some_slaving()});
  for (const TopicComparison& topic : compare(a, b).topics) {
    if (topic.topic != "downrange/trajectory") {
      EXPECT_FALSE(topic.first) << topic.topic;
      continue;
    }
    EXPECT_EQ(topic.count_a, 2u);
    ASSERT_TRUE(topic.first);
    EXPECT_EQ(topic.first->index, 1u);
    EXPECT_EQ(topic.first->log_time, static_cast<std::uint64_t>(other.received.ns));
    EXPECT_NE(topic.first->what.find("payloads"), std::string::npos);
  }
}

TEST_F(ArchiveCompare, MissingRecordsAreFound) {
  const auto a = write("a", 1, {some_slaving(), some_slaving()});
  const auto b = write("b", 1, {some_slaving()});
  const CompareReport report = compare(a, b, {"downrange/slaving"});
  ASSERT_TRUE(report.topics.at(0).first);
  EXPECT_EQ(report.topics[0].first->what, "2 messages and 1");
}

TEST_F(ArchiveCompare, RefusesAFileThatIsCutOff) {
  const auto a = write("a", 1, {some_slaving()});
  const auto b = write("b", 1, {some_slaving()});
  std::filesystem::resize_file(b, std::filesystem::file_size(b) - 20);
  EXPECT_THROW(static_cast<void>(compare(a, b)), ArchiveError);
}

}  // namespace
}  // namespace downrange::archive
