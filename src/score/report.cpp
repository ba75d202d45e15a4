#include <algorithm>
#include <cmath>
#include <downrange/est/consistency.hpp>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>
#include <string_view>

#include "score/scorer.hpp"

namespace downrange::score {
namespace {

constexpr double mdeg = std::numbers::pi / 180 / 1000;
constexpr std::size_t label_width = 22;
constexpr std::size_t text_width = 100;
constexpr std::size_t phases_per_line = 3;  // 22 + 3 * 26 = 100 columns

/// Right-aligned; decimals go when the number is too long for its column.
std::string number(double value, int width, int decimals) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(decimals) << std::setw(width) << value;
  if (decimals > 0 && text.str().size() >= static_cast<std::size_t>(width) && text.str()[0] != ' ')
    return number(value, width, 0);
  return text.str();
}

std::string percent(double share, int width, int decimals = 0) {
  return number(100 * share, width - 2, decimals) + " %";
}

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

std::string_view kind_name(ObservationKind kind) {
  switch (kind) {
    case ObservationKind::Radar:
      return "radar";
    case ObservationKind::Gps:
      return "gps";
    case ObservationKind::Angles:
      return "angles";
  }
  return "unknown";
}

std::uint64_t rejected(const SourceScore& source) {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < reason_count; ++i) {
    if (static_cast<Reason>(i) != Reason::Accepted) sum += source.count[i];
  }
  return sum;
}

/// "duplicate 20, gated 3", in lines that fit beside the label.
std::string reasons(const SourceScore& source) {
  std::string text;
  std::string line;
  for (std::size_t i = 0; i < reason_count; ++i) {
    const auto reason = static_cast<Reason>(i);
    if (reason == Reason::Accepted || source.count[i] == 0) continue;
    const std::string entry = std::string(to_string(reason)) + " " + std::to_string(source.count[i]);
    if (label_width + 10 + line.size() + entry.size() + 2 > text_width) {
      text += left("", label_width) + "          " + line + ",\n";
      line.clear();
    }
    line += (line.empty() ? "" : ", ") + entry;
  }
  if (line.empty()) return {};
  text += left("", label_width) + "          " + line + '\n';
  return text.replace(label_width, 9, "rejected:");
}

void source_table(std::ostringstream& out, const Summary& summary) {
  out << "\nMessages of each source in the whole flight, and how they fit what " << summary.method.view()
      << " assumes of it\n\n"
      << left("", label_width) << right("accepted", 10) << right("rejected", 10) << right("of outliers*", 15)
      << right("NIS in 95 %", 13) << right("worst", 9) << right("mismatch", 11) << '\n';
  for (const SourceScore& row : summary.sources) {
    const std::string rejected_of_these = row.outliers_rejected ? std::to_string(*row.outliers_rejected) : "?";
    const std::string outliers = rejected_of_these + " of " + std::to_string(row.outliers);
    out << left(row.sensor.view(), label_width)
        << right(std::to_string(row.count[static_cast<std::size_t>(Reason::Accepted)]), 10)
        << right(std::to_string(rejected(row)), 10) << right(row.outliers == 0 ? "-" : outliers, 15)
        << (row.nis_count == 0 ? right("-", 13) : percent(row.nis_inside_95, 13, 1))
        << (row.least_nis_inside_95 ? percent(*row.least_nis_inside_95, 9, 1) : right("-", 9))
        << right(row.mismatch_s == 0 ? "-" : std::to_string(row.mismatch_s) + " s", 11) << '\n'
        << reasons(row);
  }
  out << "* of outliers: rejected of those planted; NIS in 95 %: share of normalised innovations in their 95 %\n"
      << "  region, 95 % when the model is right; worst: of a full window of " << MismatchAlarm().window()
      << "; mismatch: how long the\n  alarm rang, below " << number(100 * MismatchAlarm::threshold, 0, 0)
      << " % in a full window, at less before it was full\n";
}

/// How a term is shown: its unit, in the unit SI gives.
struct TermUnit {
  std::string_view name;
  double size;
};

