#include "slave.hpp"

#include <algorithm>
#include <cmath>
#include <downrange/geo/polar.hpp>
#include <numbers>
#include <utility>

#include "indices.hpp"
#include "stage/integrity/bound.hpp"

namespace downrange {
namespace {

/// After a longer pause an antenna is where it is: nothing to go over from.
constexpr Duration longest_blended_gap = milliseconds(1000);

}  // namespace

TravelAzimuth unwrap_into_travel(double wrapped_rad, std::optional<double> previous_rad, double min_rad,
                                 double max_rad) {
  constexpr double turn = 2 * std::numbers::pi;
  const double reference = previous_rad.value_or((min_rad + max_rad) / 2);
  const double nearest = wrapped_rad + turn * std::round((reference - wrapped_rad) / turn);
  if (nearest >= min_rad && nearest <= max_rad) return {nearest, LimitNone};
  const double other = nearest < min_rad ? nearest + turn : nearest - turn;
  if (other >= min_rad && other <= max_rad) return {other, previous_rad ? LimitUnwrapped : LimitNone};
  // No turn lies inside: hold the end that is nearer to the target around the circle.
  const double to_min = std::abs(wrap_pi(wrapped_rad - min_rad));
  const double to_max = std::abs(wrap_pi(wrapped_rad - max_rad));
  return {to_min <= to_max ? min_rad : max_rad, LimitAzimuth};
}

Slave::Slave(const RangeConfig& config) : config_(config) {
  for (const AntennaConfig& antenna : config.antennas) {
    const int target = antenna.target.empty() ? 0 : index_of(config.targets, antenna.target);
    antennas_.push_back({.config = antenna, .target = target, .previous_azimuth_rad = std::nullopt});
  }
}

void Slave::tick(Time tick, std::span<const Followed> followed, ResultSink& sink) {
  for (Antenna& antenna : antennas_) {
    const Followed& of_target = followed[static_cast<std::size_t>(antenna.target)];
    if (tick - of_target.newest > config_.slave.coast) continue;
    const Time apply_at = tick + antenna.config.link_delay + antenna.config.lead;
    const auto chosen = choose(of_target, tick, apply_at);
    if (!chosen) continue;
    if (const auto c = command(antenna, of_target, *chosen, tick, apply_at)) sink.emit(*c);
  }
}

std::optional<Slave::Chosen> Slave::choose(const Followed& followed, Time tick, Time apply_at) const {
  const Method& method = *followed.method;
  const int target = followed.target;
  const auto sigma = [](const TrackEstimate& e) { return std::sqrt(e.cov.topLeftCorner<3, 3>().trace()); };
  if (const auto fused = method.fused(target, apply_at)) {
    const Duration age = tick - fused->data_epoch;
    const bool usable = age <= config_.slave.coast && sigma(*fused) <= config_.slave.coast_sigma_max_m;
    if (usable && fused->mean.allFinite())
      return Chosen{*fused, age <= config_.slave.stale ? SlavingSource::Fused : SlavingSource::Coasting};
  }
  if (const auto gps = method.gps_track(target, apply_at)) {
    const bool usable = tick - gps->data_epoch <= config_.slave.coast && sigma(*gps) <= config_.slave.coast_sigma_max_m;
    if (usable && gps->mean.allFinite()) return Chosen{*gps, SlavingSource::Gps};
  }
  return std::nullopt;
}

Slave::BlendRates Slave::blend(Antenna& antenna, const Followed& followed, const Chosen& chosen, Time tick,
                               const Polar& q, const Eigen::Vector3d& rates) const {
  const bool gps = chosen.source == SlavingSource::Gps;
  const std::optional<Previous> last =
      std::exchange(antenna.previous, Previous{.tick = tick, .revision = followed.revision, .gps = gps});
  BlendRates of_blend;
  if (!last || tick - last->tick > longest_blended_gap) {
    antenna.blend_azimuth_rad = antenna.blend_elevation_rad = 0;
  } else {
    const double dt = (tick - last->tick).seconds();
    if (last->revision != followed.revision || last->gps != gps) {
      antenna.blend_azimuth_rad = wrap_pi(last->azimuth_rad + dt * last->azimuth_rate_rad_s - q.azimuth_rad);
      antenna.blend_elevation_rad = last->elevation_rad + dt * last->elevation_rate_rad_s - q.elevation_rad;
    }
    const double away = std::hypot(antenna.blend_azimuth_rad * std::cos(q.elevation_rad), antenna.blend_elevation_rad);
    const double step = config_.slave.blend_rate_rad_s * dt;
    const double shrink = away > step ? step / away : 1;
    of_blend = {.azimuth_rad_s = -shrink * antenna.blend_azimuth_rad / dt,
                .elevation_rad_s = -shrink * antenna.blend_elevation_rad / dt};
    antenna.blend_azimuth_rad *= 1 - shrink;
    antenna.blend_elevation_rad *= 1 - shrink;
  }
  antenna.previous->azimuth_rad = q.azimuth_rad + antenna.blend_azimuth_rad;
  antenna.previous->elevation_rad = q.elevation_rad + antenna.blend_elevation_rad;
  antenna.previous->azimuth_rate_rad_s = rates[1];
  antenna.previous->elevation_rate_rad_s = rates[2];
  return of_blend;
}

std::optional<SlavingCommand> Slave::command(Antenna& antenna, const Followed& followed, const Chosen& chosen,
                                             Time tick, Time apply_at) const {
  const AntennaConfig& a = antenna.config;
  const Eigen::Matrix3d& R_enu_ecef = a.site.R_enu_ecef().R;
  // Parallax is geometry: the look angle from this site to the predicted position.
  const Displacement<Enu> look = a.site.enu_of({chosen.estimate.mean.head<3>()});
  if (!(look.m.norm() > 1.0)) return std::nullopt;  // the target is at the antenna: there is no direction
  const Polar q = polar_from_enu(look);
  const Eigen::Matrix3d J = d_polar_d_enu(look);
  const Eigen::Vector3d rates = J * (R_enu_ecef * chosen.estimate.mean.segment<3>(3));
  const Eigen::Matrix3d J_ecef = J * R_enu_ecef;
  const Eigen::Matrix3d cov = J_ecef * chosen.estimate.cov.topLeftCorner<3, 3>() * J_ecef.transpose();
  const BlendRates of_blend = blend(antenna, followed, chosen, tick, q, rates);
  const Polar pointed{q.range_m, q.azimuth_rad + antenna.blend_azimuth_rad,
                      q.elevation_rad + antenna.blend_elevation_rad};

  SlavingCommand c;
  c.antenna = a.id;
  c.target = config_.targets[static_cast<std::size_t>(antenna.target)].id;
  c.tick = tick;
  c.apply_at = apply_at;
  c.valid_until = apply_at + config_.slave.validity;
  c.data_epoch = chosen.estimate.data_epoch;
  c.age_s = (apply_at - c.data_epoch).seconds();
  c.source = chosen.source;
  c.range_m = q.range_m;
  c.range_rate_m_s = rates[0];
  c.azimuth_rate_rad_s = rates[1] + of_blend.azimuth_rad_s;
  c.elevation_rate_rad_s = rates[2] + of_blend.elevation_rad_s;
  c.sigma_azimuth_rad = std::min(std::sqrt(cov(1, 1)), std::numbers::pi);
  c.sigma_elevation_rad = std::min(std::sqrt(cov(2, 2)), std::numbers::pi);

  const TravelAzimuth azimuth =
      unwrap_into_travel(pointed.azimuth_rad, antenna.previous_azimuth_rad, a.azimuth_min_rad, a.azimuth_max_rad);
  c.azimuth_rad = azimuth.azimuth_rad;
  c.elevation_rad = std::clamp(pointed.elevation_rad, a.elevation_min_rad, a.elevation_max_rad);
  const bool elevation_held = c.elevation_rad != pointed.elevation_rad;
  const bool too_fast =
      std::abs(rates[1]) > a.azimuth_rate_max_rad_s || std::abs(rates[2]) > a.elevation_rate_max_rad_s;
  c.limits = static_cast<std::uint8_t>(azimuth.limits | (elevation_held ? LimitElevation : LimitNone) |
                                       (too_fast ? LimitRate : LimitNone));
  // A held axis stands still: an antenna that feeds the rate forward must not run into its stop.
  if (azimuth.limits & LimitAzimuth) c.azimuth_rate_rad_s = 0;
  if (elevation_held) c.elevation_rate_rad_s = 0;
  c.chain = followed.chain;
  c.bound_valid = followed.bounded;
  if (followed.bounded) {
    const Eigen::Vector3d commanded = R_enu_ecef.transpose() * enu_from_polar(pointed).m.normalized();
    c.bound_rad = bound_rad(followed.alternatives, commanded, R_enu_ecef.transpose() * look.m);
  }
  const bool finite = std::isfinite(c.azimuth_rad) && std::isfinite(c.elevation_rad) && rates.allFinite() &&
                      std::isfinite(c.sigma_azimuth_rad) && std::isfinite(c.sigma_elevation_rad);
  if (!finite) return std::nullopt;
  antenna.previous_azimuth_rad = c.azimuth_rad;
  return c;
}

}  // namespace downrange
