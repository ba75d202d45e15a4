#include <Eigen/LU>
#include <algorithm>
#include <bit>
#include <cmath>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/est/filter/hypothesis.hpp>
#include <downrange/est/method/target_life.hpp>
#include <downrange/est/model/plot_model.hpp>

namespace downrange {
namespace {

/// A plot this old says nothing of where a target is now.
constexpr Duration recent = milliseconds(1000);
/// Between two fixes a vehicle's acceleration is unknown within this.
constexpr double most_acceleration_m_s2 = 30;
/// No vehicle is faster.
constexpr double most_speed_m_s = 12'000;
/// A receiver that was believed for so long is established: from then on it is the one to explain a jump.
constexpr Duration established_after = milliseconds(10'000);
/// A radar that returns is believed to see one vehicle after so long.
constexpr Duration returned_after = milliseconds(1000);
/// A bias that was opened in vain is opened again only after this.
constexpr Duration open_again_after = milliseconds(60'000);
/// By so much more must the radars' priors speak for one position than for another (chi2 with 3 degrees of freedom:
/// one in a million).
constexpr double decisive = 30;

/// Of every term, zero where the model does not have it.
struct BiasPrior {
  Vec<bias_term_count> mean = Vec<bias_term_count>::Zero();
  Mat<bias_term_count, bias_term_count> cov = Mat<bias_term_count, bias_term_count>::Zero();
};
BiasPrior prior_of(const BiasModel& model) {
  BiasPrior prior;
  for (const BiasTerm row : model.terms) {
    const auto i = static_cast<Eigen::Index>(row);
    prior.mean[i] = model.prior_mean[i];
    for (const BiasTerm column : model.terms) {
      const auto j = static_cast<Eigen::Index>(column);
      prior.cov(i, j) = model.prior_cov(i, j);
    }
  }
  return prior;
}

}  // namespace

bool of_one_vehicle(const RadarModel& radar, const TimedPlot& first, const TimedPlot& second) {
  if (!tells_position(first.plot) || !tells_position(second.plot)) return false;
  const auto position = [&radar](const Plot& plot) { return radar.site.ecef_of(enu_from_polar(plot.measured)).m; };
  const double range_m = second.plot.measured.range_m;
  const double sigma_m =
      std::hypot(radar.sigma.range_m, range_m * radar.sigma.azimuth_rad, range_m * radar.sigma.elevation_rad);
  const Duration apart = second.epoch - first.epoch;
  return apart <= recent && (position(second.plot) - position(first.plot)).norm() <=
                                3 * std::sqrt(2) * sigma_m + most_speed_m_s * apart.seconds();
}

bool BiasOpening::open(Time now, int reopen_after) {
  if (used_since < reopen_after) return open_seldom(now);
  opened = now;
  used_since = 0;
  return true;
}

bool BiasOpening::open_seldom(Time now) {
  if (now - opened < open_again_after) return false;
  opened = now;
  used_since = 0;
  return true;
}

Arbitration::Arbitration(const MethodSettings& settings)
    : radars_(settings.radars),
      stations_(settings.stations),
      restart_after_(settings.arbitration.restart_after),
      reopen_after_(settings.arbitration.reopen_after),
      gps_max_age_(settings.gps.max_age),
      gps_use_velocity_(settings.gps_use.velocity),
      gps_error_variance_(settings.gps.error.enabled ? std::pow(settings.gps.error.sigma_m, 2) : 0),
      gate_probability_(settings.arbitration.gate_probability) {}

TargetLife Arbitration::unborn() const {
  TargetLife life;
  life.radars.resize(radars_.size());
  life.stations.resize(static_cast<std::size_t>(stations_), never);
  return life;
}

void Arbitration::accepted(TargetLife& life, const Measurement& m) const {
  life.accepted = m.epoch;
  life.refused = {};
  if (is_fix(m)) {
    ReceiverLife& receiver = life.receiver;
    if (!receiver.accepted || was_silent(life, m)) receiver.since = m.epoch;
    receiver.heard = m.epoch;
    receiver.accepted = {.epoch = m.epoch, .fix = fix_of(m)};
    receiver.refused_count = 0;
    life.stations[static_cast<std::size_t>(m.source) - life.radars.size()] = m.epoch;
    return;
  }
  RadarLife& radar = life.radars[static_cast<std::size_t>(m.source)];
  radar.accepted = {.epoch = m.epoch, .plot = plot_of(m.measured)};
  radar.rejected_in_row = 0;
  radar.refused = {};
  radar.opening.used(reopen_after_);
}

Remedy Arbitration::rejected(TargetLife& life, const Measurement& m, Verdict verdict, const Gaussian<9>& track) const {
  if (verdict == Verdict::Frozen) return Remedy::None;  // says nothing of the track
  life.refused.note(m.epoch);
  return is_fix(m) ? rejected_fix(life, m, track.mean) : rejected_plot(life, m, track);
}

Remedy Arbitration::rejected_plot(TargetLife& life, const Measurement& plot, const Gaussian<9>& track) const {
  RadarLife& radar = life.radars[static_cast<std::size_t>(plot.source)];
  const TimedPlot now{.epoch = plot.epoch, .plot = plot_of(plot.measured)};
  const bool again = of_one_vehicle(radars_[static_cast<std::size_t>(plot.source)], radar.refused, now);
  if (!again) radar.refused_since = now;
  radar.refused = now;
  const bool explained = explained_by_bias(plot.source, now, plot.epoch, track);
  if (explained) ++radar.rejected_in_row;
  if (life.refused.last(plot.epoch, restart_after_)) {
    // A receiver that agrees with itself tells better where the target is, with its next fix.
    const ReceiverLife& receiver = life.receiver;
    const bool fix_is_due =
        receiver.refused_count > 1 && receiver.agreeing_since < receiver.heard && !was_silent(life, plot);
    return again && !fix_is_due ? Remedy::Restart : Remedy::None;
  }
  const bool returns = again && radar.refused_since.epoch - radar.accepted.epoch > gps_max_age_;
  if (returns && now.epoch - radar.refused_since.epoch < returned_after) return Remedy::None;
  if (returns && overrules(life, plot, track) && radar.opening.open(plot.epoch, reopen_after_)) return Remedy::Unite;
  const bool others_follow = life.accepted > radar.accepted.epoch && plot.epoch - life.accepted <= restart_after_;
  if (!explained || radar.rejected_in_row < reopen_after_ || !others_follow) return Remedy::None;
  radar.rejected_in_row = 0;
  return radar.opening.open(plot.epoch, reopen_after_) ? Remedy::OpenBias : Remedy::None;
}

bool Arbitration::overrules(const TargetLife& life, const Measurement& plot, const Gaussian<9>& track) const {
  const auto source = static_cast<std::size_t>(plot.source);
  const TimedPlot now{.epoch = plot.epoch, .plot = plot_of(plot.measured)};
  const std::uint64_t others = other_radars(life, plot);
  if (!tells_position(now.plot) || others == 0 || has_receiver(life, plot.epoch)) return false;
  const Gaussian<3> seen = position_by_prior(source, now, track.mean);
  Vec<9> motion = track.mean;
  motion.head<3>() = seen.mean;
  const Misfit of_plot = misfit(life, others, plot.epoch, motion, seen.cov);
  if (of_plot.chi2 > chi2_quantile(gate_probability_, of_plot.dof)) return false;
  const Mat<3, 3> P = track.cov.topLeftCorner<3, 3>();
  const double of_track =
      misfit(source, now, plot.epoch, track.mean, P).chi2 + misfit(life, others, plot.epoch, track.mean, P).chi2;
  return of_plot.chi2 + decisive < of_track;
}

bool Arbitration::led_astray(TargetLife& life, const Measurement& plot, double bias_misfit, int terms) const {
  static const Gates gates(1 - 1e-6);
  return tells_position(plot.measured) && bias_misfit > gates[terms] &&
         life.radars[static_cast<std::size_t>(plot.source)].opening.open_seldom(plot.epoch);
}

Gaussian<3> Arbitration::position_by_prior(std::size_t source, const TimedPlot& plot, const Vec<9>& near) const {
  const RadarModel& radar = radars_[source];
  const BiasPrior prior = prior_of(radar.bias);
  // Where the radar would see a target at `near` tells how its measurement turns with the position.
  const PredictedPlot predicted = predict_plot(radar, near, prior.mean);
  const Mat<3, 3> to_position = predicted.d_motion.leftCols<3>().inverse();
  Mat<3, 3> open = predicted.d_bias * prior.cov * predicted.d_bias.transpose();
  open.diagonal() += plot_variance(radar, plot.plot);
  // The rest of the way by the measurement itself: it bends over kilometres.
  const Vec<3> bias = predicted.q - predict_plot(radar, near, Vec<bias_term_count>::Zero()).q;
  const Polar unbiased{plot.plot.measured.range_m - bias[0], plot.plot.measured.azimuth_rad - bias[1],
                       plot.plot.measured.elevation_rad - bias[2]};
  return {.mean = radar.site.ecef_of(enu_from_polar(unbiased)).m, .cov = to_position * open * to_position.transpose()};
}

Remedy Arbitration::rejected_fix(TargetLife& life, const Measurement& fix, const Vec<9>& track) const {
  remember_refused(life.receiver, fix, track);
  if (life.refused.last(fix.epoch, restart_after_) && fix.epoch - life.receiver.agreeing_since > Duration{0})
    return Remedy::Restart;
  if (!three_agree(life.receiver, track) || !overrules(life, fix, track)) return Remedy::None;
  life.receiver.since = fix.epoch;
  return Remedy::Unite;
}

void Arbitration::remember_refused(ReceiverLife& receiver, const Measurement& m, const Vec<9>& track) const {
  const TimedFix fix{.epoch = m.epoch, .fix = fix_of(m)};
  const bool agrees = (receiver.refused_count > 0 && agree(receiver.refused[2], fix, track)) ||
                      (receiver.refused_count > 1 && in_line(receiver.refused[1], receiver.refused[2], fix));
  if (receiver.refused_count == 0) receiver.continuous = receiver.accepted && agree(*receiver.accepted, fix, track);
  if (!agrees) receiver.agreeing_since = fix.epoch;
  if (fix.epoch - receiver.heard > gps_max_age_) receiver.since = fix.epoch;  // it is one that returns
  receiver.heard = fix.epoch;
  std::rotate(receiver.refused.begin(), receiver.refused.begin() + 1, receiver.refused.end());
  receiver.refused.back() = fix;
  receiver.refused_count = std::min(receiver.refused_count + 1, static_cast<int>(receiver.refused.size()));
}

bool Arbitration::agree(const TimedFix& first, const TimedFix& second, const Vec<9>& track) const {
  const Fix& a = first.fix;
  const Fix& b = second.fix;
  const double dt = (second.epoch - first.epoch).seconds();
  const bool with_velocity = a.velocity_valid && b.velocity_valid && gps_use_velocity_;
  const Vec<3> v = with_velocity ? Vec<3>((a.velocity.m_s + b.velocity.m_s) / 2) : Vec<3>(track.segment<3>(3));
  const double sigma = std::hypot(b.sigma_horizontal_m, b.sigma_vertical_m);
  return dt > 0 && (b.position.m - a.position.m - dt * v).norm() <=
                       3 * std::sqrt(2) * sigma + most_acceleration_m_s2 / 2 * dt * dt;
}

bool Arbitration::in_line(const TimedFix& first, const TimedFix& second, const TimedFix& third) const {
  const Fix& newest = third.fix;
  if (gps_use_velocity_ && newest.velocity_valid) return false;  // says better where it goes
  const double before = (second.epoch - first.epoch).seconds();
  const double dt = (third.epoch - second.epoch).seconds();
  if (before <= 0 || dt <= 0) return false;
  const Vec<3> v = (second.fix.position.m - first.fix.position.m) / before;
  const double sigma = std::hypot(newest.sigma_horizontal_m, newest.sigma_vertical_m);
  return v.norm() <= most_speed_m_s &&
         (newest.position.m - second.fix.position.m - dt * v).norm() <=
             3 * std::sqrt(2) * sigma * (1 + dt / before) + most_acceleration_m_s2 / 2 * dt * (dt + before);
}

bool Arbitration::three_agree(const ReceiverLife& receiver, const Vec<9>& track) const {
  const auto& [first, second, third] = receiver.refused;
  return receiver.refused_count == 3 &&
         ((agree(first, second, track) && agree(second, third, track)) || in_line(first, second, third));
}

bool Arbitration::overrules(const TargetLife& life, const Measurement& m, const Vec<9>& track) const {
  const ReceiverLife& receiver = life.receiver;
  const bool established = receiver.accepted && receiver.accepted->epoch - receiver.since >= established_after;
  if (!established && plausible(life, m, track)) return true;
  const std::uint64_t radars = recent_radars(life, m.epoch);
  if (radars == 0) return true;  // nobody contradicts
  const Fix& fix = fix_of(m);
  const Misfit of_fix = misfit(life, radars, m.epoch, motion_of(fix, track), fix_covariance(fix));
  const Misfit of_track = misfit(life, radars, m.epoch, track, fix_covariance(fix));
  if (of_fix.chi2 + decisive < of_track.chi2) return true;  // it is the track that was led astray
  // The receiver is where its own past leads: then it is the one radar that has gone elsewhere.
  return established && std::has_single_bit(radars) && receiver.continuous;
}

bool Arbitration::plausible(const TargetLife& life, const Measurement& m, const Vec<9>& track) const {
  const std::uint64_t radars = recent_radars(life, m.epoch);
  if (radars == 0) return true;
  const Fix& fix = fix_of(m);
  const Misfit of_fix = misfit(life, radars, m.epoch, motion_of(fix, track), fix_covariance(fix));
  if (of_fix.chi2 <= chi2_quantile(gate_probability_, of_fix.dof)) return true;
  // Against one radar, whose biases cannot explain it, a receiver must insist; against two it does not help.
  return std::has_single_bit(radars) && m.epoch - life.receiver.agreeing_since >= restart_after_;
}

FirstFixes Arbitration::first_fixes(TargetLife& life, const Measurement& fix, const Vec<9>& track) const {
  remember_refused(life.receiver, fix, track);
  if (life.receiver.agreeing_since == fix.epoch) return FirstFixes::Wait;
  return plausible(life, fix, track) ? FirstFixes::Hold : FirstFixes::Contradicted;
}

bool Arbitration::alone_against_gps(TargetLife& life, const Measurement& plot, bool refused_by_gps) const {
  constexpr int not_an_outlier = 3;
  int& refused = life.radars[static_cast<std::size_t>(plot.source)].refused_by_gps;
  refused = refused_by_gps ? refused + 1 : 0;
  if (!refused_by_gps) return false;
  const std::uint64_t radars = other_radars(life, plot);
  for (std::size_t i = 0; i < life.radars.size(); ++i) {
    if ((radars >> i & 1) != 0 && life.radars[i].refused_by_gps >= not_an_outlier) return false;
  }
  return true;
}

std::uint64_t Arbitration::recent_radars(const TargetLife& life, Time now) {
  std::uint64_t mask = 0;
  for (std::size_t i = 0; i < life.radars.size(); ++i) {
    if (now - life.radars[i].accepted.epoch <= recent) mask |= std::uint64_t{1} << i;
  }
  return mask;
}

std::uint64_t Arbitration::recent_sources(const TargetLife& life, Time now) {
  std::uint64_t mask = recent_radars(life, now);
  for (std::size_t i = 0; i < life.stations.size() && life.radars.size() + i < 64; ++i) {
    if (now - life.stations[i] <= recent) mask |= std::uint64_t{1} << (life.radars.size() + i);
  }
  return mask;
}

Vec<9> Arbitration::motion_of(const Fix& fix, const Vec<9>& track) const {
  Vec<9> motion = track;
  motion.head<3>() = fix.position.m;
  if (fix.velocity_valid && gps_use_velocity_) motion.segment<3>(3) = fix.velocity.m_s;
  return motion;
}

bool Arbitration::explained_by_bias(int source, const TimedPlot& plot, Time epoch, const Gaussian<9>& motion) const {
  const Misfit of_plot =
      misfit(static_cast<std::size_t>(source), plot, epoch, motion.mean, motion.cov.topLeftCorner<3, 3>());
  return of_plot.chi2 <= chi2_quantile(gate_probability_, of_plot.dof);
}

Arbitration::Misfit Arbitration::misfit(const TargetLife& life, std::uint64_t mask, Time epoch, const Vec<9>& motion,
                                        const Mat<3, 3>& P) const {
  Misfit sum;
  for (std::size_t r = 0; r < radars_.size(); ++r) {
    if ((mask >> r & 1) == 0) continue;
    const Misfit of_radar = misfit(r, life.radars[r].accepted, epoch, motion, P);
    sum.chi2 += of_radar.chi2;
    sum.dof += of_radar.dof;
  }
  return sum;
}

Arbitration::Misfit Arbitration::misfit(std::size_t source, const TimedPlot& plot, Time epoch, const Vec<9>& motion,
                                        const Mat<3, 3>& P) const {
  const RadarModel& radar = radars_[source];
  const double dt = (plot.epoch - epoch).seconds();
  Vec<9> then = motion;
  then.head<3>() += dt * motion.segment<3>(3) + dt * dt / 2 * motion.tail<3>();
  const BiasPrior prior = prior_of(radar.bias);
  const PredictedPlot predicted = predict_plot(radar, then, prior.mean);
  const Mat<3, 3> J = predicted.d_motion.leftCols<3>();
  Vec<3> variance = plot_variance(radar, plot.plot);
  const double wander = radar.wander.sigma_rad;
  variance.tail<2>() += Vec<2>(wander * azimuth_of_sky_angle(plot.plot.measured.elevation_rad), wander).cwiseAbs2();
  Mat<3, 3> S = predicted.d_bias * prior.cov * predicted.d_bias.transpose();
  S += J * (P + gps_error_variance_ * Mat<3, 3>::Identity()) * J.transpose();
  S.diagonal() += variance;
  const Vec<3> nu = plot_residual(plot.plot.measured, predicted.q);
  return with_components(plot.plot, [&]<int First, int M>() -> Misfit {
    return {.chi2 = normalised_square<M>(Vec<M>(nu.segment<M>(First)), Mat<M, M>(S.block<M, M>(First, First))),
            .dof = M};
  });
}

void Arbitration::add_engine_event(Mat<9, 9>& cov, Duration since) {
  constexpr MotionModel event{.noise = MotionModel::Noise::WhiteJerk, .q = 500, .gravity_aware = false};
  const Mat<3, 3> Q = process_noise(event, since.seconds());
  for (Eigen::Index row = 0; row < 3; ++row) {
    for (Eigen::Index column = 0; column < 3; ++column)
      cov.block<3, 3>(3 * row, 3 * column).diagonal().array() += Q(row, column);
  }
}

bool Arbitration::is_no_gps_error(const Vec<3>& error) const {
  static const double most = chi2_quantile(1 - 1e-6, 3);
  return gps_error_variance_ > 0 && error.squaredNorm() > most * gps_error_variance_;
}

Vec<6> Arbitration::away_from(const TargetLife& life, const Measurement& m, const Vec<9>& track) const {
  Vec<6> nu = Vec<6>::Zero();
  if (!is_fix(m)) {
    const auto source = static_cast<std::size_t>(m.source);
    const RadarLife& radar = life.radars[source];
    const double since = (radar.refused.epoch - radar.refused_since.epoch).seconds();
    const Vec<3> now = position_by_prior(source, radar.refused, track).mean;
    nu << now - track.head<3>(),
        (now - position_by_prior(source, radar.refused_since, track).mean) / since - track.segment<3>(3);
    return nu;
  }
  const Fix& fix = fix_of(m);
  nu.head<3>() = fix.position.m - track.head<3>();
  if (fix.velocity_valid && gps_use_velocity_) {
    nu.tail<3>() = fix.velocity.m_s - track.segment<3>(3);
  } else if (life.receiver.refused_count == 3) {
    const auto& [first, second, third] = life.receiver.refused;
    nu.tail<3>() =
        (third.fix.position.m - first.fix.position.m) / (third.epoch - first.epoch).seconds() - track.segment<3>(3);
  }
  return nu;
}

std::uint64_t Arbitration::loosened_by(const TargetLife& life, const Measurement& m) {
  const std::uint64_t following = recent_radars(life, m.epoch);
  return is_fix(m) ? following : following | std::uint64_t{1} << m.source;
}

Mat<6, 6> Arbitration::union_term(const Vec<6>& nu) {
  Mat<6, 6> term = Mat<6, 6>::Zero();
  for (int part = 0; part < 6; part += 3) term.block<3, 3>(part, part) = downrange::union_term(nu.segment<3>(part));
  return term;
}

}  // namespace downrange
