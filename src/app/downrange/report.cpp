#include <algorithm>
#include <archive/reader.hpp>
#include <archive/replay.hpp>
#include <cmath>
#include <fstream>
#include <iostream>
#include <map>

#include "calibration.hpp"
#include "flight.hpp"
#include "progress.hpp"
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

/// Says so if the archive is cut off.
bool judge_end(const archive::Reader& reader, const std::string& path) {
  const auto& cut = reader.truncated();
  if (cut)
    std::cerr << "downrange: " << path << " is cut off at byte " << cut->offset << " (" << cut->what
              << "); the report is of what is there\n";
  return cut.has_value();
}

/// The truth of one flight, as a table.
struct FlightTruth {
  Name target;  ///< the first that the archive has truth of
  bool cut_off = false;
  score::TruthTable table;
};

FlightTruth read_truth(const std::string& path) {
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
  const bool cut_off = judge_end(reader, path);
  if (samples.size() < 2) throw std::runtime_error(path + " holds no true trajectory: name one with --truth");
  return {.target = target, .cut_off = cut_off, .table = score::TruthTable(std::move(samples))};
}

/// Plots that no noise explains: further than this many sigma from the median of their 10 s. A slow bias is no outlier.
constexpr double outlier_sigmas = 10;
constexpr double outlier_bin_s = 10;

