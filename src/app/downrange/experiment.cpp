#include "sim/experiment/experiment.hpp"

#include <algorithm>
#include <fstream>
#include <iostream>
#include <thread>

#include "command.hpp"
#include "progress.hpp"
#include "sim/experiment/report.hpp"

namespace downrange::app {
namespace {

constexpr std::string_view all = "all";

struct Options {
  std::string name;
  bool list = false;
  int runs = 0;
  std::uint64_t seed = 1;
  int jobs = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  std::vector<std::string> methods;
  std::string json;
  std::string html;
  OutputFiles files;
};

std::vector<std::string> names() {
  std::vector<std::string> names;
  for (const sim::Experiment& e : sim::experiments()) names.emplace_back(e.name);
  return names;
}

int list() {
  for (const sim::Experiment& e : sim::experiments()) {
    std::cout << e.name << ": " << e.help << "\n    " << e.runs << " runs; methods";
    for (const std::string& method : e.methods) std::cout << (method == e.methods.front() ? " " : ", ") << method;
    std::cout << '\n';
  }
  return exit_ok;
}

/// What can be known to be wrong before hours of computing. Throws CLI::ValidationError.
void check_methods(const sim::Experiment& experiment, const std::vector<std::string>& methods) {
  try {
    (void)sim::chosen_methods(methods, experiment.methods);
  } catch (const std::invalid_argument& e) {
    throw CLI::ValidationError("--methods", std::string(experiment.name) + ": " + e.what());
  }
}

void write(const std::string& path, const std::string& text) {
  std::ofstream out(path);
  out << text << '\n';
  if (!out.flush()) throw std::runtime_error(path + ": cannot be written");
}

int run_experiments(const Options& o) {
  std::vector<sim::Experiment> chosen;
  for (const sim::Experiment& e : sim::experiments())
    if (o.name == all || o.name == e.name) chosen.push_back(e);
  if (o.name == all && !o.methods.empty())
    throw CLI::ValidationError("--methods", "every experiment compares methods of its own: name one experiment");
  for (const sim::Experiment& e : chosen) check_methods(e, o.methods);
  o.files.check({o.json, o.html}, {});

  std::vector<sim::ExperimentResult> results;
  for (const sim::Experiment& e : chosen) {
    Progress progress{std::string(e.name)};
    const auto show = [&progress](double fraction) { progress.show(fraction); };
    results.push_back(e.run({.runs = o.runs, .seed = o.seed, .jobs = o.jobs, .methods = o.methods, .progress = show}));
    progress.done();
    std::cout << sim::format_text(results.back()) << std::endl;
  }
  if (!o.json.empty()) write(o.json, sim::format_json(results));
  if (!o.html.empty()) write(o.html, sim::format_html(results));
  return std::all_of(results.begin(), results.end(), sim::all_reached) ? exit_ok : exit_failed;
}

}  // namespace

void add_experiment(CLI::App& app, Run& run) {
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("experiment", "Repeat a paper's experiment, against the figures to reach");
  std::vector<std::string> allowed = names();
  allowed.emplace_back(all);
  command->add_option("NAME", o->name, "Which one, or all of them")->check(CLI::IsMember(allowed));
  command->add_flag("--list", o->list, "Tell which experiments there are and what they compare");
  command->add_option("--runs", o->runs, "Monte Carlo runs (default: as many as the figures are stated for)")
      ->check(CLI::Range(1, 1'000'000));
  command->add_option("--seed", o->seed, "Draw everything from this seed")->capture_default_str();
  command->add_option("--jobs", o->jobs, "Threads; the numbers do not depend on it (default: as the machine has)")
      ->check(CLI::Range(1, 1024));
  command->add_option("--methods", o->methods, "Only these, comma-separated (default: all that --list tells)")
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
      if (o->list) return list();
      if (o->name.empty()) throw CLI::RequiredError("NAME (or --list)");
      return run_experiments(*o);
    };
  });
}

}  // namespace downrange::app
