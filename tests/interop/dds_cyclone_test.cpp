/// A consumer written with another vendor's DDS follows the slaving commands. Domain 40.

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <thread>

#include "child_process.hpp"
#include "dds/entities.hpp"
#include "dds/outputs.hpp"
#include "dds_samples.hpp"

namespace downrange::dds {
namespace {

constexpr int domain = 40;

std::int64_t utc_now_ns() {
  return std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count();
}

std::string expected_line(const char* verdict, const SlavingCommand& command) {
  char line[256];
  std::snprintf(line, sizeof line,
                "%s %s azimuth_rad %.17g elevation_rad %.17g range_m %.17g source %d apply_at_ns %lld", verdict,
                command.target.c_str(), command.azimuth_rad, command.elevation_rad, command.range_m,
                static_cast<int>(command.source), static_cast<long long>(command.apply_at.ns));
  return line;
}

TEST(DdsCyclone, AnotherVendorsClientReadsEveryFieldOfItsAntenna) {
  Participant service(test_participant(domain, "service", ClockMode::Wall));
  OutputWriters writers(service, {});
  // Multicast may be missing in a sandbox: the client looks on this machine by unicast too.
  ChildProcess client({CYCLONE_CLIENT, std::to_string(domain), "jeju-antenna", "3", "60"},
                      {"CYCLONEDDS_URI=<Discovery><ParticipantIndex>auto</ParticipantIndex><Peers>"
                       "<Peer address=\"127.0.0.1\"/></Peers></Discovery>"});
  ASSERT_TRUE(wait_until(std::chrono::seconds(30), [&] { return writers.slaving_readers() == 1; }));

  // Its reader begins with what is written after it has met the writer: commands go out until it has its three.
  std::vector<std::string> sent;
  std::atomic<bool> done = false;
  std::thread commanding([&] {
    SlavingCommand command = sample_command("jeju-antenna");
    command.azimuth_rad = -4.123456789012345;
    command.source = SlavingSource::Coasting;
    for (int i = 0; !done; ++i) {
      const bool expired = i % 3 == 0;
      command.apply_at.ns = utc_now_ns();
      command.valid_until.ns = command.apply_at.ns + (expired ? -1 : 60'000'000'000);
      command.elevation_rad = 0.1 * i;
      sent.push_back(expected_line(expired ? "expired" : "follow", command));
      writers.emit(sample_command("another-antenna"));
      writers.emit(command);
      std::this_thread::sleep_for(std::chrono::milliseconds(25));
    }
  });
  const std::vector<std::string> lines = client.lines();
  done = true;
  commanding.join();
  EXPECT_EQ(client.wait(), 0);
  ASSERT_GE(lines.size(), 3U);
  EXPECT_NE(std::search(sent.begin(), sent.end(), lines.begin(), lines.end()), sent.end())
      << "the commands one after the other, as they were sent; first line: " << lines[0];
  EXPECT_EQ(writers.counts().incompatible, 0U);
}

}  // namespace
}  // namespace downrange::dds
