#include <array>
#include <downrange/stage/catalogue.hpp>
#include <downrange/stage/event.hpp>
#include <tuple>

namespace downrange {
namespace {

/// Rank of the topic, source, target and sequence.
std::tuple<std::size_t, Name, Name, std::uint64_t> step_rank(const Event& event) {
  return std::visit(
      []<class Record>(const Record& e) {
        using Info = MessageInfo<Record>;
        if constexpr (std::is_same_v<Record, Observation>) {
          return std::tuple(input_of_measured[e.measured.index()], Info::source(e), Info::target(e), e.sequence);
        } else if constexpr (Inputs::contains<Record>) {
          return std::tuple(input_index<Record>, Info::source(e), Info::target(e), e.sequence);
        } else {
          static_assert(std::is_same_v<Record, ClockGap>, "an input that is missing in the catalogue");
          return std::tuple(Inputs::size, Name{}, Name{}, std::uint64_t{0});  // of the wall clock
        }
      },
      event);
}

}  // namespace

std::string_view to_string(Reason reason) {
  static constexpr std::array<std::string_view, reason_count> names{
      "accepted",     "unknown_source", "simulated_mismatch", "not_finite",    "out_of_limits",
      "not_tracking", "too_late",       "from_future",        "duplicate",     "clock_step",
      "gated",        "frozen",         "no_position",        "away_from_pad", "slaved",
      "inhibited"};
  return names.at(static_cast<std::size_t>(reason));
}

bool is_mark(const Event& event) {
  return std::visit(
      []<class Record>(const Record&) {
        if constexpr (Inputs::contains<Record>) {
          return MessageInfo<Record>::delivery == Delivery::Mark;
        } else {
          return false;
        }
      },
      event);
}

Time received_of(const Event& event) {
  return std::visit([](const auto& e) { return e.received; }, event);
}

void set_received(Event& event, Time received) {
  std::visit([received](auto& e) { e.received = received; }, event);
}

Name source_of(const Event& event) {
  return std::visit([]<class Record>(const Record& e) { return MessageInfo<Record>::source(e); }, event);
}

bool step_order_less(const Event& a, const Event& b) { return step_rank(a) < step_rank(b); }

}  // namespace downrange
