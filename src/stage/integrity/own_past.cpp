#include "own_past.hpp"

#include <cmath>
#include <downrange/est/model/plot_model.hpp>
#include <utility>

namespace downrange::integrity {
namespace {

constexpr double longest_step_s = 2.1;
/// A radar's, which a folded range or another object may take out of sight: what is unforeseen grows with its square.
constexpr double longest_step_of_radar_s = 15;
constexpr double longest_gap_s = 1.6;  // between two fixes whose velocities are averaged
/// What the acceleration may change unforeseen between two samples, 1-sigma.
constexpr double unforeseen_m_s2 = 15;
constexpr double deepest_m = -2000;
constexpr double acceleration_max_m_s2 = 100;
constexpr double sigmas = 6;
constexpr Duration quiet_past = milliseconds(8000);
constexpr double back = 0.3;  // of the largest jump: less is left where it has jumped back
constexpr Duration unsaid = milliseconds(30'000);
constexpr Duration one_jump = milliseconds(1100);  // it may show in two samples
constexpr double sound = 0.5;
/// One side of the jump is wrong: a chi2 that differs by 6 says which at 20 to 1, with sites that may be 100 m off.
constexpr double decisive = 0.2;
constexpr int returns_in_a_row = 3;

double since(const Sample& before, const Sample& now) { return (now.epoch - before.epoch).seconds(); }

Mat<3, 3> noise_of(const Sample& fix) {
  return fix.median_factor() * fix_noise(fix.z, fix.sigma_horizontal_m, fix.sigma_vertical_m);
}

}  // namespace

OwnPast own_jump(const Witness& witness, const Sample& before, const Sample& now, const Threshold& threshold) {
  const double dt = since(before, now);
  if (dt <= 0 || dt > (witness.is_receiver() ? longest_step_s : longest_step_of_radar_s)) return {};
  const double slow = 2 * (1 - std::exp(-dt / witness.slow_tau_s));
  const double surprise = unforeseen_m_s2 * dt * dt / 2;
  if (witness.is_receiver()) {
    Vec<3> step = now.z - before.z;
    double surprise_m = surprise;
    if (before.velocity_valid && now.velocity_valid) {
      step -= dt / 2 * (before.motion + now.motion).segment<3>(3);
      surprise_m = unforeseen_m_s2 * dt * dt / 8 + now.sigma_velocity_m_s * dt;
    } else {
      step -= moved(before.motion, dt).head<3>() - before.motion.head<3>();
    }
    const Mat<3, 3> S =
        noise_of(before) + noise_of(now) +
        (slow * witness.slow_sigma_m * witness.slow_sigma_m + surprise_m * surprise_m) * Mat<3, 3>::Identity();
    return {threshold.ratio(step, S, true), step.norm(), step};
  }
  const BiasVector none = BiasVector::Zero();
  const PredictedPlot then = predict_plot(witness.model, before.motion, none);
  const PredictedPlot expected = predict_plot(witness.model, moved(before.motion, dt), none);
  const Vec<3> step = wrapped(witness, plot_residual({now.z[0], now.z[1], now.z[2]}, expected.q) -
                                           plot_residual({before.z[0], before.z[1], before.z[2]}, then.q));
  const Mat<3, 3> H = expected.d_motion.leftCols<3>();
  const Vec<3> variance = plot_variance(witness.model, {.measured = {now.z[0], now.z[1], now.z[2]}});
  const double cos_elevation = std::max(std::cos(now.z[2]), 0.01);
  const double wander = witness.model.wander.sigma_rad * witness.model.wander.sigma_rad;
  Vec<3> R = (before.median_factor() + now.median_factor()) * variance;
  R[1] += slow * (witness.slow_factor * variance[1] + wander / (cos_elevation * cos_elevation));
  R[2] += slow * (witness.slow_factor * variance[2] + wander);
  const bool ranged = witness.kind == WitnessKind::Radar;
  const Mat<3, bias_term_count> by_bias = expected.d_bias - then.d_bias;
  const Mat<3, 3> S = Mat<3, 3>(R.asDiagonal()) + surprise * surprise * H * H.transpose() +
                      by_bias * witness.prior.cov * by_bias.transpose() + north_jump(expected.d_bias, witness.prior);
  const double range = ranged ? now.z[0] : 0;
  return {threshold.ratio(step, S, ranged),
          Vec<3>(ranged ? step[0] : 0, range * std::cos(now.z[2]) * step[1], range * step[2]).norm(),
          {}};
}

OwnPast own_velocity(const Witness& receiver, double span_s, double lag_s, const Threshold& threshold) {
  const Ring<Sample>& all = receiver.series.samples();
  if (all.size() < 4) return {};
  const Sample& last = all.newest();
  Vec<3> travelled = Vec<3>::Zero();
  double trapezoid_m2 = 0;
  double velocity_m2 = 0;
  for (std::size_t i = 1; i < all.size(); ++i) {
    const Sample& from = all.newest(i);
    const Sample& to = all.newest(i - 1);
    const double dt = since(from, to);
    if (dt > longest_gap_s || !from.velocity_valid || !to.velocity_valid) return {};
    travelled += dt / 2 * (from.motion + to.motion).segment<3>(3);
    trapezoid_m2 = std::max(trapezoid_m2, std::pow(unforeseen_m_s2 * dt * dt / 8, 2));
    velocity_m2 += std::pow(to.sigma_velocity_m_s * dt, 2);
    const double span = since(from, last);
    if (span < span_s) continue;
    if (i < 3) return {};
    const Vec<3> mismatch = (last.z - from.z - travelled) / span;
    const Vec<3> late = lag_s * (last.motion - from.motion).segment<3>(3) / span;
    const double slow_m2 =
        2 * receiver.slow_sigma_m * receiver.slow_sigma_m * (1 - std::exp(-span / receiver.slow_tau_s));
    const Mat<3, 3> S =
        (noise_of(from) + noise_of(last) + (slow_m2 + 2 * trapezoid_m2 + velocity_m2) * Mat<3, 3>::Identity()) /
            (span * span) +
        late * late.transpose();
    return {threshold.ratio(mismatch, S, true), mismatch.norm()};
  }
  return {};
}

void Leap::note(Time at, const OwnPast& jump, bool alone) {
  const bool jumps = jump.ratio >= 1;
  if (leapt_ && at - *leapt_ > unsaid) forget();
  if (!leapt_) {
    if (!quiet_from_ || (jumps && at - *quiet_from_ < quiet_past)) {
      quiet_from_ = at;
      return;
    }
    if (!jumps || !alone) return;
    leapt_ = at;
  } else if (!jumps) {
    stays_ = true;
    return;
  }
  by_m_ += jump.step_m;
  largest_m_ = std::max(largest_m_, by_m_.norm());
  if (by_m_.norm() <= back * largest_m_) forget();
}

void Return::jumped(Time at, const Vec<3>& step_m) {
  step_m_ = jump_ && at - *jump_ <= one_jump ? step_m_ + step_m : step_m;
  jump_ = at;
  in_a_row_ = 0;
}

void Return::judge(Time at, double ratio, double ratio_without_jump) {
  if (!jump_ || at < *jump_) return;
  if (ratio >= 1 || at - *jump_ > unsaid) {
    jump_.reset();
    return;
  }
  in_a_row_ = ratio < sound && ratio_without_jump - ratio >= decisive ? in_a_row_ + 1 : 0;
  if (in_a_row_ < returns_in_a_row) return;
  since_ = std::exchange(jump_, std::nullopt);
}

bool impossible(const Witness& witness) {
  const Ring<Sample>& all = witness.series.samples();
  if (all.empty()) return false;
  const Sample& now = all.newest();
  const std::optional<Position<Ecef>> position = told_position(witness, now);
  if (!position) return false;
  constexpr auto elevation = static_cast<Eigen::Index>(BiasTerm::OffsetElevation);
  const double angle = sigmas * std::sqrt(witness.prior.cov(elevation, elevation));
  const double doubt_m = witness.is_receiver() ? 0 : now.z[0] * angle;
  if (geodetic_from_ecef(*position).height_m + doubt_m < deepest_m) return true;
  if (!witness.is_receiver() || all.size() < 2 || !now.velocity_valid || !all.newest(1).velocity_valid) return false;
  const double dt = since(all.newest(1), now);
  const Vec<3> change = (now.motion - all.newest(1).motion).segment<3>(3);
  return dt > 0 && dt < longest_step_s &&
         change.norm() > acceleration_max_m_s2 * dt + sigmas * 2 * now.sigma_velocity_m_s;
}

}  // namespace downrange::integrity
