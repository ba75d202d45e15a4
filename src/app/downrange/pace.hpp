#pragma once
/// Flight time against the wall clock, and orderly ends by signal.

#include <chrono>
#include <csignal>
#include <downrange/geo/time.hpp>
#include <thread>

namespace downrange::app {

/// Holds a flight back to `rate` seconds of flight per second; rate 0: full speed.
class Pace {
 public:
  explicit Pace(double rate) : rate_(rate) {}

  void wait_until(Time t) {
    if (rate_ == 0) return;
    if (!running_) {
      running_ = true;
      first_ = t;
      started_ = std::chrono::steady_clock::now();
    }
    std::this_thread::sleep_until(
        started_ + std::chrono::nanoseconds(static_cast<std::int64_t>(static_cast<double>((t - first_).ns) / rate_)));
  }

 private:
  double rate_;
  bool running_ = false;
  Time first_;
  std::chrono::steady_clock::time_point started_;
};

/// SIGINT and SIGTERM are blocked (before any thread is made) and waited for: a command that runs until it is told to
/// stop closes its files like any other.
class StopSignal {
 public:
  StopSignal() {
    sigemptyset(&set_);
    sigaddset(&set_, SIGINT);
    sigaddset(&set_, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &set_, nullptr);
  }

  /// Whether the signal came within `timeout`.
  [[nodiscard]] bool wait_for(std::chrono::milliseconds timeout) const {
    const timespec spec{.tv_sec = timeout.count() / 1000, .tv_nsec = timeout.count() % 1000 * 1'000'000};
    return sigtimedwait(&set_, nullptr, &spec) > 0;
  }

 private:
  sigset_t set_{};
};

}  // namespace downrange::app
