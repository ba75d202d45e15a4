#include <algorithm>
#include <iostream>
#include <map>

#include "command.hpp"
#include "dds/inputs.hpp"
#include "dds/outputs.hpp"
#include "pace.hpp"
#include "rotctl/client.hpp"
#include "rotctl/server.hpp"
#include "text/printable.hpp"

namespace downrange::app {
namespace {

struct Options {
  DdsOptions dds;
  std::string antennas;
  std::string antenna;
  rotctl::Endpoint endpoint{"127.0.0.1", 4533};
};

config::ConfigError wrong(const config::ServiceConfig& config, const std::string& key, const std::string& message) {
  return config::ConfigError({{config.file.string(), 0, key, message}});
}

const AntennaConfig& antenna_of(const config::ServiceConfig& config, std::string_view id) {
  for (const AntennaConfig& antenna : config.range.antennas)
    if (antenna.id.view() == id) return antenna;
  throw CLI::ValidationError("'" + std::string(id) + "': allowed is the id of an [[antenna]] of " +
                             config.file.string());
}

rotctl::Travel travel_of(const AntennaConfig& antenna) {
  return {antenna.azimuth_min_rad, antenna.azimuth_max_rad, antenna.elevation_min_rad, antenna.elevation_max_rad};
}

config::ServiceConfig load_live(const Options& o) {
  config::ServiceConfig config = o.dds.load();
  if (config.clock.mode != config::ClockMode::Wall)
    throw wrong(config, "clock.mode", "found \"range\", allowed: \"wall\", for a rotator turns in real time");
  return config;
}

/// `take` gets every command, from a thread of the middleware.
dds::OutputReaders read_commands(dds::Participant& participant, std::function<void(const SlavingCommand&)> take) {
  dds::OutputSelection wanted;
  wanted.health = wanted.status = wanted.lossless = false;
  wanted.commands_only = true;
  const auto result = [take = std::move(take)](const Result& r) {
    if (const auto* command = std::get_if<SlavingCommand>(&r)) take(*command);
  };
  return {participant, wanted, {.result = result, .status = {}}};
}

/// A line for a person, from any thread.
void say(const Name& antenna, const std::string& text) {
  std::cerr << std::string(antenna.view()) + ": " + text + '\n' << std::flush;
}

/// What another's reader or writer keeps from being heard, said once.
void wait_for_stop(const StopSignal& stop, const dds::Participant& participant) {
  dds::NewMismatches mismatches;
  while (!stop.wait_for(std::chrono::milliseconds(1000)))
    for (const std::string& text : mismatches.among(participant.mismatches()))
      std::cerr << "does not match: " + text::printable(text) + '\n';
}

std::vector<config::RotctlConfig> chosen(const config::ServiceConfig& config, const std::string& antennas) {
  if (config.rotctl.empty())
    throw wrong(config, "antenna", "no antenna has a rotator, required: [antenna.rotctl] under its [[antenna]]");
  if (antennas.empty()) return config.rotctl;
  std::vector<config::RotctlConfig> some;
  for (const Name& id : parse_names(antennas)) {
    const auto rotator =
        std::ranges::find(config.rotctl, antenna_of(config, id.view()).id, &config::RotctlConfig::antenna);
    if (rotator == config.rotctl.end())
      throw wrong(
          config, "antenna",
          "\"" + std::string(id.view()) + "\" has no rotator, required: [antenna.rotctl] under its [[antenna]]");
    some.push_back(*rotator);
  }
  return some;
}

rotctl::LinkSettings settings_of(const config::ServiceConfig& config, const config::RotctlConfig& rotator) {
  const AntennaConfig& antenna = antenna_of(config, rotator.antenna.view());
  return {.antenna = antenna.id,
          .travel = travel_of(antenna),
          .link_delay = antenna.link_delay,
          .lead = antenna.lead,
          .rate_hz = rotator.rate_hz,
          .timeout = rotator.timeout,
          .simulated = config.range.ingest.expect_simulated};
}

int drive(const Options& o) {
  const config::ServiceConfig config = load_live(o);
  const std::vector<config::RotctlConfig> rotators = chosen(config, o.antennas);
  const StopSignal stop;
  dds::Participant participant(participant_options(config, "downrange-rotctl"));
  dds::AntennaReportWriter reports(participant);
  std::map<Name, rotctl::Client> clients;
  for (const config::RotctlConfig& rotator : rotators) {
    const Name id = rotator.antenna;
    clients.try_emplace(
        id, rotctl::Endpoint{rotator.host, rotator.port}, settings_of(config, rotator),
        rotctl::ClientCallbacks{.report = [&reports](const AntennaReport& r) { static_cast<void>(reports.write(r)); },
                                .note = [id](const std::string& text) { say(id, text); }});
  }
  {
    const dds::OutputReaders commands = read_commands(participant, [&](const SlavingCommand& command) {
      if (const auto client = clients.find(command.antenna); client != clients.end()) client->second.take(command);
    });
    wait_for_stop(stop, participant);
  }
  for (auto& [id, client] : clients) {
    client.finish();
    const rotctl::LinkCounts n = client.counts();
    say(id, std::to_string(n.positions) + " positions sent, " + std::to_string(n.refused) + " refused, " +
                std::to_string(n.stops) + " stops, " + std::to_string(n.reports) + " reports of where it points");
  }
  return exit_ok;
}

int serve(const Options& o) {
  const config::ServiceConfig config = load_live(o);
  const AntennaConfig& antenna = antenna_of(config, o.antenna);
  const StopSignal stop;
  rotctl::Server server({.endpoint = o.endpoint,
                         .travel = travel_of(antenna),
                         .ahead = antenna.link_delay + antenna.lead,
                         .info = "Downrange " DOWNRANGE_VERSION ", commands to " + std::string(antenna.id.view())},
                        [&](const std::string& text) { say(antenna.id, text); });
  dds::Participant participant(participant_options(config, "downrange-rotctld"));
  const dds::OutputReaders commands = read_commands(participant, [&](const SlavingCommand& command) {
    if (command.antenna == antenna.id) server.take(command);
  });
  say(antenna.id, "where it is commanded to point is told on " + rotctl::to_string(server.endpoint()));
  wait_for_stop(stop, participant);
  return exit_ok;
}

}  // namespace

void add_rotctl(CLI::App& app, Run& run) {
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("rotctl", "Move antennas through their rotator daemons (Hamlib's rotctld)");
  command->add_option("CONFIG", o->dds.config, "Configuration of the range, with [antenna.rotctl]")->required();
  command->add_option("--antenna", o->antennas, "Of these antennas only, e.g. goheung-tm,jeju-tm (default: all)");
  o->dds.add_to(*command);
  command->footer(
      "Follows downrange/slaving: rate_hz times a second the position for the instant at which the rotator is there\n"
      "(link_delay_ms and lead_ms of [[antenna]] after it is sent); when no valid command is left it is stopped. What\n"
      "the rotator measures goes to range/antenna. A rotator that is silent, or gone, is connected to again. Ctrl-C "
      "or\n"
      "SIGTERM stops the rotators that are moving, and ends.");
  command->callback([o, &run] { run = [o] { return drive(*o); }; });
}

void add_rotctld(CLI::App& app, Run& run) {
  auto o = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("rotctld", "Tell trackers where an antenna points, as Hamlib's rotctld does; moves nothing");
  command->add_option("CONFIG", o->dds.config, "Configuration of the range")->required();
  command->add_option("ANTENNA", o->antenna, "Whose commands are told")->required();
  command->add_option("--listen", o->endpoint.host, "Address to listen on; 0.0.0.0: of every interface")
      ->capture_default_str();
  command->add_option("--port", o->endpoint.port, "TCP port; 0: one that is free")
      ->capture_default_str()
      ->check(CLI::Range(0, 65'535));
  o->dds.add_to(*command);
  command->footer(
      "p (\\get_pos) tells azimuth and elevation that hold now, in deg, RPRT -11 while no command holds; \\dump_state\n"
      "the travel of [[antenna]], _ what this is, q ends. What would move a rotator (P, S, K, R, M) is refused: RPRT\n"
      "-11; what is no command: RPRT -1. At most 16 clients. Anyone who reaches the port may ask: mind --listen.");
  command->callback([o, &run] { run = [o] { return serve(*o); }; });
}

}  // namespace downrange::app
