#include <archive/reader.hpp>
#include <archive/replay.hpp>
#include <fstream>
#include <iostream>
#include <mutex>
#include <type_traits>

#include "app/machine_clock.hpp"
#include "command.hpp"
#include "dds/inputs.hpp"
#include "dds/outputs.hpp"
#include "pace.hpp"
#include "preflight.hpp"

namespace downrange::app {
namespace {

struct Options {
  DdsOptions dds;
  std::string archive;
  std::string json;
  double seconds = 10;
  OutputFiles files;
};

PreflightLimits limits_of(const Options& o) {
  PreflightLimits limits;
  limits.window = seconds(o.seconds);
  return limits;
}

/// The given configuration, or the one that the archive carries.
config::ServiceConfig configuration_of(const Options& o) {
  if (!o.dds.config.empty()) return o.dds.load();
  const auto attached = archive::read_attachment(o.archive, "config.toml");
  if (!attached) throw std::runtime_error(o.archive + " carries no configuration: give one");
  return config::load_text(*attached, o.archive + ":config.toml", o.dds.overrides());
}

void read(const std::string& path, Preflight& preflight) {
  archive::require_events(path);
  archive::Reader reader(path);
  while (const auto entry = reader.next()) {
    std::visit(
        [&]<class Record>(const Record& record) {
          if constexpr (std::is_same_v<Record, archive::BadRecord>) {
            throw archive::ArchiveError(path + ": " + record.topic + ": " + record.what);
          } else if constexpr (std::is_same_v<Record, SlavingCommand>) {
            preflight.note(record);
          } else if constexpr (std::is_constructible_v<Event, const Record&>) {
            if (entry->role == archive::Role::Input) preflight.note(Event(record));
          }
        },
        entry->record);
  }
  reader.raw().require_declared();
}

void listen(const Options& o, const config::ServiceConfig& config, Preflight& preflight) {
  if (config.clock.mode != config::ClockMode::Wall)
    throw std::runtime_error("preflight looks at what comes live, on the wall clock; of a recorded flight: --archive");
  const StopSignal stop;
  std::mutex mutex;  // the middleware calls back from several threads
  dds::Participant participant(participant_options(config, "downrange-preflight"));
  {
    const dds::InputReader inputs(participant, {.sensors = true, .mission = true, .ingest_nodes = {}},
                                  [&](const Event& event, const dds::RangeStamp&, const Name&) {
                                    const std::scoped_lock lock(mutex);
                                    preflight.note(event);
                                  });
    dds::OutputSelection wanted;
    wanted.health = wanted.lossless = false;
    const dds::OutputReaders results(participant, wanted,
                                     {.result =
                                          [&](const Result& result) {
                                            const std::scoped_lock lock(mutex);
                                            if (const auto* c = std::get_if<SlavingCommand>(&result))
                                              preflight.note(*c);
                                          },
                                      .status =
                                          [&](const dds::ServiceStatus& status) {
                                            const std::scoped_lock lock(mutex);
                                            preflight.note_clock("node " + std::string(status.node.view()), status.utc);
                                          }});
    std::cerr << "listening for " << o.seconds << " s in domain " << config.dds.domain << '\n';
    static_cast<void>(stop.wait_for(std::chrono::milliseconds(static_cast<std::int64_t>(1000 * o.seconds) + 1000)));
  }
  preflight.note_clock("this machine", read_utc_state());
}

int judge(const Options& o) {
  if (o.dds.config.empty() && o.archive.empty()) throw CLI::RequiredError("CONFIG or --archive");
  o.files.check({o.json}, {o.dds.config, o.archive});
  const config::ServiceConfig config = configuration_of(o);
  Preflight preflight(config.range, limits_of(o));
  if (o.archive.empty())
    listen(o, config, preflight);
  else
    read(o.archive, preflight);
  const PreflightReport report = preflight.report();
  std::cout << format_text(report);
  if (!o.json.empty()) {
    std::ofstream out(o.json);
    out << format_json(report) << '\n';
    if (!out.flush()) throw std::runtime_error(o.json + ": cannot be written");
  }
  return report.go() ? exit_ok : exit_failed;
}

}  // namespace

void add_preflight(CLI::App& app, Run& run) {
  auto o = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("preflight", "Go or no-go: sources against the pad, antennas' loops and clocks, on one page");
  command->add_option("CONFIG", o->dds.config, "Configuration of the range (with --archive: default its own)");
  command->add_option("--archive", o->archive, "Judge a recorded flight's last seconds before lift-off instead");
  command->add_option("--seconds", o->seconds, "How long to look")
      ->capture_default_str()
      ->check(CLI::Range(1.0, 3600.0));
  command->add_option("--json", o->json, "Write the page's numbers to this file as well");
  o->files.add_to(*command);
  o->dds.add_to(*command);
  command->footer(
      "Of each source: messages a second, latency, stamps ahead of reception, what is rejected, and the residual "
      "against\n"
      "[pad], where the vehicle stands until lift-off, in sigma of noise and bias priors. Of each antenna that "
      "reports\n"
      "(range/antenna): how well it follows our commands. Of this machine and each node: is its clock synchronised.\n"
      "What cannot be judged is said and is no no-go. Exit code 0: go, 1: no-go or could not be done, 2: usage.");
  command->callback([o, &run] { run = [o] { return judge(*o); }; });
}

}  // namespace downrange::app
