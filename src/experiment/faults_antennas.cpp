#include <algorithm>
#include <cstdio>
#include <numbers>

#include "experiment/faults.hpp"

namespace downrange::experiment::faults {
namespace {

constexpr double deg = std::numbers::pi / 180;
constexpr int digits = 3;

Cell percent(const score::MountScore& mounts, long count) {
  if (mounts.steps == 0) return {"-"};
  if (count == 0) return {"0", 0};
  const double share = 100 * mounts.share_of(count);
  char text[16];
  std::snprintf(text, sizeof text, "%.2f", share);
  return {text, share};
}

Cell number(double value) { return {number_text(value, digits), value}; }

/// All antennas, all seeds.
score::MountScore pooled(const std::vector<score::FaultScore>& scores) {
  score::MountScore all;
  for (const score::FaultScore& score : scores) all += score.all_mounts();
  return all;
}

/// Of one antenna in one flight, the longest.
double longest_withheld_s(const std::vector<score::FaultScore>& scores) {
  long most = 0;
  for (const score::FaultScore& score : scores)
    for (const auto& [antenna, mount] : score.mounts) most = std::max(most, mount.withheld);
  return score::MountScore::seconds_of(most);
}

/// As many per flight as any of the seeds has.
int most_changes(const std::vector<score::FaultScore>& scores) {
  int most = 0;
  for (const score::FaultScore& score : scores) most = std::max(most, score.all_mounts().changes);
  return most;
}

std::vector<Cell> row_of(const std::string& name, const score::MountScore& mounts, double withheld_s, int changes) {
  std::vector<Cell> row{{name},
                        percent(mounts, mounts.on_target),
                        mounts.steps > mounts.withheld ? number(mounts.worst_rad / deg) : Cell{"-"},
                        number(withheld_s)};
  for (const long followed : mounts.followed) row.push_back(percent(mounts, followed));
  row.push_back(percent(mounts, mounts.withheld));
  row.push_back({std::to_string(changes), static_cast<double>(changes)});
  return row;
}

/// Of all flights that are meant.
template <class Meant>
std::vector<Cell> sum_of(const std::string& name, const std::vector<Flown>& flown, const Meant& meant) {
  score::MountScore all;
  double withheld_s = 0;
  int changes = 0;
  for (const Flown& f : flown) {
    if (!meant(f)) continue;
    all += pooled(f.scores);
    withheld_s = std::max(withheld_s, longest_withheld_s(f.scores));
    changes = std::max(changes, most_changes(f.scores));
  }
  return row_of(name, all, withheld_s, changes);
}

bool believes_no_majority(const Flown& f) { return !f.row.fault->expected.majority_lies; }

}  // namespace

Table antennas_of(const std::vector<Flown>& flown) {
  Table table;
  table.caption = "The same at the antennas, in % of the time; excursion, withheld s and changes: worst over seeds";
  table.columns = {"scenario", "on target", "excursion", "withheld s", "fused",  "coast",
                   "single",   "GPS",       "plan",      "none",       "changes"};
  for (const Flown& f : flown)
    table.rows.push_back(row_of(f.row.name, pooled(f.scores), longest_withheld_s(f.scores), most_changes(f.scores)));
  table.rows.push_back(sum_of("but a lying majority", flown, believes_no_majority));
  table.rows.push_back(sum_of("all", flown, [](const Flown&) { return true; }));
  return table;
}

std::vector<Figure> antenna_figures_of(const std::vector<Flown>& flown) {
  score::MountScore all;
  score::MountScore told;
  for (const Flown& f : flown) {
    const score::MountScore mounts = pooled(f.scores);
    all += mounts;
    if (believes_no_majority(f)) told += mounts;
  }
  return {shown("mounts on target, but of a lying majority, share of time", told.share_of(told.on_target)),
          shown("commands withheld, likewise", told.share_of(told.withheld)),
          shown("mounts on target, all scenarios, share of time", all.share_of(all.on_target))};
}

}  // namespace downrange::experiment::faults
