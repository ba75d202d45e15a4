/// The service in flight, when things go wrong around it. DDS domains 150 to 159.

#include <gtest/gtest.h>
#include <time.h>

#include <algorithm>
#include <archive/compare.hpp>
#include <archive/replay.hpp>
#include <archive/writer.hpp>
#include <atomic>
#include <downrange/stage/engine.hpp>
#include <memory>
#include <mutex>
#include <numbers>

#include "config/load.hpp"
#include "daemon_process.hpp"
#include "dds/inputs.hpp"
#include "dds/outputs.hpp"
#include "dds/range_clock.hpp"

namespace downrange::test {
namespace {

using namespace std::chrono_literals;

Time utc_now() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return {static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec};
}

/// A vehicle above the sea south of the pad, and what the example range's sensors see of it. No noise: the figures are
/// not the point here.
class Vehicle {
 public:
  [[nodiscard]] RadarTspi plot(std::size_t radar, std::uint64_t sequence, Time epoch) const {
    const RadarConfig& config = range_.radars[radar];
    RadarTspi tspi;
    tspi.sensor = config.id;
    tspi.target = "kslv";
    tspi.sequence = sequence;
    tspi.epoch = epoch;
    tspi.measured = polar_from_enu(config.site.enu_of(at(epoch)));
    tspi.simulated = true;
    return tspi;
  }
  [[nodiscard]] GpsFix fix(std::uint64_t sequence, Time epoch) const {
    GpsFix fix;
    fix.target = "kslv";
    fix.station = "jeju-tgs";
    fix.sequence = sequence;
    fix.epoch = epoch;
    fix.position = at(epoch);
    fix.simulated = true;
    return fix;
  }

 private:
  [[nodiscard]] static Position<Ecef> at(Time t) {
    const double degree = std::numbers::pi / 180;
    const double s = static_cast<double>(t.ns % 1'000'000'000'000) * 1e-9;
    return ecef_from_geodetic({(33 - 0.001 * s) * degree, 127.5 * degree, 80e3 + 10 * s});
  }

  RangeConfig range_ = config::load(naro).range;
};

std::vector<std::string> arguments(int domain, const std::filesystem::path& archive) {
  return {"--config",  naro,   "--domain", std::to_string(domain), "--set", "ingest.expect_simulated=true",
          "--archive", archive};
}

/// A radar site and an operator's screen in one: feeds the service, reads its status.
class Site {
 public:
  explicit Site(int domain, dds::ClockMode clock = dds::ClockMode::Wall)
      : participant_({domain, source_dir / "config/dds-qos.xml", "test-site", clock}),
        readers_(participant_, selection(), {{}, [this](const dds::ServiceStatus& status) { keep(status); }}) {}

  [[nodiscard]] dds::Participant& participant() { return participant_; }
  [[nodiscard]] dds::ServiceStatus status() const {
    const std::lock_guard lock(mutex_);
    return status_;
  }

 private:
  static dds::OutputSelection selection() {
    dds::OutputSelection selection;
    selection.bias = selection.trajectory = selection.slaving = selection.health = false;
    return selection;
  }
  void keep(const dds::ServiceStatus& status) {
    const std::lock_guard lock(mutex_);
    status_ = status;
  }

  dds::Participant participant_;
  mutable std::mutex mutex_;
  dds::ServiceStatus status_;
  dds::OutputReaders readers_;
};

/// Plots at 100 Hz until told to stop.
class Feeder {
 public:
  explicit Feeder(dds::Participant& participant) : writers_(participant), thread_([this] { run(); }) {}
  ~Feeder() {
    stop_ = true;
    thread_.join();
  }
  Feeder(const Feeder&) = delete;
  Feeder& operator=(const Feeder&) = delete;

 private:
  void run() {
    for (std::uint64_t n = 1; !stop_; ++n) {
      static_cast<void>(writers_.write(vehicle_.plot(n % 2, n, utc_now())));
      if (n % 50 == 0) static_cast<void>(writers_.write(vehicle_.fix(n, utc_now())));
      std::this_thread::sleep_for(10ms);
    }
  }

