/// The service as the service manager and the operator see it. DDS domains 140 to 149.

#include <gtest/gtest.h>

#include <algorithm>

#include "daemon_process.hpp"

namespace downrange::test {
namespace {

class DaemonProcess : public testing::Test {
 protected:
  [[nodiscard]] std::filesystem::path file(const std::string& name) const { return folder_.path() / name; }

  /// The example range in a folder of its own, one text replaced.
  [[nodiscard]] std::filesystem::path write_config(const std::string& old_text, const std::string& new_text) const {
    std::string text = read_text(naro);
    const std::size_t at = text.find(old_text);
    if (at == std::string::npos) throw std::runtime_error("naro.toml has no " + old_text);
    text.replace(at, old_text.size(), new_text);
    std::ofstream(file("range.toml")) << text;
    std::filesystem::copy_file(source_dir / "config/dds-qos.xml", file("dds-qos.xml"),
                               std::filesystem::copy_options::overwrite_existing);
    return file("range.toml");
  }

  Folder folder_;
};

TEST_F(DaemonProcess, TellsReadyFeedsTheWatchdogAndStopsInOrder) {
  for (const auto& [number, domain] : {std::pair{SIGTERM, "140"}, std::pair{SIGINT, "141"}}) {
    SCOPED_TRACE(domain);
    NotifySocket manager(file(std::string("notify-") + domain));
    Daemon daemon(folder_.path(), {"--config", naro, "--domain", domain},
                  {{{"NOTIFY_SOCKET", manager.path()}, {"WATCHDOG_USEC", "150000"}}, {}});
    EXPECT_TRUE(eventually([&] { return manager.count("READY=1") == 1; })) << daemon.log();
    EXPECT_TRUE(eventually([&] { return manager.count("WATCHDOG=1") >= 3; })) << daemon.log();
    EXPECT_EQ(manager.count("STOPPING=1"), 0);
    daemon.signal(number);
    EXPECT_EQ(daemon.wait(), 0) << daemon.log();
    EXPECT_EQ(manager.count("STOPPING=1"), 1);
    EXPECT_NE(daemon.log().find("stopped"), std::string::npos) << daemon.log();
  }
}

TEST_F(DaemonProcess, WritesJournalPrioritiesUnderJournald) {
  Daemon daemon(folder_.path(), {"--config", naro, "--domain", "142"}, {{{"JOURNAL_STREAM", "8:1"}}, {}});
  EXPECT_TRUE(daemon.logs("<6>downranged ")) << daemon.log();
}

TEST_F(DaemonProcess, BadConfigurationListsEveryProblem) {
  Daemon daemon(folder_.path(), {"--config", source_dir / "tests/fault/config_bad/several_problems.toml"});
  EXPECT_EQ(daemon.wait(), 2);
  const std::string log = daemon.log();
  EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 4) << log;
  EXPECT_NE(log.find("several_problems.toml:26: antenna[0].leed_ms: unknown key, did you mean lead_ms?"),
            std::string::npos)
      << log;
}

TEST_F(DaemonProcess, MissingConfigurationAndWrongOptions) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"--config", "/no/such/range.toml"}, "/no/such/range.toml: no such file"},
      {{}, "--config is required"},
      {{"--config", naro, "--domain", "233"}, "--domain: dds.domain: found 233"},
      {{"--config", naro, "--stages", "ingest,fusion"}, "--stages: node.stages: found"},
      {{"--config", naro, "--sources", "seoul"}, "--sources: node.sources: found \"seoul\""},
      {{"--config", naro, "--set", "fuse.bacth_ms=3"}, "did you mean fuse.batch_ms?"},
      {{"--config", naro, "--verbose"}, "--verbose"},
  };
  for (const auto& [arguments, message] : cases) {
    SCOPED_TRACE(message);
    std::filesystem::remove(file("daemon.log"));
    Daemon daemon(folder_.path(), arguments);
    EXPECT_EQ(daemon.wait(), 2);
    EXPECT_NE(daemon.log().find(message), std::string::npos) << daemon.log();
  }
}

TEST_F(DaemonProcess, VersionAndHelp) {
  for (const char* option : {"--version", "--help"}) {
    Daemon daemon(folder_.path(), {option});
    EXPECT_EQ(daemon.wait(), 0);
    EXPECT_NE(daemon.log().find("downranged"), std::string::npos);
  }
}

