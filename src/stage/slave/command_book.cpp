#include "stage/slave/command_book.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace downrange {
namespace {

constexpr Duration clocks_differ = milliseconds(1000);
/// Commands that apply no more are kept so long, for who asks of an instant just past.
constexpr Duration kept = milliseconds(1000);
constexpr std::size_t most_commands = 32'768;

bool finite(const SlavingCommand& c) {
  const std::array numbers{c.azimuth_rad,
                           c.elevation_rad,
                           c.azimuth_rate_rad_s,
                           c.elevation_rate_rad_s,
                           c.acceleration_valid ? c.azimuth_acceleration_rad_s2 : 0,
                           c.acceleration_valid ? c.elevation_acceleration_rad_s2 : 0};
  return std::ranges::all_of(numbers, [](double x) { return std::isfinite(x); });
}

CommandedPointing carried(const SlavingCommand& c, Time t, bool second_order) {
  const double dt = (t - c.apply_at).seconds();
  CommandedPointing aim{.azimuth_rad = c.azimuth_rad + dt * c.azimuth_rate_rad_s,
                        .elevation_rad = c.elevation_rad + dt * c.elevation_rate_rad_s,
                        .tick = c.tick,
                        .source = c.source};
  if (second_order) {
    aim.azimuth_rad += 0.5 * dt * dt * c.azimuth_acceleration_rad_s2;
    aim.elevation_rad += 0.5 * dt * dt * c.elevation_acceleration_rad_s2;
  }
  return aim;
}

CommandedPointing between(const SlavingCommand& from, const SlavingCommand& to, Time t) {
  const bool goes_around = std::abs(to.azimuth_rad - from.azimuth_rad) > std::numbers::pi;
  if (goes_around) return carried(from, t, from.acceleration_valid);
  const double part = (t - from.apply_at).seconds() / (to.apply_at - from.apply_at).seconds();
  const bool second_order = from.acceleration_valid && to.acceleration_valid;
  CommandedPointing a = carried(from, t, second_order);
  const CommandedPointing b = carried(to, t, second_order);
  if (second_order) {
    a.azimuth_rad += part * (b.azimuth_rad - a.azimuth_rad);
    a.elevation_rad += part * (b.elevation_rad - a.elevation_rad);
  } else {  // as good as two tangents, and as smooth
    a.azimuth_rad = from.azimuth_rad + part * (to.azimuth_rad - from.azimuth_rad);
    a.elevation_rad = from.elevation_rad + part * (to.elevation_rad - from.elevation_rad);
  }
  return a;
}

}  // namespace

bool CommandBook::take(const SlavingCommand& command, Time now) {
  if (!finite(command) || command.valid_until < command.apply_at) return false;
  if (command.valid_until < now) {
    ++expired_;
    return false;
  }
  if (command.apply_at > now + ahead_ + clocks_differ) {
    ++from_future_;
    return false;
  }
  if (!commands_.empty() && command.apply_at <= commands_.back().apply_at) return false;
  commands_.push_back(command);
  while (commands_.size() > 1 && (commands_[1].apply_at < now - kept || commands_.size() > most_commands))
    commands_.pop_front();
  return true;
}

std::optional<CommandedPointing> CommandBook::at(Time t) const {
  const auto next = std::ranges::upper_bound(commands_, t, {}, &SlavingCommand::apply_at);
  if (next == commands_.begin()) return std::nullopt;
  const SlavingCommand& from = *std::prev(next);
  if (t > from.valid_until) return std::nullopt;
  return next == commands_.end() ? carried(from, t, from.acceleration_valid) : between(from, *next, t);
}

std::optional<Time> CommandBook::valid_until() const {
  if (commands_.empty()) return std::nullopt;
  return commands_.back().valid_until;
}

}  // namespace downrange
