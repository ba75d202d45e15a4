#include "experiment/flights.hpp"

#include <algorithm>
#include <downrange/stage/source_table.hpp>
#include <set>

#include "experiment/parallel.hpp"

namespace downrange::experiment {
namespace flights {
namespace {

constexpr double end_s = 600;
/// GPS is out from 160 to 184 s on both flights: the flight as a whole, and that.
const std::vector<score::Phase> whole_and_outage{{"flight", 0, end_s}, {"outage", 160, 184}};
/// Fusion against one source: before and after the outage, which GPS alone does not survive.
const std::vector<score::Phase> around_outage{{"flight", 0, end_s}, {"20-155 s", 20, 155}, {"190-600 s", 190, end_s}};

std::vector<Name> radars_seen(const RecordedFlight& flight) {
  std::set<Name> seen;
  for (const Event& event : flight.events)
    if (const auto* plot = std::get_if<RadarTspi>(&event)) seen.insert(plot->sensor);
  std::vector<Name> radars;
  for (const Source& source : SourceTable(flight.range))
    if (seen.contains(source.name)) radars.push_back(source.name);
  return radars;
}

/// What is flown of one flight: those that take longest first.
std::vector<Replay> replays(const RecordedFlight& flight, const std::vector<Name>& methods) {
  const std::vector<Name> radars = radars_seen(flight);
  std::vector<Name> stations;
  for (const Source& source : SourceTable(flight.range))
    if (source.kind == SourceKind::Telemetry) stations.push_back(source.name);
  const auto is_asked = [&](const Name& method) {
    return std::find(methods.begin(), methods.end(), method) != methods.end();
  };
  std::vector<Replay> all{
      {.label = "everything", .methods = methods, .phases = whole_and_outage, .points = true},
      {.label = "without GPS", .methods = methods, .without = stations, .phases = whole_and_outage}};
  for (const Name& radar : radars)
    all.push_back({.label = "without " + std::string(radar.view()),
                   .methods = methods,
                   .without = {radar},
                   .phases = whole_and_outage});
  std::vector<Name> of_residuals;
  for (const Name method : {"joint", "uncorrected"})
    if (is_asked(method)) of_residuals.push_back(method);
  if (!of_residuals.empty())
    all.push_back({.label = "in order", .methods = of_residuals, .phases = whole_and_outage, .in_order = true});
  if (!is_asked("joint")) return all;
  const std::vector<Name> joint{"joint"};
  all.push_back({.label = "on ticks", .methods = joint, .phases = around_outage, .on_ticks = true});
  all.push_back({.label = "GPS alone", .methods = joint, .without = radars, .phases = around_outage, .on_ticks = true});
  for (const Name& radar : radars) {
    std::vector<Name> others = stations;
    std::copy_if(radars.begin(), radars.end(), std::back_inserter(others), [&](const Name& r) { return r != radar; });
    all.push_back({.label = std::string(radar.view()) + " alone",
                   .methods = joint,
                   .without = others,
                   .phases = around_outage,
                   .on_ticks = true});
  }
  return all;
}

}  // namespace

const Flown* FlightResult::find(std::string_view label) const {
  const auto found = std::find_if(flown.begin(), flown.end(), [&](const Flown& f) { return f.replay.label == label; });
  return found == flown.end() ? nullptr : &*found;
}

std::vector<FlightResult> fly(std::span<const RecordedFlight> flights, const ExperimentOptions& options) {
  std::vector<Name> methods;
  for (const std::string& method : chosen_methods(options.methods, flight_methods())) methods.emplace_back(method);
  struct Job {
    std::size_t flight;
    Replay replay;
  };
  std::vector<Job> jobs;
  std::vector<FlightResult> results;
  for (std::size_t i = 0; i < flights.size(); ++i) {
    results.push_back({flights[i].name, flights[i].range, radars_seen(flights[i]), {}});
    for (const Replay& replay : replays(flights[i], methods)) jobs.push_back({i, replay});
  }
  const auto run = [&](int i) {
    const Job& job = jobs[static_cast<std::size_t>(i)];
    return fly(flights[job.flight], job.replay);
  };
  std::vector<Flown> flown = parallel_runs<Flown>(static_cast<int>(jobs.size()), options.jobs, run, options.progress);
  for (std::size_t i = 0; i < jobs.size(); ++i) results[jobs[i].flight].flown.push_back(std::move(flown[i]));
  return results;
}

}  // namespace flights

const std::vector<std::string>& flight_methods() {
  static const std::vector<std::string> methods{"joint", "schmidt", "song2015", "uncorrected"};
  return methods;
}

ExperimentResult flights_result(std::span<const flights::FlightResult> flown) {
  ExperimentResult out;
  out.name = "flights";
  out.title = "Recorded flights through the service's engine";
  out.settings = {
      {"flights", "profiles of real flights with synthesised sensors; positions against their truth, 0-600 s"},
      {"range", "config/cape.toml: joint with its defaults, launch kinematics, gate 0.9999"},
      {"in the GPS outage", "160-184 s"},
      {"best single source",
       "joint with GPS alone and with each radar alone, position on every tick (25 ms), same windows"},
      {"outliers",
       "plots 10 sigma and more off the median of their 10 s; rejected by ingest or gate, as they arrive and in order"},
      {"systematic error left", "rms of the 10 s means of plot - truth, newest bias known before the plot taken out"},
      {"NIS, residuals",
       "the same messages at their own epochs; plots that the gate rejects are outside; azimuth on the sky"}};
  for (const flights::FlightResult& flight : flown) {
    for (Figure& figure : flights::figures(flight)) out.figures.push_back(std::move(figure));
    for (Plot& plot : flights::plots(flight)) out.plots.push_back(std::move(plot));
    for (std::string& note : flights::notes(flight)) out.notes.push_back(std::move(note));
  }
  return out;
}

ExperimentResult run_flights(const ExperimentOptions& options, std::span<const flights::RecordedFlight> recorded) {
  return flights_result(flights::fly(recorded, options));
}

}  // namespace downrange::experiment
