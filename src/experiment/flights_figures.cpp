#include <algorithm>
#include <array>
#include <optional>

#include "experiment/flights.hpp"

namespace downrange::experiment::flights {
namespace {

/// What section 10 asks of a flight; the time tag that was put in is -6 ms.
struct Asked {
  std::string_view flight;
  double rms_m, p95_m, outage_m, inside_95, time_tag_ms, without_gps_m;
};
constexpr std::array asked_of{Asked{"falcon_heavy_demo", 5, 6, 14, 0.85, 2, 100},
                              Asked{"falcon9_crs11", 6, 8, 13, 0.60, 1.5, 25}};
constexpr double merritt_time_tag_ms = -6;

const Asked* asked(const std::string& flight) {
  const auto found = std::find_if(asked_of.begin(), asked_of.end(), [&](const Asked& a) { return a.flight == flight; });
  return found == asked_of.end() ? nullptr : &*found;
}

constexpr std::size_t whole = 0;
constexpr std::size_t outage = 1;  ///< of replays as they were received

/// Rows of one flight; without figures to reach where section 10 does not know it.
class Table {
 public:
  explicit Table(const FlightResult& flight) : flight_(flight), asked_(asked(flight.name)) {}

  void most(const std::string& what, double measured, double Asked::*limit) {
    add(asked_ == nullptr ? shown(name(what), measured) : at_most(name(what), measured, asked_->*limit));
  }
  void most(const std::string& what, double measured, double limit) {
    add(asked_ == nullptr ? shown(name(what), measured) : at_most(name(what), measured, limit));
  }
  void least(const std::string& what, double measured, double limit) {
    add(asked_ == nullptr ? shown(name(what), measured) : at_least(name(what), measured, limit));
  }
  void show(const std::string& what, double measured) { add(shown(name(what), measured)); }
  void add(Figure figure) { rows_.push_back(std::move(figure)); }

  [[nodiscard]] std::string name(const std::string& what) const { return short_name() + ": " + what; }
  [[nodiscard]] const Asked* asks() const { return asked_; }
  [[nodiscard]] std::vector<Figure> figures() && { return std::move(rows_); }

 private:
  /// "falcon_heavy" of "falcon_heavy_demo": the table is narrow.
  [[nodiscard]] std::string short_name() const {
    std::string text = flight_.name;
    if (text.ends_with("_demo")) text.resize(text.size() - 5);
    return text;
  }

