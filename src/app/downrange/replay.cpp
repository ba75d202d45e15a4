#include <algorithm>
#include <archive/replay.hpp>
#include <chrono>
#include <cstdio>
#include <downrange/stage/catalogue.hpp>
#include <iostream>
#include <numeric>
#include <set>

#include "fault_options.hpp"
#include "flight.hpp"
#include "pace.hpp"
#include "progress.hpp"
#include "text/printable.hpp"

namespace downrange::app {
namespace {

struct Options {
  DdsOptions dds;
  std::string archive;
  std::string out;
  std::string methods;
  std::string rate = "max";
  bool sort = false;
  bool over_dds = false;
  std::string nodes;
  FaultOptions fault;
  std::uint64_t seed = 1;
  OutputFiles files;
};

/// The given configuration, or the one the archive carries.
config::ServiceConfig configuration(const Options& o) {
  config::Overrides overrides = o.dds.overrides();
  if (!o.methods.empty()) {
    std::string list;
    for (const Name& name : parse_names(o.methods))
      list += (list.empty() ? "\"" : ", \"") + std::string(name.view()) + "\"";
    overrides.push_back({"fuse.methods", "[" + list + "]", "--methods"});
  }
  if (!o.dds.config.empty()) return config::load(o.dds.config, overrides);
  const auto attached = archive::read_attachment(o.archive, "config.toml");
  if (!attached) throw std::runtime_error(o.archive + " carries no configuration: give one with --config");
  return config::load_text(*attached, o.archive + ":config.toml", overrides);
}

/// Says where the archive ends if it is cut off. The exit code.
int judge_end(const archive::EventSource& source, const std::string& path) {
  if (!source.truncated()) return exit_ok;
  std::cerr << "downrange: " << path << " is cut off at byte " << source.truncated()->offset << " ("
            << source.truncated()->what << "); replayed up to there\n";
  return exit_cut_off;
}

/// How many results of each topic there were, and how many measurements of each verdict.
struct Counter final : ResultSink {
  void emit(const Result& result) override {
    std::visit([this]<class Record>(const Record&) { ++count[Outputs::index_of<Record>()]; }, result);
    if (const auto* observation = std::get_if<Observation>(&result)) count_verdict(*observation);
  }
  void count_verdict(const Observation& observation) {
    ++verdicts.at(static_cast<std::size_t>(observation.verdict));
    if (observation.verdict == Reason::UnknownSource && unknown.size() < most_named) unknown.insert(observation.sensor);
  }
  std::array<std::uint64_t, Outputs::size> count{};  ///< by the place in Outputs
  std::array<std::uint64_t, reason_count> verdicts{};
  static constexpr std::size_t most_named = 9;  ///< and the last of them as "..."
  std::set<Name> unknown;                       ///< of those rejected as unknown_source: who sent them
};

/// Measurements that the configuration has no place for, beside others that it has.
void tell_unknown(const Counter& counter, const Options& o) {
  const std::uint64_t rejected = counter.verdicts[static_cast<std::size_t>(Reason::UnknownSource)];
  if (rejected == 0) return;
  std::string names;
  std::size_t named = 0;
  for (const Name& name : counter.unknown) {
    if (++named == Counter::most_named) break;
    names += (names.empty() ? "" : ", ") + text::printable(name.view());
  }
  if (named == Counter::most_named) names += ", ...";
  std::cerr << "downrange: " << o.archive << ": " << rejected << " measurements of " << names
            << " are rejected (unknown_source): the configuration does not have the source, or the target\n";
}

/// What most often makes a whole flight worth nothing.
std::string advice(Reason reason) {
  switch (reason) {
    case Reason::SimulatedMismatch:
      return "the flight is simulated and the configuration expects a real one, or the reverse: "
             "--set ingest.expect_simulated=true or false";
    case Reason::UnknownSource:
      return "the configuration does not have these radars, stations or targets: is it this flight's range?";
    default:
      return "is this the flight's configuration?";
  }
}

/// Says so when there were measurements and none was accepted, or some of sources that nobody configured. The exit
/// code.
int judge_verdicts(const Counter& counter, const Options& o) {
  const auto& verdicts = counter.verdicts;
  const std::uint64_t rejected = std::accumulate(verdicts.begin() + 1, verdicts.end(), std::uint64_t{0});
  if (rejected == 0 || verdicts[static_cast<std::size_t>(Reason::Accepted)] > 0) {
    tell_unknown(counter, o);
    return exit_ok;
  }
  std::string reasons;
  for (std::size_t i = 1; i < verdicts.size(); ++i) {
    if (verdicts[i] == 0) continue;
    reasons += (reasons.empty() ? "" : ", ") + std::to_string(verdicts[i]) + ' ' +
               std::string(to_string(static_cast<Reason>(i)));
  }
  const auto most = static_cast<Reason>(std::max_element(verdicts.begin() + 1, verdicts.end()) - verdicts.begin());
  std::cerr << "downrange: " << o.archive << ": none of its " << rejected << " measurements was accepted (" << reasons
            << "); " << advice(most) << '\n';
  if (!o.out.empty()) std::cerr << "downrange: " << o.out << " is written: of each measurement, why it was rejected\n";
  return exit_failed;
}

/// The archive's events with the fault in them. Reads all of it.
std::vector<Event> with_fault(const Options& o, const config::ServiceConfig& config, archive::EventSource& source) {
  const ChosenFault fault(o.fault);
  if (fault.fault().actions.empty())
    throw std::runtime_error(fault.fault().name +
                             ": is a flight of its own, which no recorded flight can become: use simulate");
  std::vector<Event> events;
  while (auto event = source.next()) events.push_back(std::move(*event));
  const Time liftoff = liftoff_told(events, o.archive);
  return fault.play(std::move(events), config.range, liftoff, o.seed);
}

int replay_here(const Options& o, const config::ServiceConfig& config) {
  archive::require_events(o.archive);
  archive::EventSource source(o.archive, {.sort = o.sort, .slack = config.range.tick});
  std::optional<archive::NewArchive> out;
  archive::Writer* writer = nullptr;
  std::optional<ArchiveSink> to_archive;
  Counter counter;
  std::vector<ResultSink*> sinks{&counter};
  if (!o.out.empty()) {
    writer = &out.emplace(o.out, archive::WriterOptions{.overwrite = o.files.overwrite(o.out)}).writer();
    writer->attach("config.toml", "application/toml", config.text);
    sinks.push_back(&to_archive.emplace(*writer));
  }
  source.on_truth([&](const archive::Truth& truth) {
    if (writer != nullptr) writer->write_truth(truth);
  });

  Progress progress("replaying");
  Pace pace(parse_rate(o.rate));
  FanOut sink(sinks);
  std::optional<Time> first;
  Time last{};
  std::uint64_t events = 0;
  const auto started = std::chrono::steady_clock::now();
  const auto before = [&](const Event& event) {
    last = received_of(event);
    if (!first) first = last;
    pace.wait_until(last);
    if (writer != nullptr) writer->write(event);
    if (const auto* observation = std::get_if<Observation>(&event)) counter.count_verdict(*observation);
    if (++events % 256 == 0) progress.show(source.progress());
  };
  if (o.fault.given()) {
    const std::vector<Event> arrivals = with_fault(o, config, source);
    replay_in_process(arrivals, source.last_tick(), config.range, config.node.stages, sink, before);
  } else {
    replay_in_process(source, config.range, config.node.stages, sink, before);
  }
  if (writer != nullptr && source.last_tick()) writer->write_last_tick(*source.last_tick());
  const int code = out ? close_archive(*out, o.out) : exit_ok;
  const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  progress.show(1);
  progress.done();
  const int end = judge_end(source, o.archive);
  const double flight_s = first ? (last - *first).seconds() : 0;
  std::printf("%s: %llu events over %.1f s replayed in %.2f s (%.0f times real time)\n", o.archive.c_str(),
              static_cast<unsigned long long>(events), flight_s, took, took > 0 ? flight_s / took : 0.0);
  Outputs::for_each([&]<class Record>() {
    const std::string_view topic = MessageInfo<Record>::topic;
    std::printf("  %9llu %.*s\n", static_cast<unsigned long long>(counter.count[Outputs::index_of<Record>()]),
                static_cast<int>(topic.size()), topic.data());
  });
  const int verdicts = judge_verdicts(counter, o);
  if (code != exit_ok) return code;
  return verdicts != exit_ok ? verdicts : end;
}

int replay_over_dds(const Options& o, const config::ServiceConfig& config) {
  archive::require_events(o.archive);
  // Each step has a time of its own: no event may be behind another at all.
  const archive::EventOrder order{.sort = o.sort, .slack = Duration{0}};
  archive::EventSource source(o.archive, order);
  std::vector<Name> nodes = parse_names(o.nodes);
  if (nodes.empty()) {
    nodes = config.dds.ingest_nodes;
    nodes.push_back(config.node.id);
  }
  Progress progress("flying");
  const DriveOptions drive{.nodes = nodes, .rate = parse_rate(o.rate)};
  if (o.fault.given()) {
    const std::vector<Event> arrivals = with_fault(o, config, source);
    std::size_t i = 0;
    drive_over_dds(
        config, "downrange-replay", drive,
        [&]() -> std::optional<Event> { return i < arrivals.size() ? std::optional(arrivals[i++]) : std::nullopt; },
        [&](Time) { progress.show(static_cast<double>(i) / static_cast<double>(arrivals.size())); },
        source.last_tick());
    progress.done();
    return judge_end(source, o.archive);
  }
  // The last tick stands at the archive's end: a first pass finds it, and that every record can be read.
  while (source.next()) {
  }
  archive::EventSource again(o.archive, order);
  drive_over_dds(
      config, "downrange-replay", drive, [&] { return again.next(); }, [&](Time) { progress.show(again.progress()); },
      source.last_tick());
  progress.done();
  return judge_end(again, o.archive);
}

}  // namespace

void add_replay(CLI::App& app, Run& run) {
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("replay", "Replay an archive through the engine, here or over DDS");
  command->add_option("ARCHIVE", o->archive, "Recorded, simulated or imported flight (.mcap)")->required();
  command->add_option("--config", o->dds.config, "Configuration (default: the one in the archive)");
  command->add_option("--methods", o->methods, "Methods side by side, comma-separated (default: the configuration's)");
  command->add_option("--out", o->out, "Write events and results to this archive (.mcap)");
  command->add_option("--rate", o->rate, "Seconds of flight per second, or max")->capture_default_str();
  command->add_flag("--sort", o->sort,
                    "Read the whole archive first and replay its events in the order they were received: for files of "
                    "tools that merge or sort by topic");
  command->add_flag(
      "--dds", o->over_dds,
      "Publish the recorded messages to running nodes: on the range clock in lockstep, on the wall clock with "
      "--rate 1 as if they came now, marked as simulated");
  command->add_option("--nodes", o->nodes,
                      "Nodes that take part, comma-separated (default: dds.ingest_nodes and node.id)");
  o->fault.add_to(*command);
  command->add_option("--seed", o->seed, "Draw what the fault draws from this seed")->capture_default_str();
  o->files.add_to(*command);
  o->dds.add_to(*command);
  command->footer(
      "In-process replay of a recorded flight gives the recorded bits again: compare with downrange diff.\n"
      "Exit code 1: no event in the archive, or none of its measurements accepted. FILE of --out appears when the\n"
      "replay is done: until then it is FILE.part, which a replay that fails removes.\n"
      "Exit code 3: the archive is cut off, and replayed up to its last complete record.");
  command->callback([o, &run] {
    run = [o] {
      o->files.check({o->out}, {o->archive, o->dds.config, o->fault.file});
      const auto config = configuration(*o);
      const std::string not_written = o->out.empty() ? "" : "; " + o->out + " is not written";
      try {
        return o->over_dds ? replay_over_dds(*o, config) : replay_here(*o, config);
      } catch (const archive::OrderError& error) {
        throw archive::ArchiveError(error.what() +
                                    ("; --sort reads the whole archive and sorts it first" + not_written));
      } catch (const archive::ArchiveError& error) {
        throw archive::ArchiveError(error.what() + not_written);
      }
    };
  });
}

}  // namespace downrange::app
