#include <algorithm>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>
#include <string_view>

#include "sim/score.hpp"

namespace downrange::sim {
namespace {

constexpr double mdeg = std::numbers::pi / 180 / 1000;
constexpr std::size_t label_width = 22;
constexpr std::size_t phases_per_line = 3;  // 22 + 3 * 26 = 100 columns

/// Right-aligned; decimals go when the number is too long for its column.
std::string number(double value, int width, int decimals) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(decimals) << std::setw(width) << value;
  if (decimals > 0 && text.str().size() >= static_cast<std::size_t>(width) && text.str()[0] != ' ')
    return number(value, width, 0);
  return text.str();
}

std::string percent(double share, int width) { return number(100 * share, width - 2, 0) + " %"; }

std::string right(std::string_view text, std::size_t width) {
  return text.size() >= width ? std::string(text) : std::string(width - text.size(), ' ') + std::string(text);
}

/// Left-aligned, one blank at least before the next column.
std::string left(std::string_view text, std::size_t width) {
  std::string cell(text.substr(0, width - 1));
  cell.resize(width, ' ');
  return cell;
}

std::string_view source_name(SlavingSource source) {
  switch (source) {
    case SlavingSource::Fused:
      return "fused";
    case SlavingSource::Coasting:
      return "coasting";
    case SlavingSource::SingleSensor:
      return "single sensor";
    case SlavingSource::Gps:
      return "GPS";
    case SlavingSource::Nominal:
      return "nominal";
  }
  return "unknown";
}

std::string phase_heading(const Phase& phase) {
  std::ostringstream text;
  text << phase.name << ' ' << phase.from_s << "-" << phase.to_s << " s";
  return text.str();
}

std::string position_cells(const PositionScore& score) {
  if (score.samples == 0) return right("-", 7) + right("-", 7) + right("-", 7) + right("-", 5);
  return number(score.rms_m, 7, 1) + number(score.p95_m, 7, 1) + number(score.worst_m, 7, 1) +
         number(100 * score.inside_95, 5, 0);
}

void position_table(std::ostringstream& out, const Summary& summary) {
  out << "Position error against the truth, m (in %: inside the reported 95 % ellipsoid)\n";
  for (std::size_t first = 0; first < summary.phases.size(); first += phases_per_line) {
    const std::size_t last = std::min(first + phases_per_line, summary.phases.size());
    out << '\n' << left("", label_width);
    for (std::size_t i = first; i < last; ++i) out << right(phase_heading(summary.phases[i]), 26);
    out << '\n' << left("", label_width);
    for (std::size_t i = first; i < last; ++i)
      out << right("rms", 7) << right("p95", 7) << right("worst", 7) << right("in %", 5);
    out << '\n';
    for (const TrajectoryScore& row : summary.trajectories) {
      out << left(row.label, label_width);
      for (std::size_t i = first; i < last; ++i) out << position_cells(row.phases[i]);
      out << '\n';
    }
  }
}

std::string before_after(const RadarScore& radar, double before, double after, double unit) {
  if (radar.plots == 0) return right("-", 11) + right("-", 9);
  return number(before / unit, 11, 1) + number(after / unit, 9, 1);
}

void radar_table(std::ostringstream& out, const Summary& summary) {
  out << "\nSystematic error of each radar in these phases: rms of 10 s means of measured - true, no outliers\n\n"
      << left("", label_width) << right("plots", 8) << right("rejected", 10) << right("range, m", 20)
      << right("azimuth*, mdeg", 20) << right("elevation, mdeg", 20) << '\n'
      << left("", label_width + 18);
  for (int i = 0; i < 3; ++i) out << right("before", 11) << right("after", 9);
  out << '\n';
  for (const RadarScore& radar : summary.radars)
    out << left(radar.sensor.view(), label_width) << right(std::to_string(radar.plots), 8)
        << right(std::to_string(radar.rejected), 10)
        << before_after(radar, radar.before.range_m, radar.after.range_m, 1)
        << before_after(radar, radar.before.azimuth_rad, radar.after.azimuth_rad, mdeg)
        << before_after(radar, radar.before.elevation_rad, radar.after.elevation_rad, mdeg) << '\n';
  out << "* azimuth times cos elevation; after: with the estimated bias taken out\n";
}

void pointing_table(std::ostringstream& out, const Summary& summary) {
  out << "\nSlaving: angle between command and true direction when the command is applied, mdeg; age, ms\n\n"
      << left("", label_width) << left("source", 14) << right("commands", 9) << right("held*", 7) << right("rms", 10)
      << right("p95", 8) << right("worst", 8) << right("2-sigma", 9) << right("age", 6) << right("worst", 7) << '\n';
  for (const PointingScore& row : summary.pointing)
    out << left(row.antenna.view(), label_width) << left(source_name(row.source), 14)
        << right(std::to_string(row.commands), 9) << right(std::to_string(row.held), 7)
        << number(row.rms_rad / mdeg, 10, 1) << number(row.p95_rad / mdeg, 8, 1) << number(row.worst_rad / mdeg, 8, 1)
        << percent(row.inside_2_sigma, 9) << number(1000 * row.mean_age_s, 6, 0) << number(1000 * row.worst_age_s, 7, 0)
        << '\n';
  out << "* target outside the antenna's travel: not scored; 2-sigma: share within, 95 % when honest;\n"
      << "  age: of the newest measurement behind the command, at application\n";
}

nlohmann::ordered_json json_of(const SystematicError& error) {
  return {{"range_m", error.range_m}, {"azimuth_sky_rad", error.azimuth_rad}, {"elevation_rad", error.elevation_rad}};
}

nlohmann::ordered_json json_of(const PositionScore& score) {
  return {{"samples", score.samples},
          {"rms_m", score.rms_m},
          {"p95_m", score.p95_m},
          {"worst_m", score.worst_m},
          {"inside_95", score.inside_95}};
}

}  // namespace

