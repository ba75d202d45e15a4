#include <Eigen/Eigenvalues>
#include <cmath>
#include <downrange/geo/polar.hpp>
#include <numbers>

namespace downrange {
namespace {

constexpr double two_pi = 2 * std::numbers::pi;
/// Horizontal distance is never taken below this part of the range: the zenith gives large numbers, not infinities.
constexpr double zenith_floor = 1e-6;

/// Products of sine and cosine of one angle, as their averages over the noise (`mean`) and how far the product of the
/// averaged sine and cosine stands above that (`excess`). Differences are formed analytically: subtracting the products
/// themselves would lose ten digits at 1000 km.
struct AngleMoments {
  struct Moment {
    double mean;
    double excess;
  };
  Moment sin2, cos2, sincos;
  double single;  ///< factor on a single sine or cosine
};

/// With C = cos 2x: mean sin^2 = (1 - C e^{m+2h})/2, product e^h (1 - C e^m)/2, excess = expm1(h) (1 + C e^{h+m})/2.
/// (h, m) is (s^2, 0) for the unbiased, (-s^2, 0) for the raw, (-s^2, -2 s^2) for the averaged additive conversion.
AngleMoments moments(double angle_rad, double h, double m) {
  const double C = std::cos(2 * angle_rad);
  const double S = std::sin(2 * angle_rad);
  const double inner = std::exp(h + m);
  const double outer = std::exp(m + 2 * h);
  const double step = std::expm1(h);
  return {.sin2 = {(1 - C * outer) / 2, step * (1 + C * inner) / 2},
          .cos2 = {(1 + C * outer) / 2, step * (1 - C * inner) / 2},
          .sincos = {S * outer / 2, -step * S * inner / 2},
          .single = std::exp(h / 2 + m / 4)};
}

/// range2 * (excess of the product) + var_range * (product of the means), in (east, north, up).
Eigen::Matrix3d conversion_covariance(const Polar& q, const AngleMoments& az, const AngleMoments& el, double range2,
                                      double var_range) {
  const auto entry = [&](const AngleMoments::Moment& a, const AngleMoments::Moment& b) {
    return range2 * (a.mean * b.excess + a.excess * b.mean + a.excess * b.excess) + var_range * a.mean * b.mean;
  };
  const double with_up = az.single * (range2 * el.sincos.excess + var_range * el.sincos.mean);
  Eigen::Matrix3d R;
  R(0, 0) = entry(az.sin2, el.cos2);
  R(1, 1) = entry(az.cos2, el.cos2);
  R(2, 2) = range2 * el.sin2.excess + var_range * el.sin2.mean;
  R(0, 1) = R(1, 0) = entry(az.sincos, el.cos2);
  R(0, 2) = R(2, 0) = std::sin(q.azimuth_rad) * with_up;
  R(1, 2) = R(2, 1) = std::cos(q.azimuth_rad) * with_up;
  return R;
}

}  // namespace

double wrap_pi(double angle_rad) {
  const double wrapped = std::remainder(angle_rad, two_pi);
  return wrapped <= -std::numbers::pi ? std::numbers::pi : wrapped;
}

double wrap_two_pi(double angle_rad) {
  const double wrapped = std::remainder(angle_rad, two_pi);
  // A tiny negative angle plus two pi rounds to two pi itself, which is outside the half-open interval.
  const double positive = wrapped < 0 ? wrapped + two_pi : wrapped;
  return positive >= two_pi ? 0.0 : positive + 0.0;
}

Polar polar_from_enu(const Displacement<Enu>& d) {
  const double horizontal = std::hypot(d.m.x(), d.m.y());
  return {.range_m = std::hypot(horizontal, d.m.z()),
          .azimuth_rad = horizontal > 0 ? wrap_two_pi(std::atan2(d.m.x(), d.m.y())) : 0.0,
          .elevation_rad = std::atan2(d.m.z(), horizontal)};
}

Displacement<Enu> enu_from_polar(const Polar& q) {
  const double horizontal = q.range_m * std::cos(q.elevation_rad);
  return {{horizontal * std::sin(q.azimuth_rad), horizontal * std::cos(q.azimuth_rad),
           q.range_m * std::sin(q.elevation_rad)}};
}

Eigen::Matrix3d d_polar_d_enu(const Displacement<Enu>& d) {
  const double range = d.m.norm();
  const double horizontal = std::max(std::hypot(d.m.x(), d.m.y()), zenith_floor * range);
  const double range2 = range * range;
  const double horizontal2 = horizontal * horizontal;
  Eigen::Matrix3d J;
  J.row(0) = d.m.transpose() / range;
  J.row(1) << d.m.y() / horizontal2, -d.m.x() / horizontal2, 0;
  J.row(2) << -d.m.x() * d.m.z() / (range2 * horizontal), -d.m.y() * d.m.z() / (range2 * horizontal),
      horizontal / range2;
  return J;
}

Eigen::Matrix3d d_enu_d_polar(const Polar& q) {
  const double sin_az = std::sin(q.azimuth_rad);
  const double cos_az = std::cos(q.azimuth_rad);
  const double sin_el = std::sin(q.elevation_rad);
  const double cos_el = std::cos(q.elevation_rad);
  const double rho = q.range_m;
  Eigen::Matrix3d J;
  J << sin_az * cos_el, rho * cos_az * cos_el, -rho * sin_az * sin_el,  //
      cos_az * cos_el, -rho * sin_az * cos_el, -rho * cos_az * sin_el,  //
      sin_el, 0, rho * cos_el;
  return J;
}

ConvertedMeasurement raw_conversion_statistics(const Polar& truth, const PolarSigma& sigma) {
  const double var_az = sigma.azimuth_rad * sigma.azimuth_rad;
  const double var_el = sigma.elevation_rad * sigma.elevation_rad;
  const double lambda_el = std::exp(-var_el / 2);
  const double lambda = std::exp(-var_az / 2) * lambda_el;
  const double range2 = truth.range_m * truth.range_m;
  return {.z = {enu_from_polar(truth).m.cwiseProduct(Eigen::Vector3d(lambda, lambda, lambda_el))},
          .R = conversion_covariance(truth, moments(truth.azimuth_rad, -var_az, 0),
                                     moments(truth.elevation_rad, -var_el, 0), -range2, sigma.range_m * sigma.range_m)};
}

ConvertedMeasurement convert_additive(const Polar& q, const PolarSigma& sigma) {
  const double var_range = sigma.range_m * sigma.range_m;
  const double var_az = sigma.azimuth_rad * sigma.azimuth_rad;
  const double var_el = sigma.elevation_rad * sigma.elevation_rad;
  const double lambda_el = std::exp(-var_el / 2);
  const double lambda = std::exp(-var_az / 2) * lambda_el;
  const double horizontal = 1 - lambda * lambda + lambda;
  const double vertical = 1 - lambda_el * lambda_el + lambda_el;
  return {.z = {enu_from_polar(q).m.cwiseProduct(Eigen::Vector3d(horizontal, horizontal, vertical))},
          .R = conversion_covariance(q, moments(q.azimuth_rad, -var_az, -2 * var_az),
                                     moments(q.elevation_rad, -var_el, -2 * var_el),
                                     -(q.range_m * q.range_m + var_range), var_range)};
}

ConvertedMeasurement convert_unbiased(const Polar& q, const PolarSigma& sigma) {
  const double var_az = sigma.azimuth_rad * sigma.azimuth_rad;
  const double var_el = sigma.elevation_rad * sigma.elevation_rad;
  const double lambda_el = std::exp(-var_el / 2);
  const double lambda = std::exp(-var_az / 2) * lambda_el;
  const double range2 = q.range_m * q.range_m;
  ConvertedMeasurement c{
      .z = {enu_from_polar(q).m.cwiseQuotient(Eigen::Vector3d(lambda, lambda, lambda_el))},
      .R = conversion_covariance(q, moments(q.azimuth_rad, var_az, 0), moments(q.elevation_rad, var_el, 0), range2,
                                 sigma.range_m * sigma.range_m)};
  // E[R] is right everywhere, but a single R loses its smallest eigenvalue to fourth-order terms at the zenith.
  if (std::cos(q.elevation_rad) < 100 * (sigma.azimuth_rad + sigma.elevation_rad)) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(c.R);
    const double floor = range2 * var_el * (var_az + var_el);
    const Eigen::Vector3d lifted = eigen.eigenvalues().cwiseMax(floor);
    c.R = eigen.eigenvectors() * lifted.asDiagonal() * eigen.eigenvectors().transpose();
  }
  return c;
}

}  // namespace downrange
