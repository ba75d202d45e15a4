#include <array>
#include <downrange/stage/event.hpp>
#include <tuple>

namespace downrange {
namespace {

/// Rank of the topic, source, target and sequence: MissionEvent, radar, GPS, angles.
std::tuple<int, Name, Name, std::uint64_t> step_rank(const Event& event) {
  struct Rank {
    std::tuple<int, Name, Name, std::uint64_t> operator()(const MissionEvent& e) const {
      return {0, e.mission, {}, e.sequence};
    }
    std::tuple<int, Name, Name, std::uint64_t> operator()(const RadarTspi& e) const {
      return {1, e.sensor, e.target, e.sequence};
    }
    std::tuple<int, Name, Name, std::uint64_t> operator()(const GpsFix& e) const {
      return {2, e.station, e.target, e.sequence};
    }
    std::tuple<int, Name, Name, std::uint64_t> operator()(const AngleTspi& e) const {
      return {3, e.sensor, e.target, e.sequence};
    }
    std::tuple<int, Name, Name, std::uint64_t> operator()(const Observation& e) const {
      return {1 + static_cast<int>(e.kind), e.sensor, e.target, e.sequence};
    }
    std::tuple<int, Name, Name, std::uint64_t> operator()(const ClockGap&) const { return {}; }  // of the wall clock
  };
  return std::visit(Rank{}, event);
}

}  // namespace

std::string_view to_string(Reason reason) {
  static constexpr std::array<std::string_view, reason_count> names{
      "accepted",     "unknown_source", "simulated_mismatch", "not_finite",   "out_of_limits",
      "not_tracking", "too_late",       "from_future",        "duplicate",    "clock_step",
      "gated",        "frozen",         "no_position",        "away_from_pad"};
  return names.at(static_cast<std::size_t>(reason));
}

Time received_of(const Event& event) {
  return std::visit([](const auto& e) { return e.received; }, event);
}

void set_received(Event& event, Time received) {
  std::visit([received](auto& e) { e.received = received; }, event);
}

bool step_order_less(const Event& a, const Event& b) { return step_rank(a) < step_rank(b); }

}  // namespace downrange
