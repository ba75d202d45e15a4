#include <algorithm>
#include <cmath>
#include <downrange/est/joint.hpp>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace downrange {
namespace {

constexpr double deg = std::numbers::pi / 180;

/// White jerk, m^2/s^5 (ALGORITHMS.md section 2, `ca`).
constexpr double q_jerk = 10;
/// Gauss-Markov error of the GPS position: 1-sigma and correlation time (section 4a: 2-3 m, 60-100 s, on the high
/// side).
constexpr double gps_error_sigma_m = 3;
constexpr double gps_error_tau_s = 80;
constexpr double initial_sigma_acceleration = 20;
/// Prior 1-sigma of a radar's block (section 3).
Vec<10> bias_prior() {
  Vec<10> sigma;
  sigma << 100, 0.2 * deg, 0.2 * deg, 1e-4, 1e-3, 1e-3, 100, 100, 100, 0.02;
  return sigma;
}
constexpr std::array<BiasTerm, Joint::radar_size> terms_of_block{
    BiasTerm::OffsetRange,  BiasTerm::OffsetAzimuth,  BiasTerm::OffsetElevation, BiasTerm::ScaleRange,
    BiasTerm::ScaleAzimuth, BiasTerm::ScaleElevation, BiasTerm::OffsetSouth,     BiasTerm::OffsetEast,
    BiasTerm::OffsetZenith, BiasTerm::TimeTag};

/// A Jacobian that is zero outside one target's and one radar's block.
template <int M>
struct BlockJacobian {
  int target_at = 0;
  Mat<M, Joint::target_size> of_target = Mat<M, Joint::target_size>::Zero();
  int radar_at = -1;  ///< -1: the measurement has no radar
  Mat<M, Joint::radar_size> of_radar = Mat<M, Joint::radar_size>::Zero();
};

/// Kalman update by blocks: H P H' and P H' touch the two blocks only, P loses W W' with W = P H' L^-T, S = L L'.
template <int M>
Outcome update(Joint::State& s, const BlockJacobian<M>& H, const Vec<M>& nu, const Mat<M, M>& R, double gate,
               SourceAccount& account) {
  using Columns = Eigen::Matrix<double, Eigen::Dynamic, M, 0, Joint::max_states, M>;
  Columns PHt = s.P.middleCols<Joint::target_size>(H.target_at) * H.of_target.transpose();
  if (H.radar_at >= 0) PHt.noalias() += s.P.middleCols<Joint::radar_size>(H.radar_at) * H.of_radar.transpose();
  Mat<M, M> S = H.of_target * PHt.template middleRows<Joint::target_size>(H.target_at) + R;
  if (H.radar_at >= 0) S += H.of_radar * PHt.template middleRows<Joint::radar_size>(H.radar_at);

  const Eigen::LLT<Mat<M, M>> llt(S);
  if (llt.info() != Eigen::Success) return {.verdict = Verdict::Singular, .nis = 0, .dof = M};
  const Vec<M> whitened = llt.matrixL().solve(nu);
  const Outcome outcome{.verdict = whitened.squaredNorm() <= gate ? Verdict::Accepted : Verdict::Gated,  // NaN is gated
                        .nis = whitened.squaredNorm(),
                        .dof = M};
  if (outcome.verdict != Verdict::Accepted) return outcome;
  const Columns W = llt.matrixL().solve(PHt.transpose()).transpose();
  s.x += W * whitened;
  s.P.selfadjointView<Eigen::Lower>().rankUpdate(W, -1.0);
  s.P.triangularView<Eigen::StrictlyUpper>() = s.P.transpose();
  const Vec<M> normalised = nu.cwiseQuotient(S.diagonal().cwiseSqrt());
  account.residual.add(normalised.mean(), normalised.squaredNorm() / M, outcome.nis / M);
  return outcome;
}

/// Blocks of the white-jerk process noise over dt, each times I3, (position, velocity, acceleration) squared.
Mat<3, 3> jerk_noise(double dt) {
  const double d2 = dt * dt;
  const double d3 = d2 * dt;
  Mat<3, 3> Q;
  Q << d3 * d2 / 20, d2 * d2 / 8, d3 / 6,  //
      d2 * d2 / 8, d3 / 3, d2 / 2,         //
      d3 / 6, d2 / 2, dt;
  return q_jerk * Q;
}

}  // namespace

