#include "stage/slave/antenna_pointing.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "stage/indices.hpp"
#include "stage/integrity/bound.hpp"
#include "stage/slave/beam.hpp"
#include "stage/slave/turn.hpp"

namespace downrange {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double degree = pi / 180;
/// The antenna lags behind its commands where it is farther from them than this, on the sky.
constexpr double lags_rad = 0.02 * degree;
/// A turn is chosen for good when the velocity is known to this.
constexpr double known_velocity_m_s = 100;
/// Above, the target's own azimuth may turn by that much.
constexpr double turns_fast_above_rad = 80 * degree;
/// A seam closes at this share of the azimuth's rate, which a plan leaves free; a wider one is a step that was meant.
constexpr double seam_rate = 0.04;
constexpr double widest_seam_rad = 10 * degree;
/// A reading is compared with the track that far from the instant of the command: beyond, a constant acceleration says
/// no more where the target was (7 m for a jerk of 5 m/s^3).
constexpr double readings_within_s = 2;

std::unique_ptr<const RefractionTable> air_over(const AntennaConfig& antenna) {
  if (antenna.refractivity == 0) return nullptr;
  return std::make_unique<RefractionTable>(atmosphere_over(antenna.site.geodetic(), antenna.refractivity));
}

bool velocity_is_known(const TrackEstimate& e) {
  return e.cov.block<3, 3>(3, 3).trace() < known_velocity_m_s * known_velocity_m_s;
}

/// What is not known of the antenna itself, 1-sigma per axis.
void widen(Look& look, double azimuth_rad, double elevation_rad) {
  const double across = azimuth_rad * std::cos(look.elevation.angle_rad);
  look.sky.diagonal() += Eigen::Vector2d(across * across, elevation_rad * elevation_rad);
  look.sigma_azimuth_rad = std::min(std::hypot(look.sigma_azimuth_rad, azimuth_rad), pi);
  look.sigma_elevation_rad = std::min(std::hypot(look.sigma_elevation_rad, elevation_rad), pi);
}

/// On the sky, as seen from the look: across and up.
Eigen::Vector2d offset_on_sky(const Look& look, double azimuth_rad, double elevation_rad, double angle_rad) {
  const double da = azimuth_rad - look.azimuth.angle_rad;
  const double ce = std::cos(elevation_rad);
  const double se = std::sin(elevation_rad);
  const double across = ce * std::sin(da);
  const double up = se * std::cos(look.elevation.angle_rad) - ce * std::cos(da) * std::sin(look.elevation.angle_rad);
  const double length = std::hypot(across, up);
  if (!(length > 0)) return {angle_rad, 0};
  return angle_rad / length * Eigen::Vector2d(across, up);
}

}  // namespace

AntennaPointing::AntennaPointing(const AntennaConfig& antenna, const RangeConfig& range)
    : configured_(antenna),
      antenna_(antenna),
      range_(range),
      configured_target_(antenna.target.empty() ? 0 : index_of(range.targets, antenna.target)),
      target_(configured_target_),
      offset_(range.slave.blend_rate_rad_s),
      air_(air_over(antenna)),
      horizon_(antenna.elevation_min_rad, antenna.horizon),
      ladder_(antenna_, range.slave, air_.get()),
      blend_(range.slave.blend_rate_rad_s),
      keyhole_(antenna_),
      azimuth_axis_({antenna.azimuth_rate_max_rad_s, antenna.azimuth_acceleration_max_rad_s2}),
      elevation_axis_({antenna.elevation_rate_max_rad_s, antenna.elevation_acceleration_max_rad_s2}) {
  if (const auto noise = mount_noise(range, antenna)) mount_error_.emplace(*noise, antenna.mount_error_max_rad);
  readings_.reserve(most_readings);
}

void AntennaPointing::note_reading(Time epoch, double azimuth_rad, double elevation_rad) {
  if (mount_error_ && readings_.size() < most_readings) readings_.push_back({epoch, azimuth_rad, elevation_rad});
}