/// Marks the outliers among a flight's plots by the truth, so that systematic errors are those of the good plots.
void mark_outliers(const std::string& flight, const RangeConfig& range, const score::TruthTable& truth,
                   score::Scorer& scorer) {
  struct Plot {
    std::uint64_t sequence;
    std::array<double, 3> sigmas;  ///< error of range, azimuth, elevation over its 1-sigma
  };
  std::map<std::pair<Name, std::int64_t>, std::vector<Plot>> bins;
  archive::Reader reader(flight);
  while (const auto entry = reader.next()) {
    const auto* p = std::get_if<RadarTspi>(&entry->record);
    if (p == nullptr) continue;
    const auto radar =
        std::find_if(range.radars.begin(), range.radars.end(), [&](const auto& r) { return r.id == p->sensor; });
    const auto state = truth.at(p->epoch);
    if (radar == range.radars.end() || !state) continue;
    const Polar q = polar_from_enu(radar->site.enu_of(state->position));
    const std::array<double, 3> sigmas{
        (p->measured.range_m - q.range_m) / radar->sigma.range_m,
        wrap_pi(p->measured.azimuth_rad - q.azimuth_rad) * std::cos(q.elevation_rad) / radar->sigma.azimuth_rad,
        (p->measured.elevation_rad - q.elevation_rad) / radar->sigma.elevation_rad};
    bins[{p->sensor, p->epoch.ns / static_cast<std::int64_t>(outlier_bin_s * 1e9)}].push_back({p->sequence, sigmas});
  }
  for (auto& [key, plots] : bins) {
    std::array<double, 3> median{};
    for (std::size_t k = 0; k < 3; ++k) {
      auto middle = plots.begin() + static_cast<std::ptrdiff_t>(plots.size() / 2);
      std::nth_element(plots.begin(), middle, plots.end(),
                       [k](const Plot& a, const Plot& b) { return a.sigmas[k] < b.sigmas[k]; });
      median[k] = middle->sigmas[k];
    }
    for (const Plot& plot : plots) {
      for (std::size_t k = 0; k < 3; ++k) {
        if (!(std::abs(plot.sigmas[k] - median[k]) <= outlier_sigmas)) scorer.mark_outlier(key.first, plot.sequence);
      }
    }
  }
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

/// Events of the flight that the report needs beside the results.
struct Marks {
  std::optional<Time> liftoff;
  std::optional<Time> first;
  Time last{};
};

void print_service_status(const std::string& received) {
  archive::RawReader reader(received);
  while (reader.next()) {
  }
  const auto found = reader.metadata().find("status");
  if (found == reader.metadata().end()) return;
  const auto& s = found->second;
  const auto text = [&](const char* key) { return s.count(key) != 0 ? s.at(key) : std::string("?"); };
  std::cout << "\nService " << text("node") << ": plot in to results written, median " << text("latency_p50_us")
            << ", 95 % " << text("latency_p95_us") << ", 99 % " << text("latency_p99_us") << ", worst "
            << text("latency_max_us") << " microseconds; " << text("consumed") << " messages in, " << text("emitted")
            << " results out, " << text("dropped") << " dropped, " << text("write_failures") << " failed writes.\n";
}

int report(const Options& o) {
  o.files.check({o.json, o.calibration}, {o.flight, o.truth, o.received, o.config, o.scenario});
  config::ServiceConfig config;
  if (!o.config.empty()) {
    config = config::load(o.config);
  } else {
    const auto attached = archive::read_attachment(o.flight, "config.toml");
    if (!attached) throw std::runtime_error(o.flight + " carries no configuration: give one with --config");
    config = config::load_text(*attached, o.flight + ":config.toml");
  }
  if (!o.calibration.empty()) return write_calibration(o.flight, o.method, o.calibration, config);
  const FlightTruth known = read_truth(o.truth.empty() ? o.flight : o.truth);
  const score::TruthTable& truth = known.table;

  Marks marks;
  bool has_results = false;
  bool cut_off = known.cut_off;
  {
    archive::Reader reader(o.flight);
    while (const auto entry = reader.next()) {
      if (const auto* m = std::get_if<MissionEvent>(&entry->record);
          m != nullptr && m->kind == MissionEventKind::Liftoff)
        marks.liftoff = m->epoch;
      const auto* plot = std::get_if<RadarTspi>(&entry->record);
      if (plot != nullptr) {
        if (!marks.first) marks.first = plot->epoch;
        marks.last = std::max(marks.last, plot->epoch);
      }
      has_results = has_results || std::holds_alternative<Trajectory>(entry->record);
    }
    if (!o.truth.empty()) cut_off = judge_end(reader, o.flight) || cut_off;
  }
  if (!marks.first) throw std::runtime_error(o.flight + " holds no radar plots");
  if (!has_results)
    throw std::runtime_error(o.flight + " holds no trajectory: run downrange replay " + o.flight + " --out FILE first");
  const Time liftoff = marks.liftoff.value_or(*marks.first);
  std::vector<score::Phase> phases;
  if (!o.scenario.empty()) phases = sim::load_scenario(o.scenario, config.range).phases;
  if (phases.empty())
    phases.push_back({"flight", (*marks.first - liftoff).seconds() - 1, (marks.last - liftoff).seconds() + 1});

  score::Scorer scorer(
      config.range, known.target, [&](Time t) { return truth.at(t); }, liftoff, phases);
  mark_outliers(o.flight, config.range, truth, scorer);

  Progress progress("scoring");
  ResultSink& flown = scorer.open_run("fused");
  const bool commands_from_consumer = !o.received.empty();
  archive::Reader results(o.flight);
  while (const auto entry = results.next()) {
    progress.show(0.5 * results.raw().progress());
    std::visit(
        [&](const auto& r) {
          if constexpr (std::is_constructible_v<Result, decltype(r)>) {
            // Where a consumer recorded what it received, its commands are what counts.
            if (commands_from_consumer && std::is_same_v<std::decay_t<decltype(r)>, SlavingCommand>) return;
            flown.emit(Result(r));
          }
        },
        entry->record);
  }
  if (commands_from_consumer) {
    archive::Reader reader(o.received);
    while (const auto entry = reader.next()) {
      if (const auto* c = std::get_if<SlavingCommand>(&entry->record)) flown.emit(Result(*c));
    }
    cut_off = judge_end(reader, o.received) || cut_off;
  }
  for (std::size_t i = 0; i < config.range.radars.size(); ++i) {
    const Name& radar = config.range.radars[i].id;
    progress.show(0.5 + 0.5 * static_cast<double>(i) / static_cast<double>(config.range.radars.size()));
    replay_alone(o.flight, config.range, config.node.stages, radar,
                 scorer.open_run(std::string(radar.view()) + " alone"));
  }
  progress.show(1);
  progress.done();

  const score::Summary summary = scorer.summary();
  std::cout << score::format_text(summary);
  if (commands_from_consumer) print_service_status(o.received);
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
  CLI::App* command = app.add_subcommand("report", "Judge a flight against its truth: position, bias, pointing");
  command->add_option("FLIGHT", o->flight, "Archive with events and results, of downranged or of replay --out")
      ->required();
  command->add_option("--truth", o->truth, "Archive with the true trajectory (default: FLIGHT itself)");
  command->add_option("--received", o->received,
                      "What a slaving consumer received (watch --record): its commands are judged");
  command->add_option("--config", o->config, "Configuration (default: the one in FLIGHT)");
  command->add_option("--scenario", o->scenario,
                      "Scenario whose phases the flight is judged by (default: the flight as a whole)");
  command->add_option("--json", o->json, "Write the numbers to this file as well");
  CLI::Option* calibration = command->add_option(
      "--calibration", o->calibration,
      "Write the biases found to this file instead, for the radars' key calibration; needs no truth");
  command->add_option("--method", o->method, "Whose biases (default: the method that slaving followed)")
      ->needs(calibration)
      ->check(CLI::IsMember(method_names()));
  o->files.add_to(*command);
  command->footer(
      "Beside the fused track: the fusion without bias correction (where it ran) and every radar alone, replayed here\n"
      "from the same messages. Plots further than 10 sigma from the median of their 10 s are outliers and not scored.\n"
      "Exit code 3: an archive read is cut off, and the report is of what is there.");
  command->callback([o, &run] { run = [o] { return report(*o); }; });
}

}  // namespace downrange::app
