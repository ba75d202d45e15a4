#include "board.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <numbers>
#include <optional>
#include <string_view>
#include <text/printable.hpp>

#include "stage/integrity_text.hpp"

namespace downrange::app {
namespace {

constexpr double deg = std::numbers::pi / 180;
constexpr double silent_after_s = 3;  ///< a node tells its status every second
constexpr double track_old_after_s = 2;
constexpr double health_old_after_s = 3;  ///< likewise every second

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
  if (limits & LimitKeyhole) text += " keyhole";
  return text;
}

/// "  off 0.53 deg  in beam 93 %": what the antenna misses, and how probably it sees its target.
std::string beam_of(const SlavingCommand& c) {
  constexpr double least_told_rad = 0.01 * deg;
  std::string text;
  char part[40];
  if (c.off_target_rad > least_told_rad) {
    std::snprintf(part, sizeof part, "  off %.2f deg", c.off_target_rad / deg);
    text += part;
  }
  if (c.probability_valid) {
    std::snprintf(part, sizeof part, "  in beam %.0f %%", 100 * c.probability_in_beam);
    text += part;
  }
  return text;
}

/// "  off plan 120 along, -30 across, 15 m up".
std::string off_plan(const Trajectory& t) {
  if (!t.deviation_valid) return {};
  char text[100];
  std::snprintf(text, sizeof text, "  off plan %.0f along, %.0f across, %.0f m up", t.deviation_m[0], t.deviation_m[1],
                t.deviation_m[2]);
  return text;
}

double sigma_of(const Trajectory& t) {
  // Diagonal entries of the packed upper triangle: row i starts after the rows above it.
  const int n = t.state_size;
  const double variance =
      t.covariance[0] + t.covariance[static_cast<std::size_t>(n)] + t.covariance[static_cast<std::size_t>(2 * n - 1)];
  return std::sqrt(variance);
}

/// "in view to 08:52:31 (az 10.2), highest 67.1 deg at 08:48:01 (free fall)".
std::string sight_of(const AntennaAccount& account) {
  constexpr std::array basis{"free fall", "planned", "planned lift-off"};
  const auto clock = [](Time t) { return utc(t).substr(0, 8); };  // hh:mm:ss
  if (!account.pass_valid) return {};
  char part[80];
  std::string text;
  if (account.acquisition_valid) {
    std::snprintf(part, sizeof part, "rises %s (az %.1f)", clock(account.acquisition).c_str(),
                  account.acquisition_azimuth_rad / deg);
    text += part;
  } else {
    text += account.in_view ? "in view" : "not seen within 15 min";
  }
  if (account.loss_valid) {
    std::snprintf(part, sizeof part, " to %s (az %.1f)", clock(account.loss).c_str(), account.loss_azimuth_rad / deg);
    text += part;
  }
  if (account.highest_valid) {
    std::snprintf(part, sizeof part, ", highest %.1f deg at %s", account.highest_elevation_rad / deg,
                  clock(account.highest).c_str());
    text += part;
  }
  return text + " (" + basis.at(static_cast<std::size_t>(account.basis)) + ")";
}

/// What operators ordered of an antenna, and when it sees its target: a line each, where there is something to tell.
std::string lines_of(const AntennaAccount& account, const std::string& age) {
  char name[40];
  std::snprintf(name, sizeof name, "%-16s ", account.antenna.c_str());
  std::string text;
  if (!account.orders.empty()) text += name + ("ORDERED: " + std::string(account.orders.view())) + age + '\n';
  if (const std::string sight = sight_of(account); !sight.empty()) text += name + sight + age + '\n';
  return text;
}

/// Share of NIS inside 95 %, as "97.3 %"; a dash where there is none yet.
std::string inside(const SourceHealth& h) {
  if (h.nis_count == 0) return "      -";
  char text[16];
  std::snprintf(text, sizeof text, "%5.1f %%", 100 * h.nis_inside_95);
  return text;
}

/// "since T+241.3, by kim: pointing steps", as far as it is told.
std::string since_and_by(const SourceHealth& h, std::optional<Time> liftoff) {
  std::string text;
  if (h.since.ns != 0) text += " since " + mission_time(h.since, liftoff);
  if (!h.by.empty()) text += " by " + std::string(h.by.view());
  if (!h.reason.empty()) text += " (" + std::string(h.reason.view()) + ")";
  return text;
}

/// ", seen by kim": an alarm that was acknowledged.
std::string seen_by(const SourceHealth& h) {
  return h.acknowledged_by.empty() ? "" : ", seen by " + std::string(h.acknowledged_by.view());
}

/// "qualified", "SUSPECT since T+241.3 by integrity", or "NOT qualified: silent since T+230.0".
std::string qualification(const SourceHealth& h, std::optional<Time> liftoff) {
  if (h.qualified && h.suspect) return "SUSPECT" + since_and_by(h, liftoff) + seen_by(h);
  if (h.qualified && h.forced) return "qualified, FORCED" + since_and_by(h, liftoff);
  if (h.qualified) return "qualified";
  const std::string_view why = why_not_qualified(h);
  return "NOT qualified" + (why.empty() ? "" : ": " + std::string(why)) + since_and_by(h, liftoff) + seen_by(h);
}

/// "  off 12.5 m of 11.5, 0.010 deg of 0.012": what was seen, and what was to be expected.
std::string residual(const SourceHealth& h) {
  std::string text;
  char part[60];
  if (h.expected_m > 0) {
    std::snprintf(part, sizeof part, "  off %.1f m of %.1f", h.residual_m, h.expected_m);
    text += part;
  }
  if (h.expected_rad > 0) {
    std::snprintf(part, sizeof part, "%s%.3f deg of %.3f", text.empty() ? "  off " : ", ", h.residual_rad / deg,
                  h.expected_rad / deg);
    text += part;
  }
  return text;
}

/// "  old 4 s" where `epoch` is more than `limit_s` behind.
std::string old(Time epoch, Time time, double limit_s) {
  const double age_s = (time - epoch).seconds();
  if (!(age_s > limit_s)) return {};
  char text[40];
  std::snprintf(text, sizeof text, "  old %.0f s", age_s);
  return text;
}

}  // namespace

