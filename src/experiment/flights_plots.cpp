#include <cmath>
#include <iterator>
#include <limits>

#include "experiment/flights.hpp"

namespace downrange::experiment::flights {
namespace {

/// rms of each second against its middle, with gaps where there was no track.
template <class Value>
Curve over_seconds(std::string label, const std::map<std::int64_t, Second>& seconds, bool dashed, const Value& value) {
  Curve curve{.label = std::move(label), .dashed = dashed};
  for (auto it = seconds.begin(); it != seconds.end(); ++it) {
    if (it != seconds.begin() && std::prev(it)->first + 1 != it->first) {
      curve.x.push_back(static_cast<double>(it->first));
      curve.y.push_back(std::numeric_limits<double>::quiet_NaN());
    }
    curve.x.push_back(static_cast<double>(it->first) + 0.5);
    curve.y.push_back(value(it->second));
  }
  return curve;
}

double rms(const Second& s) { return std::sqrt(s.square / s.count); }
double two_sigma(const Second& s) { return 2 * std::sqrt(s.variance / s.count); }

Plot error_plot(const FlightResult& flight, std::string title) {
  return {.title = flight.name + ": " + std::move(title),
          .x_label = "time after lift-off, s",
          .y_label = "position error, rms of each second, m",
          .log_y = true};
}

void add_error_plots(const FlightResult& flight, std::vector<Plot>& all) {
  const Flown* const everything = flight.find("everything");
  Plot by_method = error_plot(flight, "position error by method");
  for (const Name& method : everything->replay.methods) {
    if (const auto found = everything->error.find(method); found != everything->error.end())
      by_method.curves.push_back(over_seconds(std::string(method.view()), found->second, false, rms));
  }
  const Name& first = everything->replay.methods.front();
  if (const auto found = everything->error.find(first); found != everything->error.end())
    by_method.curves.push_back(
        over_seconds("2 sigma promised by " + std::string(first.view()), found->second, true, two_sigma));
  all.push_back(std::move(by_method));

  Plot by_sources = error_plot(flight, "position error of " + std::string(first.view()) + " without a source");
  for (const Flown& flown : flight.flown) {
    if (flown.replay.on_ticks || flown.replay.in_order) continue;
    if (const auto found = flown.error.find(first); found != flown.error.end())
      by_sources.curves.push_back(over_seconds(flown.replay.label, found->second, false, rms));
  }
  all.push_back(std::move(by_sources));
}

}  // namespace

std::vector<Plot> plots(const FlightResult& flight) {
  std::vector<Plot> all;
  add_error_plots(flight, all);
  const Flown* const in_order = flight.find("in order");
  if (in_order == nullptr) return all;
  const std::vector<Name>& methods = in_order->replay.methods;
  for (const Name& radar : flight.radars) {
    for (const Component& component : components) {
      const std::string of = std::string(component.name) + " residual of " + std::string(radar.view()) + ", ";
      // What is not corrected first, as the paper has it.
      for (auto method = methods.rbegin(); method != methods.rend(); ++method) {
        const auto of_method = in_order->residuals.find(*method);
        if (of_method == in_order->residuals.end() || !of_method->second.contains(radar)) continue;
        all.push_back(residual_plot(of + std::string(method->view()) + " (" + flight.name + ')', of + flight.name,
                                    of_method->second.at(radar), component));
      }
    }
  }
  return all;
}

}  // namespace downrange::experiment::flights
