#include "experiment/faults.hpp"

#include <algorithm>
#include <ctime>
#include <downrange/stage/engine.hpp>
#include <map>
#include <stdexcept>
#include <tuple>

#include "experiment/parallel.hpp"
#include "sim/simulation.hpp"

namespace downrange::experiment {
namespace faults {
namespace {

/// A flight goes on so long after its fault: to see it recover.
constexpr double flown_on_s = 75;
/// A flight has recovered when it is this near to the same flight without the fault.
constexpr double recovered_ratio = 1.5;
constexpr double recovered_least_m = 10;

RangeConfig with_radars(RangeConfig range, int radars) {
  range.radars.resize(std::min(range.radars.size(), static_cast<std::size_t>(radars)));
  return range;
}

sim::Scenario with_radars_of(sim::Scenario scenario, const RangeConfig& range) {
  std::erase_if(scenario.radars, [&](const sim::RadarScenario& radar) {
    return std::ranges::find(range.radars, radar.id, &RadarConfig::id) == range.radars.end();
  });
  return scenario;
}

bool is_meant(const std::string& pattern, const Row& row) {
  if (pattern.ends_with('*')) return row.name.starts_with(pattern.substr(0, pattern.size() - 1));
  return pattern == row.name || pattern == row.fault->name;
}

sim::Scenario scenario_of(const Plan& plan, const Row& row, const RangeConfig& range) {
  sim::Scenario scenario = with_radars_of(plan.scenario, range);
  if (const sim::FlightVariant* variant = plan.catalogue.flight_of(*row.fault))
    scenario = sim::flown_as(std::move(scenario), *variant, range);
  return scenario;
}

score::FaultScore fly(const RangeConfig& range, const sim::Simulation& flight, const std::vector<Event>& events,
                      score::FaultCase fault) {
  fault.truth = [&flight](Time t) { return flight.truth(t); };
  score::FaultJudge judge(range, std::move(fault));
  Engine engine(range, {}, judge);
  for (const Event& event : events) engine.handle(engine.admit(event));
  if (!events.empty()) engine.advance_to(received_of(events.back()) + seconds(2));  // commands of the last second
  return judge.score();
}

/// The same flight without the fault: its errors, second by second after lift-off.
score::FaultScore fly_without(const Plan& plan, const Row& row, std::uint64_t seed) {
  const RangeConfig range = with_radars(plan.range, row.radars);
  const sim::Scenario scenario = scenario_of(plan, row, range);
  const sim::Simulation flight(scenario, seed);
  return fly(range, flight, flight.events(), {.target = scenario.target, .begin = scenario.liftoff});
}

double recovered_m(const score::FaultScore& without, double end_s) {
  double worst_m = 0;
  for (const score::FaultSecond& second : without.seconds)
    if (second.t_s >= end_s && second.t_s < end_s + score::recovery_horizon.seconds())
      worst_m = std::max(worst_m, second.error_m);
  return std::max(recovered_least_m, recovered_ratio * worst_m);
}

/// One flight of a row, faults as `fault` has them.
score::FaultScore fly_fault(const Plan& plan, const Row& row, const sim::Fault& fault, std::uint64_t seed,
                            const score::FaultScore* without) {
  const RangeConfig range = with_radars(plan.range, row.radars);
  sim::Scenario scenario = scenario_of(plan, row, range);
  const double end_s = row.begin_s + fault.lasts_s.value_or(0);
  if (fault.lasts_s) sim::end_at(scenario, std::min(scenario.end_s, end_s + flown_on_s));
  const sim::Simulation flight(scenario, seed);
  const sim::Injected injected =
      sim::inject(plan.catalogue, fault,
                  {.range = range, .liftoff = scenario.liftoff, .begin_s = row.begin_s, .seed = seed}, flight.events());
  const std::string where = plan.catalogue.file.string() + ":" + std::to_string(fault.line);
  if (injected.touched == 0 && !fault.actions.empty())
    throw sim::ScenarioError(where + ": " + row.name +
                             " changes no message: nothing is sent by its sources while it lasts");
  score::FaultCase judged{.target = scenario.target,
                          .begin = scenario.liftoff + seconds(row.begin_s),
                          .liars = sim::sources_meant(fault.liars, range, where)};
  if (fault.lasts_s) judged.end = scenario.liftoff + seconds(end_s);
  if (without != nullptr) judged.recovered_m = recovered_m(*without, end_s);
  return fly(range, flight, injected.events, std::move(judged));
}

/// The same with the liars silent while the fault lasts.
sim::Fault silenced(sim::Fault fault) {
  fault.actions = {{.sources = fault.liars, .effect = sim::Silence{}, .line = fault.line}};
  return fault;
}

score::FaultScore fly_with(const Plan& plan, const Row& row, std::uint64_t seed, const score::FaultScore* without) {
  const sim::Fault& fault = *row.fault;
  score::FaultScore score = fly_fault(plan, row, fault, seed, without);
  if (!fault.liars.empty() && score::is_too_far_off(score, fault.expected))
    score.without_liars_m = fly_fault(plan, row, silenced(fault), seed, nullptr).during.worst;
  return score;
}

bool is_compared(const Row& row) { return row.fault->lasts_s && !row.fault->actions.empty(); }

/// Flights without a fault that rows are compared with: by flight, number of radars and seed.
using Twin = std::tuple<std::string, int, std::uint64_t>;

Twin twin_of(const Row& row, std::uint64_t seed) { return {row.fault->flight, row.radars, seed}; }

}  // namespace

std::vector<Row> rows_of(const Plan& plan) {
  std::vector<Row> rows;
  for (const sim::Fault& fault : plan.catalogue.faults) {
    for (const double begin_s : fault.begin_s) {
      for (const int radars : fault.radars)
        rows.push_back(
            {&fault, begin_s, radars, fault.name + "@" + number_text(begin_s, 3) + "/" + std::to_string(radars)});
    }
  }
  if (plan.only.empty()) return rows;
  for (const std::string& pattern : plan.only) {
    if (std::ranges::none_of(rows, [&](const Row& row) { return is_meant(pattern, row); }))
      throw std::invalid_argument("'" + pattern + "' is no fault of " + plan.catalogue.file.string() +
                                  " (--list tells which there are)");
  }
  std::erase_if(rows, [&](const Row& row) {
    return std::ranges::none_of(plan.only, [&](const std::string& pattern) { return is_meant(pattern, row); });
  });
  return rows;
}

std::vector<Flown> fly(const Plan& plan, const ExperimentOptions& options) {
  const std::vector<Row> rows = rows_of(plan);
  const int seeds = options.runs > 0 ? options.runs : fault_seeds;
  const auto seed_of = [&](int i) { return options.seed + static_cast<std::uint64_t>(i); };

  std::map<Twin, const Row*> wanted;
  for (const Row& row : rows)
    for (int i = 0; i < seeds; ++i)
      if (is_compared(row)) wanted.emplace(twin_of(row, seed_of(i)), &row);
  const std::vector<std::pair<Twin, const Row*>> twins(wanted.begin(), wanted.end());
  const double all = static_cast<double>(twins.size() + rows.size() * static_cast<std::size_t>(seeds));
  const double share_of_twins = static_cast<double>(twins.size()) / all;
  const auto fly_twin = [&](int i) {
    const auto& [twin, row] = twins[static_cast<std::size_t>(i)];
    return fly_without(plan, *row, std::get<std::uint64_t>(twin));
  };
  std::vector<score::FaultScore> without =
      parallel_runs<score::FaultScore>(static_cast<int>(twins.size()), options.jobs, fly_twin,
                                       [&](double done) { options.progress(done * share_of_twins); });
  std::map<Twin, const score::FaultScore*> known;
  for (std::size_t i = 0; i < twins.size(); ++i) known.emplace(twins[i].first, &without[i]);

  const auto fly_row = [&](int i) {
    const Row& row = rows[static_cast<std::size_t>(i / seeds)];
    const std::uint64_t seed = seed_of(i % seeds);
    return fly_with(plan, row, seed, is_compared(row) ? known.at(twin_of(row, seed)) : nullptr);
  };
  std::vector<score::FaultScore> scores = parallel_runs<score::FaultScore>(
      static_cast<int>(rows.size()) * seeds, options.jobs, fly_row,
      [&](double done) { options.progress(share_of_twins + done * (1 - share_of_twins)); });

  std::vector<Flown> flown;
  auto score = scores.begin();
  for (const Row& row : rows) {
    Flown& f = flown.emplace_back(Flown{row, {}, {}});
    for (int i = 0; i < seeds; ++i, ++score) {
      for (const std::string& what : score::missed(*score, row.fault->expected))
        if (std::ranges::find(f.missed, what) == f.missed.end()) f.missed.push_back(what);
      f.scores.push_back(std::move(*score));
    }
  }
  return flown;
}

}  // namespace faults

ExperimentResult run_faults(const ExperimentOptions& options, const faults::Plan& plan) {
  const std::clock_t started = std::clock();
  const std::vector<faults::Flown> flown = faults::fly(plan, options);
  const double cpu_s = static_cast<double>(std::clock() - started) / CLOCKS_PER_SEC;
  ExperimentResult out;
  out.name = "faults";
  out.title = "Faults of sources and vehicle, each against what is expected of the service";
  out.runs = options.runs > 0 ? options.runs : fault_seeds;
  out.seed = options.seed;
  out.figures = faults::figures_of(flown);
  std::ranges::move(faults::antenna_figures_of(flown), std::back_inserter(out.figures));
  out.tables = {faults::table_of(flown), faults::antennas_of(flown)};
  out.plots = faults::plots_of(flown);
  out.settings = {
      {"catalogue", plan.catalogue.file.string()},
      {"scenario", "NAME@BEGIN/RADARS: begins so many seconds after lift-off, so many radars beside GPS"},
      {"worst, rms",
       "position error of the primary track while the fault lasts; as expected too where it is not above " +
           number_text(score::as_without_ratio, 1) + " times that of the same flight with the liars silent"},
      {"cw",
       "confidently wrong: command more than 0.25 deg off, beyond 5 of its sigma and its bound, target beyond 5 km; "
       "cw-s: "
       "beyond sigma alone"},
      {"accused",
       "the first source after the fault's begin, by integrity, or all of whose messages are rejected; ! innocent"},
      {"recovery",
       "from the fault's end to the last error above 1.5 times the worst of the same flight without it, 10 m at least; "
       "60 s at most"},
      {"bound", "share of positions sent with a bound that it covers"},
      {"mounts",
       "15 deg/s and 20 deg/s^2 on both axes, parked at first; they go from command to command to second order and "
       "stand "
       "after valid_until; every antenna of the range"},
      {"on target",
       "within 0.25 deg of the target's direction: share of the time from the fault's begin on with the target above "
       "the "
       "antenna's horizon; followed, by what commands are made of, and withheld are shares of the same"},
      {"excursion",
       "farthest from the target, deg, while commands are followed, from the arrival at what they command on"},
      {"CPU", number_text(cpu_s / 3600, 2) + " h on " + std::to_string(options.jobs) + " threads"}};
  for (const faults::Flown& f : flown) {
    if (f.missed.empty()) continue;
    std::string note = f.row.name + ": ";
    for (const std::string& what : f.missed) note += (what == f.missed.front() ? "" : "; ") + what;
    out.notes.push_back(std::move(note));
  }
  return out;
}

}  // namespace downrange::experiment
