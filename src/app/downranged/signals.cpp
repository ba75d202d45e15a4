#include "signals.hpp"

#include <initializer_list>

namespace downrange::app {
namespace {

constexpr int failure_signal = SIGUSR1;

}  // namespace

Signals::Signals() : main_thread_(pthread_self()) {
  sigemptyset(&awaited_);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, failure_signal}) sigaddset(&awaited_, signal);
  sigset_t blocked = awaited_;
  for (const int signal : {SIGPIPE, SIGXFSZ}) sigaddset(&blocked, signal);
  pthread_sigmask(SIG_BLOCK, &blocked, nullptr);
}

Wake Signals::wait() const {
  int signal = 0;
  sigwait(&awaited_, &signal);
  if (signal == SIGHUP) return Wake::Reload;
  return signal == failure_signal ? Wake::ServiceFailed : Wake::Stop;
}

void Signals::service_failed() const { pthread_kill(main_thread_, failure_signal); }

}  // namespace downrange::app
