#pragma once
/// Monte Carlo runs on several threads whose result does not depend on how many.

#include <algorithm>
#include <atomic>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace downrange::experiment {

/// run(0), ..., run(count - 1), each on one of `jobs` threads; results in the order of the index. A run draws all its
/// random numbers from its own index, and whoever sums up does so over the returned vector: then nothing depends on
/// the threads. The first exception of a run is thrown again here. `progress` gets the fraction done.
template <class Result>
std::vector<Result> parallel_runs(int count, int jobs, const std::function<Result(int)>& run,
                                  const std::function<void(double)>& progress) {
  std::vector<Result> results(static_cast<std::size_t>(count));
  std::atomic<int> next{0};
  std::mutex mutex;
  int done = 0;
  std::exception_ptr failure;
  const auto work = [&] {
    for (int i = next++; i < count; i = next++) {
      try {
        results[static_cast<std::size_t>(i)] = run(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!failure) failure = std::current_exception();
        next = count;
        return;
      }
      const std::lock_guard lock(mutex);
      progress(static_cast<double>(++done) / count);
    }
  };
  std::vector<std::thread> threads;
  for (int i = 1; i < std::min(jobs, count); ++i) threads.emplace_back(work);
  work();
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
  return results;
}

}  // namespace downrange::experiment