Joint::Joint(MethodSettings settings)
    : settings_(std::move(settings)),
      gate3_(chi2_quantile(settings_.gate_probability, 3)),
      gate6_(chi2_quantile(settings_.gate_probability, 6)) {
  if (settings_.targets > max_targets || settings_.radars.size() > max_radars)
    throw std::invalid_argument("method joint takes at most " + std::to_string(max_targets) + " targets and " +
                                std::to_string(max_radars) + " radars");
}

Joint::State Joint::initial() const {
  State s;
  const int radars = static_cast<int>(settings_.radars.size());
  const int n = radar_at(radars);
  s.x = Eigen::VectorXd::Zero(n);
  s.P = Eigen::MatrixXd::Zero(n, n);
  s.targets.resize(static_cast<std::size_t>(settings_.targets));
  for (Target& target : s.targets) target.contributed.fill(Time{std::numeric_limits<std::int64_t>::min() / 2});
  s.radars.resize(settings_.radars.size());
  for (int i = 0; i < radars; ++i) open_radar(s, i);
  s.accounts.resize(settings_.radars.size() + static_cast<std::size_t>(settings_.stations));
  return s;
}

int Joint::source_of(const Measurement& m) const {
  return m.kind == Measurement::Kind::Gps ? static_cast<int>(settings_.radars.size()) + m.source : m.source;
}

void Joint::open_radar(State& s, int radar) const {
  const int r = radar_at(radar);
  s.x.segment<radar_size>(r).setZero();
  s.P.middleRows<radar_size>(r).setZero();
  s.P.middleCols<radar_size>(r).setZero();
  s.P.diagonal().segment<radar_size>(r) = bias_prior().cwiseAbs2();
}

void Joint::start(State& s, int target, Time epoch, const Gaussian<9>& estimate) const {
  const int k = target_at(target);
  s.started = true;
  s.epoch = epoch;
  s.targets[static_cast<std::size_t>(target)].started = true;
  s.targets[static_cast<std::size_t>(target)].data_epoch = epoch;
  s.x.segment<9>(k) = estimate.mean;
  s.P.block<9, 9>(k, k) = estimate.cov;
  s.P.block<3, 3>(k + 9, k + 9).diagonal().setConstant(gps_error_sigma_m * gps_error_sigma_m);
}

Outcome Joint::apply(State& s, const Measurement& m) const {
  if (!s.started) s.epoch = m.epoch;
  s.started = true;
  predict(s, m.epoch);

  const bool gps = m.kind == Measurement::Kind::Gps;
  Target& target = s.targets[static_cast<std::size_t>(m.target)];
  Outcome outcome;
  if (!target.started) {
    start_target(s, m);
  } else {
    outcome = gps ? apply_fix(s, m) : apply_plot(s, m);
  }
  const int k = target_at(m.target);
  if (gps) remember(target.last_fix, m, s.x.segment<3>(k + 3), s.P.block<3, 3>(k + 3, k + 3));
  SourceAccount& account = s.accounts[static_cast<std::size_t>(source_of(m))];
  count(account, outcome.verdict);
  if (outcome.verdict != Verdict::Accepted) {
    after_rejection(s, m, outcome.verdict);
    return outcome;
  }

  target.data_epoch = m.epoch;
  target.nis = outcome.nis;
  target.nis_dof = outcome.dof;
  if (gps) {
    target.fixes_rejected_in_row = 0;
    s.last_fix = m.epoch;
    return outcome;
  }
  target.plots_rejected_in_row = 0;
  target.contributed[static_cast<std::size_t>(m.source)] = m.epoch;
  Radar& radar = s.radars[static_cast<std::size_t>(m.source)];
  radar.epoch = m.epoch;
  ++radar.samples;
  if (s.last_fix && m.epoch - *s.last_fix <= settings_.gps_max_age) {
    radar.referenced = true;
    radar.updated = m.epoch;
  }
  return outcome;
}