void AntennaPointing::obey(const AntennaWill& will) {
  azimuth_trim_rad_ = will.azimuth_trim_rad;
  elevation_trim_rad_ = will.elevation_trim_rad;
  const int target = will.target.value_or(configured_target_);
  if (std::exchange(target_, target) == target) return;
  ladder_.forget();
  readings_.clear();
  planned_.reset();
  turn_settled_ = false;
  // A plan near the zenith was one for the other target: from where it has led the antenna to the new one.
  if (last_ && seam_.plan != 0) {
    const Axes upright = over_ ? over_the_zenith(last_->axes) : last_->axes;
    blend_.was(upright.azimuth, upright.elevation);
  }
  keyhole_.clear();
  seam_ = {};
}

bool AntennaPointing::take_place(Time at) {
  if (!antenna_.moves) return true;
  place_ = platform_.at(at);
  if (place_) antenna_.site = place_->site;
  return place_.has_value();
}

void AntennaPointing::move_with_platform(Aim& aim) const {
  if (!place_) return;
  TrackEstimate relative = aim.estimate;
  relative.mean.segment<3>(3) -= place_->velocity.m_s;
  Look& look = aim.look;
  if (const auto moving = look_at(antenna_.site, air_.get(), relative)) look = *moving;
  look.azimuth.rate_rad_s -= place_->turn_rate_rad_s;
  const double by_place = place_->sigma_position_m / look.range_m;
  const double cos_elevation = std::max(std::cos(look.elevation.angle_rad), 1e-6);
  widen(look, std::hypot(by_place / cos_elevation, place_->sigma_heading_rad), by_place);
}

void AntennaPointing::learn_mount_error(const Aim& aim) {
  if (!mount_error_) return;
  const bool measured = aim.origin.source != SlavingSource::Coasting && aim.origin.source != SlavingSource::Nominal;
  for (const Reading& reading : measured ? std::span<const Reading>(readings_) : std::span<const Reading>()) {
    TrackEstimate then = aim.estimate;
    const double dt = (reading.epoch - aim.estimate.epoch).seconds();
    if (std::abs(dt) > readings_within_s) continue;  // of before a stop, say
    then.mean.head<3>() += dt * (then.mean.segment<3>(3) + dt / 2 * then.mean.tail<3>());
    const auto look = look_at(antenna_.site, air_.get(), then);
    if (!look) continue;
    mount_error_->note(reading.epoch, wrap_pi(reading.azimuth_rad - look->azimuth.angle_rad),
                       reading.elevation_rad - look->elevation.angle_rad, std::cos(look->elevation.angle_rad),
                       look->sigma_azimuth_rad, look->sigma_elevation_rad);
  }
  readings_.clear();
}

void AntennaPointing::offset_axes(double cos_elevation, Time tick, bool resumes) {
  offset_.want(azimuth_trim_rad_ + mount_offset_.azimuth_rad, elevation_trim_rad_ + mount_offset_.elevation_rad);
  if (resumes) {
    offset_.jump();
  } else {
    offset_.step((tick - last_->tick).seconds(), cos_elevation);
  }
  antenna_.azimuth_min_rad = configured_.azimuth_min_rad - offset_.azimuth_rad();
  antenna_.azimuth_max_rad = configured_.azimuth_max_rad - offset_.azimuth_rad();
  const double top = configured_.elevation_max_rad - offset_.elevation_rad();
  // What an offset lends does not make a mount one that goes over the zenith.
  antenna_.elevation_max_rad = configured_.elevation_max_rad <= pi / 2 ? std::min(top, pi / 2) : top;
}

Axes AntennaPointing::with_offset(Axes axes) const {
  axes.azimuth.angle_rad += offset_.azimuth_rad();
  axes.azimuth.rate_rad_s += offset_.azimuth_rate_rad_s();
  axes.elevation.angle_rad += offset_.elevation_rad();
  axes.elevation.rate_rad_s += offset_.elevation_rate_rad_s();
  const auto inside = [&](AxisMotion& axis, double least, double most, SlavingLimit limit) {
    const double angle = std::clamp(axis.angle_rad, least, most);
    if (angle == axis.angle_rad) return;
    axis = {.angle_rad = angle};
    axes.limits |= limit;
  };
  if (axes.limits & LimitAzimuth) axes.azimuth.rate_rad_s = 0;
  inside(axes.azimuth, configured_.azimuth_min_rad, configured_.azimuth_max_rad, LimitAzimuth);
  inside(axes.elevation, configured_.elevation_min_rad, configured_.elevation_max_rad, LimitElevation);
  return axes;
}

