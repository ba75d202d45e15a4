#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "experiment/faults.hpp"

namespace downrange::experiment::faults {
namespace {

constexpr int digits = 3;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

Cell cell(double value) { return {number_text(value, digits), value}; }
Cell count(long value) { return {std::to_string(value), static_cast<double>(value)}; }
Cell words(std::string text) { return {std::move(text)}; }

/// Over the seeds: the largest; NaN where one of them has none.
template <class ValueOf>
double worst(const std::vector<score::FaultScore>& scores, const ValueOf& value_of) {
  double most = -std::numeric_limits<double>::infinity();
  for (const score::FaultScore& score : scores) {
    const std::optional<double> value = value_of(score);
    if (!value) return nan;
    most = std::max(most, *value);
  }
  return most;
}

template <class CountOf>
long sum(const std::vector<score::FaultScore>& scores, const CountOf& count_of) {
  long all = 0;
  for (const score::FaultScore& score : scores) all += count_of(score);
  return all;
}

double rms(const std::vector<score::FaultScore>& scores) {
  double squares = 0;
  double samples = 0;
  for (const score::FaultScore& score : scores) {
    const auto n = static_cast<double>(score.during.count);
    squares += n * score.during.rms * score.during.rms;
    samples += n;
  }
  return std::sqrt(squares / samples);
}

/// Whom the seeds accuse first, an innocent one with "!".
std::string accused(const std::vector<score::FaultScore>& scores) {
  std::set<std::string> names;
  for (const score::FaultScore& score : scores)
    names.insert(score.accusation ? std::string(score.accusation->source.view()) + (score.accusation->right ? "" : "!")
                                  : "-");
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : " ") + name;
  return text;
}

std::vector<Cell> row_of(const Flown& flown) {
  const auto& scores = flown.scores;
  const auto during = [](const score::FaultScore& s) {
    return s.during.count > 0 ? std::optional(s.during.worst) : std::nullopt;
  };
  const auto delay = [](const score::FaultScore& s) {
    return s.accusation ? std::optional(s.accusation->delay_s) : std::nullopt;
  };
  score::Share bound;
  for (const score::FaultScore& score : scores) bound += score.bound;
  const double recovery_s = worst(scores, [](const score::FaultScore& s) { return s.recovery_s; });
  const bool recovers = scores.front().recovers;
  return {
      words(flown.row.name),
      count(static_cast<long>(scores.size())),
      cell(worst(scores, during)),
      cell(rms(scores)),
      count(sum(scores, [](const score::FaultScore& s) { return s.confidently_wrong; })),
      count(sum(scores, [](const score::FaultScore& s) { return s.wrong_by_sigma; })),
      words(accused(scores)),
      cell(worst(scores, delay)),
      recovers && std::isnan(recovery_s) ? words("never") : cell(recovers ? recovery_s : nan),
      cell(100 * bound.value()),
      words(flown.missed.empty() ? (flown.row.fault->expected.majority_lies ? "met (majority)" : "met") : "MISSED")};
}

/// The curve's value at each second; NaN outside.
template <class ValueOf>
Curve curve_of(std::string label, const Flown& flown, const ValueOf& value_of, bool dashed = false) {
  Curve curve{.label = std::move(label), .dashed = dashed};
  for (const score::FaultSecond& second : flown.scores.front().seconds) {
    curve.x.push_back(second.t_s + flown.row.begin_s);
    curve.y.push_back(value_of(second));
  }
  return curve;
}

Plot error_plot(const Flown& flown) {
  Plot plot{.title = flown.row.name + ": " + flown.row.fault->what,
            .x_label = "after lift-off, s",
            .y_label = "position error, m",
            .log_y = true};
  plot.curves.push_back(curve_of("worst error", flown, [](const auto& s) { return s.error_m; }));
  plot.curves.push_back(curve_of(
      "3 sigma", flown, [](const auto& s) { return 3 * s.sigma_m; }, true));
  plot.curves.push_back(curve_of(
      "bound", flown, [](const auto& s) { return s.bound_m.value_or(nan); }, true));
  return plot;
}

/// Lines at levels: the fault at 0, the sources while they are accused above, what was followed below.
Plot verdict_plot(const Flown& flown) {
  const auto& seconds = flown.scores.front().seconds;
  std::set<Name> sources;
  std::set<Name> chains;
  for (const score::FaultSecond& second : seconds) {
    sources.insert(second.accused.begin(), second.accused.end());
    if (!second.chain.empty()) chains.insert(second.chain);
  }
  Plot plot{.title = flown.row.name + ": who is accused, what is followed",
            .x_label = "after lift-off, s",
            .y_label = "accused above, followed below 0"};
  const auto level = [](bool is, double at) { return is ? at : nan; };
  const double lasts_s = flown.row.fault->lasts_s.value_or(std::numeric_limits<double>::infinity());
  plot.curves.push_back(
      curve_of("the fault lasts", flown, [&](const auto& s) { return level(s.t_s >= 0 && s.t_s < lasts_s, 0); }));
  double at = 0;
  for (const Name& source : sources) {
    ++at;
    plot.curves.push_back(curve_of(std::string(source.view()) + " accused", flown, [&](const auto& s) {
      return level(std::ranges::find(s.accused, source) != s.accused.end(), at);
    }));
  }
  at = 0;
  for (const Name& chain : chains) {
    --at;
    plot.curves.push_back(curve_of(std::string(chain.view()) + " followed", flown,
                                   [&](const auto& s) { return level(s.chain == chain, at); }));
  }
  return plot;
}

}  // namespace

