/// The service in flight, when things go wrong around it. DDS domains 150 to 159.

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>

#include "config/load.hpp"
#include "daemon_process.hpp"
#include "dds/inputs.hpp"
#include "dds/outputs.hpp"
#include "dds/range_clock.hpp"
#include "flight_support.hpp"

namespace downrange::test {
namespace {

using namespace std::chrono_literals;

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
    selection.results = selection.health = false;
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

TEST(DaemonFlight, AnArchiveThatIsTakenAwayGoesOnInANewFile) {
  const Folder folder;
  const std::filesystem::path archives = folder.path() / "archives";
  Site site(158);
  Daemon daemon(folder.path(), arguments(158, archives / "flight.mcap"));
  {
    const Feeder feeder(site.participant());
    ASSERT_TRUE(eventually([&] { return site.status().consumed > 100; })) << daemon.log();
    std::filesystem::remove(archives / "flight.mcap");
    EXPECT_TRUE(eventually([&] { return site.status().archive_state == "recording anew: file removed"; }));
    EXPECT_TRUE(daemon.logs("recording goes on in " + (archives / "flight-2.mcap").string())) << daemon.log();
    std::filesystem::remove_all(archives);
    EXPECT_TRUE(eventually([&] { return std::filesystem::exists(archives); })) << daemon.log();
    const std::uint64_t consumed = site.status().consumed;
    ASSERT_TRUE(eventually([&] { return site.status().consumed > consumed + 100; })) << daemon.log();
  }
  daemon.signal(SIGTERM);
  ASSERT_EQ(daemon.wait(), 0) << daemon.log();
  EXPECT_GT(events_in(archives / "flight-2.mcap"), 50U);
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
