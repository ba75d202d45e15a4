#pragma once
/// An estimate of many states of which each measurement touches two blocks: a target's motion and a radar's bias.
/// What method joint, schmidt and the bound are made of.

#include <array>
#include <cmath>
#include <downrange/est/filter/estimates.hpp>
#include <downrange/est/filter/gaussian.hpp>
#include <downrange/est/filter/low_rank.hpp>
#include <downrange/est/filter/model_set.hpp>
#include <downrange/est/filter/noise_scale.hpp>
#include <downrange/est/model/measurement.hpp>
#include <downrange/est/model/plot_model.hpp>
#include <downrange/est/model/sensors.hpp>
#include <limits>
#include <span>
#include <vector>

namespace downrange {

/// Mean and covariance of the whole state vector under one model of motion. Sized once: assigning does not allocate.
struct Hypothesis {
  Eigen::VectorXd x;
  Eigen::MatrixXd P;  ///< symmetric; states that are switched off have zero rows
};

/// A state vector, wherever it stands.
using StateRef = Eigen::Ref<const Eigen::VectorXd>;

/// Where one radar's bias stands in a state vector: its terms, then, where it wanders, its slow errors across and along
/// elevation, both on the sky: that of azimuth is the first over cos(elevation).
struct RadarBlock {
  static constexpr int max_size = bias_term_count + 2;

  int at = 0;
  int terms = 0;
  PointingWander wander{};
  std::array<BiasTerm, bias_term_count> term{};
  BiasModel model;

