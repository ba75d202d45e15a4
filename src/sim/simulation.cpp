#include "sim/simulation.hpp"

#include <algorithm>

#include "sim/antenna_models.hpp"

namespace downrange::sim {
namespace {

constexpr double flight_margin_s = 30;  ///< truth for commands that are applied after the last measurement
constexpr Duration mission_delay = milliseconds(50);
constexpr double separation_s = 3;  ///< after a stage's cut-off

struct StagingMark {
  double t_s;
  const char* label;
};
constexpr StagingMark staging_marks[] = {
    {229, "MECO"}, {232, "separation"}, {395, "kick motor ignition"}, {453, "SECO"}};

/// The mission clock's messages: the plan at the start, then each mark as it happens.
std::vector<MissionEvent> mission_events(const Scenario& scenario) {
  std::vector<MissionEvent> events;
  const auto add = [&](MissionEventKind kind, const char* label, Time epoch, Time received) {
    events.push_back({scenario.name, label, kind, events.size() + 1, epoch, received, scenario.simulated});
  };
  const Time start = scenario.liftoff + seconds(scenario.start_s);
  add(MissionEventKind::PlannedLiftoff, "planned lift-off", scenario.liftoff, start);
  add(MissionEventKind::Liftoff, "lift-off", scenario.liftoff, scenario.liftoff + mission_delay);
  if (scenario.profile.hop) return events;  // of one stage
  const double last_burn_s = scenario.profile.burns.back().to_s;
  for (const StagingMark& mark : staging_marks) {
    const Time epoch = scenario.liftoff + seconds(mark.t_s);
    const bool happens = mark.t_s <= last_burn_s + separation_s;  // not after an early cut-off
    if (happens && mark.t_s < scenario.end_s) add(MissionEventKind::Staging, mark.label, epoch, epoch + mission_delay);
  }
  return events;
}

}  // namespace

std::vector<RadarTruth> simulate_sensors(const Scenario& scenario, const score::TruthFunction& truth,
                                         std::uint64_t seed, std::vector<Event>& events) {
  const auto append = [&](const auto& measured) { events.insert(events.end(), measured.begin(), measured.end()); };
  std::vector<RadarTruth> radars;
  for (const RadarScenario& radar : scenario.radars) {
    RadarRun run = simulate_radar(radar, scenario, truth, seed);
    append(run.plots);
    radars.push_back({radar.id, run.bias, std::move(run.outlier_sequences)});
  }
  for (const RadarScenario& sensor : scenario.angle_sensors) append(simulate_angles(sensor, scenario, truth, seed));
  if (!scenario.stations.empty()) append(simulate_gps(scenario, truth, seed));
  for (const PlatformScenario& platform : scenario.platforms) append(simulate_platform(platform, scenario, seed));
  for (const AntennaScenario& antenna : scenario.antennas) append(simulate_antenna(antenna, scenario));
  return radars;
}

void sort_by_arrival(std::vector<Event>& events) {
  std::stable_sort(events.begin(), events.end(), [](const Event& a, const Event& b) {
    const Time received_a = received_of(a);
    const Time received_b = received_of(b);
    return received_a != received_b ? received_a < received_b : step_order_less(a, b);
  });
}

Simulation::Simulation(const Scenario& scenario, std::uint64_t seed)
    : trajectory_(scenario.profile, scenario.liftoff, scenario.end_s + flight_margin_s) {
  const score::TruthFunction truth = [this](Time t) { return trajectory_.at(t); };
  for (const MissionEvent& event : mission_events(scenario)) events_.emplace_back(event);
  radars_ = simulate_sensors(scenario, truth, seed, events_);
  sort_by_arrival(events_);
}

}  // namespace downrange::sim
