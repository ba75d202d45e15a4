#include <algorithm>
#include <array>
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

SourceTable::SourceTable(const RangeConfig& config) {
  for (const RadarConfig& radar : config.radars)
    sources_.push_back({radar.id, SourceKind::Radar, radar.site, three_periods(radar.rate_hz)});
  for (const AngleSensorConfig& sensor : config.angle_sensors)
    sources_.push_back({sensor.id, SourceKind::AngleSensor, sensor.site, three_periods(sensor.rate_hz)});
  for (const TelemetryConfig& station : config.telemetry)
    sources_.push_back({station.id, SourceKind::Telemetry, station.site, config.align.gps.max_age});
}

SourceId SourceTable::find(SourceKind kind, const Name& name) const {
  return position_of(sources_, [&](const Source& s) { return s.kind == kind && s.name == name; });
}

SourceId SourceTable::find(const Name& name) const {
  return position_of(sources_, [&](const Source& s) { return s.name == name; });
}

}  // namespace downrange
