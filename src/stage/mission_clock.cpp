#include "mission_clock.hpp"

#include <algorithm>

namespace downrange {

MissionClock::MissionClock(const RangeConfig& config) : simulated_(config.ingest.expect_simulated) {
  marks_.reserve(max_marks);
}

std::string MissionClock::refusal(const MissionEvent& event) const {
  if (event.simulated != simulated_)
    return simulated_ ? "this node flies simulated missions only" : "a simulated mark, and this node flies a real one";
  if (!plausible(event.epoch)) return "its time is none between 1970 and 2100";
  if (event.kind == MissionEventKind::Hold && in_flight(event.epoch)) return "no hold after lift-off: recycle first";
  return {};
}

void MissionClock::note(const MissionEvent& event) {
  if (!refusal(event).empty()) return;
  switch (event.kind) {
    case MissionEventKind::PlannedLiftoff:
      planned_ = event.epoch;
      hold_.reset();
      return;
    case MissionEventKind::Liftoff:
      announced_ = event.epoch;
      hold_.reset();
      return;
    case MissionEventKind::Hold:
      hold_ = event.epoch;
      return;
    case MissionEventKind::Recycle:
      planned_.reset();
      announced_.reset();
      motion_.reset();
      hold_.reset();
      marks_.clear();
      return;
    case MissionEventKind::Staging:
    case MissionEventKind::Mark:
      if (marks_.size() == max_marks) marks_.erase(marks_.begin());
      marks_.push_back({.kind = event.kind, .label = event.label, .epoch = event.epoch});
      return;
  }
}

void MissionClock::note_motion(Time since) {
  if (!motion_) motion_ = since;
}

std::optional<Duration> MissionClock::t_plus(Time at) const {
  if (liftoff()) return at - *liftoff();
  if (!planned_) return std::nullopt;
  return (hold_ ? std::min(at, *hold_) : at) - *planned_;
}

}  // namespace downrange
