#include <cstdio>
#include <iostream>

#include "command.hpp"
#include "fault_options.hpp"
#include "flight.hpp"
#include "progress.hpp"
#include "sim/simulation.hpp"

namespace downrange::app {
namespace {

struct Options {
  DdsOptions dds;
  std::string scenario;
  std::optional<std::uint64_t> seed;
  bool over_dds = false;
  std::string nodes;
  std::string rate = "1";
  std::string archive;
  std::string truth;
  FaultOptions fault;
  OutputFiles files;
};

std::string mission_time(Time t, Time liftoff) {
  char text[32];
  std::snprintf(text, sizeof text, "T%+.1f s", (t - liftoff).seconds());
  return text;
}

int write_truth(const sim::Simulation& flight, const sim::Scenario& scenario, const std::string& path, bool overwrite) {
  archive::NewArchive archive(path, {.overwrite = overwrite});
  const Duration step = milliseconds(50);
  for (Time t = scenario.liftoff + seconds(scenario.start_s); t <= scenario.liftoff + seconds(scenario.end_s);
       t = t + step) {
    if (const auto state = flight.truth(t))
      archive.writer().write_truth(
          {.target = scenario.target, .epoch = t, .position = state->position, .velocity = state->velocity});
  }
  return close_archive(archive, path);
}

int write_archive(const std::vector<Event>& events, const config::ServiceConfig& config, const std::string& path,
                  bool overwrite) {
  archive::NewArchive archive(path, {.overwrite = overwrite});
  archive.writer().attach("config.toml", "application/toml", config.text);
  for (const Event& event : events) archive.writer().write(event);
  return close_archive(archive, path);
}

int simulate(const Options& o) {
  const double rate = parse_rate(o.rate);
  o.files.check({o.archive, o.truth}, {o.dds.config, o.scenario, o.fault.file});
  const config::ServiceConfig config = o.dds.load();
  sim::Scenario scenario = sim::load_scenario(o.scenario, config.range);
  std::optional<ChosenFault> fault;
  if (o.fault.given()) fault.emplace(o.fault);
  if (fault && fault->flight() != nullptr) scenario = sim::flown_as(scenario, *fault->flight(), config.range);
  if (scenario.simulated != config.range.ingest.expect_simulated)
    std::cerr << "note: the scenario's messages are " << (scenario.simulated ? "" : "not ")
              << "marked as simulated, and ingest.expect_simulated is the opposite: every one will be rejected\n";
  const std::uint64_t seed = o.seed.value_or(scenario.seed);
  const sim::Simulation flight(scenario, seed);
  std::vector<Event> events = flight.events();
  if (fault) events = fault->play(std::move(events), config.range, scenario.liftoff, seed);
  std::cerr << "scenario " << scenario.name.view() << ": " << events.size() << " messages of " << scenario.radars.size()
            << " radars, " << scenario.angle_sensors.size() << " angle sensors and " << scenario.stations.size()
            << " telemetry stations\n";

  if (!o.truth.empty() && write_truth(flight, scenario, o.truth, o.files.overwrite(o.truth)) != exit_ok)
    return exit_failed;
  if (!o.archive.empty() && write_archive(events, config, o.archive, o.files.overwrite(o.archive)) != exit_ok)
    return exit_failed;
  if (!o.over_dds) return exit_ok;

  std::vector<Name> nodes = parse_names(o.nodes);
  if (nodes.empty()) {
    nodes = config.dds.ingest_nodes;
    nodes.push_back(config.node.id);
  }
  std::size_t i = 0;
  Progress progress("flying");
  drive_over_dds(
      config, "downrange-simulate", {.nodes = nodes, .rate = rate},
      [&]() -> std::optional<Event> { return i < events.size() ? std::optional(events[i++]) : std::nullopt; },
      [&](Time t) {
        progress.show(static_cast<double>(i) / static_cast<double>(events.size()), mission_time(t, scenario.liftoff));
      });
  return exit_ok;
}

}  // namespace

void add_simulate(CLI::App& app, Run& run) {
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("simulate", "Fly a launch scenario: to an archive, or live over DDS");
  command->add_option("CONFIG", o->dds.config, "Configuration of the range")->required();
  command->add_option("--scenario", o->scenario, "Scenario, e.g. tools/scenarios/launch.toml")->required();
  command->add_option("--seed", o->seed, "Draw noise and biases from this seed (default: the scenario's)");
  command->add_flag(
      "--dds", o->over_dds,
      "Publish as radars and telemetry stations do, on the range clock or as they would now, on the wall clock");
  command->add_option("--rate", o->rate, "Seconds of flight per second, or max")->capture_default_str();
  command->add_option("--nodes", o->nodes,
                      "Nodes that take part, comma-separated (default: dds.ingest_nodes and node.id)");
  command->add_option("--archive", o->archive, "Write the messages to this archive (.mcap)");
  command->add_option("--truth", o->truth, "Write the true trajectory to this archive (.mcap), for report");
  o->fault.add_to(*command);
  o->files.add_to(*command);
  o->dds.add_to(*command);
  command->callback([o, &run] {
    run = [o] {
      if (!o->over_dds && o->archive.empty() && o->truth.empty())
        throw CLI::ValidationError("simulate", "say where the flight shall go: --dds, --archive FILE or --truth FILE");
      return simulate(*o);
    };
  });
}

}  // namespace downrange::app
