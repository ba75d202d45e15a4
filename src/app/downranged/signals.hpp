#pragma once
/// The process's signals, blocked in every thread and waited for in one place. No signal handlers.

#include <pthread.h>

#include <csignal>

namespace downrange::app {

enum class Wake { Stop, Reload, ServiceFailed };

class Signals {
 public:
  /// To be made before any thread. Blocks SIGINT, SIGTERM, SIGHUP; and SIGPIPE and SIGXFSZ, so that a closed pipe or a
  /// file-size limit is an error of the write, not the end of the service.
  Signals();

  /// The next thing the main thread has to do.
  [[nodiscard]] Wake wait() const;
  /// Wakes wait() with ServiceFailed, from any thread.
  void service_failed() const;

 private:
  sigset_t awaited_;
  pthread_t main_thread_;
};

}  // namespace downrange::app
