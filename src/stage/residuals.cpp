#include "residuals.hpp"

#include <algorithm>
#include <cmath>
#include <downrange/est/model/plot_model.hpp>

namespace downrange {
namespace {

/// A track that is older says nothing of a source.
constexpr Duration oldest_track = milliseconds(5000);

}  // namespace

Residuals::Residuals(std::size_t sources, std::vector<RadarModel> radars)
    : radars_(std::move(radars)), accounts_(sources) {}

void Residuals::note(SourceId source, int target, const Observation& o, const Method& method) {
  Account& account = accounts_[static_cast<std::size_t>(source)];
  const Duration since = o.epoch - account.newest;
  if (account.samples > 0 && since < spacing) return;
  const std::optional<TrackEstimate> track = method.fused(target, o.epoch);
  if (!track || o.epoch - track->data_epoch > oldest_track || !track->mean.head(track->size).allFinite()) return;
  Squares s;
  if (const auto* fix = std::get_if<Fix>(&o.measured)) {
    s = squares(method.account(source).noise.believed(*fix), *track);
  } else {
    s = squares(radars_[static_cast<std::size_t>(source)], plot_of(o.measured), *track, method.bias(source),
                method.account(source).noise);
  }
  ++account.samples;
  account.newest = o.epoch;
  // The plain mean of the first samples, then one that forgets.
  const double forgetting = since.seconds() / (since.seconds() + memory.seconds());
  const double weight = std::max(1.0 / account.samples, std::min(forgetting, 1.0));
  const auto add = [weight](double& mean, double value) { mean += weight * (value - mean); };
  add(account.mean.m2, s.m2);
  add(account.mean.expected_m2, s.expected_m2);
  add(account.mean.rad2, s.rad2);
  add(account.mean.expected_rad2, s.expected_rad2);
}

Residuals::Squares Residuals::squares(const Fix& fix, const TrackEstimate& track) const {
  const double noise =
      2 * fix.sigma_horizontal_m * fix.sigma_horizontal_m + fix.sigma_vertical_m * fix.sigma_vertical_m;
  return {.m2 = (fix.position.m - track.mean.head<3>()).squaredNorm() / 3,
          .expected_m2 = (track.cov.topLeftCorner<3, 3>().trace() + noise) / 3};
}

Residuals::Squares Residuals::squares(const RadarModel& radar, const Plot& plot, const TrackEstimate& track,
                                      const BiasEstimate& bias, const NoiseScale& noise) const {
  Vec<9> motion = Vec<9>::Zero();
  motion.head(track.size) = track.mean.head(track.size);
  Vec<bias_term_count> value = Vec<bias_term_count>::Zero();
  for (int i = 0; i < bias.terms; ++i) value[static_cast<int>(bias.term[static_cast<std::size_t>(i)])] = bias.value[i];
  const PredictedPlot predicted = predict_plot(radar, motion, value);
  const Vec<3> nu = plot_residual(plot.measured, predicted.q);
  Vec<3> variance = plot_variance(radar, plot).cwiseProduct(noise.factors<3>(0));
  Mat<9, 9> P = Mat<9, 9>::Zero();
  P.topLeftCorner(track.size, track.size) = track.cov.topLeftCorner(track.size, track.size);
  variance += (predicted.d_motion * P * predicted.d_motion.transpose()).diagonal();
  for (int i = 0; i < bias.terms; ++i) {
    const auto row = predicted.d_bias.col(static_cast<int>(bias.term[static_cast<std::size_t>(i)]));
    for (int k = 0; k < bias.terms; ++k) {
      const auto column = predicted.d_bias.col(static_cast<int>(bias.term[static_cast<std::size_t>(k)]));
      variance += bias.cov(i, k) * row.cwiseProduct(column);
    }
  }
  Squares s;
  if (plot.angles_valid) {
    const double on_sky = std::cos(plot.measured.elevation_rad) * std::cos(plot.measured.elevation_rad);
    s.rad2 = (nu[1] * nu[1] * on_sky + nu[2] * nu[2]) / 2;
    s.expected_rad2 = (variance[1] * on_sky + variance[2]) / 2;
  }
  if (plot.range_valid) {
    s.m2 = nu[0] * nu[0];
    s.expected_m2 = variance[0];
  }
  return s;
}

ResidualSize Residuals::of(SourceId source) const {
  const Squares& mean = accounts_[static_cast<std::size_t>(source)].mean;
  return {.m = std::sqrt(mean.m2),
          .expected_m = std::sqrt(mean.expected_m2),
          .rad = std::sqrt(mean.rad2),
          .expected_rad = std::sqrt(mean.expected_rad2)};
}

}  // namespace downrange
