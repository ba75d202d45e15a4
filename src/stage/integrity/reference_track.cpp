#include "reference_track.hpp"

namespace downrange::integrity {
namespace {

constexpr Duration farthest = milliseconds(2500);

Duration apart(Time a, Time b) { return a < b ? b - a : a - b; }

}  // namespace

Vec<9> moved(const Vec<9>& motion, double dt_s) {
  Vec<9> later = motion;
  later.head<3>() += dt_s * motion.segment<3>(3) + dt_s * dt_s / 2 * motion.tail<3>();
  later.segment<3>(3) += dt_s * motion.tail<3>();
  return later;
}

std::optional<Vec<9>> ReferenceTrack::at(Time at) const {
  const State* nearest = nullptr;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    const State& state = states_.newest(i);
    if (nearest == nullptr || apart(state.epoch, at) < apart(nearest->epoch, at)) nearest = &state;
  }
  if (nearest == nullptr || apart(nearest->epoch, at) > farthest) return std::nullopt;
  return moved(nearest->motion, (at - nearest->epoch).seconds());
}

}  // namespace downrange::integrity