  Vehicle vehicle_;
  std::atomic<bool> stop_ = false;
  dds::InputWriters writers_;
  std::thread thread_;
};

/// A flight of 30 s on the range clock: two radars at 20 Hz, GPS at 1 Hz half a second late.
void fly(dds::Participant& participant, const std::vector<Name>& nodes) {
  const Vehicle vehicle;
  dds::DriverOptions options;
  options.nodes = nodes;
  dds::RangeClockDriver driver(participant, options);
  driver.wait_for_nodes(patience);
  const Time start{1'800'000'000'000'000'000};
  for (std::uint64_t i = 0; i < 600; ++i) {
    const Time t = start + milliseconds(static_cast<std::int64_t>(50 * i));
    std::vector<Event> events;
    for (const std::size_t radar : {0u, 1u}) events.emplace_back(vehicle.plot(radar, i, t - milliseconds(20)));
    if (i % 20 == 10) events.emplace_back(vehicle.fix(i, t - milliseconds(500)));
    driver.step(t, events);
  }
  driver.finish();
}
constexpr std::uint64_t flight_events = 600 * 2 + 30;

/// An archive's events once more through an engine in this process, with the configuration attached to it.
void replay(const std::filesystem::path& from, const std::filesystem::path& to) {
  struct Recording final : ResultSink {
    explicit Recording(const std::filesystem::path& file) : writer(file) {}
    void emit(const Result& result) override { writer.write(result); }
    archive::Writer writer;
  } recording(to);
  const auto config = config::load_text(archive::read_attachment(from, "config.toml").value_or(""), "config.toml");
  Engine engine(config.range, config.node.stages, recording);
  archive::EventSource source(from);
  while (const auto event = source.next()) {
    recording.writer.write(*event);
    engine.handle(*event);
  }
  engine.advance_to(source.last_tick().value());
  ASSERT_TRUE(recording.writer.close().ok());
}

/// Whether two archives hold the same bits on each of the topics, and on none of them nothing.
testing::AssertionResult same_bits(const std::filesystem::path& a, const std::filesystem::path& b,
                                   const std::vector<std::string>& topics = {}) {
  const archive::CompareReport report = archive::compare(a, b, topics);
  const bool empty = std::ranges::any_of(report.topics, [](const auto& topic) { return topic.count_a == 0; });
  if (report.identical() && !empty) return testing::AssertionSuccess();
  auto failure = testing::AssertionFailure();
  for (const auto& t : report.topics) {
    failure << t.topic << ": " << t.count_a << " and " << t.count_b << " messages";
    if (t.first) failure << ", first difference at " << t.first->index << ": " << t.first->what;
    failure << '\n';
  }
  return failure;
}

std::uint64_t events_in(const std::filesystem::path& file) {
  archive::EventSource source(file);
  std::uint64_t events = 0;
  while (source.next()) ++events;
  return events;
}

TEST(DaemonFlight, KilledServiceLeavesAReadableArchive) {
  const Folder folder;
  const std::filesystem::path file = folder.path() / "flight.mcap";
  Site site(150);
  Daemon daemon(folder.path(), arguments(150, file));
  {
    const Feeder feeder(site.participant());
    // One second of log time closes a chunk.
    ASSERT_TRUE(eventually([&] { return site.status().consumed > 250; })) << daemon.log();
    EXPECT_EQ(site.status().archive_state, "recording");
    daemon.signal(SIGKILL);
    EXPECT_EQ(daemon.wait(), -SIGKILL);
  }
  EXPECT_GT(events_in(file), 50u);
  EXPECT_NE(archive::read_attachment(file, "config.toml").value_or("").find("[align]"), std::string::npos);
}

TEST(DaemonFlight, StoppedServiceLeavesACompleteArchive) {
  const Folder folder;
  const std::filesystem::path file = folder.path() / "flight.mcap";
  Site site(151);
  Daemon daemon(folder.path(), arguments(151, file));
  {
    const Feeder feeder(site.participant());
    ASSERT_TRUE(eventually([&] { return site.status().consumed > 250; })) << daemon.log();
  }
  daemon.signal(SIGTERM);
  ASSERT_EQ(daemon.wait(), 0) << daemon.log();
  archive::EventSource source(file);
  std::uint64_t events = 0;
  while (source.next()) ++events;
  EXPECT_GE(events, 250u);
  EXPECT_FALSE(source.truncated().has_value());
  EXPECT_TRUE(source.last_tick().has_value());

  // The configuration in force, options included, loads again from the archive.
  const auto config = config::load_text(archive::read_attachment(file, "config.toml").value_or(""), "config.toml");
  EXPECT_TRUE(config.range.ingest.expect_simulated);
  EXPECT_EQ(config.dds.domain, 151);

  // What was live is reproduced: ticks, late events and all.
  replay(file, folder.path() / "replay.mcap");
  EXPECT_TRUE(same_bits(file, folder.path() / "replay.mcap"));
}

TEST(DaemonFlight, FullDiskEndsTheArchiveNotTheTracking) {
  const Folder folder;
  Site site(152);
  std::vector<std::string> words = arguments(152, folder.path() / "flight.mcap");
  words.insert(words.end(), {"--set", "archive.compression=none"});
  // Files end at 64 kB, the log included: a write beyond it fails, as on a full disk.
  Daemon daemon(folder.path(), words, {{}, std::pair{RLIMIT_FSIZE, rlim_t{65536}}});
  const Feeder feeder(site.participant());
  ASSERT_TRUE(eventually([&] { return site.status().archive_state == "failed"; })) << daemon.log();
  const std::uint64_t consumed = site.status().consumed;
  EXPECT_TRUE(eventually([&] { return site.status().consumed > consumed + 100; })) << daemon.log();
  EXPECT_TRUE(daemon.logs("archive failed, tracking goes on without it"));
  EXPECT_TRUE(daemon.running());
}

TEST(DaemonFlight, RangeClockFlightsEachHaveTheirArchiveWithTheSameBits) {
  const Folder folder;
  Site site(153, dds::ClockMode::Range);
  std::vector<std::string> words = arguments(153, folder.path() / "flight.mcap");
  words.insert(words.end(), {"--clock", "range", "--node", "centre"});
  Daemon daemon(folder.path(), words);
  fly(site.participant(), {"centre"});
  EXPECT_EQ(events_in(folder.path() / "flight.mcap"), flight_events);
  fly(site.participant(), {"centre"});
  EXPECT_TRUE(same_bits(folder.path() / "flight.mcap", folder.path() / "flight-2.mcap"));
  replay(folder.path() / "flight.mcap", folder.path() / "replay.mcap");
  EXPECT_TRUE(same_bits(folder.path() / "flight.mcap", folder.path() / "replay.mcap"));
  EXPECT_EQ(daemon.log().find(" error "), std::string::npos) << daemon.log();
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(), 0) << daemon.log();
}

