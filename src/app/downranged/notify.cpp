#include "notify.hpp"

#include <systemd/sd-daemon.h>
#include <time.h>

#include <chrono>

namespace downrange::app {

void notify_ready(const std::string& status) { sd_notify(0, ("READY=1\nSTATUS=" + status).c_str()); }

void notify_reloading() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  const auto us = static_cast<long long>(now.tv_sec) * 1'000'000 + now.tv_nsec / 1000;
  sd_notifyf(0, "RELOADING=1\nMONOTONIC_USEC=%lld", us);
}

void notify_stopping() { sd_notify(0, "STOPPING=1"); }

Watchdog::Watchdog(const std::atomic<std::uint64_t>& progress) : progress_(progress) {
  std::uint64_t limit_us = 0;
  // A third of the limit: one lost beat does not matter.
  if (sd_watchdog_enabled(0, &limit_us) > 0) thread_ = std::thread([this, limit_us] { run(limit_us / 3); });
}

Watchdog::~Watchdog() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  stopped_.notify_one();
  if (thread_.joinable()) thread_.join();
}

void Watchdog::run(std::uint64_t interval_us) {
  std::uint64_t seen = progress_.load();
  std::unique_lock lock(mutex_);
  while (!stopped_.wait_for(lock, std::chrono::microseconds(interval_us), [this] { return stop_; })) {
    const std::uint64_t now = progress_.load();
    if (now != seen) sd_notify(0, "WATCHDOG=1");
    seen = now;
  }
}

}  // namespace downrange::app
