#include "pad_test.hpp"

#include <algorithm>
#include <cmath>

namespace downrange::integrity {
namespace {

constexpr std::size_t least = 5;
constexpr std::size_t most = 60;
constexpr double at_rest_m_s = 5;
constexpr double sigmas = 3;
/// Where on the vehicle a receiver's antenna is, and how well the pad is known, 1-sigma.
constexpr double survey_m = 2;

/// What a sensor's two samples are apart, beyond their noise.
double moved_m(const Witness& sensor, const Sample& from, const Sample& to) {
  const double range = to.z[0];
  const Vec<3> change = wrapped(sensor, to.z - from.z);
  const PolarSigma& sigma = sensor.model.sigma;
  const Vec<3> beyond = (change.cwiseAbs() - sigmas * Vec<3>(sigma.range_m, sigma.azimuth_rad, sigma.elevation_rad))
                            .cwiseMax(Vec<3>::Zero());
  return Vec<3>(beyond[0], range * std::cos(to.z[2]) * beyond[1], range * beyond[2]).norm();
}

}  // namespace

PadTest::PadTest(const Site& pad) : pad_(pad) {
  surveyor_.kind = WitnessKind::Receiver;
  surveyor_.slow_sigma_m = survey_m;
}

TestResult PadTest::operator()(const Witness& witness, const Threshold& threshold) const {
  const Ring<Sample>& all = witness.series.samples();
  const std::size_t n = std::min(all.size(), most);
  // A receiver that says itself that it stands needs no second fix.
  if (n < (witness.is_receiver() && n > 0 && all.newest().velocity_valid ? 1 : least)) return {};
  const Sample& newest = all.newest();
  const Sample& oldest = all.newest(n - 1);
  const double span = (newest.epoch - oldest.epoch).seconds();

  if (!witness.is_receiver()) {
    if (moved_m(witness, oldest, newest) > at_rest_m_s * span) return {};
    Sample standing;
    standing.epoch = newest.epoch;
    standing.z = pad_.ecef().m;
    standing.motion.head<3>() = pad_.ecef().m;
    return coarse_test(surveyor_, standing, witness, newest, threshold);
  }
  Vec<3> mean = Vec<3>::Zero();
  for (std::size_t i = 0; i < n; ++i) mean += all.newest(i).z / static_cast<double>(n);
  const double noise_m = sigmas * std::hypot(newest.sigma_horizontal_m, newest.sigma_vertical_m);
  const bool moves = newest.velocity_valid ? newest.motion.segment<3>(3).norm() > at_rest_m_s
                                           : (newest.z - oldest.z).norm() > at_rest_m_s * span + noise_m;
  if (moves) return {};
  const Mat<3, 3> S = fix_noise(mean, newest.sigma_horizontal_m, newest.sigma_vertical_m) / static_cast<double>(n) +
                      (witness.slow_sigma_m * witness.slow_sigma_m + survey_m * survey_m) * Mat<3, 3>::Identity();
  const Vec<3> off = mean - pad_.ecef().m;
  TestResult result;
  result.ratio = threshold.ratio(off, S, true, &result.whitened);
  result.apart_m = off.norm();
  return result;
}

}  // namespace downrange::integrity