void Board::add(const Result& result, Clock::time_point now) {
  const std::scoped_lock lock(mutex_);
  newest_ = now;
  std::visit([this](const auto& record) { keep(record); }, result);
}

void Board::keep(const Trajectory& trajectory) {
  tracks_[{trajectory.target, trajectory.method}] = trajectory;
  newest_range_time_ = std::max(newest_range_time_, trajectory.epoch);
}

void Board::keep(const SlavingCommand& command) {
  ++commands_;
  commands_by_antenna_[command.antenna] = command;
  newest_range_time_ = std::max(newest_range_time_, command.tick);
}

void Board::keep(const AntennaAccount& account) {
  accounts_[account.antenna] = account;
  newest_range_time_ = std::max(newest_range_time_, account.tick);
}

void Board::keep(const Integrity& record) {
  integrity_[record.target] = record;
  newest_range_time_ = std::max(newest_range_time_, record.time);
}

void Board::keep(const ImpactPoint& record) {
  impacts_[record.target][record.chain] = record;
  newest_range_time_ = std::max(newest_range_time_, record.epoch);
}

void Board::add(const SourceHealth& health, const Name& node, Clock::time_point now) {
  const std::scoped_lock lock(mutex_);
  newest_ = now;
  newest_range_time_ = std::max(newest_range_time_, health.time);
  health_[{health.sensor, node}] = health;
}

void Board::add(const dds::ServiceStatus& status, Clock::time_point now) {
  const std::scoped_lock lock(mutex_);
  nodes_[status.node] = {status, now};
  newest_range_time_ = std::max(newest_range_time_, status.last_tick);
}

bool Board::idle_for(double seconds, Clock::time_point now) const {
  const std::scoped_lock lock(mutex_);
  return std::chrono::duration<double>(now - newest_).count() > seconds;
}

std::uint64_t Board::commands() const {
  const std::scoped_lock lock(mutex_);
  return commands_;
}

std::string Board::lines(Clock::time_point now, Time utc_now) const {
  const std::scoped_lock lock(mutex_);
  const Time time = clock_ == dds::ClockMode::Wall ? utc_now : newest_range_time_;
  std::string text;
  char line[300];
  for (const auto& [key, t] : tracks_) {
    std::snprintf(line, sizeof line,
                  "%-10s %-12s %s  %8.4f %9.4f  %8.2f km  %7.1f m/s  1-sigma %6.1f m  NIS %5.2f%s%s%s\n",
                  t.target.c_str(), t.method.c_str(), utc(t.epoch).c_str(), t.geodetic.latitude_rad / deg,
                  t.geodetic.longitude_rad / deg, t.geodetic.height_m / 1000, t.speed_m_s, sigma_of(t), t.nis,
                  off_plan(t).c_str(), t.quality == TrackQuality::Coasting ? "  coasting" : "",
                  old(t.epoch, time, track_old_after_s).c_str());
    text += line;
  }
  for (const auto& [antenna, c] : commands_by_antenna_) {
    std::snprintf(line, sizeof line,
                  "%-16s for %s  az %8.3f  el %7.3f deg  range %8.2f km  1-sigma %6.1f mdeg  %-8s age %.2f s%s%s%s\n",
                  antenna.c_str(), utc(c.apply_at).c_str(), c.azimuth_rad / deg, c.elevation_rad / deg,
                  c.range_m / 1000, c.sigma_elevation_rad / deg * 1e3, name_of(c.source), c.age_s, beam_of(c).c_str(),
                  limits_of(c.limits).c_str(), c.valid_until < time ? "  EXPIRED" : "");
    text += line;
  }
  for (const auto& [antenna, account] : accounts_)
    text += lines_of(account, old(account.tick, time, track_old_after_s));
  text += integrity_lines(time) + impact_lines_of_all(time) + health_lines(time) + node_lines(now);
  return text.empty() ? "nothing received yet\n" : text::printable(text, true);
}

