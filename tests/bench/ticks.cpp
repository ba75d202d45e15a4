/// Is every tick met? Reads the commands and the status of a service on the wall clock as an antenna in another process
/// does, for some seconds. tools/bench load runs it beside the service and its simulated radars.
///
///   downrange_ticks DOMAIN PROFILES SECONDS TICK_MS
///
/// Each antenna that has commands should have one of each tick, before the next tick. Exit status 1: not so, or inputs
/// were dropped.

#include <downrangePubSubTypes.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "reader.hpp"

namespace {

using namespace downrange::bench;
using downrange::wire::ServiceStatusV4;
using downrange::wire::SlavingCommandV4;

class Ticks {
 public:
  explicit Ticks(Ns tick_ns) : tick_ns_(tick_ns) {}

  void command(const SlavingCommandV4& command, Ns, Ns here) {
    const std::lock_guard lock(mutex_);
    ticks_[command.antenna_id().to_string()].insert(command.tick_ns());
    after_tick_.push_back(here - command.tick_ns());
  }
  void status(const ServiceStatusV4& status, Ns, Ns) {
    const std::lock_guard lock(mutex_);
    if (statuses_ == 0) first_ = status;
    last_ = status;
    ++statuses_;
    most_waiting_ = std::max<unsigned>(most_waiting_, status.queue_depth());
    most_behind_ = std::max<Ns>(most_behind_, status.time_ns() - status.last_tick_ns());
  }

  [[nodiscard]] int report() const;

 private:
  const Ns tick_ns_;
  mutable std::mutex mutex_;
  std::map<std::string, std::set<Ns>> ticks_;  ///< by antenna
  std::vector<Ns> after_tick_;
  ServiceStatusV4 first_;
  ServiceStatusV4 last_;
  int statuses_ = 0;
  unsigned most_waiting_ = 0;
  Ns most_behind_ = 0;
};

int Ticks::report() const {
  const std::lock_guard lock(mutex_);
  if (after_tick_.empty() || statuses_ < 2) {
    std::fprintf(stderr, "no commands, or no status\n");
    return 1;
  }
  Ns missing = 0;
  Ns ticks = 0;
  for (const auto& [antenna, seen] : ticks_) {
    const Ns due = (*seen.rbegin() - *seen.begin()) / tick_ns_ + 1;
    ticks += due;
    missing += due - static_cast<Ns>(seen.size());
  }
  std::vector<Ns> sorted = after_tick_;
  std::sort(sorted.begin(), sorted.end());
  const auto late = std::count_if(sorted.begin(), sorted.end(), [this](Ns ns) { return ns >= tick_ns_; });
  const auto at = [&](double share) {
    return static_cast<double>(sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))]) * 1e-6;
  };
  const double seconds = static_cast<double>(last_.time_ns() - first_.time_ns()) * 1e-9;
  const auto per_s = [&](auto member) { return static_cast<double>((last_.*member)() - (first_.*member)()) / seconds; };
  using Counter = std::uint64_t (ServiceStatusV4::*)() const;
  const auto dropped = last_.dropped() - first_.dropped();
  std::printf("inputs %.0f /s, results %.0f /s\n", per_s(static_cast<Counter>(&ServiceStatusV4::consumed)),
              per_s(static_cast<Counter>(&ServiceStatusV4::emitted)));
  std::printf("ticks of %zu antennas: %lld, without a command: %lld, later than the next tick: %lld\n", ticks_.size(),
              ticks, missing, static_cast<Ns>(late));
  std::printf("tick -> command read: p50 %.2f ms, p99 %.2f, p99.9 %.2f, most %.2f (a tick: %.0f)\n", at(0.5), at(0.99),
              at(0.999), at(1), static_cast<double>(tick_ns_) * 1e-6);
  std::printf(
      "received -> result written: p50 %.0f us, p99 %.0f; inputs waiting at a status: %u at most; last tick %.0f "
      "ms old at most; dropped: %llu\n",
      last_.latency_p50_us(), last_.latency_p99_us(), most_waiting_, static_cast<double>(most_behind_) * 1e-6,
      static_cast<unsigned long long>(dropped));
  return missing == 0 && late == 0 && dropped == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) {
    std::fprintf(stderr, "usage: %s DOMAIN PROFILES SECONDS TICK_MS\n", argv[0]);
    return 2;
  }
  auto& participant = participant_in(argv[1], argv[2]);
  Ticks ticks(std::atoll(argv[4]) * 1'000'000);
  const auto into = [&ticks](auto member) {
    return [&ticks, member](const auto& sample, Ns written, Ns here) { (ticks.*member)(sample, written, here); };
  };
  const Reader<SlavingCommandV4, downrange::wire::SlavingCommandV4PubSubType> commands(
      participant, "downrange/slaving", "slaving-client", into(&Ticks::command));
  const Reader<ServiceStatusV4, downrange::wire::ServiceStatusV4PubSubType> statuses(participant, "downrange/status",
                                                                                     "state", into(&Ticks::status));
  std::this_thread::sleep_for(std::chrono::seconds(std::atoi(argv[3])));
  const int status = ticks.report();
  participant.delete_contained_entities();
  fdds::DomainParticipantFactory::get_instance()->delete_participant(&participant);
  return status;
}
