#include <algorithm>
#include <archive/reader.hpp>
#include <archive/replay.hpp>
#include <array>
#include <downrange/stage/catalogue.hpp>
#include <fstream>
#include <iostream>
#include <map>
#include <optional>
#include <set>
#include <text/printable.hpp>

#include "calibration.hpp"
#include "flight.hpp"
#include "progress.hpp"
#include "score/outliers.hpp"
#include "score/scorer.hpp"
#include "sim/scenario.hpp"

namespace downrange::app {
namespace {

struct Options {
  std::string flight;
  std::string truth;
  std::string received;
  std::string config;
  std::string scenario;
  std::string json;
  std::string calibration;
  std::string method;
  OutputFiles files;
};

/// Says so if the archive is cut off. Throws ArchiveError where it has messages that cannot be read.
bool judge_end(const archive::Reader& reader, const std::string& path) {
  reader.raw().require_declared();
  const auto& cut = reader.truncated();
  if (cut)
    std::cerr << "downrange: " << path << " is cut off at byte " << cut->offset << " (" << cut->what
              << "); the report is of what is there\n";
  return cut.has_value();
}

/// The truth of one flight, as a table.
struct FlightTruth {
  Name target;  ///< the first that the archive has truth of
  score::TruthTable table;
};

/// Of the archive named for it, else of the flight's own. Nothing where that holds none.
std::optional<FlightTruth> read_truth(const Options& o, bool& cut_off) {
  const std::string& path = o.truth.empty() ? o.flight : o.truth;
  archive::Reader reader(path);
  std::vector<score::TruthSample> samples;
  Name target;
  while (const auto entry = reader.next()) {
    const auto* truth = std::get_if<archive::Truth>(&entry->record);
    if (truth == nullptr) continue;
    if (target.empty()) target = truth->target;
    if (truth->target == target)
      samples.push_back({.time = truth->epoch, .state = {.position = truth->position, .velocity = truth->velocity}});
  }
  if (!o.truth.empty()) cut_off = judge_end(reader, path) || cut_off;
  if (samples.size() == 1)
    std::cerr << "downrange: " << path << " holds a single true sample, which is no trajectory: judged without truth\n";
  if (samples.size() < 2) return std::nullopt;
  return FlightTruth{.target = target, .table = score::TruthTable(std::move(samples))};
}

/// What the flight's archive tells before anything is judged.
struct Flight {
  struct Span {
    Time first;
    Time last;
  };
  std::optional<Time> liftoff;
  std::map<Name, Span> accepted;  ///< epochs of what ingest accepted, by target
  Name first_target;              ///< of the first of these
  std::set<Name> heard;           ///< sources of these
  std::array<std::uint64_t, reason_count> count{};
  bool has_results = false;

