#include "experiment/experiment.hpp"

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <optional>
#include <thread>

#include "command.hpp"
#include "config/load.hpp"
#include "experiment/faults.hpp"
#include "experiment/flights.hpp"
#include "experiment/honesty.hpp"
#include "experiment/impact.hpp"
#include "experiment/report.hpp"
#include "fault_options.hpp"
#include "progress.hpp"
#include "recorded_flights.hpp"

namespace downrange::app {
namespace {

constexpr std::string_view all = "all";
constexpr std::string_view flights = "flights";
constexpr std::string_view faults = "faults";
constexpr std::string_view honesty = "honesty";
constexpr std::string_view without_gps = "without-gps";

/// Can use recorded flights, and does without.
bool uses_truths(std::string_view name) { return name == honesty || name == without_gps; }

struct Options {
  std::string name;
  bool list = false;
  std::string data;
  int runs = 0;
  std::optional<std::uint64_t> seed;
  int jobs = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  std::vector<std::string> methods;
  std::string faults;
  std::vector<std::string> only;
  std::string json;
  std::string html;
  OutputFiles files;
};

std::vector<experiment::flights::RecordedFlight> load_flights(const std::filesystem::path& folder) {
  std::vector<experiment::flights::RecordedFlight> loaded;
  for (const std::string& flight : flights_in(folder)) loaded.push_back(load_flight(folder, flight));
  return loaded;
}

/// With the CPU time that it took, of all threads.
experiment::ExperimentResult timed(const std::function<experiment::ExperimentResult()>& run) {
  const std::clock_t begin = std::clock();
  experiment::ExperimentResult result = run();
  const double hours = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC / 3600;
  result.notes.push_back("CPU time: " + experiment::number_text(hours, 3) + " h.");
  return result;
}

/// Those of the papers, then those that want the recorded flights that `folder` has.
std::vector<experiment::Experiment> all_experiments(const std::filesystem::path& folder) {
  std::vector<experiment::Experiment> experiments = experiment::experiments();
  experiments.push_back(
      {"impact", "vacuum impact point: error against the fall of the true state, with GPS and without",
       experiment::impact_runs, experiment::honesty_methods(), [](const experiment::ExperimentOptions& options) {
         return timed([&] { return experiment::run_impact(options); });
       }});
  experiments.push_back(
      {honesty, "covariance against error over many seeds of four profiles, with GPS and without (two of them --data)",
       experiment::honesty_runs, experiment::honesty_methods(), [folder](const experiment::ExperimentOptions& options) {
         return timed([&] { return experiment::run_honesty(options, load_flights(folder)); });
       }});
  experiments.push_back(
      {without_gps, "no GPS: two radars against their uncorrected fusion and the bound, one alone (truths: --data)",
       experiment::without_gps_runs, experiment::honesty_methods(),
       [folder](const experiment::ExperimentOptions& options) {
         return timed([&] { return experiment::run_without_gps(options, load_flights(folder)); });
       }});
  experiments.push_back({flights, "recorded flights (--data): position, biases, gate, sources switched off", 0,
                         experiment::flight_methods(), [folder](const experiment::ExperimentOptions& options) {
                           return experiment::run_flights(options, load_flights(folder));
                         }});
  return experiments;
}

/// The catalogue asked for, with the range and the scenario that it names.
experiment::faults::Plan load_plan(const Options& o) {
  experiment::faults::Plan plan;
  plan.catalogue = sim::load_faults(o.faults.empty() ? default_faults() : o.faults);
  plan.only = o.only;
  const std::string file = plan.catalogue.file.string();
  if (plan.catalogue.range.empty() || plan.catalogue.scenario.empty())
    throw std::runtime_error(file + ": names no range and scenario to fly (keys range, scenario)");
  plan.range = config::load(plan.catalogue.range).range;
  plan.scenario = sim::load_scenario(plan.catalogue.scenario, plan.range);
  return plan;
}

experiment::Experiment faults_experiment(const Options& o) {
  const auto fly = [o](const experiment::ExperimentOptions& options) {
    return experiment::run_faults(options, load_plan(o));
  };
  return {faults,
          "faults of sources and vehicle (--faults): error, accusation, recovery, bound",
          experiment::fault_seeds,
          {"joint"},
          fly};
}

std::vector<std::string> names() {
  std::vector<std::string> names;
  for (const experiment::Experiment& e : all_experiments({})) names.emplace_back(e.name);
  names.emplace_back(faults);
  return names;
}

int list_faults(const Options& o) {
  const experiment::faults::Plan plan = load_plan(o);
  const sim::Fault* last = nullptr;
  for (const experiment::faults::Row& row : experiment::faults::rows_of(plan)) {
    if (row.fault != last) std::cout << row.fault->name << ": " << row.fault->what << '\n';
    std::cout << "    " << row.name << '\n';
    last = row.fault;
  }
  return exit_ok;
}

int list(const Options& o) {
  if (o.name == faults) return list_faults(o);
  std::vector<experiment::Experiment> listed = all_experiments({});
  listed.push_back(faults_experiment(o));
  for (const experiment::Experiment& e : listed) {
    std::cout << e.name << ": " << e.help << "\n    ";
    if (e.runs > 0) std::cout << e.runs << " runs; ";
    std::cout << "methods";
    for (const std::string& method : e.methods) std::cout << (method == e.methods.front() ? " " : ", ") << method;
    std::cout << '\n';
  }
  return exit_ok;
}

/// What can be known to be wrong before hours of computing. Throws CLI::ValidationError.
void check_methods(const experiment::Experiment& experiment, const std::vector<std::string>& methods) {
  try {
    (void)experiment::chosen_methods(methods, experiment.methods);
  } catch (const std::invalid_argument& e) {
    throw CLI::ValidationError("--methods", std::string(experiment.name) + ": " + e.what());
  }
}

void write(const std::string& path, const std::string& text) {
  std::ofstream out(path);
  out << text << '\n';
  if (!out.flush()) throw std::runtime_error(path + ": cannot be written");
}

/// Options that mean nothing for what was chosen. Throws CLI::ValidationError.
void check_options(const Options& o) {
  if (o.name == all && !o.methods.empty())
    throw CLI::ValidationError("--methods", "every experiment compares methods of its own: name one experiment");
  if (o.name == flights && (o.runs > 0 || o.seed))
    throw CLI::ValidationError(o.runs > 0 ? "--runs" : "--seed",
                               "recorded flights are flown as they were: nothing is drawn");
  if (o.name != faults && (!o.faults.empty() || !o.only.empty()))
    throw CLI::ValidationError(o.faults.empty() ? "--only" : "--faults", "only experiment faults plays a catalogue");
  if (o.name != flights && !uses_truths(o.name) && o.name != all && !o.data.empty())
    throw CLI::ValidationError("--data", "only experiment flights, honesty and without-gps read recorded flights");
}

/// Whether `folder` has flights; says so where `all` goes on without them. Throws std::runtime_error where flights were
/// asked for.
bool has_flights(const Options& o, const std::filesystem::path& folder) {
  if (!flights_in(folder).empty()) return true;
  const std::string absent = "no recorded flights in " + folder.string() + " (--data or DOWNRANGE_DATA names another)";
  if (o.name == flights || !o.data.empty()) throw std::runtime_error(absent);
  std::cout << flights << ": left out, " << absent << '\n' << std::endl;
  return false;
}

std::vector<experiment::Experiment> chosen_experiments(const Options& o, const std::filesystem::path& folder) {
  std::vector<experiment::Experiment> chosen;
  if (o.name == faults) {
    (void)experiment::faults::rows_of(load_plan(o));
    check_methods(faults_experiment(o), o.methods);
    return {faults_experiment(o)};
  }
  for (const experiment::Experiment& e : all_experiments(folder)) {
    if (o.name != all && o.name != e.name) continue;
    check_methods(e, o.methods);
    const bool asked_for_flights = e.name == flights || (uses_truths(e.name) && e.name == o.name && !o.data.empty());
    if (!asked_for_flights || has_flights(o, folder)) chosen.push_back(e);
  }
  return chosen;
}

/// That outputs can be written, as far as it can be known. Throws std::runtime_error.
void check_outputs(const Options& o, const std::filesystem::path& folder) {
  std::vector<std::string> inputs;
  if (o.name == flights || uses_truths(o.name) || o.name == all) {
    for (const std::string& flight : flights_in(folder))
      for (std::string& file : files_of_flight(folder, flight)) inputs.push_back(std::move(file));
  }
  o.files.check({o.json, o.html}, inputs);
  for (const std::string& output : {o.json, o.html}) {
    if (output.empty()) continue;
    const std::filesystem::path parent = std::filesystem::absolute(output).parent_path();
    if (!std::filesystem::is_directory(parent))
      throw std::runtime_error(output + ": there is no folder " + parent.string());
  }
}

int run_experiments(const Options& o) {
  check_options(o);
  const std::filesystem::path folder = flights_folder(o.data);
  const std::vector<experiment::Experiment> chosen = chosen_experiments(o, folder);
  check_outputs(o, folder);
  std::vector<experiment::ExperimentResult> results;
  for (const experiment::Experiment& e : chosen) {
    Progress progress{std::string(e.name)};
    const auto show = [&progress](double fraction) { progress.show(fraction); };
    results.push_back(
        e.run({.runs = o.runs, .seed = o.seed.value_or(1), .jobs = o.jobs, .methods = o.methods, .progress = show}));
    progress.done();
    std::cout << experiment::format_text(results.back()) << std::endl;
  }
  if (!o.json.empty()) write(o.json, experiment::format_json(results));
  if (!o.html.empty()) write(o.html, experiment::format_html(results));
  return std::all_of(results.begin(), results.end(), experiment::all_reached) ? exit_ok : exit_failed;
}

}  // namespace

void add_experiment(CLI::App& app, Run& run) {
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("experiment", "Repeat a paper's experiment, against the figures to reach");
  std::vector<std::string> allowed = names();
  allowed.emplace_back(all);
  command->add_option("NAME", o->name, "Which one, or all of them (but faults, which takes hours)")
      ->check(CLI::IsMember(allowed));
  command->add_flag("--list", o->list,
                    "Tell which experiments there are and what they compare; of faults, what the catalogue has");
  command->add_option(
      "--data", o->data,
      "Folder of the recorded flights (default: DOWNRANGE_DATA, or shared/data beside the checkout, which "
      "experiment flights needs and honesty and without-gps can use: mappings and range are there)");
  command->add_option("--runs", o->runs, "Monte Carlo runs (default: as many as the figures are stated for)")
      ->check(CLI::Range(1, 1'000'000));
  command->add_option("--seed", o->seed, "Draw everything from this seed (default: 1)");
  command->add_option("--jobs", o->jobs, "Threads; the numbers do not depend on it (default: as the machine has)")
      ->check(CLI::Range(1, 1024));
  command->add_option("--methods", o->methods, "Only these, comma-separated (default: all that --list tells)")
      ->delimiter(',');
  command->add_option(
      "--faults", o->faults,
      "Catalogue for experiment faults (default: tools/scenarios/faults/catalogue.toml of the checkout)");
  command
      ->add_option("--only", o->only,
                   "Of experiment faults only these, comma-separated: names as faults --list tells, or gps-*")
      ->delimiter(',');
  command->add_option("--json", o->json, "Write figures and curves to this file as well");
  command->add_option("--html", o->html, "Write a page with the table and the plots to this file as well");
  o->files.add_to(*command);
  command->footer(
      "Exit code 0: every figure is reached, 1: one falls short, 2: command line. The same seed gives the same "
      "numbers\n"
      "on any number of threads. Fewer runs than stated give figures that scatter more than their limits allow for.");
  command->callback([o, &run] {
    run = [o] {
      if (o->list) return list(*o);
      if (o->name.empty()) throw CLI::RequiredError("NAME (or --list)");
      return run_experiments(*o);
    };
  });
}

}  // namespace downrange::app
