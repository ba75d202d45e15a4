/// The service's own parts at their limits.

#include <gtest/gtest.h>

#include <cstdlib>

#include "app/downranged/event_queue.hpp"
#include "app/downranged/latency.hpp"
#include "app/downranged/notify.hpp"

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
  for (const auto& event : {plot("b", 1), plot("a", 1), plot("x", 1), plot("b", 2), plot("a", 2)}) queue.push(event);
  EXPECT_EQ(queue.depth(), 5u);
  EXPECT_EQ(drain(queue), "b1 a1 x1 b2 a2 ");
  EXPECT_EQ(queue.depth(), 0u);
}

TEST(Queue, AFloodPushesOutItsOwnOldestOnly) {
  EventQueue queue({"a", "b"}, 16);
  queue.push(plot("b", 1));
  for (std::uint64_t n = 1; n <= 20; ++n) queue.push(plot("a", n));
  EXPECT_EQ(queue.dropped(), 4u);
  EXPECT_EQ(queue.depth(), 17u);
  EXPECT_TRUE(drain(queue).starts_with("b1 a5 a6 "));
}

TEST(Queue, StrangersShareOneRing) {
  EventQueue queue({"a"}, 16);
  for (std::uint64_t n = 1; n <= 100; ++n) queue.push(plot(("stranger" + std::to_string(n)).c_str(), n));
  EXPECT_EQ(queue.depth(), 16u);
  EXPECT_EQ(queue.dropped(), 84u);
}

TEST(Queue, CloseEndsAWait) {
  EventQueue queue({"a"}, 16);
  std::thread waiter([&] { queue.wait(std::chrono::hours(1)); });
  queue.close();
  waiter.join();
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