  const FlightResult& flight_;
  const Asked* asked_;
  std::vector<Figure> rows_;
};

std::optional<double> time_tag_ms(const Flown& flown, const Name& radar) {
  const auto found = flown.bias.find(radar);
  if (found == flown.bias.end()) return std::nullopt;
  const SensorBias& bias = found->second;
  for (std::size_t i = 0; i < static_cast<std::size_t>(bias.terms); ++i)
    if (bias.term[i] == BiasTerm::TimeTag) return 1e3 * bias.value[i];
  return std::nullopt;
}

/// As the plots arrived and as history has them in the end: a late message can turn a verdict.
GateCount worse_gate(const Flown& arrived, const Flown* in_order) {
  GateCount gate = arrived.gate;
  if (in_order == nullptr) return gate;
  gate.outliers_rejected = std::min(gate.outliers_rejected, in_order->gate.outliers_rejected);
  gate.plots_rejected = std::max(gate.plots_rejected, in_order->gate.plots_rejected);
  return gate;
}

void position_rows(Table& table, const FlightResult& flight, const Flown& all) {
  const score::PositionScore joint = all.position("joint", whole);
  table.most("joint, rms, m", joint.rms_m, &Asked::rms_m);
  table.most("joint, p95, m", joint.p95_m, &Asked::p95_m);
  table.least("joint, share inside 95 %", joint.inside_95, table.asks() == nullptr ? 0 : table.asks()->inside_95);
  table.most("joint in the GPS outage, rms, m", all.position("joint", outage).rms_m, &Asked::outage_m);
  if (const Flown* without_gps = flight.find("without GPS"))
    table.most("joint without GPS, rms, m", without_gps->position("joint", whole).rms_m, &Asked::without_gps_m);
}

void plot_rows(Table& table, const FlightResult& flight, const Flown& all) {
  if (const auto tag = time_tag_ms(all, "merritt"); tag && table.asks() != nullptr)
    table.add(within(table.name("time tag of merritt, ms"), *tag, merritt_time_tag_ms - table.asks()->time_tag_ms,
                     merritt_time_tag_ms + table.asks()->time_tag_ms));
  const GateCount gate = worse_gate(all, flight.find("in order"));
  if (gate.outliers > 0)
    table.least("share of " + std::to_string(gate.outliers) + " outliers rejected",
                static_cast<double>(gate.outliers_rejected) / gate.outliers, 1);
  if (gate.plots > 0)
    table.most("share of " + std::to_string(gate.plots) + " good plots rejected",
               static_cast<double>(gate.plots_rejected) / gate.plots, 1e-3);
  for (const score::SystematicScore& radar : all.summary.systematic) {
    if (std::find(flight.radars.begin(), flight.radars.end(), radar.sensor) == flight.radars.end()) continue;
    const std::string of = "left of " + std::string(radar.sensor.view());
    table.most(of + ", range, m", radar.after.range_m, 4);
    table.most(of + ", azimuth x cos el, mdeg", radar.after.azimuth_rad / mdeg, 12);
    table.most(of + ", elevation, mdeg", radar.after.elevation_rad / mdeg, 10);
  }
}

/// Of the single sources the best one by rms, whatever part of the window it covers.
void single_source_rows(Table& table, const FlightResult& flight) {
  const Flown* const fused = flight.find("on ticks");
  if (fused == nullptr) return;
  for (std::size_t w = 1; w < fused->replay.phases.size(); ++w) {
    const Flown* best = nullptr;
    for (const Flown& flown : flight.flown) {
      if (!flown.replay.label.ends_with(" alone") || flown.position("joint", w).samples == 0) continue;
      if (best == nullptr || flown.position("joint", w).rms_m < best->position("joint", w).rms_m) best = &flown;
    }
    if (best == nullptr) continue;
    const std::string& window = fused->replay.phases[w].name;
    const double all = fused->position("joint", w).rms_m;
    const double alone = best->position("joint", w).rms_m;
    table.most("joint / best single source, " + window, all / alone, 1.02);
    table.show("joint, " + window + ", rms, m", all);
    table.show(best->replay.label + ", " + window + ", rms, m", alone);
  }
}

void method_rows(Table& table, const FlightResult& flight) {
  for (const Flown& flown : flight.flown) {
    const Replay& replay = flown.replay;
    if (replay.on_ticks || replay.in_order) continue;
    for (const Name& method : replay.methods) {
      const score::PositionScore score = flown.position(method, whole);
      if (score.samples > 0) table.show(replay.label + ", " + std::string(method.view()) + ", rms, m", score.rms_m);
    }
  }
  for (const Flown& flown : flight.flown) {
    if (flown.replay.label.ends_with(" alone"))
      table.show(flown.replay.label + ", joint, rms, m", flown.position("joint", whole).rms_m);
  }
}

void nis_rows(Table& table, const FlightResult& flight) {
  const Flown* const in_order = flight.find("in order");
  if (in_order == nullptr || in_order->replay.methods.front() != Name("joint")) return;
  for (const auto& [radar, share] : in_order->nis)
    table.show("joint, NIS inside 95 %, " + std::string(radar.view()), share.value());
}

bool flies_joint(const Flown& flown) { return flown.replay.methods.front() == Name("joint"); }

}  // namespace

std::vector<Figure> figures(const FlightResult& flight) {
  Table table(flight);
  if (const Flown* all = flight.find("everything"); all != nullptr && flies_joint(*all)) {
    position_rows(table, flight, *all);
    plot_rows(table, flight, *all);
    single_source_rows(table, flight);
  }
  method_rows(table, flight);
  nis_rows(table, flight);
  return std::move(table).figures();
}

std::vector<std::string> notes(const FlightResult& flight) {
  std::vector<std::string> notes;
  const Flown* const all = flight.find("everything");
  if (all == nullptr || !flies_joint(*all)) return notes;
  const double inside = all->position("joint", whole).inside_95;
  if (inside > 0.99)
    notes.push_back(flight.name + ": a share inside 95 % of " + number_text(inside, 4) +
                    " is above 0.99: the covariance is wider than the errors are.");
  std::string terms;
  for (const Name& radar : flight.radars) {
    const auto found = all->bias.find(radar);
    if (found == all->bias.end()) continue;
    std::string of_radar;
    for (std::size_t i = 0; i < static_cast<std::size_t>(found->second.terms); ++i) {
      if (found->second.state[i] != BiasState::NotObservable) continue;
      of_radar += (of_radar.empty() ? "" : ", ") + std::string(to_string(found->second.term[i]));
    }
    if (!of_radar.empty()) terms += (terms.empty() ? "" : "; ") + std::string(radar.view()) + ' ' + of_radar;
  }
  notes.push_back(flight.name +
                  ": bias terms of joint that stayed not observable: " + (terms.empty() ? "none" : terms) + '.');
  return notes;
}

}  // namespace downrange::experiment::flights
