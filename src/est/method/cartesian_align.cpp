#include <algorithm>
#include <cassert>
#include <cmath>
#include <downrange/est/filter/consistency.hpp>
#include <downrange/est/method/cartesian_align.hpp>
#include <downrange/est/model/motion.hpp>
#include <downrange/est/model/plot_model.hpp>
#include <limits>

namespace downrange {
namespace {

/// A bias estimate beyond this many sigma of its prior is a wrong reference, not a bias. Cartesian scales that stand
/// for the polar bias of a real radar reach 15.
constexpr double bias_sigmas_max = 30;

const Mat<3, 6> H = (Mat<3, 6>() << Mat<3, 3>::Identity(), Mat<3, 3>::Zero()).finished();

/// C of eq. (18), with the project's sign: measured = (1 + eps) true + b.
Mat<3, 6> bias_matrix(const Vec<3>& z_sez) {
  Mat<3, 6> C;
  C << Mat<3, 3>::Identity(), Mat<3, 3>(z_sez.asDiagonal());
  return C;
}

double seconds_between(Time later, Time earlier) { return (later - earlier).seconds(); }

void add_knot(GpsTrack& gps) {
  if (gps.knot_count == GpsTrack::max_knots) {
    std::rotate(gps.knots.begin(), gps.knots.begin() + 1, gps.knots.end());
    --gps.knot_count;
  }
  gps.knots[static_cast<std::size_t>(gps.knot_count++)] = {.epoch = gps.epoch, .filtered = gps.state};
}

}  // namespace

CartesianAlign::CartesianAlign(MethodSettings settings, bool correct)
    : settings_(std::move(settings)),
      arbitration_(settings_),
      correct_(correct),
      gate3_(correct ? chi2_quantile(settings_.arbitration.gate_probability, 3)
                     : std::numeric_limits<double>::infinity()),
      gate6_(chi2_quantile(settings_.arbitration.gate_probability, 6)) {
  assert(settings_.cartesian_bias.window <= RadarBias::max_window);
  assert(settings_.gps.alignment.fixes >= 1 && settings_.gps.alignment.fixes < GpsTrack::max_knots);
}

CartesianAlign::State CartesianAlign::initial() const {
  State s;
  s.radars.resize(settings_.radars.size());
  for (RadarBias& bias : s.radars) bias.estimate = prior_bias();
  s.gps.resize(static_cast<std::size_t>(settings_.targets));
  s.lives.resize(static_cast<std::size_t>(settings_.targets), arbitration_.unborn());
  reserve(s);
  return s;
}

void CartesianAlign::reserve(State& state) const {
  if (!settings_.gps.alignment.smooth) return;
  for (GpsTrack& gps : state.gps) gps.held.reserve(GpsTrack::max_held);
}

Gaussian<6> CartesianAlign::prior_bias() const {
  Vec<6> variance;
  variance << Vec<3>::Constant(settings_.cartesian_bias.offset_prior_m * settings_.cartesian_bias.offset_prior_m),
      Vec<3>::Constant(settings_.cartesian_bias.scale_prior * settings_.cartesian_bias.scale_prior);
  return {.mean = Vec<6>::Zero(), .cov = correct_ ? Mat<6, 6>(variance.asDiagonal()) : Mat<6, 6>::Zero()};
}

Outcome CartesianAlign::apply_fix(State& state, SourceAccount& account, const Measurement& m,
                                  const std::optional<TrackEstimate>& fused) const {
  GpsTrack& gps = state.gps[static_cast<std::size_t>(m.target)];
  TargetLife& life = state.lives[static_cast<std::size_t>(m.target)];
  TrackVelocity velocity;
  if (gps.reference.started)
    velocity = {.m_s = gps.state.mean.tail<3>(),
                .sigma_m_s = std::sqrt(gps.state.cov.bottomRightCorner<3, 3>().trace())};
  if (is_frozen(gps.last_fix, m, velocity)) {
    const Outcome frozen{.verdict = Verdict::Frozen, .nis = 0, .dof = 3};
    count(account, frozen);
    return frozen;
  }
  const std::uint64_t radars = Arbitration::recent_radars(life, m.epoch);
  Vec<9> motion = Vec<9>::Zero();
  bool agrees = false;
  if (fused && radars != 0) {
    motion = fused->mean;
    const Mat<3, 3> S = fused->cov.topLeftCorner<3, 3>() + fix_covariance(fix_of(m));
    agrees = normalised_square<3>(fix_of(m).position.m - motion.head<3>(), S) <= gate3_;
  } else if (gps.reference.started) {
    motion.head<6>() =
        cv::predict(gps.state, seconds_between(m.epoch, gps.epoch), settings_.cartesian_bias.gps_q_m2_s3).mean;
  }
  const Outcome outcome = update_gps_track(
      arbitration_, life, gps.reference, m, motion, agrees, [&] { start_gps(gps, m); },
      [&] { return update_by_fix(gps, account, m); },
      [&] {
        if (settings_.gps.alignment.smooth) release_held(state, gps);
      },
      [&] { loosen_biases(state, radars); });
  count(account, outcome);
  return outcome;
}

Outcome CartesianAlign::update_by_fix(GpsTrack& gps, SourceAccount& account, const Measurement& m) const {
  const Gaussian<6> predicted =
      cv::predict(gps.state, seconds_between(m.epoch, gps.epoch), settings_.cartesian_bias.gps_q_m2_s3);
  const Fix& fix = fix_of(m);
  const Mat<3, 3> R = fix_covariance(fix);
  Outcome outcome;
  const auto apply = [&](const auto& u) {
    outcome = {.verdict = u.verdict, .nis = u.nis, .dof = static_cast<int>(u.innovation.size())};
    if (outcome.verdict != Verdict::Accepted) return;
    note_innovation(account, u.innovation, u.S, u.nis);
    gps.state = u.posterior;
    gps.epoch = m.epoch;
    if (settings_.gps.alignment.smooth) add_knot(gps);
  };
  if (fix.velocity_valid && settings_.gps_use.velocity) {
    Mat<6, 6> R6 = Mat<6, 6>::Zero();
    R6.topLeftCorner<3, 3>() = R;
    R6.bottomRightCorner<3, 3>().diagonal().setConstant(fix.sigma_velocity_m_s * fix.sigma_velocity_m_s);
    Vec<6> z;
    z << fix.position.m, fix.velocity.m_s;
    apply(kalman_update<6, 6>(predicted, z - predicted.mean, Mat<6, 6>::Identity(), R6, gate6_));
  } else {
    apply(kalman_update<6, 3>(predicted, fix.position.m - H * predicted.mean, H, R, gate3_));
  }
  // A gated fix leaves track and age as they were: the reference must not look fresh.
  return outcome;
}

void CartesianAlign::start_gps(GpsTrack& gps, const Measurement& m) const {
  const Fix& fix = fix_of(m);
  const bool with_velocity = fix.velocity_valid && settings_.gps_use.velocity;
  const double sigma_velocity = with_velocity ? fix.sigma_velocity_m_s : settings_.start.sigma_velocity_m_s;
  gps.epoch = m.epoch;
  gps.state.mean << fix.position.m, (with_velocity ? fix.velocity.m_s : Vec<3>::Zero());
  gps.state.cov.setZero();
  gps.state.cov.topLeftCorner<3, 3>() = fix_covariance(fix);
  gps.state.cov.bottomRightCorner<3, 3>().diagonal().setConstant(sigma_velocity * sigma_velocity);
  gps.knot_count = 0;
  gps.held.clear();  // no fix of this track came before them
  if (settings_.gps.alignment.smooth) add_knot(gps);
}

TimedPosition CartesianAlign::compensated(State& state, const Measurement& m) const {
  const RadarModel& model = settings_.radars[static_cast<std::size_t>(m.source)];
  RadarBias& bias = state.radars[static_cast<std::size_t>(m.source)];

  const ConvertedMeasurement converted =
      convert_unbiased(without_refraction(model, plot_of(m.measured).measured), model.sigma);  // (8)-(13)
  const Mat<3, 3> R_sez_enu = sez_from_enu().R;
  const Vec<3> z_sez = R_sez_enu * converted.z.m;
  const Mat<3, 3> R_sez = R_sez_enu * converted.R * R_sez_enu.transpose();

  if (m.reset_bias) forget(bias);
  if (correct_) align(state, m, z_sez, R_sez);
  bias.epoch = m.epoch;

  // Compensation (14): true = z - C b, and what is not known of b is noise of the compensated plot.
  const Mat<3, 6> C = bias_matrix(z_sez);
  const Mat<3, 3> R_ecef_sez = model.site.R_sez_ecef().R.transpose();
  TimedPosition z;
  z.z = model.site.ecef().m + R_ecef_sez * (z_sez - C * bias.estimate.mean);
  z.R = R_ecef_sez * (R_sez + C * bias.estimate.cov * C.transpose()) * R_ecef_sez.transpose();
  return z;
}

Remedy CartesianAlign::rejected(State& state, const Measurement& plot, Verdict verdict) const {
  TargetLife& life = state.lives[static_cast<std::size_t>(plot.target)];
  const GpsTrack& gps = state.gps[static_cast<std::size_t>(plot.target)];
  constexpr double anywhere_m2 = 1e16;
  Gaussian<9> motion{.mean = Vec<9>::Zero(), .cov = anywhere_m2 * Mat<9, 9>::Identity()};
  if (gps.reference.confirmed && plot.epoch - gps.epoch <= settings_.gps.max_age) {
    const Gaussian<6> now =
        cv::predict(gps.state, seconds_between(plot.epoch, gps.epoch), settings_.cartesian_bias.gps_q_m2_s3);
    motion.mean.head<6>() = now.mean;
    motion.cov.topLeftCorner<6, 6>() = now.cov;
  }
  const Remedy remedy = arbitration_.rejected(life, plot, verdict, motion);
  if (remedy == Remedy::OpenBias) forget(state.radars[static_cast<std::size_t>(plot.source)]);
  return remedy;
}

bool CartesianAlign::is_refused(State& state, const Measurement& plot) const {
  const GpsTrack& gps = state.gps[static_cast<std::size_t>(plot.target)];
  const RadarBias& bias = state.radars[static_cast<std::size_t>(plot.source)];
  // Where plots wait for fixes, the newest ones that were compared tell.
  const int in_row = settings_.gps.alignment.smooth ? 3 : 1;
  const bool refused = correct_ && gps.reference.confirmed && plot.epoch - gps.epoch <= settings_.gps.max_age &&
                       bias.rejected_in_row >= in_row;
  return arbitration_.alone_against_gps(state.lives[static_cast<std::size_t>(plot.target)], plot, refused);
}

void CartesianAlign::loosen_biases(State& state, std::uint64_t radars) const {
  const Mat<6, 6> step = prior_bias().cov / 4;
  for (std::size_t i = 0; i < state.radars.size(); ++i) {
    if ((radars >> i & 1) != 0) state.radars[i].estimate.cov += step;
  }
}

void CartesianAlign::forget(RadarBias& bias) const {
  bias.estimate = prior_bias();
  bias.windowed = bias.next = 0;
  bias.rejected_in_row = 0;
}

void CartesianAlign::align(State& state, const Measurement& m, const Vec<3>& z_sez, const Mat<3, 3>& R_sez) const {
  GpsTrack& gps = state.gps[static_cast<std::size_t>(m.target)];
  const HeldPlot plot{.epoch = m.epoch, .radar = m.source, .z_sez = z_sez, .R_sez = R_sez};
  if (settings_.gps.alignment.smooth) {
    if (gps.reference.started && gps.held.size() < GpsTrack::max_held) gps.held.push_back(plot);
  } else if (gps.reference.confirmed && m.epoch - gps.epoch <= settings_.gps.max_age) {
    // (17) Kalman prediction of GPS to the radar's epoch.
    estimate_bias(state.radars[static_cast<std::size_t>(m.source)], plot,
                  cv::predict(gps.state, seconds_between(m.epoch, gps.epoch), settings_.cartesian_bias.gps_q_m2_s3));
  }
}

void CartesianAlign::release_held(State& state, GpsTrack& gps) const {
  const int later = settings_.gps.alignment.fixes;
  if (gps.knot_count <= later) return;
  const Time until = gps.knots[static_cast<std::size_t>(gps.knot_count - later)].epoch;
  const auto end = std::ranges::find_if(gps.held, [until](const HeldPlot& plot) { return plot.epoch > until; });
  for (auto plot = gps.held.begin(); plot != end; ++plot) {
    const auto reference = smoothed_at(gps, plot->epoch, settings_.cartesian_bias.gps_q_m2_s3);
    if (reference) estimate_bias(state.radars[static_cast<std::size_t>(plot->radar)], *plot, *reference);
  }
  gps.held.erase(gps.held.begin(), end);
}

std::optional<Gaussian<6>> smoothed_at(const GpsTrack& track, Time t, double q) {
  // One step back: from what is known at `to` by everything, to `from` filtered.
  const auto step_back = [q](const Gaussian<6>& from, double dt, const Gaussian<6>& smoothed) -> Gaussian<6> {
    const Gaussian<6> predicted = cv::predict(from, dt, q);
    const Mat<6, 6> C = predicted.cov.llt().solve(cv::transition(dt) * from.cov).transpose();  // P F' P(to|from)^-1
    const Mat<6, 6> P = from.cov + C * (smoothed.cov - predicted.cov) * C.transpose();
    return {.mean = from.mean + C * (smoothed.mean - predicted.mean), .cov = (P + P.transpose()) / 2};
  };
  if (track.knot_count < 2 || t > track.knots[static_cast<std::size_t>(track.knot_count - 1)].epoch)
    return std::nullopt;
  Gaussian<6> smoothed = track.knots[static_cast<std::size_t>(track.knot_count - 1)].filtered;
  for (int i = track.knot_count - 2; i >= 0; --i) {
    const GpsTrack::Knot& from = track.knots[static_cast<std::size_t>(i)];
    const GpsTrack::Knot& to = track.knots[static_cast<std::size_t>(i + 1)];
    if (t >= from.epoch) {
      const double dt = seconds_between(t, from.epoch);
      const Gaussian<6> at_t = dt == 0 ? from.filtered : cv::predict(from.filtered, dt, q);
      const double rest = seconds_between(to.epoch, t);
      return rest == 0 ? smoothed : step_back(at_t, rest, smoothed);
    }
    smoothed = step_back(from.filtered, seconds_between(to.epoch, from.epoch), smoothed);
  }
  return std::nullopt;
}

void CartesianAlign::estimate_bias(RadarBias& bias, const HeldPlot& plot, const Gaussian<6>& reference) const {
  const RadarModel& model = settings_.radars[static_cast<std::size_t>(plot.radar)];
  const Mat<3, 3>& R_sez_ecef = model.site.R_sez_ecef().R;
  const Vec<3>& z_sez = plot.z_sez;

  // (15), (16) pseudo measurement and its noise.
  const Vec<3> z_b = z_sez - R_sez_ecef * (reference.mean.head<3>() - model.site.ecef().m);
  const Mat<3, 3> R_b = R_sez_ecef * reference.cov.topLeftCorner<3, 3>() * R_sez_ecef.transpose() + plot.R_sez;

  // (19)-(21)
  Gaussian<6> prior = bias.estimate;
  // Plots that waited for fixes come target by target: the radar's bias may have been brought further already.
  if (bias.samples > 0) prior.cov += bias_process_noise(bias, std::max(0.0, seconds_between(plot.epoch, bias.updated)));
  // (22), (23)
  const Mat<3, 6> C = bias_matrix(z_sez);
  const auto u = kalman_update<6, 3>(prior, z_b - C * prior.mean, C, R_b, gate3_);
  const Vec<6> prior_sigma = prior_bias().cov.diagonal().cwiseSqrt();
  // Far outside of what a radar's bias can be, the reference is wrong, whatever the gate says: the windowed process
  // noise grows with the error and would follow it.
  const bool plausible = (u.posterior.mean.cwiseAbs().array() <= bias_sigmas_max * prior_sigma.array()).all();
  if (u.verdict != Verdict::Accepted || !plausible) {
    ++bias.rejected_in_row;
    // What no bias explains is none: the radar follows something else.
    const Mat<3, 3> S = C * prior_bias().cov * C.transpose() + R_b;
    const bool explained = normalised_square<3>(z_b, S) <= gate3_;
    const bool due = explained && bias.rejected_in_row % settings_.arbitration.reopen_after == 0;
    if (due && bias.opening.open(plot.epoch, settings_.arbitration.reopen_after)) forget(bias);
    return;
  }
  bias.estimate = u.posterior;
  bias.updated = bias.samples > 0 ? std::max(bias.updated, plot.epoch) : plot.epoch;
  bias.rejected_in_row = 0;
  bias.opening.used(settings_.arbitration.reopen_after);
  ++bias.samples;
  if (settings_.cartesian_bias.window > 0) {
    bias.window[static_cast<std::size_t>(bias.next)] = bias.estimate.mean;
    bias.next = (bias.next + 1) % settings_.cartesian_bias.window;
    bias.windowed = std::min(bias.windowed + 1, settings_.cartesian_bias.window);
  }
}

Mat<6, 6> CartesianAlign::bias_process_noise(const RadarBias& bias, double dt) const {
  const double offset = settings_.cartesian_bias.offset_drift_m_sqrt_s;
  const double scale = settings_.cartesian_bias.scale_drift_sqrt_s;
  Vec<6> drift;
  drift << Vec<3>::Constant(offset * offset), Vec<3>::Constant(scale * scale);
  Mat<6, 6> Q = (drift * dt).asDiagonal();
  if (bias.windowed < 2) return Q;
  // (20): sample covariance of the last N estimates, as printed (ERRATA: it feeds on itself; window = 0 leaves it out).
  const auto n = static_cast<std::size_t>(bias.windowed);
  Vec<6> mean = Vec<6>::Zero();
  for (std::size_t i = 0; i < n; ++i) mean += bias.window[i];
  mean /= bias.windowed;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec<6> d = bias.window[i] - mean;
    Q += d * d.transpose() / bias.windowed;
  }
  return Q;
}