Table table_of(const std::vector<Flown>& flown) {
  Table table;
  table.caption = "Each scenario, worst over its seeds";
  table.columns = {"scenario", "seeds",   "worst m",    "rms m",   "cw",      "cw-s",
                   "accused",  "after s", "recovery s", "bound %", "expected"};
  for (const Flown& f : flown) table.rows.push_back(row_of(f));
  return table;
}

std::vector<Figure> figures_of(const std::vector<Flown>& flown) {
  long missed = 0;
  long wrong = 0;
  long wrong_by_sigma = 0;
  score::Share accused;
  score::Share bound;
  for (const Flown& f : flown) {
    missed += f.missed.empty() ? 0 : 1;
    if (f.row.fault->expected.majority_lies) continue;
    for (const score::FaultScore& score : f.scores) {
      wrong += score.confidently_wrong;
      wrong_by_sigma += score.wrong_by_sigma;
      bound += score.bound;
      if (f.row.fault->expected.accusation_s) accused.add(score.accusation && score.accusation->right);
    }
  }
  const auto number = [](long n) { return static_cast<double>(n); };
  const char* first_accused = "flights with a liar that can be told: it is the first accused, share";
  const char* covered = "bound covers the error, share of positions with one";
  const bool nothing_expected = accused.count == 0;  // of a few scenarios by name
  const bool nothing_bounded = bound.count == 0;
  return {at_most("scenarios that are not as expected", number(missed), 0),
          shown("scenarios flown", number(static_cast<long>(flown.size()))),
          at_most("confidently wrong commands, but of a lying majority", number(wrong), 0),
          shown("the same by sigma alone", number(wrong_by_sigma)),
          nothing_expected ? shown(first_accused, accused.value()) : at_least(first_accused, accused.value(), 0.95),
          nothing_bounded ? shown(covered, bound.value()) : at_least(covered, bound.value(), 0.999)};
}

std::vector<Plot> plots_of(const std::vector<Flown>& flown) {
  std::vector<Plot> plots;
  for (const Flown& f : flown) {
    plots.push_back(error_plot(f));
    plots.push_back(verdict_plot(f));
  }
  return plots;
}

}  // namespace downrange::experiment::faults