std::optional<Aim> AntennaPointing::aim(const Followed& followed, std::optional<Time> liftoff, Time tick) {
  const NominalTrajectory& nominal = range_.targets[static_cast<std::size_t>(target_)].nominal;
  if (!take_place(apply_at(tick))) return std::nullopt;
  auto aim = ladder_.choose(followed, nominal, liftoff, tick, apply_at(tick));
  if (!aim) return aim;
  aim->origin.target = target_;
  move_with_platform(*aim);
  learn_mount_error(*aim);
  mount_offset_ = mount_error_ ? mount_error_->at(apply_at(tick)) : MountOffset{};
  widen(aim->look, mount_offset_.sigma_azimuth_rad, mount_offset_.sigma_elevation_rad);
  return aim;
}

void AntennaPointing::choose_turn_of_pass() {
  const auto turn = choose_turn(pass_.points(), antenna_, turn_rad_);
  if (!turn) return;
  turn_rad_ = pass_.points().front().azimuth_rad + turn->offset_rad;
  over_ = turn->over;
}

void AntennaPointing::plan(const Aim& aim, const TargetPath& path, Time tick, bool resumes) {
  if (!resumes && planned_ && tick - *planned_ < planned_every) return;
  planned_ = resumes ? std::nullopt : std::optional(tick);  // a pass that is under way is planned with the next tick
  pass_.see(path.path(), antenna_.site, air_.get(), antenna_.elevation_min_rad);
  const bool known = path.timed() && velocity_is_known(aim.estimate);
  if (resumes || (known && !turn_settled_)) choose_turn_of_pass();
  turn_settled_ = known || (turn_settled_ && !resumes);
  // A plan near the zenith is one of azimuths: a platform that turns would leave it behind.
  if (path.timed() && last_ && !resumes && !antenna_.moves) {
    const double azimuth = last_->axes.azimuth.at((tick - last_->tick).seconds());
    keyhole_.make(path.path(), pass_, antenna_.site, air_.get(), apply_at(tick), azimuth, over_);
  } else {
    keyhole_.clear();
  }
}

Axes AntennaPointing::axes_of_plan(const AxisMotion& own, const AxisMotion& azimuth,
                                   const AxisMotion& elevation) const {
  constexpr double h_s = 0.01;
  Axes axes;
  axes.azimuth = own;
  const auto nearest = [&](double dt_s) {
    return nearest_elevation(axes.azimuth.at(dt_s) - azimuth.at(dt_s), elevation.at(dt_s), antenna_.elevation_max_rad);
  };
  const double now = nearest(0);
  const double later = nearest(h_s);
  const double earlier = nearest(-h_s);
  axes.elevation = {now, (later - earlier) / (2 * h_s), (later - 2 * now + earlier) / (h_s * h_s)};
  axes.limits = LimitKeyhole;
  return axes;
}

Axes AntennaPointing::axes_of_target(const AxisMotion& azimuth, const AxisMotion& elevation) {
  const auto inside = [&](const Axes& axes) {
    return unwrap_into_travel(axes.azimuth.angle_rad, turn_rad_, antenna_.azimuth_min_rad, antenna_.azimuth_max_rad);
  };
  const Axes upright{.azimuth = azimuth, .elevation = elevation};
  Axes axes = over_ ? over_the_zenith(upright) : upright;
  TravelAzimuth travelled = inside(axes);
  if (travelled.limits == LimitUnwrapped) {
    // It must go around: where to, says the rest of the pass.
    choose_turn_of_pass();
    axes = over_ ? over_the_zenith(upright) : upright;
    travelled = inside(axes);
  }
  axes.azimuth.angle_rad = travelled.azimuth_rad;
  // A held axis stands still: an antenna that feeds the rate forward must not run into its stop.
  if (travelled.limits & LimitAzimuth) axes.azimuth = {.angle_rad = travelled.azimuth_rad};
  axes.limits = travelled.limits & LimitAzimuth;
  const bool around = last_ && !keyhole_.active(apply_at(last_->tick)) &&
                      std::abs(axes.azimuth.angle_rad - last_->axes.azimuth.angle_rad) > 0.75 * pi &&
                      elevation.angle_rad < turns_fast_above_rad;
  if (around || (last_ && travelled.limits & LimitUnwrapped)) axes.limits |= LimitUnwrapped;
  return axes;
}

