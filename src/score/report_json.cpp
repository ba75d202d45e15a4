#include <cmath>
#include <nlohmann/json.hpp>

#include "score/summary.hpp"

namespace downrange::score {
namespace {

using nlohmann::ordered_json;

/// null where there is no number: `known` says so, or it is not finite.
ordered_json number(bool known, double value) {
  return known && std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
}

ordered_json number(const std::optional<std::size_t>& value) {
  return value ? ordered_json(*value) : ordered_json(nullptr);
}

ordered_json json_of(const SourceScore& source, OutlierOrigin origin) {
  ordered_json reasons = ordered_json::object();
  for (std::size_t i = 0; i < reason_count; ++i) {
    const auto reason = static_cast<Reason>(i);
    if (reason != Reason::Accepted) reasons[std::string(to_string(reason))] = source.count[i];
  }
  const bool told = origin != OutlierOrigin::None;
  ordered_json sigma_ratio = ordered_json::array();
  for (const double ratio : source.sigma_ratio) sigma_ratio.push_back(number(ratio > 0, ratio));
  return {
      {"source", source.sensor.view()},
      {"kind", name_of(source.kind)},
      {"accepted", source.accepted()},
      {"rejected", reasons},
      {"excluded", source.excluded},
      {"outliers", told ? ordered_json(source.outliers) : ordered_json(nullptr)},
      {"outliers_rejected", told ? number(source.outliers_rejected) : ordered_json(nullptr)},
      {"nis_count", source.nis_count},
      {"nis_inside_95", number(source.nis_count > 0, source.nis_inside_95)},
      {"nis_independent", number(source.nis_count > 0, source.nis_independent)},
      {"nis_band_low", number(source.nis_count > 0, source.nis_band.low)},
      {"nis_band_high", number(source.nis_count > 0, source.nis_band.high)},
      {"least_nis_inside_95", number(source.least_nis_inside_95.has_value(), source.least_nis_inside_95.value_or(0))},
      {"mismatch_s", source.mismatch_s},
      {"sigma_ratio", sigma_ratio}};
}

ordered_json json_of(const SensorBias& bias) {
  ordered_json terms = ordered_json::array();
  for (int i = 0; i < bias.terms; ++i) {
    const auto k = static_cast<std::size_t>(i);
    terms.push_back({{"term", to_string(bias.term[k])},
                     {"value", number(true, bias.value[k])},
                     {"sigma", number(true, sigma_of(bias, i))},
                     {"state", to_string(bias.state[k])}});
  }
  return {{"source", bias.sensor.view()}, {"plots", bias.samples}, {"terms", terms}};
}

ordered_json json_of(const SystematicError& error, const SystematicScore& of) {
  const bool known = of.plots > 0;
  ordered_json json = ordered_json::object();
  if (of.has_range) json["range_m"] = number(known, error.range_m);
  if (!of.has_angles) return json;
  json["azimuth_sky_rad"] = number(known, error.azimuth_rad);
  json["elevation_rad"] = number(known, error.elevation_rad);
  return json;
}

/// Those of one kind, under the name of their table in the configuration.
ordered_json json_of(const std::vector<SystematicScore>& scores, SourceKind kind, const char* name) {
  ordered_json rows = ordered_json::array();
  for (const SystematicScore& score : scores)
    if (score.kind == kind)
      rows.push_back({{name, score.sensor.view()},
                      {"plots", score.plots},
                      {"rejected", score.rejected},
                      {"before", json_of(score.before, score)},
                      {"after", json_of(score.after, score)}});
  return rows;
}

ordered_json json_of(const PositionScore& score) {
  const bool known = score.samples > 0;
  return {{"samples", score.samples},
          {"rms_m", number(known, score.rms_m)},
          {"p95_m", number(known, score.p95_m)},
          {"worst_m", number(known, score.worst_m)},
          {"inside_95", number(known, score.inside_95)}};
}

ordered_json json_of(const std::vector<TrajectoryScore>& scores, const std::vector<Phase>& of) {
  ordered_json rows = ordered_json::array();
  for (const TrajectoryScore& row : scores) {
    ordered_json phases = ordered_json::array();
    for (std::size_t i = 0; i < row.phases.size(); ++i) {
      ordered_json entry = {{"phase", of[i].name}, {"from_s", of[i].from_s}, {"to_s", of[i].to_s}};
      entry.update(json_of(row.phases[i]));
      phases.push_back(entry);
    }
    rows.push_back({{"label", row.label}, {"phases", phases}});
  }
  return rows;
}

ordered_json json_of(const PointingScore& row) {
  const bool known = row.scored > 0;
  return {{"antenna", row.antenna.view()},
          {"source", name_of(row.source)},
          {"commands", row.commands},
          {"held", row.held},
          {"rms_rad", number(known, row.rms_rad)},
          {"p95_rad", number(known, row.p95_rad)},
          {"worst_rad", number(known, row.worst_rad)},
          {"inside_2_sigma", number(known, row.inside_2_sigma)},
          {"mean_age_s", row.mean_age_s},
          {"worst_age_s", row.worst_age_s}};
}

ordered_json json_of(const std::optional<Extreme>& extreme, const char* name) {
  if (!extreme) return nullptr;
  return {{name, number(true, extreme->value)}, {"t_s", extreme->t_s}};
}

ordered_json json_of(const std::optional<double>& value) {
  return value ? number(true, *value) : ordered_json(nullptr);
}

ordered_json json_of(const ImpactScore& row) {
  const bool known = row.judged > 0;
  return {{"chain", row.chain.view()},
          {"points", row.points},
          {"without_point", row.without_point},
          {"judged", row.judged},
          {"rms_m", number(known, row.rms_m)},
          {"p95_m", number(known, row.p95_m)},
          {"worst_m", number(known, row.worst_m)},
          {"inside_95", number(known, row.inside_95)},
          {"longest_loss", json_of(row.longest_loss, "data_loss_s")},
          {"over_limit", row.over_limit},
          {"first_over_limit_s", json_of(row.first_over_limit_s)}};
}

ordered_json json_of(const BoundaryScore& row) {
  return {{"boundary", row.boundary.view()},
          {"least", json_of(row.least_m, "distance_m")},
          {"least_present", json_of(row.least_present_m, "distance_m")},
          {"most_outside", json_of(row.most_outside, "probability")},
          {"first_outside_s", json_of(row.first_outside_s)}};
}

ordered_json json_of(OutlierOrigin origin) {
  switch (origin) {
    case OutlierOrigin::None:
      return nullptr;
    case OutlierOrigin::Truth:
      return "truth";
    case OutlierOrigin::Planted:
      return "planted";
  }
  return nullptr;
}

}  // namespace

std::string format_json(const Summary& summary) {
  ordered_json pointing = ordered_json::array();
  for (const PointingScore& row : summary.pointing) pointing.push_back(json_of(row));
  ordered_json sources = ordered_json::array();
  for (const SourceScore& source : summary.sources) sources.push_back(json_of(source, summary.outliers));
  ordered_json biases = ordered_json::array();
  for (const SensorBias& bias : summary.biases) biases.push_back(json_of(bias));
  ordered_json json = ordered_json::object();
  json["truth"] = summary.truth_known;
  if (summary.truth_known) {
    json["trajectories"] = json_of(summary.trajectories, summary.phases);
    json["radars"] = json_of(summary.systematic, SourceKind::Radar, "radar");
    json["angle_sensors"] = json_of(summary.systematic, SourceKind::AngleSensor, "angle_sensor");
  } else {
    json["against_gps"] = json_of(summary.against_gps, summary.phases);
  }
  json["pointing"] = pointing;
  json["method"] = summary.method.view();
  json["outliers_told_by"] = json_of(summary.outliers);
  json["sources"] = sources;
  json["biases"] = biases;
  json["integrity"] = ordered_json::array();
  for (const IntegrityNote& note : summary.integrity)
    json["integrity"].push_back({{"t_s", note.t_s}, {"text", note.text}});
  json["bound"] = {{"positions", summary.bounded}, {"covered", summary.bound_holds}};
  json["impact"] = ordered_json::array();
  for (const ImpactScore& row : summary.impacts) json["impact"].push_back(json_of(row));
  json["boundaries"] = ordered_json::array();
  for (const BoundaryScore& row : summary.boundaries) json["boundaries"].push_back(json_of(row));
  return json.dump(2) + "\n";
}

}  // namespace downrange::score
