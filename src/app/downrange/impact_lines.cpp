#include "impact_lines.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <downrange/geo/ground_polygon.hpp>
#include <numbers>
#include <vector>

namespace downrange::app {
namespace {

constexpr double deg = std::numbers::pi / 180;
constexpr std::size_t screen_width = 80;
constexpr std::size_t boundaries_shown = 3;
constexpr double told_after_s = 1;  ///< without data

template <class... Values>
std::string format(const char* pattern, const Values&... values) {
  std::array<char, 200> text{};
  std::snprintf(text.data(), text.size(), pattern, values...);
  return text.data();
}

/// "350 m", "12.3 km".
std::string length(double m) {
  return std::abs(m) < 1000 ? format("%.0f m", m) : format(std::abs(m) < 1e5 ? "%.1f km" : "%.0f km", m / 1000);
}

std::string side(double m) { return format("%8s %s", length(std::abs(m)).c_str(), m < 0 ? "OUTSIDE" : "inside "); }

/// Both semi-axes of the 1-sigma ellipse.
std::string ellipse(const std::array<double, 3>& cov) {
  const double middle = (cov[0] + cov[2]) / 2;
  const double half = std::hypot((cov[0] - cov[2]) / 2, cov[1]);
  return length(std::sqrt(middle + half)) + " x " + length(std::sqrt(std::max(middle - half, 0.0)));
}

std::string point_line(const ImpactPoint& i) {
  const std::string head = format("%-10s vacuum impact ", i.target.c_str());
  if (!i.impact_valid && i.data_age_s == 0 && i.data_loss_timer_s > 0) return head + "none: there is no track\n";
  if (!i.impact_valid) return head + "none: it does not come down\n";
  return head + format("%8.4f %9.4f in %6.1f s  sigma %s\n", i.point.latitude_rad / deg, i.point.longitude_rad / deg,
                       i.time_to_impact_s, ellipse(i.covariance_m2).c_str());
}

std::string boundary_lines(const ImpactPoint& i) {
  std::vector<BoundaryDistance> nearest = i.boundaries;
  const auto distance = [&](const BoundaryDistance& b) { return i.impact_valid ? b.distance_m : b.present_distance_m; };
  std::ranges::stable_sort(nearest, {}, distance);
  nearest.resize(std::min(nearest.size(), boundaries_shown));
  std::string text;
  for (const BoundaryDistance& b : nearest) {
    text += format("  %-12s ", b.boundary.c_str());
    if (i.impact_valid) text += side(b.distance_m) + format(" P(out) %7.1e", b.probability_outside);
    if (b.time_valid) text += b.time_s < 1e4 ? format(" in %5.1f s", b.time_s) : " in > 9999 s";
    text += (i.impact_valid ? " now" : "now") + side(b.present_distance_m);
    text.erase(text.find_last_not_of(' ') + 1);
    text += '\n';
  }
  if (i.boundaries.size() > nearest.size())
    text += format("  and %zu boundaries that it is farther inside of\n", i.boundaries.size() - nearest.size());
  return text;
}

std::string loss_line(const ImpactPoint& i) {
  const bool over = i.data_loss_limit_valid && i.data_loss_timer_s > i.data_loss_limit_s;
  if (!over && i.data_loss_timer_s < told_after_s) return {};
  std::string text = format("  %s for %.1f s", over ? "DATA LOST" : "no data", i.data_loss_timer_s);
  if (i.data_loss_limit_valid) text += format(", allowed: %.1f s", i.data_loss_limit_s);
  return text + '\n';
}

/// "  only-goheung 1.2 km off, only-GPS 12 m off", over several lines.
std::string chain_lines(const ImpactsByChain& impacts, const ImpactPoint& selected) {
  if (!selected.impact_valid) return {};
  const Position<Ecef> here = ecef_from_geodetic(selected.point);
  const auto axes = enu_from_ecef_at(selected.point);
  std::string text;
  std::string line;
  for (const auto& [chain, i] : impacts) {
    if (chain.empty()) continue;
    std::string told(chain.view());
    const bool over = i.data_loss_limit_valid && i.data_loss_timer_s > i.data_loss_limit_s;
    told +=
        i.impact_valid ? ' ' + length(ground_offset(here, axes, ecef_from_geodetic(i.point)).norm()) + " off" : " none";
    if (over) told += format(" (DATA LOST %.0f s)", i.data_loss_timer_s);
    if (!line.empty() && line.size() + told.size() + 2 > screen_width) {
      text += line + '\n';
      line.clear();
    }
    line += (line.empty() ? "  " : ", ") + told;
  }
  return line.empty() ? text : text + line + '\n';
}

}  // namespace

std::string impact_lines(const ImpactsByChain& impacts) {
  const auto selected = impacts.find(Name{});
  if (selected == impacts.end()) return {};
  const ImpactPoint& i = selected->second;
  return point_line(i) + boundary_lines(i) + loss_line(i) + chain_lines(impacts, i);
}

}  // namespace downrange::app
