#include "fault_options.hpp"

#include <cstdio>
#include <stdexcept>

#include "shipped_files.hpp"

namespace downrange::app {

void FaultOptions::add_to(CLI::App& command) {
  CLI::Option* of_file =
      command.add_option("--faults", file, "Catalogue of faults, e.g. tools/scenarios/faults/catalogue.toml");
  command.add_option("--fault", name, "Which fault to put in (default: the catalogue's only one)")->needs(of_file);
  command.add_option("--fault-begin", begin_s, "Seconds after lift-off (default: the first that the fault names)")
      ->needs(of_file);
}

ChosenFault::ChosenFault(const FaultOptions& options)
    : catalogue_(sim::load_faults(options.file)),
      fault_(&catalogue_.find(options.name)),
      begin_s_(options.begin_s.value_or(fault_->begin_s.front())) {}

std::vector<Event> ChosenFault::play(std::vector<Event> events, const RangeConfig& range, Time liftoff,
                                     std::uint64_t seed) const {
  sim::Injected injected = sim::inject(
      catalogue_, *fault_, {.range = range, .liftoff = liftoff, .begin_s = begin_s_, .seed = seed}, std::move(events));
  if (injected.touched == 0 && !fault_->actions.empty())
    throw sim::ScenarioError(catalogue_.file.string() + ":" + std::to_string(fault_->line) + ": " + fault_->name +
                             " changes no message: its sources send nothing while it lasts");
  std::fprintf(stderr, "fault %s from T%+.1f s: %s; %zu messages changed\n", fault_->name.c_str(), begin_s_,
               fault_->what.c_str(), injected.touched);
  return std::move(injected.events);
}

Time liftoff_told(const std::vector<Event>& events, const std::string& archive) {
  std::optional<Time> told;
  for (const Event& event : events) {
    const auto* mark = std::get_if<MissionEvent>(&event);
    if (mark == nullptr) continue;
    if (mark->kind == MissionEventKind::PlannedLiftoff || mark->kind == MissionEventKind::Liftoff) told = mark->epoch;
  }
  if (!told)
    throw std::runtime_error(archive +
                             ": no message of the mission clock tells its lift-off, after which faults begin");
  return *told;
}

std::string default_faults() { return shipped_file("scenarios/faults/catalogue.toml").string(); }

}  // namespace downrange::app
