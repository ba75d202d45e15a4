#include "experiment/launch_result.hpp"
#include "experiment/residual_plot.hpp"

namespace downrange::experiment::launch {
namespace {

/// What of each second is drawn against its middle.
template <class Value>
Curve over_time(std::string label, const Score& score, bool dashed, const Value& rms) {
  Curve curve{.label = std::move(label), .dashed = dashed};
  for (std::size_t i = 0; i < score.second.size(); ++i) {
    curve.x.push_back(tracking_from_s + static_cast<double>(i) + 0.5);
    curve.y.push_back(rms(score.second[i]));
  }
  return curve;
}

template <class Value>
Plot against_time(const Result& result, std::string title, std::string y_label, Case which, const Score& bound,
                  const Value& rms) {
  Plot plot{std::move(title), "time after lift-off, s", std::move(y_label), true, {}};
  for (const Flown& f : result.flown) {
    if (f.contestant.which == which) plot.curves.push_back(over_time(f.contestant.label, f.score, false, rms));
  }
  plot.curves.push_back(over_time("bound", bound, true, rms));
  return plot;
}

Plot ripple_plot(const Result& result, std::size_t window) {
  Plot plot{.title = "Bias left by time since the last fix, " + windows()[window].name + ", both radars",
            .x_label = "time since the last GPS fix, s",
            .y_label = "rms of bias left, m",
            .log_y = true,
            .row = "ripple"};
  const auto curve_of = [window](std::string label, const Score& score, bool dashed) {
    Curve curve{.label = std::move(label), .dashed = dashed};
    for (std::size_t i = 0; i < ripple_bins; ++i) {
      curve.x.push_back((static_cast<double>(i) + 0.5) * fix_interval_s / ripple_bins);
      curve.y.push_back(score.window[window].ripple[i].rms());
    }
    return curve;
  };
  for (const Flown& f : result.flown) {
    if (f.contestant.which == Case::Base && f.contestant.gets_fixes)
      plot.curves.push_back(curve_of(f.contestant.label, f.score, false));
  }
  plot.curves.push_back(curve_of("bound", result.bound, true));
  return plot;
}

/// Fig. 5 and 6 of song2015, methods side by side.
Plot residual_plot_of(const Flown& flown, std::size_t w, std::size_t radar, const Component& component) {
  const score::Phase& window = windows()[w];
  std::vector<Residual> inside;
  for (const PlotResidual& r : flown.residuals) {
    if (r.radar == static_cast<int>(radar) && window.from_s <= r.t_s && r.t_s < window.to_s) inside.push_back(r);
  }
  const std::string of =
      std::string(component.name) + " residual of " + std::string(radar_names[radar]) + ", " + window.name;
  return residual_plot(of + ", " + flown.contestant.label + (w == 0 ? " (paper: figure 5)" : " (paper: figure 6)"), of,
                       inside, component);
}

}  // namespace

std::vector<Plot> plots(const Result& result) {
  std::vector<Plot> all;
  const auto position = [](const Errors& e) { return e.position.rms(); };
  all.push_back(against_time(result, "Position error", "rms over runs, m", Case::Base, result.bound, position));
  for (std::size_t r = 0; r < radars; ++r) {
    const auto bias_left = [r](const Errors& e) { return e.bias_left[r].rms(); };
    all.push_back(against_time(result, "Bias left after compensation, " + std::string(radar_names[r]),
                               "rms over runs, m", Case::Base, result.bound, bias_left));
  }
  all.push_back(against_time(result, "Position error, GPS lost at 370 s", "rms over runs, m", Case::GpsLost,
                             result.bound_gps_lost, position));
  for (std::size_t w = 0; w < windows().size(); ++w) all.push_back(ripple_plot(result, w));
  for (const std::size_t w : {std::size_t{0}, std::size_t{2}}) {
    for (std::size_t radar = 0; radar < radars; ++radar) {
      for (const Component& component : components) {
        for (const std::string_view label : {"uncorrected", "song2015", "joint-ca"}) {
          const Flown* const flown = result.find(label);
          if (flown != nullptr) all.push_back(residual_plot_of(*flown, w, radar, component));
        }
      }
    }
  }
  return all;
}

}  // namespace downrange::experiment::launch
