#include <algorithm>
#include <array>
#include <cmath>
#include <downrange/stage/source_table.hpp>

namespace downrange {
namespace {

Duration three_periods(double rate_hz) { return std::max(seconds(1.0), seconds(3 / rate_hz)); }

template <class Matches>
SourceId position_of(const std::vector<Source>& sources, Matches matches) {
  const auto found = std::ranges::find_if(sources, matches);
  return found == sources.end() ? no_source : static_cast<SourceId>(found - sources.begin());
}

}  // namespace

std::string_view to_string(SourceKind kind) {
  static constexpr std::array<std::string_view, 3> names{"radar", "angle_sensor", "telemetry"};
  return names.at(static_cast<std::size_t>(kind));
}

SourceKind kind_of(const Measured& measured) {
  static constexpr std::array kinds{SourceKind::Radar, SourceKind::Telemetry, SourceKind::AngleSensor};
  static_assert(kinds.size() == std::variant_size_v<Measured>);
  return kinds.at(measured.index());
}

std::string learnt_noise(SourceKind kind, const SigmaRatios& ratios) {
  static constexpr std::array<std::string_view, 4> of_radar{"range", "azimuth", "elevation", "range rate"};
  static constexpr std::array<std::string_view, 4> of_receiver{"horizontal", "vertical", "velocity", ""};
  std::string text;
  for (std::size_t i = 0; i < ratios.size(); ++i) {
    if (!(ratios[i] > 0)) continue;
    const std::int64_t hundredths = std::llround(100 * ratios[i]);
    const std::string decimals = std::to_string(100 + hundredths % 100).substr(1);
    text += (text.empty() ? "" : ", ") + std::string((kind == SourceKind::Telemetry ? of_receiver : of_radar)[i]) +
            ' ' + std::to_string(hundredths / 100) + '.' + decimals;
  }
  return text;
}

SourceTable::SourceTable(const RangeConfig& config) {
  for (const RadarConfig& radar : config.radars)
    sources_.push_back({.name = radar.id,
                        .kind = SourceKind::Radar,
                        .site = radar.site,
                        .silent_after = three_periods(radar.rate_hz),
                        .rate_hz = radar.rate_hz,
                        .sigma = measured_sigma(radar),
                        .refractivity = radar.refractivity});
  for (const AngleSensorConfig& sensor : config.angle_sensors)
    sources_.push_back({.name = sensor.id,
                        .kind = SourceKind::AngleSensor,
                        .site = sensor.site,
                        .silent_after = three_periods(sensor.rate_hz),
                        .rate_hz = sensor.rate_hz,
                        .sigma = {.azimuth_rad = sensor.sigma_azimuth_rad, .elevation_rad = sensor.sigma_elevation_rad},
                        .refractivity = sensor.refractivity});
  for (const TelemetryConfig& station : config.telemetry)
    sources_.push_back({.name = station.id,
                        .kind = SourceKind::Telemetry,
                        .site = station.site,
                        .silent_after = config.align.gps.max_age});
}

SourceId SourceTable::find(SourceKind kind, const Name& name) const {
  return position_of(sources_, [&](const Source& s) { return s.kind == kind && s.name == name; });
}

SourceId SourceTable::find(const Name& name) const {
  return position_of(sources_, [&](const Source& s) { return s.name == name; });
}

}  // namespace downrange
