#pragma once
/// The running service: DDS on both sides of the engine's thread. Starts in the constructor, stops in stop().

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "app/machine_clock.hpp"
#include "config/service_config.hpp"
#include "dds/inputs.hpp"
#include "dds/outputs.hpp"
#include "dds/participant.hpp"
#include "dds/range_clock.hpp"
#include "event_queue.hpp"
#include "flight.hpp"
#include "latency.hpp"
#include "utc_watch.hpp"

namespace downrange::app {

class Service {
 public:
  /// `on_failure` is called from the engine's thread when it cannot go on. Throws dds::DdsError, archive::ArchiveError
  /// and std::runtime_error for a broken environment, with what is broken in the text.
  /// `utc` is read from the engine's thread too.
  Service(const config::ServiceConfig& config, std::function<void()> on_failure, std::function<Time()> utc = utc_now);
  ~Service();
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  /// Consumes what has arrived, closes the archive and ends. Once; the destructor does it otherwise.
  void stop();

  /// Rises while the engine's thread is alive, with or without input.
  [[nodiscard]] const std::atomic<std::uint64_t>& progress() const { return progress_; }
  /// Why the engine's thread ended by itself. To be asked after stop().
  [[nodiscard]] const std::optional<std::string>& failure() const { return failure_; }

 private:
  /// The middleware's messages go into our log while the service lives.
  struct MiddlewareLog {
    MiddlewareLog();
    ~MiddlewareLog();
    MiddlewareLog(const MiddlewareLog&) = delete;
    MiddlewareLog& operator=(const MiddlewareLog&) = delete;
  };
  using Clock = std::chrono::steady_clock;
  /// As the last status had it; losses as the log last told them.
  struct Reported {
    Clock::time_point at;
    std::uint64_t consumed = 0;
    std::uint64_t emitted = 0;
    std::uint64_t dropped = 0;
    std::uint64_t write_failures = 0;
    std::uint64_t expired = 0;
  };

  void run();
  void follow_wall_clock();
  void follow_range_clock();
  void consume_arrived();
  /// What still waits when the service is told to stop, as far as there is time for it.
  void consume_the_rest();
  void consume_oldest();
  /// After a step of UTC: back, a new flight, for an engine does not go back in time.
  void take_step(Duration step);
  /// An engine that is far behind its clock leaves the ticks up to `now` out: their commands are for nobody.
  void leave_out_ticks(Time now);
  void consume(const dds::RangeStep& step);
  [[nodiscard]] std::optional<dds::RangeStep> next_step();
  /// A new flight in place of the last; without an archive where that cannot be opened.
  void begin_flight();
  /// The same after a step of UTC back: what operators ordered and what the mission's clock tells holds on.
  void begin_flight_anew();
  void end_flight();
  [[nodiscard]] std::unique_ptr<Recorder> open_recorder() const;
  [[nodiscard]] std::string archive_state();
  /// Whether this node takes the event: measurements of its sources only.
  [[nodiscard]] bool takes(const Event& event) const;
  /// For the watchdog, and once a second the status.
  void beat();
  void publish_status();
  [[nodiscard]] dds::ReadCounts read_counts() const;
  void report_losses(std::uint64_t dropped, const EventQueue::Losses& queue, const dds::ReadCounts& read,
                     const dds::WriteCounts& written);
  /// Logs who does not match, each once; for the status.
  [[nodiscard]] std::string report_mismatches();

  const config::ServiceConfig config_;
  std::function<void()> on_failure_;
  std::function<Time()> utc_;
  MiddlewareLog middleware_log_;
  dds::Participant participant_;
  dds::OutputWriters outputs_;

  EventQueue queue_;                                   ///< wall clock
  std::unique_ptr<dds::InputReader> input_;            ///< wall clock
  std::unique_ptr<dds::RangeClockFollower> follower_;  ///< range clock

  // The engine thread's own.
  std::unique_ptr<Flight> flight_;
  std::uint64_t consumed_before_ = 0;  ///< in flights that are over
  std::uint64_t emitted_before_ = 0;
  std::uint64_t expired_before_ = 0;
  std::string state_;
  std::string archive_failure_;  ///< why this flight has no archive
  UtcWatch utc_watch_;           ///< wall clock
  LatencyHistogram latency_;
  Clock::time_point next_status_;
  Reported reported_;
  dds::NewMismatches new_mismatches_;

  std::atomic<bool> stop_ = false;
  std::atomic<std::uint64_t> progress_ = 0;
  std::optional<std::string> failure_;
  std::thread thread_;
};

}  // namespace downrange::app