std::optional<TrackEstimate> CartesianAlign::gps_track(const State& state, int target, Time at) const {
  const GpsTrack& gps = state.gps[static_cast<std::size_t>(target)];
  if (!gps.reference.confirmed || !correct_) return std::nullopt;
  return estimate_at(gps.state, gps.epoch, at, settings_.cartesian_bias.gps_q_m2_s3);
}

BiasEstimate CartesianAlign::bias(const State& state, int radar) const {
  if (!correct_) return {};
  const RadarBias& bias = state.radars[static_cast<std::size_t>(radar)];
  BiasEstimate b;
  b.epoch = bias.epoch;
  b.samples = bias.samples;
  b.reference = bias.samples > 0 ? BiasReference::Gps : BiasReference::None;
  b.terms = 6;
  b.value.head<6>() = bias.estimate.mean;
  b.cov.topLeftCorner<6, 6>() = bias.estimate.cov;
  Vec<BiasEstimate::max_terms> prior = Vec<BiasEstimate::max_terms>::Zero();
  prior.head<3>().setConstant(settings_.cartesian_bias.offset_prior_m);
  prior.segment<3>(3).setConstant(settings_.cartesian_bias.scale_prior);
  for (int i = 0; i < 6; ++i) b.term[static_cast<std::size_t>(i)] = static_cast<BiasTerm>(i);
  // A plot that waits for fixes has not lost its reference.
  const auto refers = [&](const GpsTrack& gps) {
    return gps.reference.confirmed && bias.epoch - gps.epoch <= settings_.gps.max_age;
  };
  const bool referenced = settings_.gps.alignment.smooth ? std::ranges::any_of(state.gps, refers)
                                                         : bias.epoch - bias.updated <= settings_.gps.max_age;
  const bool frozen = bias.samples > 0 && !referenced;
  b.state = bias_states(b, prior, frozen);
  return b;
}

Gaussian<6> started_from(const TimedPosition& z, double sigma_velocity_m_s) {
  Gaussian<6> x;
  x.mean << z.z, Vec<3>::Zero();
  x.cov.setZero();
  x.cov.topLeftCorner<3, 3>() = z.R;
  x.cov.bottomRightCorner<3, 3>().diagonal().setConstant(sigma_velocity_m_s * sigma_velocity_m_s);
  return x;
}

TrackEstimate estimate_at(const Gaussian<6>& state, Time data_epoch, Time at, double q) {
  const Gaussian<6> x = at == data_epoch ? state : cv::predict(state, seconds_between(at, data_epoch), q);
  TrackEstimate e;
  e.epoch = at;
  e.data_epoch = data_epoch;
  e.mean.head<6>() = x.mean;
  e.cov.topLeftCorner<6, 6>() = x.cov;
  return e;
}

}  // namespace downrange