void Joint::after_rejection(State& s, const Measurement& m, Verdict verdict) const {
  Target& target = s.targets[static_cast<std::size_t>(m.target)];
  const SourceAccount& account = s.accounts[static_cast<std::size_t>(source_of(m))];
  if (m.kind == Measurement::Kind::Gps) {
    const bool insists = verdict != Verdict::Frozen && ++target.fixes_rejected_in_row >= gps_restart_after;
    if (insists) start_target(s, m);
  } else if (++target.plots_rejected_in_row >= settings_.reopen_after) {
    start_target(s, m);  // no radar was accepted for so long: the track is lost, not the radars
  } else if (account.rejected_in_row % settings_.reopen_after == 0) {
    open_radar(s, m.source);  // this radar alone disagrees: its bias is opened again
  }
}

void Joint::predict(State& s, Time t) const {
  const double dt = (t - s.epoch).seconds();
  s.epoch = t;
  if (dt <= 0) return;
  const double h = dt * dt / 2;
  const double phi = std::exp(-dt / gps_error_tau_s);
  const Mat<3, 3> Q = jerk_noise(dt);
  for (int i = 0; i < settings_.targets; ++i) {
    if (!s.targets[static_cast<std::size_t>(i)].started) continue;
    const int k = target_at(i);
    s.x.segment<3>(k) += dt * s.x.segment<3>(k + 3) + h * s.x.segment<3>(k + 6);
    s.x.segment<3>(k + 3) += dt * s.x.segment<3>(k + 6);
    s.x.segment<3>(k + 9) *= phi;
    // F P F' by rows, then by columns: the blocks of biases and other targets are constant and never multiplied.
    s.P.middleRows<3>(k) += dt * s.P.middleRows<3>(k + 3) + h * s.P.middleRows<3>(k + 6);
    s.P.middleRows<3>(k + 3) += dt * s.P.middleRows<3>(k + 6);
    s.P.middleRows<3>(k + 9) *= phi;
    s.P.middleCols<3>(k) += dt * s.P.middleCols<3>(k + 3) + h * s.P.middleCols<3>(k + 6);
    s.P.middleCols<3>(k + 3) += dt * s.P.middleCols<3>(k + 6);
    s.P.middleCols<3>(k + 9) *= phi;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column)
        s.P.block<3, 3>(k + 3 * row, k + 3 * column).diagonal().array() += Q(row, column);
    }
    s.P.block<3, 3>(k + 9, k + 9).diagonal().array() += gps_error_sigma_m * gps_error_sigma_m * (1 - phi * phi);
  }
}