std::string Board::integrity_lines(Time time) const {
  std::string text;
  for (const auto& [target, record] : integrity_) {
    text += selection(record) + old(record.time, time, track_old_after_s) + '\n';
    for (std::size_t i = 0; i < record.sources.size(); ++i) {
      if (record.sources[i].verdict != IntegrityVerdict::Agrees) text += "  " + sentence(record, i) + '\n';
    }
  }
  return text;
}

std::string Board::impact_lines_of_all(Time time) const {
  std::string text;
  for (const auto& [target, impacts] : impacts_) {
    text += impact_lines(impacts);
    const auto selected = impacts.find(Name{});
    const std::string age = selected == impacts.end() ? "" : old(selected->second.epoch, time, track_old_after_s);
    if (!age.empty()) text += "  the impact point is" + age + '\n';
  }
  return text;
}

std::string Board::health_lines(Time time) const {
  std::string text;
  char line[600];
  std::optional<Time> liftoff;
  for (const auto& [target, record] : integrity_) {
    if (record.liftoff_valid) liftoff = record.liftoff;
  }
  const bool several = std::any_of(health_.begin(), health_.end(), [&](const auto& entry) {
    return entry.first.second != health_.begin()->first.second;
  });
  for (const auto& [key, h] : health_) {
    const auto& [sensor, node] = key;
    std::uint64_t rejected = 0;
    for (std::size_t i = 1; i < reason_count; ++i) rejected += h.count[i];
    std::snprintf(
        line, sizeof line,
        "%-16s %5.0f /s  latency %.3f s  accepted %8llu  rejected %6llu  NIS/dof %5.2f  in 95 %% %s%s  %s%s%s%s%s\n",
        sensor.c_str(), h.rate_hz, h.latency_s, static_cast<unsigned long long>(h.count[0]),
        static_cast<unsigned long long>(rejected), h.nis, inside(h).c_str(), residual(h).c_str(),
        qualification(h, liftoff).c_str(), h.mismatch ? "  MISMATCH" : "", several ? "  at " : "",
        several ? node.c_str() : "", old(h.time, time, health_old_after_s).c_str());
    text += line;
  }
  return text;
}

std::string Board::node_lines(Clock::time_point now) const {
  std::string text;
  char line[300];
  for (const auto& [node, heard] : nodes_) {
    const auto& s = heard.status;
    const double age_s = std::chrono::duration<double>(now - heard.at).count();
    const std::string role(role_of(s.stages));
    char silent[40];
    std::snprintf(silent, sizeof silent, "SILENT %.0f s", age_s);
    std::snprintf(
        line, sizeof line,
        "node %-12s %-6s %s  queue %u  in %llu (%.0f /s)  out %llu (%.0f /s)  99 %% within %.0f us  archive %s\n",
        node.c_str(), role.c_str(), age_s > silent_after_s ? silent : s.state.c_str(), s.queue_depth,
        static_cast<unsigned long long>(s.consumed), s.consumed_per_s, static_cast<unsigned long long>(s.emitted),
        s.emitted_per_s, s.latency_us[2], s.archive_state.c_str());
    text += line;
    if (!s.mismatch.empty()) text += "  DOES NOT MATCH  " + s.mismatch + '\n';
  }
  return text;
}

std::map<std::string, std::string> Board::status_metadata() const {
  const std::scoped_lock lock(mutex_);
  std::map<std::string, std::string> m;
  const dds::ServiceStatus* busiest = nullptr;
  for (const auto& [node, heard] : nodes_) {
    if (busiest == nullptr || heard.status.emitted > busiest->emitted) busiest = &heard.status;
  }
  if (busiest == nullptr) return m;
  const auto whole = [](double us) {
    char text[32];
    std::snprintf(text, sizeof text, "%.0f", us);
    return std::string(text);
  };
  m["node"] = busiest->node.view();
  m["version"] = busiest->version;
  m["latency_p50_us"] = whole(busiest->latency_us[0]);
  m["latency_p95_us"] = whole(busiest->latency_us[1]);
  m["latency_p99_us"] = whole(busiest->latency_us[2]);
  m["latency_max_us"] = whole(busiest->latency_us[3]);
  m["consumed"] = std::to_string(busiest->consumed);
  m["emitted"] = std::to_string(busiest->emitted);
  m["dropped"] = std::to_string(busiest->dropped);
  m["write_failures"] = std::to_string(busiest->write_failures);
  return m;
}

}  // namespace downrange::app
