#pragma once
/// Calibrations: what a flight found of its sensors' biases, as a TOML file for the next one.

#include <downrange/stage/result.hpp>
#include <downrange/stage/source_table.hpp>
#include <optional>
#include <span>
#include <string>

#include "config/schema.hpp"

namespace downrange::config {

/// Where a calibration comes from.
struct CalibrationOrigin {
  std::string archive;        ///< file name of the flight's archive
  std::string configuration;  ///< hash of the configuration it was flown with
};

struct CalibratedSensor {
  SourceKind kind = SourceKind::Radar;  ///< its table in the file
  SensorBias bias;
  SigmaRatios sigma_ratio{};  ///< what was learnt of its noise
};

/// The file's text: each sensor's terms with value, 1-sigma and state, and their correlation; its noise, for people, as
/// a remark. A term that the flight did not show keeps the sigma it had, so nothing is pretended. The biases are of one
/// method and of different sensors, with positive definite covariances.
[[nodiscard]] std::string calibration_text(const CalibrationOrigin& origin, std::span<const CalibratedSensor> sensors);

/// One sensor's table of such a file. Problems are reported; nothing when there are any.
[[nodiscard]] std::optional<BiasCalibration> read_calibration(const toml::table& table, const std::string& path,
                                                              const Report& report);

}  // namespace downrange::config
