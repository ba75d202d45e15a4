/// The service on the wall clock: every kind of source over real DDS, UTC that is stepped, a node that was stopped.
/// Domains 60 to 69.

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <map>
#include <mutex>
#include <optional>

#include "app/downranged/flight.hpp"
#include "app/downranged/service.hpp"
#include "dds/inputs.hpp"
#include "dds/outputs.hpp"

#define DOWNRANGED ""
#include "flight_support.hpp"

namespace downrange::app {
namespace {

using test::eventually;

/// The example range with an optical tracker beside its first radar.
config::ServiceConfig range_with_tracker(int domain) {
  const std::string tracker = R"(
[[angle_sensor]]
id = "optical"
latitude_deg = 34.4390
longitude_deg = 127.5105
height_m = 160
sigma_azimuth_deg = 0.003
sigma_elevation_deg = 0.003
)";
  config::ServiceConfig config = config::load_text(test::read_text(test::naro) + tracker, test::naro,
                                                   {{"ingest.expect_simulated", "true", "test"}});
  config.dds.domain = domain;
  config.dds.profiles = test::source_dir / "config/dds-qos.xml";
  return config;
}

/// A site's sensors and an operator's screen.
class Site {
 public:
  Site(const config::ServiceConfig& config, std::function<Time()> utc)
      : utc_(std::move(utc)),
        tracker_(config.range.angle_sensors.at(0)),
        participant_({config.dds.domain, config.dds.profiles, "test-site", dds::ClockMode::Wall}),
        readers_(participant_, selection(),
                 {{},
                  [this](const dds::ServiceStatus& status) {
                    const std::lock_guard lock(mutex_);
                    status_[status.node] = status;
                  },
                  [this](const SourceHealth& health, const Name& node) {
                    const std::lock_guard lock(mutex_);
                    health_[{health.sensor, node}] = health;
                  }}),
        writers_(participant_) {}

  /// One plot of each radar, and the tracker's angles.
  void send() {
    ++sequence_;
    const Time now = utc_();
    for (const std::size_t radar : {0U, 1U}) static_cast<void>(writers_.write(vehicle_.plot(radar, sequence_, now)));
    static_cast<void>(writers_.write(vehicle_.angles(tracker_, sequence_, now)));
  }
  /// Of an operator, given now; its sequence.
  std::uint64_t order(OperatorOrder what, const Name& subject) {
    OperatorCommand command;
    command.operator_id = "kim";
    command.order = what;
    command.subject = subject;
    command.reason = "test";
    command.sequence = ++sequence_;
    command.epoch = utc_();
    command.simulated = true;
    EXPECT_TRUE(writers_.write(command));
    return command.sequence;
  }
  /// None: the node has not answered.
  [[nodiscard]] std::optional<std::string> refusal(const Name& node, std::uint64_t sequence) const {
    for (const dds::Acknowledgement& a : status(node).acknowledgements) {
      if (a.sender == Name("kim") && a.sequence == sequence) return std::string(a.refusal.view());
    }
    return std::nullopt;
  }
  [[nodiscard]] SourceHealth health(const Name& source, const Name& node) const {
    const std::lock_guard lock(mutex_);
    const auto found = health_.find({source, node});
    return found == health_.end() ? SourceHealth{} : found->second;
  }
  [[nodiscard]] dds::ServiceStatus status(const Name& node) const {
    const std::lock_guard lock(mutex_);
    const auto found = status_.find(node);
    return found == status_.end() ? dds::ServiceStatus{} : found->second;
  }
  [[nodiscard]] std::uint64_t accepted(const Name& source, const Name& node) const {
    const std::lock_guard lock(mutex_);
    const auto found = health_.find({source, node});
    return found == health_.end() ? 0 : found->second.count[0];
  }

 private:
  static dds::OutputSelection selection() {
    dds::OutputSelection selection;
    selection.results = false;
    return selection;
  }

