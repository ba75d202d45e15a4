#pragma once
/// What the service manager is told (sd_notify); nothing happens where there is none.

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>

namespace downrange::app {

void notify_ready(const std::string& status);
void notify_reloading();
void notify_stopping();

/// Feeds the service manager's watchdog while `progress` keeps rising; a stuck engine is not covered up.
class Watchdog {
 public:
  explicit Watchdog(const std::atomic<std::uint64_t>& progress);
  ~Watchdog();
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

 private:
  void run(std::uint64_t interval_us);

  const std::atomic<std::uint64_t>& progress_;
  std::mutex mutex_;
  std::condition_variable stopped_;
  bool stop_ = false;
  std::thread thread_;  ///< none where no watchdog is asked for
};

}  // namespace downrange::app
