#include "score/summary.hpp"

#include <cmath>
#include <numeric>

namespace downrange::score {

std::uint64_t SourceScore::rejected() const {
  return std::accumulate(count.begin(), count.end(), std::uint64_t{0}) - accepted();
}

std::string_view name_of(SourceKind kind) {
  switch (kind) {
    case SourceKind::Radar:
      return "radar";
    case SourceKind::Telemetry:
      return "gps";
    case SourceKind::AngleSensor:
      return "angles";
  }
  return "unknown";
}

std::string_view name_of(SlavingSource source) {
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

double sigma_of(const SensorBias& bias, int i) {
  const int diagonal = triangle_size(bias.terms) - triangle_size(bias.terms - i);
  return std::sqrt(bias.covariance[static_cast<std::size_t>(diagonal)]);
}

}  // namespace downrange::score
