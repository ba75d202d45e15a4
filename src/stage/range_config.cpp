#include <downrange/stage/range_config.hpp>

namespace downrange {
namespace {

double size_of(const BiasSizes& sizes, BiasTerm term) {
  switch (term) {
    case BiasTerm::OffsetSouth:
    case BiasTerm::OffsetEast:
    case BiasTerm::OffsetZenith:
      return sizes.sez_offset_m;
    case BiasTerm::ScaleSouth:
    case BiasTerm::ScaleEast:
    case BiasTerm::ScaleZenith:
      return sizes.sez_scale;
    case BiasTerm::OffsetRange:
      return sizes.range_m;
    case BiasTerm::OffsetAzimuth:
    case BiasTerm::OffsetElevation:
      return sizes.angle_rad;
    case BiasTerm::ScaleRange:
      return sizes.range_scale;
    case BiasTerm::ScaleAzimuth:
    case BiasTerm::ScaleElevation:
      return sizes.angle_scale;
    case BiasTerm::TimeTag:
      return sizes.time_tag_s;
  }
  return 0;
}

void calibrate(BiasModel& model, const BiasCalibration& calibration) {
  const std::vector<BiasTerm>& calibrated = calibration.terms;
  for (std::size_t i = 0; i < calibrated.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    model.prior_mean[static_cast<Eigen::Index>(calibrated[i])] = calibration.mean[row];
    for (std::size_t j = 0; j < calibrated.size(); ++j)
      model.prior_cov(static_cast<Eigen::Index>(calibrated[i]), static_cast<Eigen::Index>(calibrated[j])) =
          calibration.cov(row, static_cast<Eigen::Index>(j));
  }
}

}  // namespace

std::vector<BiasBlock> default_bias_blocks() { return {BiasBlock::Polar, BiasBlock::SezOffset, BiasBlock::Time}; }

BiasModel bias_model_of(const BiasConfig& config) {
  BiasModel model = bias_model(config.blocks);
  for (const BiasTerm term : model.terms) {
    const auto i = static_cast<Eigen::Index>(term);
    const double prior = size_of(config.prior, term);
    model.prior_cov(i, i) = prior * prior;
    model.drift[i] = size_of(config.drift, term);
  }
  calibrate(model, config.calibration);
  return model;
}

PolarSigma measured_sigma(const RadarConfig& radar) {
  return {.range_m = radar.measures.range ? radar.sigma.range_m : 0,
          .azimuth_rad = radar.measures.angles ? radar.sigma.azimuth_rad : 0,
          .elevation_rad = radar.measures.angles ? radar.sigma.elevation_rad : 0};
}

BiasModel bias_model_of(const RadarConfig& radar) {
  BiasModel model = bias_model_of(radar.bias);
  std::erase_if(model.terms, [&](BiasTerm term) {
    const bool of_range = term == BiasTerm::OffsetRange || term == BiasTerm::ScaleRange;
    const bool of_angles = !of_range && term >= BiasTerm::OffsetAzimuth && term <= BiasTerm::ScaleElevation;
    return (of_range && !radar.measures.range) || (of_angles && !radar.measures.angles);
  });
  return model;
}

BiasModel bias_model_of(const AngleSensorConfig& config) {
  BiasModel model;
  model.terms = {BiasTerm::OffsetAzimuth, BiasTerm::OffsetElevation};
  for (const BiasTerm term : model.terms) {
    const auto i = static_cast<Eigen::Index>(term);
    model.prior_cov(i, i) = config.bias_prior_rad * config.bias_prior_rad;
    model.drift[i] = config.bias_drift_rad_sqrt_s;
  }
  calibrate(model, config.calibration);
  return model;
}

}  // namespace downrange
