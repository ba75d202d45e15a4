/// What runs on several threads, apart from what they do: small enough for CI to build it under the thread sanitizer.
#include <gtest/gtest.h>

#include <archive/file_thread.hpp>
#include <atomic>
#include <filesystem>
#include <stdexcept>
#include <thread>
#include <vector>

#include "experiment/parallel.hpp"

namespace downrange {
namespace {

using experiment::parallel_runs;

TEST(ParallelRuns, ResultsStandInOrderOnAnyNumberOfThreads) {
  const auto square = [](int i) { return i * i; };
  for (const int jobs : {1, 3, 50}) {
    double last = 0;
    const std::vector<int> results = parallel_runs<int>(40, jobs, square, [&last](double done) {
      EXPECT_GT(done, last);
      last = done;
    });
    ASSERT_EQ(results.size(), 40u);
    for (int i = 0; i < 40; ++i) EXPECT_EQ(results[static_cast<std::size_t>(i)], i * i);
    EXPECT_EQ(last, 1);
  }
}

TEST(ParallelRuns, ARunThatThrowsEndsTheOthers) {
  std::atomic<int> ran{0};
  const auto run = [&ran](int i) -> int {
    if (i == 3) throw std::runtime_error("run 3");
    ++ran;
    return i;
  };
  for (const int jobs : {1, 3}) {
    ran = 0;
    EXPECT_THROW((void)parallel_runs<int>(10'000, jobs, run, [](double) {}), std::runtime_error);
    EXPECT_LT(ran, 10'000);
  }
}

/// Several writers, one that asks how far the file is, and a queue that is too short for them.
TEST(FileThread, CountsEveryMessageWhoeverSubmitsIt) {
  using namespace archive;
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "threads_test.mcap";
  constexpr std::uint64_t writers = 3;
  constexpr std::uint64_t blocks = 200;
  std::atomic<std::uint64_t> accepted{0};
  std::atomic<bool> done{false};
  WriterStatus end;
  {
    FileThread file(path, {.compression = Compression::None, .queue_chunks = 2, .overwrite = true});
    std::thread watcher([&] {
      while (!done) {
        const WriterStatus now = file.status();
        EXPECT_LE(now.messages_written, writers * blocks);
        EXPECT_TRUE(file.in_place());
        EXPECT_FALSE(file.failed());
      }
    });
    std::vector<std::thread> threads;
    threads.reserve(writers);
    for (std::uint64_t w = 0; w < writers; ++w) {
      threads.emplace_back([&, wait = w == 0] {
        for (std::uint64_t i = 0; i < blocks; ++i) {
          Bytes bytes = file.spare_buffer();
          bytes.assign(100, 7);
          if (file.submit({.op = Op::Schema, .bytes = std::move(bytes), .messages = 1}, wait)) ++accepted;
        }
      });
    }
    for (std::thread& thread : threads) thread.join();
    done = true;
    watcher.join();
    file.finish();
    end = file.status();
  }
  EXPECT_GE(accepted, blocks) << "of the one that waits all";
  EXPECT_EQ(end.messages_written, accepted);
  EXPECT_EQ(end.messages_written + end.messages_lost, writers * blocks);
  EXPECT_EQ(end.chunks_waiting, 0u);
  EXPECT_EQ(std::filesystem::file_size(path), end.bytes_written);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace downrange
