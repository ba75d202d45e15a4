#include "witness.hpp"

#include <cmath>
#include <downrange/est/filter/hypothesis.hpp>
#include <memory>

namespace downrange::integrity {
namespace {

constexpr Duration between_known = milliseconds(1000);
/// A filter's covariance of a bias is as good as its models: its sigmas count double.
constexpr double distrust = 4;

KnownBias prior_of(const BiasModel& model) {
  KnownBias prior;
  for (const BiasTerm a : model.terms) {
    const auto i = static_cast<Eigen::Index>(a);
    prior.mean[i] = model.prior_mean[i];
    for (const BiasTerm b : model.terms)
      prior.cov(i, static_cast<Eigen::Index>(b)) = model.prior_cov(i, static_cast<Eigen::Index>(b));
  }
  return prior;
}

/// `sensor`: a radar or an angles-only tracker.
template <class Sensor>
Witness ground_witness(const Sensor& sensor, int id, const PolarSigma& sigma, bool tells_range,
                       const NoGpsRegime& without_gps) {
  Witness w;
  w.kind = tells_range ? WitnessKind::Radar : WitnessKind::Angles;
  w.sources = set_of(id);
  w.heard = true;
  w.model.site = sensor.site;
  w.model.sigma = sigma;
  w.model.azimuth_sigma_on_sky = sensor.azimuth_sigma_on_sky;
  w.model.bias = bias_model_of(sensor);
  w.wander_beside_gps = sensor.wander;
  w.model.wander = without_gps.enabled ? wander_without_gps(sensor.wander, without_gps) : sensor.wander;
  if (sensor.refractivity != 0)
    w.model.refraction =
        std::make_shared<RefractionTable>(atmosphere_over(sensor.site.geodetic(), sensor.refractivity));
  w.slow_factor = sensor.angle_inflation - 1;
  w.slow_tau_s = w.model.wander.tau_s;
  w.prior = prior_of(w.model.bias);
  w.series = SampleSeries(sensor.rate_hz, false);
  return w;
}

}  // namespace

const KnownBias& Witness::known_at(Time at) const {
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (known.newest(i).epoch <= at) return known.newest(i);
  }
  return prior;
}

void Witness::note_bias(Time now, const BiasEstimate& bias) {
  if (!known.empty() && now - known.newest().epoch < between_known) return;
  KnownBias entry = prior;
  if (bias.terms > 0 && bias.reference == BiasReference::Gps) {
    entry.mean.setZero();
    entry.cov.setZero();
    for (int a = 0; a < bias.terms; ++a) {
      const auto i = static_cast<Eigen::Index>(bias.term[static_cast<std::size_t>(a)]);
      entry.mean[i] = bias.value[a];
      for (int b = 0; b < bias.terms; ++b)
        entry.cov(i, static_cast<Eigen::Index>(bias.term[static_cast<std::size_t>(b)])) = distrust * bias.cov(a, b);
    }
  }
  entry.epoch = now;
  known.push(entry);
}

void Witness::receiver_is_heard() {
  if (is_receiver()) return;
  model.wander = wander_beside_gps;
  slow_tau_s = model.wander.tau_s;
}

std::vector<Witness> witnesses_of(const RangeConfig& config, int receivers) {
  const NoGpsRegime& without_gps = config.align.gps.no_gps;
  std::vector<Witness> all;
  for (const RadarConfig& radar : config.radars)
    all.push_back(ground_witness(radar, static_cast<int>(all.size()), radar.sigma, radar.measures.range, without_gps));
  for (const AngleSensorConfig& sensor : config.angle_sensors)
    all.push_back(ground_witness(sensor, static_cast<int>(all.size()),
                                 {.azimuth_rad = sensor.sigma_azimuth_rad, .elevation_rad = sensor.sigma_elevation_rad},
                                 false, without_gps));
  for (int i = 0; i < receivers; ++i) {
    Witness w;
    w.kind = WitnessKind::Receiver;
    w.slow_sigma_m = config.align.gps.error.enabled ? config.align.gps.error.sigma_m : 0;
    w.slow_tau_s = config.align.gps.error.tau_s;
    w.series = SampleSeries(1, true);
    all.push_back(w);
  }
  return all;
}

}  // namespace downrange::integrity