void AntennaPointing::mend_seam(AxisMotion& azimuth, std::uint64_t plan, Time tick) {
  const std::uint64_t before = std::exchange(seam_.plan, plan);
  const double dt = (tick - last_->tick).seconds();
  if (before != plan) {
    seam_.off_rad = last_->axes.azimuth.at(dt) - azimuth.angle_rad;
    if (std::abs(seam_.off_rad) > widest_seam_rad) seam_.off_rad = 0;
  }
  const double step = seam_rate * antenna_.azimuth_rate_max_rad_s * dt;
  const double left = std::copysign(std::max(std::abs(seam_.off_rad) - step, 0.0), seam_.off_rad);
  azimuth.rate_rad_s += (left - seam_.off_rad) / dt;
  azimuth.angle_rad += left;
  seam_.off_rad = left;
}

void AntennaPointing::follow(const Axes& axes, Time tick, bool resumes) {
  if (!last_) {
    azimuth_axis_.put(axes.azimuth);
    elevation_axis_.put(axes.elevation);
    return;
  }
  if (resumes) {
    azimuth_axis_.stop();
    elevation_axis_.stop();
  }
  const double dt = resumes ? range_.tick.seconds() : (tick - last_->tick).seconds();
  azimuth_axis_.follow(axes.azimuth, dt);
  elevation_axis_.follow(axes.elevation, dt);
}