TermUnit unit_of(BiasTerm term) {
  switch (term) {
    case BiasTerm::OffsetSouth:
    case BiasTerm::OffsetEast:
    case BiasTerm::OffsetZenith:
    case BiasTerm::OffsetRange:
      return {"m", 1};
    case BiasTerm::OffsetAzimuth:
    case BiasTerm::OffsetElevation:
      return {"mdeg", mdeg};
    case BiasTerm::ScaleSouth:
    case BiasTerm::ScaleEast:
    case BiasTerm::ScaleZenith:
    case BiasTerm::ScaleRange:
    case BiasTerm::ScaleAzimuth:
    case BiasTerm::ScaleElevation:
      return {"ppm", 1e-6};
    case BiasTerm::TimeTag:
      return {"ms", 1e-3};
  }
  return {"", 1};
}

double sigma_of(const SensorBias& bias, int i) {
  const int diagonal = triangle_size(bias.terms) - triangle_size(bias.terms - i);
  return std::sqrt(bias.covariance[static_cast<std::size_t>(diagonal)]);
}

void bias_table(std::ostringstream& out, const Summary& summary) {
  if (summary.biases.empty()) return;
  out << "\nBiases at the end by " << summary.method.view() << " (measured = true + bias)\n\n"
      << left("", label_width) << left("term", 18) << right("value", 12) << right("1-sigma", 12) << "       state*\n";
  for (const SensorBias& bias : summary.biases) {
    for (int i = 0; i < bias.terms; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const TermUnit unit = unit_of(bias.term[k]);
      out << left(i == 0 ? bias.sensor.view() : "", label_width) << left(to_string(bias.term[k]), 18)
          << number(bias.value[k] / unit.size, 12, 2) << number(sigma_of(bias, i) / unit.size, 12, 2) << ' '
          << left(unit.name, 6) << to_string(bias.state[k]) << '\n';
    }
  }
  out << "* not observable: the flight could not tell the term, alone or from the others; frozen: without a\n"
      << "  reference in the end. Terms stand in for each other: what counts is what all of them leave, above\n";
}

nlohmann::ordered_json json_of(const SourceScore& source) {
  using nlohmann::ordered_json;
  ordered_json reasons = ordered_json::object();
  for (std::size_t i = 0; i < reason_count; ++i) {
    const auto reason = static_cast<Reason>(i);
    if (reason != Reason::Accepted) reasons[std::string(to_string(reason))] = source.count[i];
  }
  const auto known = [](bool is, double share) { return is ? ordered_json(share) : ordered_json(nullptr); };
  return {
      {"source", source.sensor.view()},
      {"kind", kind_name(source.kind)},
      {"accepted", source.count[static_cast<std::size_t>(Reason::Accepted)]},
      {"rejected", reasons},
      {"outliers", source.outliers},
      {"outliers_rejected", source.outliers_rejected ? nlohmann::json(*source.outliers_rejected) : nlohmann::json()},
      {"nis_count", source.nis_count},
      {"nis_inside_95", known(source.nis_count > 0, source.nis_inside_95)},
      {"least_nis_inside_95", known(source.least_nis_inside_95.has_value(), source.least_nis_inside_95.value_or(0))},
      {"mismatch_s", source.mismatch_s}};
}

nlohmann::ordered_json json_of(const SensorBias& bias) {
  nlohmann::ordered_json terms = nlohmann::ordered_json::array();
  for (int i = 0; i < bias.terms; ++i) {
    const auto k = static_cast<std::size_t>(i);
    terms.push_back({{"term", to_string(bias.term[k])},
                     {"value", bias.value[k]},
                     {"sigma", sigma_of(bias, i)},
                     {"state", to_string(bias.state[k])}});
  }
  return {{"source", bias.sensor.view()}, {"plots", bias.samples}, {"terms", terms}};
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
  source_table(out, summary);
  bias_table(out, summary);
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
  ordered_json sources = ordered_json::array();
  for (const SourceScore& source : summary.sources) sources.push_back(json_of(source));
  ordered_json biases = ordered_json::array();
  for (const SensorBias& bias : summary.biases) biases.push_back(json_of(bias));
  const ordered_json summary_json = {{"trajectories", trajectories},    {"radars", radars},   {"pointing", pointing},
                                     {"method", summary.method.view()}, {"sources", sources}, {"biases", biases}};
  return summary_json.dump(2) + "\n";
}

}  // namespace downrange::score
