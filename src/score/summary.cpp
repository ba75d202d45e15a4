#include "score/summary.hpp"

#include <cmath>

namespace downrange::score {

std::uint64_t SourceScore::rejected() const {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < count.size(); ++i) sum += static_cast<Reason>(i) == Reason::Accepted ? 0 : count[i];
  return sum;
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