TEST_F(DaemonProcess, ArchiveFolderThatCannotBeWritten) {
  std::ofstream(file("in-the-way")) << "a file, not a folder";
  Daemon daemon(folder_.path(), {"--config", naro, "--domain", "143", "--archive", file("in-the-way/flights")});
  EXPECT_EQ(daemon.wait(), 1);
  EXPECT_NE(daemon.log().find("archives cannot be written to " + file("in-the-way/flights").string()),
            std::string::npos)
      << daemon.log();
}

TEST_F(DaemonProcess, LogFileThatCannotBeWritten) {
  Daemon daemon(folder_.path(), {"--config", naro, "--domain", "144", "--set", "log.file=/proc/no/such.log"});
  EXPECT_EQ(daemon.wait(), 1);
  EXPECT_NE(daemon.log().find("log.file"), std::string::npos) << daemon.log();
}

TEST_F(DaemonProcess, ProfilesThatAreNoProfiles) {
  const std::filesystem::path config = write_config("profiles = \"dds-qos.xml\"", "profiles = \"broken.xml\"");
  std::ofstream(file("broken.xml")) << "<profiles><participant";
  Daemon daemon(folder_.path(), {"--config", config, "--domain", "145"});
  EXPECT_EQ(daemon.wait(), 1);
  EXPECT_NE(daemon.log().find("broken.xml"), std::string::npos) << daemon.log();
}

TEST_F(DaemonProcess, DomainThatCannotBeOpened) {
  // Too few file descriptors for the sockets of a participant. How many are too few depends on the machine's
  // interfaces.
  int refused = 0;
  for (rlim_t descriptors = 4; descriptors <= 9; ++descriptors) {
    const std::filesystem::path folder = folder_.path() / std::to_string(descriptors);
    std::filesystem::create_directory(folder);
    Daemon daemon(folder, {"--config", naro, "--domain", "146"}, {{}, std::pair{RLIMIT_NOFILE, descriptors}});
    // It ends by itself with a message, or it runs; then it ends in order.
    ASSERT_TRUE(eventually([&] { return !daemon.running() || daemon.log().find(" info ") != std::string::npos; }));
    if (daemon.running()) daemon.signal(SIGTERM);
    const std::optional<int> code = daemon.wait();
    ASSERT_TRUE(code.has_value()) << daemon.log();
    if (*code == 0) continue;
    ++refused;
    EXPECT_NE(daemon.log().find("downranged: "), std::string::npos) << daemon.log();
  }
  EXPECT_GT(refused, 0);
}

TEST_F(DaemonProcess, ReloadTakesTheLogLevelAndNamesTheRest) {
  const std::filesystem::path config = write_config("level = \"info\"", "level = \"info\"");
  NotifySocket manager(file("notify"));
  Daemon daemon(folder_.path(), {"--config", config, "--domain", "147"}, {{{"NOTIFY_SOCKET", manager.path()}}, {}});
  ASSERT_TRUE(eventually([&] { return manager.count("READY=1") == 1; })) << daemon.log();

  static_cast<void>(write_config("coast_sigma_max_m = 5000", "coast_sigma_max_m = 6000"));
  daemon.signal(SIGHUP);
  EXPECT_TRUE(daemon.logs("reload: slave.coast_sigma_max_m changes only with a restart")) << daemon.log();
  EXPECT_TRUE(daemon.logs("reload: done, 1 changed keys need a restart")) << daemon.log();

  static_cast<void>(write_config("coast_sigma_max_m = 5000", "coast_sigma_max_m = \"long\""));
  daemon.signal(SIGHUP);
  EXPECT_TRUE(daemon.logs("slave.coast_sigma_max_m: found \"long\" (text)")) << daemon.log();
  EXPECT_TRUE(daemon.logs("reload: refused")) << daemon.log();
  EXPECT_TRUE(eventually([&] { return manager.count("READY=1") == 3; })) << daemon.log();

  static_cast<void>(write_config("level = \"info\"", "level = \"error\""));
  daemon.signal(SIGHUP);
  EXPECT_TRUE(eventually([&] { return manager.count("READY=1") == 4; })) << daemon.log();
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(), 0);
  EXPECT_EQ(daemon.log().find(" stopped"), std::string::npos) << "an info after the level went up:\n" << daemon.log();
}

}  // namespace
}  // namespace downrange::test
