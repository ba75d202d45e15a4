/// Many targets at once, for the benchmarks of load: every target of the range flies the scenario's trajectory, one
/// behind the other, and every sensor of the scenario tracks each of them.
///
///   downrange_crowd RANGE SCENARIO OUT.mcap
///
/// Prints the number of plots.

#include <cstdio>
#include <exception>

#include "archive/new_archive.hpp"
#include "config/load.hpp"
#include "sim/simulation.hpp"

namespace downrange {
namespace {

constexpr double first_ahead_s = 120;  ///< where the vehicle of the scenario is so much later, in flight
constexpr double apart_s = 0.2;        ///< from one target to the next, on the way

std::vector<Event> crowd(const RangeConfig& range, sim::Scenario scenario) {
  const double last_s = scenario.end_s + first_ahead_s + apart_s * static_cast<double>(range.targets.size()) + 30;
  const sim::LaunchTrajectory trajectory(scenario.profile, scenario.liftoff, last_s);
  std::vector<Event> events;
  double ahead_s = first_ahead_s;
  for (const TargetConfig& target : range.targets) {
    scenario.target = target.id;
    const auto truth = [&](Time t) { return trajectory.at(t + seconds(ahead_s)); };
    (void)sim::simulate_sensors(scenario, truth, scenario.seed++, events);
    ahead_s += apart_s;
  }
  sim::sort_by_arrival(events);
  return events;
}

int run(const char* range, const char* scenario, const char* out) {
  const config::ServiceConfig config = config::load(range);
  const std::vector<Event> events = crowd(config.range, sim::load_scenario(scenario, config.range));
  archive::NewArchive archive(out, {.overwrite = true});
  archive.writer().attach("config.toml", "application/toml", config.text);
  std::size_t plots = 0;
  for (const Event& event : events) {
    archive.writer().write(event);
    plots += std::holds_alternative<RadarTspi>(event) ? 1 : 0;
  }
  if (const archive::WriterStatus status = archive.close(); !status.ok()) {
    std::fprintf(stderr, "%s: %s\n", out, status.failure.c_str());
    return 1;
  }
  std::printf("%zu\n", plots);
  return 0;
}

}  // namespace
}  // namespace downrange

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: %s RANGE SCENARIO OUT.mcap\n", argv[0]);
    return 2;
  }
  try {
    return downrange::run(argv[1], argv[2], argv[3]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