void Joint::start_target(State& s, const Measurement& m) const {
  const int k = target_at(m.target);
  Target& target = s.targets[static_cast<std::size_t>(m.target)];
  target.started = true;
  target.data_epoch = m.epoch;
  target.plots_rejected_in_row = 0;
  target.fixes_rejected_in_row = 0;

  s.x.segment<target_size>(k).setZero();
  s.P.middleRows<target_size>(k).setZero();
  s.P.middleCols<target_size>(k).setZero();
  const double any_velocity = settings_.initial_sigma_velocity_m_s * settings_.initial_sigma_velocity_m_s;
  double velocity_variance = any_velocity;
  if (m.kind == Measurement::Kind::Gps) {
    s.x.segment<3>(k) = m.position.m;
    const double sigma = std::max(m.sigma_horizontal_m, m.sigma_vertical_m);
    s.P.block<3, 3>(k, k).diagonal().setConstant(sigma * sigma + gps_error_sigma_m * gps_error_sigma_m);
    if (m.velocity_valid && settings_.gps_use_velocity) {
      s.x.segment<3>(k + 3) = m.velocity.m_s;
      velocity_variance = m.sigma_velocity_m_s * m.sigma_velocity_m_s;
    }
  } else {
    const RadarModel& radar = settings_.radars[static_cast<std::size_t>(m.source)];
    const ConvertedMeasurement converted = convert_unbiased(m.plot, radar.sigma);
    // The radar's bias is not known yet: it is part of what the first position may be wrong by.
    const Mat<3, 3> J = d_enu_d_polar(m.plot);
    const Vec<10> sigma = bias_prior();
    const Mat<3, 3> from_bias = J * sigma.head<3>().cwiseAbs2().asDiagonal() * J.transpose() +
                                Mat<3, 3>(sigma.segment<3>(6).cwiseAbs2().asDiagonal());
    const Mat<3, 3> R_ecef_enu = radar.site.R_enu_ecef().R.transpose();
    s.x.segment<3>(k) = radar.site.ecef_of(converted.z).m;
    s.P.block<3, 3>(k, k) = R_ecef_enu * (converted.R + from_bias) * R_ecef_enu.transpose();
  }
  s.P.block<3, 3>(k + 3, k + 3).diagonal().setConstant(velocity_variance);
  s.P.block<3, 3>(k + 6, k + 6).diagonal().setConstant(initial_sigma_acceleration * initial_sigma_acceleration);
  s.P.block<3, 3>(k + 9, k + 9).diagonal().setConstant(gps_error_sigma_m * gps_error_sigma_m);
}

Outcome Joint::apply_fix(State& s, const Measurement& m) const {
  const int k = target_at(m.target);
  const Target& target = s.targets[static_cast<std::size_t>(m.target)];
  SourceAccount& account = s.accounts[static_cast<std::size_t>(source_of(m))];
  if (is_frozen(m, target.last_fix)) return {.verdict = Verdict::Frozen, .nis = 0, .dof = 3};
  const Mat<3, 3> R_position = fix_covariance(m);
  const Vec<3> nu_position = m.position.m - s.x.segment<3>(k) - s.x.segment<3>(k + 9);
  if (!m.velocity_valid || !settings_.gps_use_velocity) {
    BlockJacobian<3> H{.target_at = k};
    H.of_target.leftCols<3>().setIdentity();
    H.of_target.rightCols<3>().setIdentity();
    return update<3>(s, H, nu_position, R_position, gate3_, account);
  }
  BlockJacobian<6> H{.target_at = k};
  H.of_target.topLeftCorner<3, 3>().setIdentity();
  H.of_target.topRightCorner<3, 3>().setIdentity();
  H.of_target.block<3, 3>(3, 3).setIdentity();
  Vec<6> nu;
  nu << nu_position, m.velocity.m_s - s.x.segment<3>(k + 3);
  Mat<6, 6> R = Mat<6, 6>::Zero();
  R.topLeftCorner<3, 3>() = R_position;
  R.bottomRightCorner<3, 3>().diagonal().setConstant(m.sigma_velocity_m_s * m.sigma_velocity_m_s);
  return update<6>(s, H, nu, R, gate6_, account);
}

