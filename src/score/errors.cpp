#include "score/errors.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <boost/math/distributions/beta.hpp>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/est/model/bias_terms.hpp>
#include <numbers>
#include <span>

#include "stage/slave/travel.hpp"

namespace downrange::score {
namespace {

Eigen::Vector3d direction(double azimuth_rad, double elevation_rad) {
  return enu_from_polar({1.0, azimuth_rad, elevation_rad}).m;
}

}  // namespace

Spread spread_of(std::vector<double> errors) {
  if (errors.empty()) return {};
  Squares squares;
  for (const double error : errors) squares.add(error * error);
  const double worst = *std::ranges::max_element(errors);
  const auto rank = static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(errors.size()))) - 1;
  std::ranges::nth_element(errors, errors.begin() + static_cast<std::ptrdiff_t>(rank));
  return {errors.size(), squares.rms(), errors[rank], worst};
}

bool inside_95(double square, int dof) {
  InsideShare share;
  share.add(square, dof);
  return share.inside == 1;
}

Band honest_band(double share, double independent) {
  namespace bm = boost::math;
  constexpr double tail = 0.025;
  Band band{.low = 0, .high = 1};
  if (!(independent >= 1)) return band;
  const double inside = std::clamp(share, 0.0, 1.0) * independent;
  const double outside = independent - inside;
  if (inside > 0) band.low = bm::quantile(bm::beta_distribution<>(inside, outside + 1), tail);
  if (outside > 0) band.high = bm::quantile(bm::complement(bm::beta_distribution<>(inside + 1, outside), tail));
  return band;
}

Eigen::MatrixXd covariance_of(const Trajectory& trajectory) {
  const int n = trajectory.state_size;
  Eigen::MatrixXd P(n, n);
  std::size_t k = 0;
  for (int row = 0; row < n; ++row)
    for (int column = row; column < n; ++column) P(row, column) = P(column, row) = trajectory.covariance[k++];
  return P;
}

Gaussian<3> position_at(const Trajectory& trajectory, Time epoch) {
  const double dt = (epoch - trajectory.epoch).seconds();
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(3, trajectory.state_size);
  A.leftCols<3>().diagonal().setOnes();
  A.middleCols<3>(3).diagonal().setConstant(dt);
  if (trajectory.state_size == 9) A.rightCols<3>().diagonal().setConstant(dt * dt / 2);
  const auto x = Eigen::Map<const Eigen::VectorXd>(trajectory.state.data(), trajectory.state_size);
  return {A * x, A * covariance_of(trajectory) * A.transpose()};
}

Eigen::Vector3d plot_error(const Polar& measured, const Polar& truth) {
  return {measured.range_m - truth.range_m,
          wrap_pi(measured.azimuth_rad - truth.azimuth_rad) * std::cos(truth.elevation_rad),
          measured.elevation_rad - truth.elevation_rad};
}

double time_tag_of(const SensorBias& bias) {
  const auto end = bias.term.begin() + bias.terms;
  const auto found = std::find(bias.term.begin(), end, BiasTerm::TimeTag);
  return found == end ? 0 : bias.value[static_cast<std::size_t>(found - bias.term.begin())];
}

Polar corrected(const Polar& measured, const SensorBias& bias, const RefractionTable* air) {
  const auto terms = static_cast<std::size_t>(bias.terms);
  Polar plot = compensate(measured, std::span(bias.term).first(terms), std::span(bias.value).first(terms));
  if (air == nullptr) return plot;
  const Refraction bent = air->at_measured(plot.range_m, plot.elevation_rad);
  plot.range_m -= bent.range_m;
  plot.elevation_rad -= bent.elevation_rad;
  return plot;
}

Polar pointing_at(const Site& site, const RefractionTable* air, const Position<Ecef>& target) {
  Polar look = polar_from_enu(site.enu_of(target));
  if (air != nullptr) look.elevation_rad += air->at_true(look.range_m, look.elevation_rad).refraction.elevation_rad;
  return look;
}

std::map<Name, RefractionTable> air_of_antennas(const RangeConfig& range) {
  std::map<Name, RefractionTable> air;
  for (const AntennaConfig& antenna : range.antennas) {
    if (antenna.refractivity > 0)
      air.emplace(antenna.id, RefractionTable(atmosphere_over(antenna.site.geodetic(), antenna.refractivity)));
  }
  return air;
}

bool can_point_at(const AntennaConfig& antenna, const Polar& look) {
  constexpr double turn = 2 * std::numbers::pi;
  if (look.elevation_rad < Horizon(antenna.elevation_min_rad, antenna.horizon).at(look.azimuth_rad)) return false;
  const auto in_travel = [&](double azimuth_rad) {
    const double lowest = azimuth_rad + turn * std::ceil((antenna.azimuth_min_rad - azimuth_rad) / turn);
    return lowest <= antenna.azimuth_max_rad;
  };
  const bool upright = look.elevation_rad <= antenna.elevation_max_rad && in_travel(look.azimuth_rad);
  const bool over = std::numbers::pi - look.elevation_rad <= antenna.elevation_max_rad;
  return upright || (over && in_travel(look.azimuth_rad + std::numbers::pi));
}

double pointing_error(const SlavingCommand& command, const Polar& look) {
  const Eigen::Vector3d commanded =
      direction(command.azimuth_rad - command.mount_azimuth_rad, command.elevation_rad - command.mount_elevation_rad);
  const Eigen::Vector3d exact = direction(look.azimuth_rad, look.elevation_rad);
  return std::atan2(commanded.cross(exact).norm(), commanded.dot(exact));
}

int axes_within_2_sigma(const SlavingCommand& command, const Polar& look) {
  // Over the zenith the azimuth is that of the back.
  const bool over = command.elevation_rad > std::numbers::pi / 2;
  const double azimuth = std::abs(
      wrap_pi(command.azimuth_rad - command.mount_azimuth_rad - look.azimuth_rad + (over ? std::numbers::pi : 0)));
  const double up = command.elevation_rad - command.mount_elevation_rad;
  const double elevation = std::abs((over ? std::numbers::pi - up : up) - look.elevation_rad);
  return (azimuth <= 2 * command.sigma_azimuth_rad ? 1 : 0) + (elevation <= 2 * command.sigma_elevation_rad ? 1 : 0);
}

}  // namespace downrange::score
