#include <algorithm>
#include <cmath>
#include <downrange/est/filter/consistency.hpp>
#include <iomanip>
#include <numbers>
#include <sstream>
#include <string_view>

#include "score/errors.hpp"
#include "score/summary.hpp"

namespace downrange::score {
namespace {

constexpr double mdeg = std::numbers::pi / 180 / 1000;
constexpr std::size_t label_width = 22;
constexpr std::size_t text_width = 100;
constexpr std::size_t phases_per_line = 3;  // 22 + 3 * 26 = 100 columns

std::string right(std::string_view text, std::size_t width) {
  return text.size() >= width ? std::string(text) : std::string(width - text.size(), ' ') + std::string(text);
}

/// Right-aligned; decimals go when the number is too long for its column. "-" for what is no number.
std::string number(double value, int width, int decimals) {
  if (!std::isfinite(value)) return right("-", static_cast<std::size_t>(width));
  std::ostringstream text;
  text << std::fixed << std::setprecision(decimals) << std::setw(width) << value;
  if (decimals > 0 && text.str().size() >= static_cast<std::size_t>(width) && text.str()[0] != ' ')
    return number(value, width, 0);
  return text.str();
}

std::string percent(double share, int width, int decimals = 0) {
  return number(100 * share, width - 2, decimals) + " %";
}

/// Left-aligned, one blank at least before the next column.
std::string left(std::string_view text, std::size_t width) {
  std::string cell(text.substr(0, width - 1));
  cell.resize(width, ' ');
  return cell;
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

/// A phase without an estimate, or with a single one, is named: figures of it say little.
void name_thin_phases(std::ostringstream& out, const Summary& summary, const std::vector<TrajectoryScore>& rows) {
  for (std::size_t i = 0; i < summary.phases.size(); ++i) {
    std::size_t most = 0;
    for (const TrajectoryScore& row : rows) most = std::max(most, row.phases[i].samples);
    if (most <= 1)
      out << (most == 0 ? "Nothing to judge in " : "A single sample in ") << phase_heading(summary.phases[i]) << '\n';
  }
}

void position_table(std::ostringstream& out, const Summary& summary) {
  const std::vector<TrajectoryScore>& rows = summary.truth_known ? summary.trajectories : summary.against_gps;
  if (summary.truth_known) {
    out << "Position error against the truth, m (in %: inside the reported 95 % ellipsoid)\n";
  } else {
    out << "No true trajectory is known. GPS fixes against the track just before each, m (in %: inside the\n"
        << "95 % ellipsoid of track and fix)\n";
  }
  for (std::size_t first = 0; first < summary.phases.size(); first += phases_per_line) {
    const std::size_t last = std::min(first + phases_per_line, summary.phases.size());
    out << '\n' << left("", label_width);
    for (std::size_t i = first; i < last; ++i) out << right(phase_heading(summary.phases[i]), 26);
    out << '\n' << left("", label_width);
    for (std::size_t i = first; i < last; ++i)
      out << right("rms", 7) << right("p95", 7) << right("worst", 7) << right("in %", 5);
    out << '\n';
    for (const TrajectoryScore& row : rows) {
      out << left(row.label, label_width);
      for (std::size_t i = first; i < last; ++i) out << position_cells(row.phases[i]);
      out << '\n';
    }
  }
  name_thin_phases(out, summary, rows);
}

std::string before_after(bool known, double before, double after, double unit) {
  if (!known) return right("-", 11) + right("-", 9);
  return number(before / unit, 11, 1) + number(after / unit, 9, 1);
}

void systematic_table(std::ostringstream& out, const Summary& summary) {
  if (summary.systematic.empty()) {
    out << "\nSystematic errors: "
        << (summary.truth_known ? "no radar and no angle sensor is configured" : "not without a true trajectory")
        << '\n';
    return;
  }
  out << "\nSystematic error of each sensor in these phases: rms of 10 s means of measured - true, without\n"
      << "outliers and what was rejected\n\n"
      << left("", label_width) << right("plots", 8) << right("rejected*", 10) << right("range, m", 20)
      << right("azimuth*, mdeg", 20) << right("elevation, mdeg", 20) << '\n'
      << left("", label_width + 18);
  for (int i = 0; i < 3; ++i) out << right("before", 11) << right("after", 9);
  out << '\n';
  for (const SystematicScore& row : summary.systematic) {
    const bool known = row.plots > 0;
    out << left(row.sensor.view(), label_width) << right(std::to_string(row.plots), 8)
        << right(std::to_string(row.rejected), 10)
        << before_after(known && row.has_range, row.before.range_m, row.after.range_m, 1)
        << before_after(known && row.has_angles, row.before.azimuth_rad, row.after.azimuth_rad, mdeg)
        << before_after(known && row.has_angles, row.before.elevation_rad, row.after.elevation_rad, mdeg) << '\n';
  }
  out << "* rejected: in the whole flight, as in the table below; azimuth times cos elevation;\n"
      << "  after: corrected for the estimated bias\n";
}

/// Of a row whose angles are known.
std::string pointing_cells(const PointingScore& row) {
  if (row.scored == 0) return right("-", 10) + right("-", 8) + right("-", 8) + right("-", 9);
  return number(row.rms_rad / mdeg, 10, 1) + number(row.p95_rad / mdeg, 8, 1) + number(row.worst_rad / mdeg, 8, 1) +
         percent(row.inside_2_sigma, 9);
}

void pointing_table(std::ostringstream& out, const Summary& summary) {
  if (summary.pointing.empty()) {
    out << "\nSlaving: no command" << (summary.truth_known ? " while the truth is known" : "") << '\n';
    return;
  }
  out << "\nSlaving: angle between command and true direction when the command is applied, mdeg; age, ms\n\n"
      << left("", label_width) << left("source", 14) << right("commands", 9) << right("held*", 7) << right("rms", 10)
      << right("p95", 8) << right("worst", 8) << right("2-sigma", 9) << right("age", 6) << right("worst", 7) << '\n';
  for (const PointingScore& row : summary.pointing)
    out << left(row.antenna.view(), label_width) << left(name_of(row.source), 14)
        << right(std::to_string(row.commands), 9) << right(std::to_string(row.held), 7) << pointing_cells(row)
        << number(1000 * row.mean_age_s, 6, 0) << number(1000 * row.worst_age_s, 7, 0) << '\n';
  out << "* target outside the antenna's travel: not scored; 2-sigma: share within, 95 % when honest;\n"
      << "  age: of the newest measurement behind the command, at application\n";
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

std::string outliers_cell(const Summary& summary, const SourceScore& row) {
  if (summary.outliers == OutlierOrigin::None || row.outliers == 0) return "-";
  return (row.outliers_rejected ? std::to_string(*row.outliers_rejected) : "?") + " of " + std::to_string(row.outliers);
}

std::string_view outliers_note(OutlierOrigin origin) {
  switch (origin) {
    case OutlierOrigin::None:
      return "of outliers: not known without a true trajectory";
    case OutlierOrigin::Truth:
      return "of outliers: rejected of the plots 10 sigma and more off the median of their 10 s";
    case OutlierOrigin::Planted:
      return "of outliers: rejected of those planted";
  }
  return "";
}

/// "72-100"; with a mark where a right model would be elsewhere.
std::string band_cell(const SourceScore& row) {
  if (row.nis_count == 0) return "-";
  const auto whole = [](double share) { return std::to_string(std::lround(100 * share)); };
  return whole(row.nis_band.low) + '-' + whole(row.nis_band.high) + (row.nis_band.contains(0.95) ? "" : " !");
}

/// Beside the label: what ingest accepted and nobody used.
std::string excluded_line(const SourceScore& source) {
  if (source.excluded == 0) return {};
  return left("", label_width) + "not used: " + std::to_string(source.excluded) + " while excluded by integrity\n";
}

/// What was learnt of its noise, beside the label.
std::string noise_line(const SourceScore& source) {
  const std::string learnt = learnt_noise(source.kind, source.sigma_ratio);
  return learnt.empty() ? "" : left("", label_width) + "noise over configured: " + learnt + '\n';
}

void source_table(std::ostringstream& out, const Summary& summary) {
  out << "\nMessages of each source in the whole flight, and how they fit what " << summary.method.view()
      << " assumes of it\n\n"
      << left("", label_width) << right("accepted", 10) << right("rejected", 10) << right("of outliers*", 15)
      << right("NIS in 95 %", 13) << right("band*", 9) << right("worst", 9) << right("mismatch", 11) << '\n';
  for (const SourceScore& row : summary.sources)
    out << left(row.sensor.view(), label_width) << right(std::to_string(row.accepted()), 10)
        << right(std::to_string(row.rejected()), 10) << right(outliers_cell(summary, row), 15)
        << (row.nis_count == 0 ? right("-", 13) : percent(row.nis_inside_95, 13, 1)) << right(band_cell(row), 9)
        << (row.least_nis_inside_95 ? percent(*row.least_nis_inside_95, 9, 1) : right("-", 9))
        << right(row.mismatch_s == 0 ? "-" : std::to_string(row.mismatch_s) + " s", 11) << '\n'
        << reasons(row) << excluded_line(row) << noise_line(row);
  out << "* " << outliers_note(summary.outliers) << ";\n"
      << "  NIS in 95 %: share of normalised innovations in their 95 % region, 95 % when the model is right;\n"
      << "  band: where the true share may be, as errors are alike for " << alike_for_s << " s (!: not at 95 %);\n"
      << "  worst: of a full window of " << MismatchAlarm().window() << "; mismatch: how long the alarm rang, below "
      << number(100 * MismatchAlarm::threshold, 0, 0) << " % in a full\n  window, at less before it was full\n";
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

void bias_table(std::ostringstream& out, const Summary& summary) {
  if (summary.biases.empty()) {
    out << "\nBiases at the end by " << summary.method.view() << ": none\n";
    return;
  }
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

/// A sentence over several lines, broken at blanks.
void wrapped(std::ostringstream& out, const std::string& text, std::size_t indent) {
  std::size_t column = indent;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (column > indent && column + 1 + word.size() > text_width) {
      out << '\n' << std::string(indent, ' ');
      column = indent;
    }
    if (column > indent) out << ' ';
    out << word;
    column += word.size() + 1;
  }
  out << '\n';
}

void integrity_story(std::ostringstream& out, const Summary& summary) {
  if (summary.integrity.empty()) return;
  out << "\nWhat the sources say of each other, and whom the antennas follow (downrange/integrity)\n\n";
  constexpr std::size_t time_width = 11;
  for (const IntegrityNote& note : summary.integrity) {
    out << number(note.t_s, static_cast<int>(time_width) - 4, 1) << " s  ";
    wrapped(out, note.text, time_width);
  }
  if (summary.bounded > 0)
    out << "The bound covers the true error of"
        << percent(static_cast<double>(summary.bound_holds) / static_cast<double>(summary.bounded), 9, 2) << " of "
        << summary.bounded << " positions sent with one.\n";
}

std::string at_time(const std::optional<Extreme>& extreme, int width, int decimals, double unit = 1) {
  if (!extreme) return right("-", static_cast<std::size_t>(width) + 14);
  return number(extreme->value / unit, width, decimals) + " at" + number(extreme->t_s, 9, 1) + " s";
}

void impact_table(std::ostringstream& out, const Summary& summary) {
  if (summary.impacts.empty()) return;
  constexpr double km = 1000;
  out << "\nVacuum impact point in the whole flight (downrange/impact), against the fall of the true state, m\n\n"
      << left("by", label_width) << right("points", 8) << right("none*", 7) << right("rms", 9) << right("p95", 9)
      << right("worst", 10) << right("in 95 %", 9) << right("longest without data, s", 26) << '\n';
  for (const ImpactScore& row : summary.impacts) {
    const auto cell = [&](double value, int width) {
      return row.judged == 0 ? right("-", static_cast<std::size_t>(width)) : number(value, width, 1);
    };
    out << left(row.chain.empty() ? "selected chain" : row.chain.view(), label_width)
        << right(std::to_string(row.points), 8) << right(std::to_string(row.without_point), 7) << cell(row.rms_m, 9)
        << cell(row.p95_m, 9) << cell(row.worst_m, 10) << (row.judged == 0 ? right("-", 9) : percent(row.inside_95, 9))
        << at_time(row.longest_loss, 12, 1) << '\n';
    if (row.first_over_limit_s)
      out << "  without data for longer than allowed in " << row.over_limit << " records, first at"
          << number(*row.first_over_limit_s, 9, 1) << " s\n";
  }
  out << "* no track, or nothing that comes down\n";
  if (summary.boundaries.empty()) return;
  out << "\nBoundaries by the selected chain: distance, km, positive inside\n\n"
      << left("", label_width) << right("impact point's least", 26) << right("least of where it was", 26)
      << right("most likely outside", 26) << '\n';
  for (const BoundaryScore& row : summary.boundaries) {
    out << left(row.boundary.view(), label_width) << at_time(row.least_m, 12, 3, km)
        << at_time(row.least_present_m, 12, 3, km);
    std::ostringstream probability;
    if (row.most_outside) probability << std::setprecision(2) << row.most_outside->value;
    out << (row.most_outside ? right(probability.str(), 12) + " at" + number(row.most_outside->t_s, 9, 1) + " s"
                             : right("-", 26))
        << '\n';
    if (row.first_outside_s)
      out << "  the impact point was outside first at" << number(*row.first_outside_s, 9, 1) << " s\n";
  }
}

}  // namespace

std::string format_text(const Summary& summary) {
  std::ostringstream out;
  position_table(out, summary);
  systematic_table(out, summary);
  source_table(out, summary);
  bias_table(out, summary);
  integrity_story(out, summary);
  impact_table(out, summary);
  pointing_table(out, summary);
  return out.str();
}

}  // namespace downrange::score