Outcome Joint::apply_plot(State& s, const Measurement& m) const {
  const int k = target_at(m.target);
  const int r = radar_at(m.source);
  const RadarModel& radar = settings_.radars[static_cast<std::size_t>(m.source)];
  const Vec<3> offset = s.x.segment<3>(r);
  const Vec<3> scale = s.x.segment<3>(r + 3);
  const Vec<3> sez_offset = s.x.segment<3>(r + 6);
  const double tau = s.x[r + 9];

  // The plot stamped t was true at t - tau; the site's offset displaces the target in the site's axes.
  const Vec<3> a = s.x.segment<3>(k + 6);
  const Vec<3> v = s.x.segment<3>(k + 3) - tau * a;
  const Vec<3> p = s.x.segment<3>(k) - tau * s.x.segment<3>(k + 3) + tau * tau / 2 * a;
  const Mat<3, 3>& R_enu_ecef = radar.site.R_enu_ecef().R;
  const Mat<3, 3> R_enu_sez = sez_from_enu().R.transpose();
  const Displacement<Enu> d{radar.site.enu_of({p}).m + R_enu_sez * sez_offset};
  const Polar q = polar_from_enu(d);
  const Vec<3> scaled(q.range_m, wrap_pi(q.azimuth_rad - std::numbers::pi), q.elevation_rad);

  const Vec<3> bias = offset + scale.cwiseProduct(scaled);
  const Vec<3> nu(m.plot.range_m - q.range_m - bias[0], wrap_pi(m.plot.azimuth_rad - q.azimuth_rad - bias[1]),
                  m.plot.elevation_rad - q.elevation_rad - bias[2]);

  const Mat<3, 3> J = (Vec<3>::Ones() + scale).asDiagonal() * d_polar_d_enu(d);
  const Mat<3, 3> J_ecef = J * R_enu_ecef;
  BlockJacobian<3> H{.target_at = k, .of_target = {}, .radar_at = r, .of_radar = {}};
  H.of_target << J_ecef, -tau * J_ecef, tau * tau / 2 * J_ecef, Mat<3, 3>::Zero();
  H.of_radar << Mat<3, 3>::Identity(), Mat<3, 3>(scaled.asDiagonal()), J * R_enu_sez, -J_ecef * v;
  const Vec<3> sigma(radar.sigma.range_m, radar.sigma.azimuth_rad, radar.sigma.elevation_rad);
  return update<3>(s, H, nu, sigma.cwiseAbs2().asDiagonal(), gate3_,
                   s.accounts[static_cast<std::size_t>(source_of(m))]);
}

Gaussian<9> Joint::kinematics(const State& state, int target, double dt) const {
  const int k = target_at(target);
  Mat<9, 9> F = Mat<9, 9>::Identity();
  F.block<3, 3>(0, 3).diagonal().setConstant(dt);
  F.block<3, 3>(3, 6).diagonal().setConstant(dt);
  F.block<3, 3>(0, 6).diagonal().setConstant(dt * dt / 2);
  // Backwards, odd powers of dt change sign.
  Mat<3, 3> Q = jerk_noise(std::abs(dt));
  if (dt < 0) Q(0, 1) = Q(1, 0) = -Q(0, 1), Q(1, 2) = Q(2, 1) = -Q(1, 2);
  Gaussian<9> x;
  x.mean = F * state.x.segment<9>(k);
  x.cov = F * state.P.block<9, 9>(k, k) * F.transpose();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      x.cov.block<3, 3>(3 * row, 3 * column).diagonal().array() += Q(row, column);
  }
  return x;
}

BiasEstimate Joint::describe(const State& state, int radar) const {
  const Radar& r = state.radars[static_cast<std::size_t>(radar)];
  const int at = radar_at(radar);
  BiasEstimate b;
  b.epoch = r.epoch;
  b.samples = r.samples;
  b.reference = r.referenced ? BiasReference::Gps : BiasReference::None;
  b.terms = radar_size;
  std::copy(terms_of_block.begin(), terms_of_block.end(), b.term.begin());
  b.value.head<radar_size>() = state.x.segment<radar_size>(at);
  b.cov.topLeftCorner<radar_size, radar_size>() = state.P.block<radar_size, radar_size>(at, at);
  const bool frozen = r.referenced && r.epoch - r.updated > settings_.gps_max_age;
  Vec<BiasEstimate::max_terms> prior = Vec<BiasEstimate::max_terms>::Zero();
  prior.head<radar_size>() = bias_prior();
  b.state = bias_states(b, prior, frozen);
  return b;
}

}  // namespace downrange