  std::function<Time()> utc_;
  AngleSensorConfig tracker_;
  test::Vehicle vehicle_;
  dds::Participant participant_;
  mutable std::mutex mutex_;
  std::map<Name, dds::ServiceStatus> status_;
  std::map<std::pair<Name, Name>, SourceHealth> health_;
  std::uint64_t sequence_ = 0;
  dds::OutputReaders readers_;
  dds::InputWriters writers_;
};

TEST(ServiceOnWallClock, HearsEverySourceAtAnAllInOneNode) {
  config::ServiceConfig config = range_with_tracker(60);
  config.node.id = "whole";
  Site site(config, utc_now);
  Service service(config, [] {});
  for (const Name& source : {Name("optical"), config.range.radars[0].id, config.range.radars[1].id}) {
    EXPECT_TRUE(eventually([&] {
      site.send();
      return site.accepted(source, "whole") > 0;
    })) << source.view();
  }
  EXPECT_EQ(site.status("whole").dropped, 0U);
}

TEST(ServiceOnWallClock, AnOrderIsAnsweredCarriedOutAndHoldsOnWhenUtcIsSteppedBack) {
  config::ServiceConfig config = range_with_tracker(69);
  config.node.id = "whole";
  std::atomic<std::int64_t> offset_ns = 0;
  const auto utc = [&] { return utc_now() + Duration{offset_ns}; };
  Site site(config, utc);
  Service service(
      config, [] {}, utc);
  const Name radar = config.range.radars[0].id;
  ASSERT_TRUE(eventually([&] {
    site.send();
    return site.accepted(radar, "whole") > 0;
  }));
  const std::uint64_t unknown = site.order(OperatorOrder::Inhibit, "nobody");
  const std::uint64_t known = site.order(OperatorOrder::Inhibit, radar);
  ASSERT_TRUE(eventually([&] { return site.refusal("whole", unknown) && site.refusal("whole", known); }));
  EXPECT_EQ(site.refusal("whole", unknown)->find("no source is named 'nobody'"), 0U);
  EXPECT_EQ(site.refusal("whole", known), "");
  const auto inhibited = [&] {
    site.send();
    const SourceHealth health = site.health(radar, "whole");
    return health.why == Disqualification::Inhibited && health.by == Name("kim") &&
           health.count[static_cast<std::size_t>(Reason::Inhibited)] > 0;
  };
  EXPECT_TRUE(eventually(inhibited));
  offset_ns = -3'600'000'000'000;
  ASSERT_TRUE(eventually([&] { return site.status("whole").state.find("UTC back") == 0; }));
  EXPECT_TRUE(eventually([&] {
    const SourceHealth health = site.health(radar, "whole");
    return inhibited() && health.time < utc_now() - seconds(3000);
  })) << "of the flight before the step";
  const std::uint64_t release = site.order(OperatorOrder::Release, radar);
  EXPECT_TRUE(eventually([&] { return site.refusal("whole", release) == ""; }));
  EXPECT_TRUE(eventually([&] {
    site.send();
    return site.accepted(radar, "whole") > 0;
  }));
}

TEST(ServiceOnWallClock, HearsEverySourceAtACentre) {
  config::ServiceConfig ingest = range_with_tracker(61);
  ingest.node.id = "east";
  ingest.node.stages = {.ingest = true, .align = false, .fuse = false, .slave = false};
  config::ServiceConfig centre = range_with_tracker(61);
  centre.node.id = "centre";
  centre.node.stages.ingest = false;
  centre.dds.ingest_nodes = {"east"};
  Site site(centre, utc_now);
  Service east(ingest, [] {});
  Service service(centre, [] {});
  for (const Name& source : {Name("optical"), centre.range.radars[0].id, centre.range.radars[1].id}) {
    EXPECT_TRUE(eventually([&] {
      site.send();
      return site.accepted(source, "centre") > 0;
    })) << source.view();
  }
  EXPECT_EQ(site.status("centre").dropped, 0U);
}

TEST(ServiceOnWallClock, AForwardStepOfUtcIsRecordedAndItsTicksAreNotRun) {
  const test::Folder folder;
  const std::filesystem::path file = folder.path() / "flight.mcap";
  config::ServiceConfig config = range_with_tracker(62);
  config.node.id = "whole";
  config.archive.enabled = true;
  config.archive.directory = file.string();
  std::atomic<std::int64_t> offset_ns = 0;
  const auto utc = [&] { return utc_now() + Duration{offset_ns}; };
  Site site(config, utc);
  Service service(
      config, [] {}, utc);
  const auto consumed_more = [&] {
    const std::uint64_t before = site.status("whole").consumed;
    return eventually([&] {
      site.send();
      return site.status("whole").consumed > before + 20;
    });
  };
  ASSERT_TRUE(consumed_more());
  const Time stepped_at = utc();
  offset_ns = seconds(3600).ns;
  ASSERT_TRUE(consumed_more());
  EXPECT_GT(site.status("whole").last_tick, stepped_at + seconds(3600));
  service.stop();
  EXPECT_FALSE(service.failure());

  archive::Reader reader(file);
  std::vector<ClockGap> gaps;
  while (const auto entry = reader.next()) {
    if (const auto* gap = std::get_if<ClockGap>(&entry->record)) gaps.push_back(*gap);
    const auto* health = std::get_if<SourceHealth>(&entry->record);
    if (health != nullptr) {
      EXPECT_FALSE(health->time > stepped_at + seconds(60) && health->time < stepped_at + seconds(3600));
    }
  }
  EXPECT_EQ(std::ranges::count_if(gaps, [](const ClockGap& g) { return g.epoch - g.received > seconds(3500); }), 1);
  test::replay(file, folder.path() / "replay.mcap");
  EXPECT_TRUE(test::same_bits(file, folder.path() / "replay.mcap"));
}

/// A node whose clock is ahead of its ticks: as after a stop, but for certain.
TEST(ServiceOnWallClock, NeverSendsACommandThatHasExpired) {
  config::ServiceConfig config = range_with_tracker(63);
  dds::Participant participant({config.dds.domain, config.dds.profiles, "node", dds::ClockMode::Wall});
  dds::OutputWriters outputs(participant, {});
  const test::Vehicle vehicle;
  const Time start{1'800'000'000'000'000'000};
  Duration ahead{};
  Time now = start;
  Flight flight(config, outputs, nullptr, [&] { return now + ahead; });
  const auto fly = [&](double s) {
    for (const Time end = now + seconds(s); now < end; now = now + milliseconds(50)) {
      flight.consume([&] {
        RadarTspi plot = vehicle.plot(0, static_cast<std::uint64_t>(now.ns), now);
        plot.received = now;
        return plot;
      }());
      flight.advance(now);
    }
  };
  fly(10);
  EXPECT_EQ(flight.expired(), 0U);
  ahead = seconds(60);
  const std::uint64_t written = outputs.counts().samples;
  const std::uint64_t emitted = flight.emitted();
  fly(1);
  // 40 ticks, each with a command for every antenna.
  EXPECT_EQ(flight.expired(), 40 * config.range.antennas.size());
  EXPECT_EQ(outputs.counts().samples - written, flight.emitted() - emitted - flight.expired());
}

}  // namespace
}  // namespace downrange::app
