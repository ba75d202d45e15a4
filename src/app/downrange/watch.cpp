#include <archive/writer.hpp>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <map>
#include <mutex>
#include <numbers>
#include <string>

#include <unistd.h>

#include "dds/outputs.hpp"
#include "flight.hpp"
#include "pace.hpp"

namespace downrange::app {
namespace {

constexpr double deg = std::numbers::pi / 180;

struct Options {
  DdsOptions dds;
  std::string record;
  bool plain = false;
  std::optional<double> idle_s;
};

std::string utc(Time t) {
  const std::time_t whole = static_cast<std::time_t>(t.ns / 1'000'000'000);
  std::tm parts{};
  gmtime_r(&whole, &parts);
  char text[32];
  std::snprintf(text, sizeof text, "%02d:%02d:%02d.%03d", parts.tm_hour, parts.tm_min, parts.tm_sec,
                static_cast<int>(t.ns % 1'000'000'000 / 1'000'000));
  return text;
}

const char* name_of(SlavingSource source) {
  static constexpr std::array<const char*, 5> names{"fused", "coasting", "single", "gps", "nominal"};
  return names.at(static_cast<std::size_t>(source));
}

std::string limits_of(std::uint8_t limits) {
  std::string text;
  if (limits & LimitElevation) text += " elevation-held";
  if (limits & LimitAzimuth) text += " azimuth-held";
  if (limits & LimitRate) text += " too-fast";
  if (limits & LimitUnwrapped) text += " went-around";
  return text;
}

/// The newest of everything; filled by the middleware's threads, read by the screen.
class Board {
 public:
  void take(const Result& result) {
    const std::scoped_lock lock(mutex_);
    ++received_;
    newest_ = std::chrono::steady_clock::now();
    if (const auto* t = std::get_if<Trajectory>(&result)) {
      tracks_[{t->target, t->method}] = *t;
    } else if (const auto* c = std::get_if<SlavingCommand>(&result)) {
      ++commands_;
      commands_by_antenna_[c->antenna] = *c;
    } else if (const auto* h = std::get_if<SourceHealth>(&result)) {
      health_[h->sensor] = *h;
    }
    if (writer_ != nullptr) writer_->write(result);
  }
  void take(const dds::ServiceStatus& status) {
    const std::scoped_lock lock(mutex_);
    status_[status.node] = status;
  }
  void record_to(archive::Writer& writer) { writer_ = &writer; }

  [[nodiscard]] bool idle_for(double seconds) const {
    const std::scoped_lock lock(mutex_);
    return received_ > 0 && std::chrono::duration<double>(std::chrono::steady_clock::now() - newest_).count() > seconds;
  }
  [[nodiscard]] bool record_failed() const { return writer_ != nullptr && writer_->failed(); }

  [[nodiscard]] std::string lines() const {
    const std::scoped_lock lock(mutex_);
    std::string text;
    char line[200];
    for (const auto& [key, t] : tracks_) {
      std::snprintf(line, sizeof line,
                    "%-10s %-12s %s  %8.4f %9.4f  %8.2f km  %7.1f m/s  1-sigma %6.1f m  NIS %5.2f%s\n",
                    t.target.c_str(), t.method.c_str(), utc(t.epoch).c_str(), t.geodetic.latitude_rad / deg,
                    t.geodetic.longitude_rad / deg, t.geodetic.height_m / 1000, t.speed_m_s, sigma_of(t), t.nis,
                    t.quality == TrackQuality::Coasting ? "  coasting" : "");
      text += line;
    }
    for (const auto& [antenna, c] : commands_by_antenna_) {
      std::snprintf(line, sizeof line,
                    "%-16s for %s  az %8.3f  el %7.3f deg  range %8.2f km  1-sigma %6.1f mdeg  %-8s age %.2f s%s\n",
                    antenna.c_str(), utc(c.apply_at).c_str(), c.azimuth_rad / deg, c.elevation_rad / deg,
                    c.range_m / 1000, c.sigma_elevation_rad / deg * 1e3, name_of(c.source), c.age_s,
                    limits_of(c.limits).c_str());
      text += line;
    }
    for (const auto& [sensor, h] : health_) {
      std::uint64_t rejected = 0;
      for (std::size_t i = 1; i < reason_count; ++i) rejected += h.count[i];
      std::snprintf(line, sizeof line,
                    "%-16s %5.0f /s  latency %.3f s  accepted %8llu  rejected %6llu  NIS/dof %5.2f  %s\n",
                    sensor.c_str(), h.rate_hz, h.latency_s, static_cast<unsigned long long>(h.count[0]),
                    static_cast<unsigned long long>(rejected), h.nis, h.qualified ? "qualified" : "NOT qualified");
      text += line;
    }
    for (const auto& [node, s] : status_) {
      std::snprintf(line, sizeof line, "node %-12s %s  queue %u  in %llu  out %llu  99 %% within %.0f us  archive %s\n",
                    node.c_str(), s.state.c_str(), s.queue_depth, static_cast<unsigned long long>(s.consumed),
                    static_cast<unsigned long long>(s.emitted), s.latency_us[2], s.archive_state.c_str());
      text += line;
    }
    return text.empty() ? "nothing received yet\n" : text;
  }

  /// The newest status of the busiest node, for the archive.
  [[nodiscard]] std::map<std::string, std::string> status_metadata() const {
    const std::scoped_lock lock(mutex_);
    std::map<std::string, std::string> m;
    const dds::ServiceStatus* busiest = nullptr;
    for (const auto& [node, s] : status_) {
      if (busiest == nullptr || s.emitted > busiest->emitted) busiest = &s;
    }
    if (busiest == nullptr) return m;
    const auto tenths = [](double us) {
      char text[32];
      std::snprintf(text, sizeof text, "%.0f", us);
      return std::string(text);
    };
    m["node"] = busiest->node.view();
    m["version"] = busiest->version;
    m["latency_p50_us"] = tenths(busiest->latency_us[0]);
    m["latency_p95_us"] = tenths(busiest->latency_us[1]);
    m["latency_p99_us"] = tenths(busiest->latency_us[2]);
    m["latency_max_us"] = tenths(busiest->latency_us[3]);
    m["consumed"] = std::to_string(busiest->consumed);
    m["emitted"] = std::to_string(busiest->emitted);
    m["dropped"] = std::to_string(busiest->dropped);
    m["write_failures"] = std::to_string(busiest->write_failures);
    return m;
  }
  [[nodiscard]] std::uint64_t commands() const {
    const std::scoped_lock lock(mutex_);
    return commands_;
  }

 private:
  static double sigma_of(const Trajectory& t) {
    // Diagonal entries of the packed upper triangle: row i starts after the rows above it.
    const int n = t.state_size;
    const double variance =
        t.covariance[0] + t.covariance[static_cast<std::size_t>(n)] + t.covariance[static_cast<std::size_t>(2 * n - 1)];
    return std::sqrt(variance);
  }

  mutable std::mutex mutex_;
  std::map<std::pair<Name, Name>, Trajectory> tracks_;
  std::map<Name, SlavingCommand> commands_by_antenna_;
  std::map<Name, SourceHealth> health_;
  std::map<Name, dds::ServiceStatus> status_;
  std::uint64_t received_ = 0;
  std::uint64_t commands_ = 0;
  std::chrono::steady_clock::time_point newest_{};
  archive::Writer* writer_ = nullptr;
};

int watch(const Options& o) {
  const StopSignal stop;
  const config::ServiceConfig config = o.dds.load();
  Board board;
  std::optional<archive::Writer> writer;
  if (!o.record.empty()) board.record_to(writer.emplace(o.record, archive::WriterOptions{.overwrite = true}));

  dds::Participant participant(participant_options(config, "downrange-watch"));
  const bool screen = !o.plain && isatty(STDOUT_FILENO) != 0;
  {
    const dds::OutputReaders readers(participant, {.lossless = writer.has_value()},
                                     {.result = [&](const Result& r) { board.take(r); },
                                      .status = [&](const dds::ServiceStatus& s) { board.take(s); }});
    const auto period = std::chrono::milliseconds(screen ? 200 : 1000);
    while (!stop.wait_for(period)) {
      if (o.idle_s && board.idle_for(*o.idle_s)) break;
      if (board.record_failed()) break;
      if (screen) std::cout << "\033[H\033[J";
      std::cout << board.lines() << std::flush;
      if (!screen) std::cout << '\n';
    }
    const auto counts = readers.counts();
    if (counts.lost + counts.malformed + counts.incompatible > 0)
      std::cerr << counts.lost << " samples lost, " << counts.malformed << " malformed, " << counts.incompatible
                << " writers with unsuitable QoS\n";
  }
  std::cerr << board.commands() << " slaving commands received\n";
  if (!writer) return exit_ok;
  writer->metadata("status", board.status_metadata());
  return close_archive(*writer, o.record);
}

}  // namespace

void add_watch(CLI::App& app, Run& run) {
  auto o = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("watch", "Watch tracks, slaving commands, sources and nodes, as a consumer over DDS");
  command->add_option("CONFIG", o->dds.config, "Configuration of the range")->required();
  command->add_option("--record", o->record, "Store every result received in this archive (.mcap)");
  command->add_flag("--plain", o->plain, "Lines once a second instead of a screen");
  command->add_option("--idle", o->idle_s, "End when nothing has come for this many seconds (default: Ctrl-C ends)")
      ->check(CLI::PositiveNumber);
  o->dds.add_to(*command);
  command->callback([o, &run] { run = [o] { return watch(*o); }; });
}

}  // namespace downrange::app