std::optional<SlavingCommand> AntennaPointing::command(const Aim& aim, const Followed& followed, const TargetPath& path,
                                                       Time tick) {
  const bool resumes = !last_ || tick - last_->tick > longest_blended_gap;
  const Time at = apply_at(tick);
  const Look& look = aim.look;
  if (resumes) seam_ = {};
  offset_axes(std::cos(look.elevation.angle_rad), tick, resumes);
  plan(aim, path, tick, resumes);
  AxisMotion azimuth = look.azimuth;
  AxisMotion elevation = look.elevation;
  blend_.apply(tick, aim.origin, azimuth, elevation);
  Axes axes;
  if (keyhole_.active(at)) {
    AxisMotion own = keyhole_.azimuth(at);
    mend_seam(own, keyhole_.made(), tick);
    axes = axes_of_plan(own, azimuth, elevation);
  } else {
    // A plan may have led a mount that can over the zenith.
    if (seam_.plan != 0 && configured_.elevation_max_rad > pi / 2)
      over_ = std::cos(last_->axes.azimuth.angle_rad - azimuth.angle_rad) < 0;
    axes = axes_of_target(azimuth, elevation);
    if (seam_.plan != 0 || seam_.off_rad != 0) mend_seam(axes.azimuth, 0, tick);
  }
  axes.azimuth.angle_rad = std::clamp(axes.azimuth.angle_rad, antenna_.azimuth_min_rad, antenna_.azimuth_max_rad);
  hold_elevation(axes, horizon_, antenna_.elevation_max_rad);
  Axes told = with_offset(axes);
  follow(told, tick, resumes);
  const double azimuth_lag = told.azimuth.angle_rad - azimuth_axis_.angle_rad();
  const double elevation_lag = told.elevation.angle_rad - elevation_axis_.angle_rad();
  if (std::hypot(azimuth_lag * std::cos(axes.elevation.angle_rad), elevation_lag) > lags_rad) told.limits |= LimitRate;

  SlavingCommand c;
  c.antenna = antenna_.id;
  c.target = range_.targets[static_cast<std::size_t>(target_)].id;
  c.tick = tick;
  c.apply_at = at;
  c.valid_until = at + range_.slave.validity;
  c.data_epoch = aim.estimate.data_epoch;
  c.age_s = (at - c.data_epoch).seconds();
  c.source = aim.origin.source;
  c.chain = aim.origin.chain;
  c.limits = told.limits;
  c.range_m = look.range_m;
  c.range_rate_m_s = look.range_rate_m_s;
  c.azimuth_rad = told.azimuth.angle_rad;
  c.azimuth_rate_rad_s = told.azimuth.rate_rad_s;
  c.elevation_rad = told.elevation.angle_rad;
  c.elevation_rate_rad_s = told.elevation.rate_rad_s;
  c.acceleration_valid = look.acceleration_valid;
  if (c.acceleration_valid) {
    c.azimuth_acceleration_rad_s2 = told.azimuth.acceleration_rad_s2;
    c.elevation_acceleration_rad_s2 = told.elevation.acceleration_rad_s2;
  }
  c.sigma_azimuth_rad = look.sigma_azimuth_rad;
  c.sigma_elevation_rad = look.sigma_elevation_rad;
  c.mount_azimuth_rad = mount_offset_.azimuth_rad;
  c.mount_elevation_rad = mount_offset_.elevation_rad;
  // Where the antenna points: what its axes read, less what is added to them.
  const double pointed_azimuth = azimuth_axis_.angle_rad() - offset_.wanted_azimuth_rad();
  const double pointed_elevation = elevation_axis_.angle_rad() - offset_.wanted_elevation_rad();
  c.off_target_rad =
      separation_rad(pointed_azimuth, pointed_elevation, look.azimuth.angle_rad, look.elevation.angle_rad);
  c.probability_valid = antenna_.beamwidth_rad > 0;
  if (c.probability_valid) {
    const Eigen::Vector2d off = offset_on_sky(look, pointed_azimuth, pointed_elevation, c.off_target_rad);
    c.probability_in_beam = probability_in_disc(off, look.sky, antenna_.beamwidth_rad / 2);
  }
  c.bound_valid = aim.bounded;
  if (aim.bounded) {
    const double azimuth_told = c.azimuth_rad - offset_.wanted_azimuth_rad();
    const double elevation_told = c.elevation_rad - offset_.wanted_elevation_rad();
    const double unbent = elevation_told + (elevation_told > pi / 2 ? look.refraction_rad : -look.refraction_rad);
    const Eigen::Matrix3d R_ecef_enu = antenna_.site.R_enu_ecef().R.transpose();
    const Eigen::Vector3d commanded = R_ecef_enu * enu_from_polar({1, azimuth_told, unbent}).m;
    c.bound_rad = bound_rad(followed.alternatives, commanded, R_ecef_enu * look.line.m);
  }
  if (aim.bounded || c.source == SlavingSource::Fused) ladder_.note_bound(c.bound_rad);
  const bool finite = std::isfinite(c.azimuth_rad) && std::isfinite(c.elevation_rad) &&
                      std::isfinite(c.azimuth_rate_rad_s) && std::isfinite(c.elevation_rate_rad_s) &&
                      std::isfinite(c.azimuth_acceleration_rad_s2) && std::isfinite(c.elevation_acceleration_rad_s2) &&
                      std::isfinite(c.range_rate_m_s) && std::isfinite(c.sigma_azimuth_rad) &&
                      std::isfinite(c.sigma_elevation_rad) && std::isfinite(c.off_target_rad) &&
                      std::isfinite(c.probability_in_beam);
  if (!finite) return std::nullopt;
  last_ = Last{tick, axes};
  turn_rad_ = axes.azimuth.angle_rad;
  return c;
}

AntennaAccount AntennaPointing::account(const AntennaWill& will, const TargetPath* path,
                                        std::optional<Time> planned_liftoff, Time tick) const {
  AntennaAccount account;
  const std::optional<Time> begins = path == nullptr ? std::nullopt : path->begins(planned_liftoff);
  if (begins) {
    account = sighting(path->path(), *begins, antenna_.site, air_.get(), horizon_, tick);
    account.basis = path->basis();
  }
  account.antenna = configured_.id;
  account.target = range_.targets[static_cast<std::size_t>(target_)].id;
  account.tick = tick;
  account.orders = will.orders;
  return account;
}

}  // namespace downrange
