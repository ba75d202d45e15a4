#include "copies.hpp"

#include <algorithm>

namespace downrange::integrity {
namespace {

constexpr Duration same_epoch = milliseconds(1);
/// A dispute is settled where one of two is nearer to what is expected by this factor.
constexpr double clearly = 3;

}  // namespace

bool Copies::same(const Fix& a, const Fix& b) const {
  const bool position = (a.position.m - b.position.m).norm() <= tolerance_.position_m;
  const bool velocity =
      !a.velocity_valid || !b.velocity_valid || (a.velocity.m_s - b.velocity.m_s).norm() <= tolerance_.velocity_m_s;
  return position && velocity;
}

const Copies::Message& Copies::note(int station, Time epoch, const Fix& fix) {
  for (std::size_t i = 0; i < messages_.size(); ++i) {
    Message& message = messages_.newest(i);
    const Duration apart = epoch - message.epoch;
    if (apart > same_epoch || -apart > same_epoch) continue;
    const auto* end = message.copy.data() + message.count;
    const bool known = std::any_of(static_cast<const Copy*>(message.copy.data()), end,
                                   [&](const Copy& c) { return c.station == station; });
    if (!known && message.count < max_stations) message.copy[message.count++] = {station, fix};
    return message;
  }
  Message message;
  message.epoch = epoch;
  message.copy[0] = {station, fix};
  message.count = 1;
  messages_.push(message);
  return messages_.newest();
}

Copies::Odd Copies::odd(const Message& message, const std::optional<Position<Ecef>>& expected) const {
  Odd result;
  const std::size_t n = message.count;
  std::size_t best = 0;
  std::size_t best_count = 0;
  for (std::size_t i = 0; i < n; ++i) {
    std::size_t agreeing = 0;
    for (std::size_t j = 0; j < n; ++j) agreeing += same(message.copy[i].fix, message.copy[j].fix) ? 1 : 0;
    if (agreeing > best_count) {
      best = i;
      best_count = agreeing;
    }
  }
  const bool majority = 2 * best_count > n;
  if (!majority && n > 1 && expected) {
    // Two that differ: which is where the target is known to be?
    const auto off = [&](std::size_t i) { return (message.copy[i].fix.position.m - expected->m).norm(); };
    double nearest = off(best);
    for (std::size_t i = 0; i < n; ++i) {
      if (off(i) < nearest) {
        nearest = off(i);
        best = i;
      }
    }
    bool settled = true;
    for (std::size_t i = 0; i < n; ++i)
      settled = settled && (same(message.copy[i].fix, message.copy[best].fix) || off(i) > clearly * nearest);
    if (!settled) best_count = 0;
  } else if (!majority) {
    best_count = 0;
  }
  for (std::size_t i = 0; i < n; ++i) {
    const SourceSet station = set_of(message.copy[i].station);
    const Fix& fix = message.copy[i].fix;
    if (best_count == 0) {
      if (n > 1) result.disputed |= station;
    } else if (same(fix, message.copy[best].fix)) {
      result.agreeing |= station;
    } else {
      result.stations |= station;
    }
    result.apart_m = std::max(result.apart_m, (fix.position.m - message.copy[best].fix.position.m).norm());
  }
  return result;
}

}  // namespace downrange::integrity