std::string format_text(const Summary& summary) {
  std::ostringstream out;
  position_table(out, summary);
  radar_table(out, summary);
  pointing_table(out, summary);
  return out.str();
}

std::string format_json(const Summary& summary) {
  using nlohmann::ordered_json;
  ordered_json trajectories = ordered_json::array();
  for (const TrajectoryScore& row : summary.trajectories) {
    ordered_json phases = ordered_json::array();
    for (std::size_t i = 0; i < row.phases.size(); ++i) {
      const Phase& phase = summary.phases[i];
      ordered_json entry = {{"phase", phase.name}, {"from_s", phase.from_s}, {"to_s", phase.to_s}};
      entry.update(json_of(row.phases[i]));
      phases.push_back(entry);
    }
    trajectories.push_back({{"label", row.label}, {"phases", phases}});
  }
  ordered_json radars = ordered_json::array();
  for (const RadarScore& radar : summary.radars)
    radars.push_back({{"radar", radar.sensor.view()},
                      {"plots", radar.plots},
                      {"rejected", radar.rejected},
                      {"before", json_of(radar.before)},
                      {"after", json_of(radar.after)}});
  ordered_json pointing = ordered_json::array();
  for (const PointingScore& row : summary.pointing)
    pointing.push_back({{"antenna", row.antenna.view()},
                        {"source", source_name(row.source)},
                        {"commands", row.commands},
                        {"held", row.held},
                        {"rms_rad", row.rms_rad},
                        {"p95_rad", row.p95_rad},
                        {"worst_rad", row.worst_rad},
                        {"inside_2_sigma", row.inside_2_sigma},
                        {"mean_age_s", row.mean_age_s},
                        {"worst_age_s", row.worst_age_s}});
  const ordered_json summary_json = {{"trajectories", trajectories}, {"radars", radars}, {"pointing", pointing}};
  return summary_json.dump(2) + "\n";
}

}  // namespace downrange::sim