TEST(DaemonFlight, RunWhoseArchiveCannotBeOpenedIsFlownWithoutOne) {
  const Folder folder;
  const std::filesystem::path archives = folder.path() / "archives";
  Site site(157, dds::ClockMode::Range);
  std::vector<std::string> words = arguments(157, archives / "flight.mcap");
  words.insert(words.end(), {"--clock", "range", "--node", "centre"});
  Daemon daemon(folder.path(), words);
  fly(site.participant(), {"centre"});
  std::filesystem::remove_all(archives);
  fly(site.participant(), {"centre"});
  EXPECT_TRUE(daemon.logs("archive cannot be opened, tracking goes on without it")) << daemon.log();
  EXPECT_TRUE(eventually([&] { return site.status().consumed == 2 * flight_events; })) << daemon.log();
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(), 0) << daemon.log();
}

TEST(DaemonFlight, SplitOverProcessesGivesTheBitsOfOneProcess) {
  const Folder folder;
  const auto file = [&](const std::string& name) { return folder.path() / (name + ".mcap"); };
  const auto start = [&](const std::string& node, int domain, const std::vector<std::string>& more) {
    std::vector<std::string> words = arguments(domain, file(node));
    words.insert(words.end(), {"--clock", "range", "--node", node});
    words.insert(words.end(), more.begin(), more.end());
    return std::make_unique<Daemon>(folder.path(), words);
  };
  {
    Site site(154, dds::ClockMode::Range);
    const auto whole = start("whole", 154, {});
    fly(site.participant(), {"whole"});
  }
  {
    Site site(155, dds::ClockMode::Range);
    const auto east = start("east", 155, {"--stages", "ingest", "--sources", "goheung,goheung-tgs"});
    const auto south = start("south", 155, {"--stages", "ingest", "--sources", "jeju,jeju-tgs,ship-tgs"});
    const auto centre =
        start("centre", 155, {"--stages", "align,fuse,slave", "--set", R"(dds.ingest_nodes=["east", "south"])"});
    fly(site.participant(), {"east", "south", "centre"});
  }
  EXPECT_EQ(events_in(file("east")), 600u);
  EXPECT_EQ(events_in(file("south")), 630u);
  EXPECT_EQ(events_in(file("centre")), flight_events);
  EXPECT_TRUE(same_bits(file("whole"), file("centre"),
                        {"downrange/bias", "downrange/trajectory", "downrange/slaving", "downrange/health"}));
}

}  // namespace
}  // namespace downrange::test
