#include "stage/integrity/chain_plan.hpp"

#include <algorithm>
#include <downrange/est/method/method_table.hpp>
#include <string>

namespace downrange {

std::vector<SourceUnit> source_units(const SourceTable& sources, bool takes_angles) {
  std::vector<SourceUnit> units;
  SourceUnit receiver{.name = "GPS", .kind = SourceKind::Telemetry, .sources = 0, .starts_track = true};
  for (SourceId id = 0; id < static_cast<SourceId>(sources.size()); ++id) {
    const Source& source = sources[id];
    if (source.kind == SourceKind::Telemetry) {
      receiver.sources |= set_of(id);
    } else if (source.kind == SourceKind::Radar || takes_angles) {
      units.push_back(
          {.name = source.name, .kind = source.kind, .sources = set_of(id), .starts_track = measures_position(source)});
    }
  }
  if (receiver.sources != 0) units.push_back(receiver);
  return units;
}

ChainPlans plan_chains(const std::vector<SourceUnit>& units) {
  ChainPlans plans{.chains = {},
                   .without = std::vector<int>(units.size(), ChainPlans::none),
                   .alone = std::vector<int>(units.size(), ChainPlans::none)};
  const auto add = [&](const ChainPlan& plan) {
    const auto same = std::ranges::find(plans.chains, plan.sources, &ChainPlan::sources);
    if (same != plans.chains.end()) return static_cast<int>(same - plans.chains.begin());
    plans.chains.push_back(plan);
    return static_cast<int>(plans.chains.size()) - 1;
  };
  const auto all_but = [&](auto left_out) {
    SourceSet set = 0;
    bool starts = false;
    for (std::size_t i = 0; i < units.size(); ++i) {
      if (left_out(i)) continue;
      set |= units[i].sources;
      starts = starts || units[i].starts_track;
    }
    return starts ? set : SourceSet{0};
  };
  const auto only = [&](std::size_t i) {
    return ChainPlan{.name = joined_name("only-", units[i].name.view(), i),
                     .sources = units[i].sources,
                     .alone = true,
                     .independent = true};
  };

  for (std::size_t i = 0; i < units.size(); ++i) {
    const SourceSet rest = all_but([i](std::size_t j) { return j == i; });
    if (rest == 0) continue;
    const auto single = std::ranges::find(units, rest, &SourceUnit::sources);
    plans.without[i] = single != units.end()
                           ? add(only(static_cast<std::size_t>(single - units.begin())))
                           : add({.name = joined_name("without-", units[i].name.view(), i), .sources = rest});
  }
  const SourceSet radars = all_but([&](std::size_t j) { return units[j].kind != SourceKind::Radar; });
  const auto one_radar = std::ranges::find(units, radars, &SourceUnit::sources);
  if (radars != 0 && one_radar == units.end()) {
    const int all_radars = add({.name = "only-radars", .sources = radars});  // without trackers it is "without-GPS"
    plans.chains[static_cast<std::size_t>(all_radars)].independent = true;
  }
  for (std::size_t i = 0; i < units.size(); ++i) {
    const bool wanted = units.size() <= most_alone || units[i].kind == SourceKind::Telemetry;
    if (wanted && units[i].starts_track && units.size() > 1) plans.alone[i] = add(only(i));
  }
  return plans;
}

std::vector<ChainPlan> chains_of(const RangeConfig& config) {
  if (!config.integrity.enabled) return {};
  const bool takes_angles = capabilities_of(config.fuse.methods.front().view()).partial_plots;
  const auto units = source_units(SourceTable(config), takes_angles);
  return units.size() < 2 ? std::vector<ChainPlan>{} : plan_chains(units).chains;
}

Name joined_name(std::string_view prefix, std::string_view name, std::size_t number) {
  std::string text = std::string(prefix) + std::string(name);
  if (text.size() > Name::max_size) {
    const std::string end = "." + std::to_string(number);
    text = text.substr(0, Name::max_size - end.size()) + end;
  }
  return {text};
}

}  // namespace downrange