  void add(const Observation& o) {
    ++count[static_cast<std::size_t>(o.verdict)];
    if (o.verdict != Reason::Accepted) return;
    if (accepted.empty()) first_target = o.target;
    heard.insert(o.sensor);
    Span& span = accepted.try_emplace(o.target, Span{o.epoch, o.epoch}).first->second;
    span.first = std::min(span.first, o.epoch);
    span.last = std::max(span.last, o.epoch);
  }
};

/// Results beside observations, which a centre has as inputs.
bool is_result(const archive::Record& record) {
  return std::visit([]<class T>(const T&) { return Outputs::contains<T> && !std::is_same_v<T, Observation>; }, record);
}

/// `outliers` gets the plots.
Flight survey(const std::string& path, score::OutlierFinder* outliers) {
  Flight flight;
  archive::Reader reader(path);
  while (const auto entry = reader.next()) {
    if (const auto* m = std::get_if<MissionEvent>(&entry->record); m != nullptr && m->kind == MissionEventKind::Liftoff)
      flight.liftoff = m->epoch;
    if (const auto* o = std::get_if<Observation>(&entry->record)) {
      flight.add(*o);
      if (outliers != nullptr && !std::holds_alternative<Fix>(o->measured))
        outliers->add(o->sensor, o->sequence, o->epoch, plot_of(o->measured));
    }
    flight.has_results = flight.has_results || is_result(entry->record);
  }
  reader.raw().require_declared();
  return flight;
}

/// "unknown_source 20, too_late 3"
std::string reasons(const Flight& flight) {
  std::string text;
  for (std::size_t i = 0; i < reason_count; ++i) {
    const auto reason = static_cast<Reason>(i);
    if (reason == Reason::Accepted || flight.count[i] == 0) continue;
    text += (text.empty() ? "" : ", ") + std::string(to_string(reason)) + ' ' + std::to_string(flight.count[i]);
  }
  return text.empty() ? "there was none" : "rejected: " + text;
}

/// The flight as a whole, from its first accepted measurement to its last, of whatever kind.
score::Phase whole(const Flight::Span& span, Time liftoff) {
  return {"flight", (span.first - liftoff).seconds() - 1, (span.last - liftoff).seconds() + 1};
}

/// The same events through the same engine, one radar by itself and no bias estimation.
void replay_alone(const std::string& flight, RangeConfig range, const StageSet& stages, const Name& radar,
                  ResultSink& sink) {
  std::erase_if(range.radars, [&](const RadarConfig& r) { return r.id != radar; });
  range.fuse.methods = {"uncorrected"};
  range.antennas.clear();
  archive::EventSource source(flight);
  replay_in_process(source, range, stages, sink, [](const Event&) {});
}

void print_service_status(const std::string& received) {
  archive::RawReader reader(received);
  while (reader.next()) {
  }
  const auto found = reader.metadata().find("status");
  if (found == reader.metadata().end()) return;
  const auto& s = found->second;
  const auto status = [&](const char* key) {
    return s.count(key) != 0 ? text::printable(s.at(key), false, 100) : std::string("?");
  };
  std::cout << "\nService " << status("node") << ": plot in to results written, median " << status("latency_p50_us")
            << ", 95 % " << status("latency_p95_us") << ", 99 % " << status("latency_p99_us") << ", worst "
            << status("latency_max_us") << " microseconds; " << status("consumed") << " messages in, "
            << status("emitted") << " results out, " << status("dropped") << " dropped, " << status("write_failures")
            << " failed writes.\n";
}

config::ServiceConfig configuration_of(const Options& o) {
  if (!o.config.empty()) return config::load(o.config);
  const auto attached = archive::read_attachment(o.flight, "config.toml");
  if (!attached) throw std::runtime_error(o.flight + " carries no configuration: give one with --config");
  return config::load_text(*attached, o.flight + ":config.toml");
}

/// The archive's results, and the commands that a consumer recorded instead of those sent, into the scorer.
void score_results(const Options& o, ResultSink& sink, Progress& progress, bool& cut_off) {
  const bool commands_from_consumer = !o.received.empty();
  archive::Reader results(o.flight);
  while (const auto entry = results.next()) {
    progress.show(0.5 * results.raw().progress());
    std::visit(
        [&](const auto& r) {
          if constexpr (std::is_constructible_v<Result, decltype(r)>) {
            if (commands_from_consumer && std::is_same_v<std::decay_t<decltype(r)>, SlavingCommand>) return;
            sink.emit(Result(r));
          }
        },
        entry->record);
  }
  cut_off = judge_end(results, o.flight) || cut_off;
  if (!commands_from_consumer) return;
  archive::Reader reader(o.received);
  while (const auto entry = reader.next()) {
    if (const auto* c = std::get_if<SlavingCommand>(&entry->record)) sink.emit(Result(*c));
  }
  cut_off = judge_end(reader, o.received) || cut_off;
}

/// Every radar that was heard and tells positions, by itself.
void score_radars_alone(const Options& o, const config::ServiceConfig& config, const std::set<Name>& heard,
                        score::Scorer& scorer, Progress& progress) {
  std::vector<Name> radars;
  for (const Source& source : SourceTable(config.range))
    if (measures_position(source) && heard.contains(source.name)) radars.push_back(source.name);
  for (std::size_t i = 0; i < radars.size(); ++i) {
    progress.show(0.5 + 0.5 * static_cast<double>(i) / static_cast<double>(radars.size()));
    replay_alone(o.flight, config.range, config.node.stages, radars[i],
                 scorer.open_run(std::string(radars[i].view()) + " alone"));
  }
}

int report(const Options& o) {
  o.files.check({o.json, o.calibration}, {o.flight, o.truth, o.received, o.config, o.scenario});
  const config::ServiceConfig config = configuration_of(o);
  if (!o.calibration.empty()) return write_calibration(o.flight, o.method, o.calibration, config);

  bool cut_off = false;
  const std::optional<FlightTruth> known = read_truth(o, cut_off);
  if (!known && !o.truth.empty()) throw std::runtime_error(o.truth + " holds no true trajectory");
  score::TruthFunction truth;
  if (known) truth = [&table = known->table](Time t) { return table.at(t); };
  std::optional<score::OutlierFinder> outliers;
  if (known) outliers.emplace(config.range, truth);

  const Flight flight = survey(o.flight, outliers ? &*outliers : nullptr);
  if (!flight.has_results)
    throw std::runtime_error(o.flight + " holds no results: run downrange replay " + o.flight + " --out FILE first");
  const Name target = known ? known->target : flight.first_target;
  const auto span = flight.accepted.find(target);
  if (span == flight.accepted.end())
    throw std::runtime_error(o.flight + " holds no accepted measurement" +
                             (target.empty() ? "" : " of " + std::string(target.view())) +
                             ", so there is nothing to judge; " + reasons(flight));
  const Time liftoff = flight.liftoff.value_or(span->second.first);
  std::vector<score::Phase> phases;
  if (!o.scenario.empty()) phases = sim::load_scenario(o.scenario, config.range).phases;
  if (phases.empty()) phases.push_back(whole(span->second, liftoff));

  score::Scorer scorer(config.range, target, truth, liftoff, phases);
  if (outliers) scorer.know_outliers(outliers->outliers(), score::OutlierOrigin::Truth);
  Progress progress("scoring");
  score_results(o, scorer.open_run("fused"), progress, cut_off);
  score_radars_alone(o, config, flight.heard, scorer, progress);
  progress.show(1);
  progress.done();

  const score::Summary summary = scorer.summary();
  if (!flight.liftoff) std::cout << "No lift-off is recorded: times count from the first accepted measurement.\n\n";
  std::cout << text::printable(score::format_text(summary), true);
  if (!o.received.empty()) print_service_status(o.received);
  if (!o.json.empty()) {
    std::ofstream out(o.json);
    out << score::format_json(summary) << '\n';
    if (!out.flush()) throw std::runtime_error(o.json + ": cannot be written");
  }
  return cut_off ? exit_cut_off : exit_ok;
}

}  // namespace

void add_report(CLI::App& app, Run& run) {
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "report", "Judge a flight: position, bias, pointing against its truth, and what its sources say of each other");
  command->add_option("FLIGHT", o->flight, "Archive with events and results, of downranged or of replay --out")
      ->required();
  command->add_option("--truth", o->truth, "Archive with the true trajectory (default: FLIGHT itself, if it has one)");
  command->add_option("--received", o->received,
                      "What a slaving consumer received (watch --record): its commands are judged");
  command->add_option("--config", o->config, "Configuration (default: the one in FLIGHT)");
  command->add_option("--scenario", o->scenario,
                      "Scenario whose phases the flight is judged by (default: the flight as a whole)");
  command->add_option("--json", o->json, "Write the numbers to this file as well");
  CLI::Option* calibration = command->add_option(
      "--calibration", o->calibration, "Write the biases found to this file instead, for the sensors' key calibration");
  command->add_option("--method", o->method, "Whose biases (default: the first, by which antennas were pointed)")
      ->needs(calibration)
      ->check(CLI::IsMember(method_names()));
  o->files.add_to(*command);
  command->footer(
      "Beside the fused track: the fusion without bias correction (where it ran) and every radar alone, replayed here\n"
      "from the same messages. The flight begins with its first accepted measurement. Plots further than 10 sigma "
      "from\n"
      "the median of their 10 s are outliers and not scored. Without truth, fixes are held against the track just "
      "before\n"
      "each, and accounts, consistency and biases of the sources are told.\n"
      "Exit code 3: an archive read is cut off, and the report is of what is there.");
  command->callback([o, &run] { run = [o] { return report(*o); }; });
}

}  // namespace downrange::app