  [[nodiscard]] bool wanders() const { return wander.sigma_rad > 0; }
  [[nodiscard]] int size() const { return terms + (wanders() ? 2 : 0); }
  /// The bias in `x` indexed by BiasTerm; terms that are not there are zero. Slow angle errors are not in it.
  [[nodiscard]] Vec<bias_term_count> bias(const StateRef& x) const;
  /// The slow errors of azimuth and elevation (rad) in `x`, at that elevation: pointing errors are on the sky.
  [[nodiscard]] Vec<2> pointing_error(const StateRef& x, double elevation_rad) const;
  /// Both, the slow errors as offsets.
  [[nodiscard]] Vec<bias_term_count> bias_at(const StateRef& x, double elevation_rad) const;
  /// Where a term stands in the state vector; -1: the radar has none.
  [[nodiscard]] int place_of(BiasTerm wanted) const;
  /// 1-sigma of each term before any data.
  [[nodiscard]] Vec<BiasEstimate::max_terms> prior_sigma() const;
};

/// The blocks of all radars, one behind the other from `first` on.
struct BiasLayout {
  int first = 0;
  int size = 0;  ///< of all blocks
  std::vector<RadarBlock> radars;
  struct TimeTag {
    std::size_t radar = 0;
    int at = 0;           ///< in the state vector
    double variance = 0;  ///< of its prior, s^2
  };
  std::vector<TimeTag> time_tags;
};

[[nodiscard]] BiasLayout bias_layout(const std::vector<RadarModel>& radars, int first);
/// What a mount may wander until the first fix: its own, or the regime's where that is larger.
[[nodiscard]] PointingWander wander_without_gps(const PointingWander& own, const NoGpsRegime& regime);
/// What holds until the first fix: tight priors, no sez_offset, slow angle errors where angles are measured: the
/// radar's own or the regime's, whichever are larger.
[[nodiscard]] BiasLayout bias_layout_without_gps(const std::vector<RadarModel>& radars, const NoGpsRegime& regime,
                                                 int first);

/// Entries [at, at + size) as if nothing were known but mean and covariance given.
void reset_block(Hypothesis& h, int at, const Eigen::Ref<const Eigen::VectorXd>& mean,
                 const Eigen::Ref<const Eigen::MatrixXd>& cov);
void reset_bias(Hypothesis& h, const RadarBlock& block);
/// How far the radar's bias is from its prior's mean: chi2 with `block.terms` degrees of freedom of a bias that is as
/// the prior says, less of what is known of it.
[[nodiscard]] double prior_misfit(const Hypothesis& h, const RadarBlock& block);
/// A quarter of their prior covariance is added to the biases of the radars whose bits are set: a returning receiver
/// may show them to have been mistaken.
void loosen_biases(Hypothesis& h, const BiasLayout& layout, std::uint64_t radars);

/// Motion of the nine states from `at`, F P F' + Q by rows and columns: what is constant is never multiplied.
void predict_motion(Hypothesis& h, int at, const MotionModel& model, double dt);
/// First-order Gauss-Markov states [at, at + size) with stationary 1-sigma and correlation time.
void predict_gauss_markov(Hypothesis& h, int at, int size, double sigma, double tau_s, double dt);
/// Drift of the terms and of the slow angle errors.
void predict_bias(Hypothesis& h, const BiasLayout& layout, double dt);

/// Rows of a Jacobian that is zero outside the block of a motion and that of a radar.
template <int M>
struct BlockJacobian {
  int motion_at = 0;
  int motion_size = 9;                        ///< 9, or 12 where the errors of GPS follow
  Mat<M, 12> of_motion = Mat<M, 12>::Zero();  ///< the first motion_size columns count
  int radar_at = 0;
  int radar_size = 0;  ///< 0: no radar
  Mat<M, RadarBlock::max_size> of_radar = Mat<M, RadarBlock::max_size>::Zero();
};

/// Most states a hypothesis may have: what intermediate results on the stack are sized for.
inline constexpr int max_states = 1000;

template <int M>
using Columns = Eigen::Matrix<double, Eigen::Dynamic, M, 0, max_states, M>;

/// What a measurement says about a hypothesis before it is used.
template <int M>
struct Evidence {
  Vec<M> nu;        ///< measured minus predicted, angles wrapped
  Mat<M, M> S;      ///< H P H' + R
  Mat<M, M> L;      ///< its Cholesky factor, lower
  Columns<M> W;     ///< P H' L^-T: the gain is W L^-1
  Vec<M> whitened;  ///< L^-1 nu
  double nis = 0;
  double log_likelihood = -std::numeric_limits<double>::infinity();
  bool singular = true;
};

/// H X for any X of state size.
template <int M, class Matrix>
[[nodiscard]] Mat<M, Matrix::ColsAtCompileTime> observe(const BlockJacobian<M>& H, const Matrix& X) {
  Mat<M, Matrix::ColsAtCompileTime> HX =
      H.motion_size == 9 ? H.of_motion.template leftCols<9>().lazyProduct(X.template middleRows<9>(H.motion_at)).eval()
                         : H.of_motion.lazyProduct(X.template middleRows<12>(H.motion_at)).eval();
  if (H.radar_size > 0) HX += H.of_radar.leftCols(H.radar_size).lazyProduct(X.middleRows(H.radar_at, H.radar_size));
  return HX;
}

/// The rest of the evidence, from nu, S and, in W, P H'.
template <int M>
void factorise(Evidence<M>& e) {
  const Eigen::LLT<Mat<M, M>> llt(e.S);
  if (llt.info() != Eigen::Success) return;
  e.singular = false;
  e.L = llt.matrixL();
  e.whitened = llt.matrixL().solve(e.nu);
  e.nis = e.whitened.squaredNorm();
  e.log_likelihood = -e.nis / 2 - std::log(e.L.diagonal().prod());
  divide_by_transposed<Columns<M>, M>(e.W, e.L);
}

template <int M>
[[nodiscard]] Evidence<M> evidence_of(const Hypothesis& h, const BlockJacobian<M>& H, const Vec<M>& nu,
                                      const Mat<M, M>& R) {
  Evidence<M> e;
  e.nu = nu;
  e.W.resize(h.x.size(), M);
  if (H.motion_size == 9) {
    e.W = h.P.middleCols<9>(H.motion_at).lazyProduct(H.of_motion.template leftCols<9>().transpose());
  } else {
    e.W = h.P.middleCols<12>(H.motion_at).lazyProduct(H.of_motion.transpose());
  }
  if (H.radar_size > 0)
    e.W += h.P.middleCols(H.radar_at, H.radar_size).lazyProduct(H.of_radar.leftCols(H.radar_size).transpose());
  e.S = observe(H, e.W) + R;
  factorise(e);
  return e;
}

/// The Kalman gain, W L^-1.
template <int M>
[[nodiscard]] Columns<M> gain(const Evidence<M>& e) {
  Columns<M> K = e.W;
  divide_by<Columns<M>, M>(K, e.L);
  return K;
}

/// A fix of position, or position and velocity, of the motion whose nine states the three of the GPS error follow.
template <int M>
[[nodiscard]] BlockJacobian<M> fix_jacobian(int motion_at) {
  BlockJacobian<M> H{.motion_at = motion_at, .motion_size = 12};
  H.of_motion.template topLeftCorner<M, M>().setIdentity();
  H.of_motion.template topRightCorner<3, 3>().setIdentity();
  return H;
}
template <int M>
[[nodiscard]] Mat<M, M> fix_noise(const Fix& fix) {
  Mat<M, M> R = fix.sigma_velocity_m_s * fix.sigma_velocity_m_s * Mat<M, M>::Identity();
  R.template topLeftCorner<3, 3>() = fix_covariance(fix);
  return R;
}
template <int M>
[[nodiscard]] Vec<M> fix_residual(const Hypothesis& h, int motion_at, const Fix& fix) {
  Vec<M> z;
  z.template head<3>() = fix.position.m - h.x.segment<3>(motion_at + 9);
  if constexpr (M == 6) z.template tail<3>() = fix.velocity.m_s;
  return z - h.x.segment<M>(motion_at);
}

/// Kalman update: x + W L^-1 nu, P - W W'.
template <int M>
void apply_evidence(Hypothesis& h, const Evidence<M>& e) {
  h.x += e.W.lazyProduct(e.whitened);
  subtract_product(h.P, e.W, e.W);
}

/// The same but for `considered`, a part of the gain (of e.W): what it would have corrected keeps its mean and what is
/// known of it (Schmidt); only what it has in common with the rest changes.
template <int M>
void apply_evidence_but(const Columns<M>& considered, Hypothesis& h, const Evidence<M>& e) {
  h.x += (e.W - considered).lazyProduct(e.whitened);
  subtract_product(h.P, e.W, e.W);
  subtract_product(h.P, considered, -considered);
}

/// Jacobian and residual of M components of a plot for the motion at `motion_at` (nine states) and the bias block of
/// its radar.
template <int M>
struct Linearisation {
  BlockJacobian<M> H;
  Vec<M> nu;
};
using PlotLinearisation = Linearisation<3>;

/// The M components from First on.
template <int First, int M>
[[nodiscard]] Linearisation<M> components(const PlotLinearisation& plot) {
  Linearisation<M> l;
  l.nu = plot.nu.segment<M>(First);
  l.H.motion_at = plot.H.motion_at;
  l.H.motion_size = plot.H.motion_size;
  l.H.of_motion = plot.H.of_motion.middleRows<M>(First);
  l.H.radar_at = plot.H.radar_at;
  l.H.radar_size = plot.H.radar_size;
  l.H.of_radar = plot.H.of_radar.middleRows<M>(First);
  return l;
}

/// The noise of the M components from First on of a plot.
template <int First, int M>
[[nodiscard]] Mat<M, M> plot_noise(const RadarModel& radar, const Plot& plot) {
  return plot_variance(radar, plot).segment<M>(First).asDiagonal();
}

/// For the motion given (position, velocity, acceleration), which stands at `motion_at`, and the bias in `x`.
[[nodiscard]] PlotLinearisation linearise_plot(const Vec<9>& motion, int motion_at, const StateRef& x,
                                               const RadarModel& radar, const RadarBlock& block, const Polar& plot);
[[nodiscard]] PlotLinearisation linearise_plot(const Hypothesis& h, int motion_at, const MotionModel& model,
                                               const RadarModel& radar, const RadarBlock& block, const Polar& plot);

/// Whether a plot so far from the prediction bends more over that distance than a tenth of its noise: range over the
/// cross-range, the angles over both. `nu` (m, rad, rad): of range, azimuth and elevation, zero where one is not
/// measured; `variance` of their noise.
[[nodiscard]] bool bends(const Vec<3>& nu, const Vec<3>& variance, const Polar& plot);

/// M components of a plot from First on, linearised where state and plot agree best (iterated Kalman filter), for an
/// update from `h`: the prediction itself, unless the plot bends on the way there. A bias of hundreds of metres, seen
/// from near by, is met so: linearised at the prediction, the first plots would claim to know its range from its
/// angles.
template <int First, int M>
[[nodiscard]] Linearisation<M> linearise_components(const Hypothesis& h, int motion_at, const MotionModel& model,
                                                    const RadarModel& radar, const RadarBlock& block, const Polar& plot,
                                                    const Vec<M>& variance) {
  constexpr int most_iterations = 5;  // three settle all but a few in a thousand of 200 draws of 100 m at 2 km
  constexpr double settled = 0.01;    // sigmas of the innovation
  auto l = components<First, M>(linearise_plot(h, motion_at, model, radar, block, plot));
  Vec<3> nu = Vec<3>::Zero();
  Vec<3> all_variances = Vec<3>::Ones();
  nu.template segment<M>(First) = l.nu;
  all_variances.template segment<M>(First) = variance;
  if (!bends(nu, all_variances, plot)) return l;
  for (int i = 0; i < most_iterations; ++i) {
    const Evidence<M> e = evidence_of<M>(h, l.H, l.nu, Mat<M, M>(variance.asDiagonal()));
    if (e.singular) break;
    const Columns<1> step = e.W.lazyProduct(e.whitened);
    const Columns<1> x = h.x + step;
    Vec<9> motion = x.template segment<9>(motion_at);
    motion.tail<3>() = acceleration(model, motion);
    const Vec<M> before = l.nu;
    l = components<First, M>(linearise_plot(motion, motion_at, x, radar, block, plot));
    l.nu += observe(l.H, step);
    if (e.L.template triangularView<Eigen::Lower>().solve(Vec<M>(l.nu - before)).norm() < settled) break;
  }
  return l;
}

/// The same of its range rate.
[[nodiscard]] Linearisation<1> linearise_range_rate(const Hypothesis& h, int motion_at, const MotionModel& model,
                                                    const RadarModel& radar, const RadarBlock& block, const Plot& plot);

/// Several hypotheses under the models of a set, with their probabilities: interacting multiple models (Blom,
/// Bar-Shalom 1988) over the whole state vector.
struct Bank {
  int count = 1;
  std::array<Hypothesis, ModelSet::max_models> mode;
  Vec<ModelSet::max_models> probability = Vec<ModelSet::max_models>::UnitX();
};

/// A radar's bias may be anything again that its prior allows.
void open_bias(Bank& bank, const RadarBlock& block);

/// The three states from `at` on, of the mixture.
[[nodiscard]] Vec<3> combined_three(const Bank& bank, int at);
/// What to add to the covariance of a position so that another, `d` away, may be right as well (covariance union).
[[nodiscard]] Mat<3, 3> union_term(const Vec<3>& d);
/// The slow error of GPS at `error_at` is more than any receiver's: it is the motion, at `motion_at`, that may be so
/// far off. The error begins anew with `sigma_m`.
void give_error_to_motion(Bank& bank, int motion_at, int error_at, double sigma_m);

/// A motion made of a radar's plot alone is wrong by that radar's bias: the position gets what is not known of the
/// bias, and the covariance with it. Taken as independent, one target would claim to have learnt the offsets by its own
/// start.
void tie_to_bias(Hypothesis& h, int motion_at, const RadarModel& radar, const RadarBlock& block);

/// The motion of every model from a position, velocity and acceleration; a ballistic one's specific force is its prior.
void set_motion(Bank& bank, const ModelSet& set, int motion_at, const Gaussian<9>& motion);

/// One interaction with the given switching probabilities. `motion_at`: the nine states; a ballistic model takes over
/// position, velocity and biases of the others, while their specific force becomes its own prior. The position is known
/// less where the models' forces differ (est/THEORY.md, "merged onsets"). `scratch` has the size of the bank.
void mix(Bank& bank, const ModelSet& set, const Mat<3, 3>& switching, int motion_at, Bank& scratch);

/// The interactions due until `to`, on a grid of UTC (coarser after a long silence), each after `predict(grid
/// instant)`. `mixed` is the last one's instant.
template <class Predict>
void interact(Bank& bank, const ModelSet& set, int motion_at, Time& mixed, Time to, Bank& scratch,
              const Predict& predict) {
  constexpr Duration step = milliseconds(200);
  constexpr int most_steps = 300;
  if (bank.count == 1) return;
  const std::int64_t multiple = (to - mixed).ns / most_steps / step.ns + 1;
  const Duration grid{multiple * step.ns};
  const Mat<3, 3> switching = multiple == 1 ? set.switching : switching_over(set, grid.seconds());
  for (Time t = ceil_to_grid(mixed + Duration{1}, grid); t <= to; t = t + grid) {
    predict(t);
    mix(bank, set, switching, motion_at, scratch);
    mixed = t;
  }
}

/// Bayes on the probabilities.
void reweigh(Bank& bank, const Vec<ModelSet::max_models>& log_likelihoods);

/// What a measurement with this evidence tells of its noise: the mean over the hypotheses by the bank's probabilities,
/// which an accepted one has changed before.
template <int M>
[[nodiscard]] NoiseLesson<M> noise_lesson(const Bank& bank,
                                          const std::array<Evidence<M>, ModelSet::max_models>& evidence,
                                          Verdict verdict) {
  NoiseLesson<M> lesson{.verdict = verdict};
  for (int i = 0; i < bank.count; ++i) {
    const Evidence<M>& e = evidence[static_cast<std::size_t>(i)];
    lesson.excess += bank.probability[i] * (verdict == Verdict::Accepted ? noise_excess<M>(e.L, e.whitened)
                                                                         : Mat<M, M>(e.nu * e.nu.transpose() - e.S));
  }
  return lesson;
}

/// The most probable hypothesis.
[[nodiscard]] int likeliest(const Bank& bank);

/// Position, velocity, acceleration of the mixture after dt seconds, moment-matched.
[[nodiscard]] Gaussian<9> combined_motion(const Bank& bank, const ModelSet& set, int motion_at, double dt);
/// One radar's terms, values and covariance of the mixture; the rest of the estimate is the caller's.
[[nodiscard]] BiasEstimate combined_bias(const Bank& bank, const RadarBlock& block);

}  // namespace downrange
