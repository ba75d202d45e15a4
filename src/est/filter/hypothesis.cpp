#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <downrange/est/filter/hypothesis.hpp>
#include <downrange/est/filter/imm.hpp>
#include <downrange/geo/earth.hpp>

namespace downrange {
namespace {

RadarBlock block_of(const BiasModel& model, const PointingWander& wander, int at) {
  RadarBlock block;
  block.at = at;
  block.wander = wander;
  block.terms = static_cast<int>(model.terms.size());
  std::ranges::copy(model.terms, block.term.begin());
  block.model = model;
  return block;
}

Eigen::Index index(BiasTerm term) { return static_cast<Eigen::Index>(term); }

/// Of the terms of a bias, without the slow pointing errors that may follow them.
struct BlockPrior {
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, bias_term_count, 1> mean;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, bias_term_count, bias_term_count> cov;
};
BlockPrior prior_of(const RadarBlock& block) {
  BlockPrior prior;
  prior.mean.resize(block.terms);
  prior.cov.resize(block.terms, block.terms);
  for (int i = 0; i < block.terms; ++i) {
    const Eigen::Index k = index(block.term[static_cast<std::size_t>(i)]);
    prior.mean[i] = block.model.prior_mean[k];
    for (int j = 0; j < block.terms; ++j)
      prior.cov(i, j) = block.model.prior_cov(k, index(block.term[static_cast<std::size_t>(j)]));
  }
  return prior;
}

/// What is symmetric but for rounding, to the bit: nothing later mends it.
template <class Square>
void mirror(Square&& P) {
  P.template triangularView<Eigen::StrictlyUpper>() = P.transpose();
}

}  // namespace

Vec<bias_term_count> RadarBlock::bias(const StateRef& x) const {
  Vec<bias_term_count> b = Vec<bias_term_count>::Zero();
  for (int i = 0; i < terms; ++i) b[index(term[static_cast<std::size_t>(i)])] = x[at + i];
  return b;
}

Vec<2> RadarBlock::pointing_error(const StateRef& x, double elevation_rad) const {
  if (!wanders()) return Vec<2>::Zero();
  return {azimuth_of_sky_angle(elevation_rad) * x[at + terms], x[at + terms + 1]};
}

Vec<bias_term_count> RadarBlock::bias_at(const StateRef& x, double elevation_rad) const {
  Vec<bias_term_count> b = bias(x);
  b.segment<2>(index(BiasTerm::OffsetAzimuth)) += pointing_error(x, elevation_rad);
  return b;
}

Vec<BiasEstimate::max_terms> RadarBlock::prior_sigma() const {
  Vec<BiasEstimate::max_terms> sigma = Vec<BiasEstimate::max_terms>::Zero();
  for (int i = 0; i < terms; ++i) {
    const Eigen::Index k = index(term[static_cast<std::size_t>(i)]);
    sigma[i] = std::sqrt(model.prior_cov(k, k));
  }
  return sigma;
}

int RadarBlock::place_of(BiasTerm wanted) const {
  for (int i = 0; i < terms; ++i) {
    if (term[static_cast<std::size_t>(i)] == wanted) return at + i;
  }
  return -1;
}

static void append(BiasLayout& layout, const RadarBlock& block) {
  const int tag = block.place_of(BiasTerm::TimeTag);
  const double variance = block.model.prior_cov(index(BiasTerm::TimeTag), index(BiasTerm::TimeTag));
  if (tag >= 0 && variance > 0)
    layout.time_tags.push_back({.radar = layout.radars.size(), .at = tag, .variance = variance});
  layout.radars.push_back(block);
  layout.size += block.size();
}

BiasLayout bias_layout(const std::vector<RadarModel>& radars, int first) {
  BiasLayout layout{.first = first, .size = 0, .radars = {}, .time_tags = {}};
  for (const RadarModel& radar : radars) {
    append(layout, block_of(radar.bias, radar.wander, first + layout.size));
  }
  return layout;
}

PointingWander wander_without_gps(const PointingWander& own, const NoGpsRegime& regime) {
  return own.sigma_rad > regime.wander.sigma_rad ? own : regime.wander;
}

BiasLayout bias_layout_without_gps(const std::vector<RadarModel>& radars, const NoGpsRegime& regime, int first) {
  BiasLayout layout{.first = first, .size = 0, .radars = {}, .time_tags = {}};
  const auto tighten = [](BiasModel& model, BiasTerm term, double sigma) {
    const Eigen::Index k = index(term);
    if (model.prior_cov(k, k) <= sigma * sigma) return;
    const double factor = sigma / std::sqrt(model.prior_cov(k, k));
    model.prior_cov.row(k) *= factor;
    model.prior_cov.col(k) *= factor;
  };
  for (const RadarModel& radar : radars) {
    BiasModel model = radar.bias;
    std::erase_if(model.terms, [](BiasTerm term) { return term <= BiasTerm::OffsetZenith; });
    tighten(model, BiasTerm::OffsetRange, regime.offset_prior_m);
    tighten(model, BiasTerm::OffsetAzimuth, regime.angle_prior_rad);
    tighten(model, BiasTerm::OffsetElevation, regime.angle_prior_rad);
    // A quarter of the default priors: an azimuth scale of 1e-3 about south is 0.14 deg at a launch to the north-east.
    tighten(model, BiasTerm::ScaleRange, 2.5e-5);
    tighten(model, BiasTerm::ScaleAzimuth, 2.5e-4);
    tighten(model, BiasTerm::ScaleElevation, 2.5e-4);
    PointingWander wander = wander_without_gps(radar.wander, regime);
    if (radar.sigma.azimuth_rad == 0) wander = {};
    append(layout, block_of(model, wander, first + layout.size));
  }
  return layout;
}

void reset_block(Hypothesis& h, int at, const Eigen::Ref<const Eigen::VectorXd>& mean,
                 const Eigen::Ref<const Eigen::MatrixXd>& cov) {
  const Eigen::Index n = mean.size();
  h.x.segment(at, n) = mean;
  h.P.middleRows(at, n).setZero();
  h.P.middleCols(at, n).setZero();
  h.P.block(at, at, n, n) = cov.selfadjointView<Eigen::Lower>();
}

void reset_bias(Hypothesis& h, const RadarBlock& block) {
  const BlockPrior prior = prior_of(block);
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(block.size());
  Eigen::MatrixXd cov = Eigen::MatrixXd::Zero(block.size(), block.size());
  mean.head(block.terms) = prior.mean;
  cov.topLeftCorner(block.terms, block.terms) = prior.cov;
  if (block.wanders()) cov.diagonal().tail<2>().setConstant(block.wander.sigma_rad * block.wander.sigma_rad);
  reset_block(h, block.at, mean, cov);
}

double prior_misfit(const Hypothesis& h, const RadarBlock& block) {
  const BlockPrior prior = prior_of(block);
  decltype(prior.mean) away = h.x.segment(block.at, block.terms);
  away -= prior.mean;
  return away.dot(prior.cov.llt().solve(away));
}

void loosen_biases(Hypothesis& h, const BiasLayout& layout, std::uint64_t radars) {
  for (std::size_t radar = 0; radar < layout.radars.size(); ++radar) {
    const RadarBlock& block = layout.radars[radar];
    if ((radars >> radar & 1) != 0) h.P.block(block.at, block.at, block.terms, block.terms) += prior_of(block).cov / 4;
  }
}

void predict_motion(Hypothesis& h, int at, const MotionModel& model, double dt) {
  h.x.segment<9>(at) = predict_mean(model, h.x.segment<9>(at), dt);
  const double half = dt * dt / 2;
  Eigen::MatrixXd& P = h.P;
  P.middleCols<3>(at) += dt * P.middleCols<3>(at + 3) + half * P.middleCols<3>(at + 6);
  P.middleCols<3>(at + 3) += dt * P.middleCols<3>(at + 6);
  // The rows of the other states are the transposed columns just made; within the block F acts from the left as well.
  P.block<3, 9>(at, at) += dt * P.block<3, 9>(at + 3, at) + half * P.block<3, 9>(at + 6, at);
  P.block<3, 9>(at + 3, at) += dt * P.block<3, 9>(at + 6, at);
  const Mat<3, 3> Q = process_noise(model, dt);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      P.block<3, 3>(at + 3 * row, at + 3 * column).diagonal().array() += Q(row, column);
  }
  mirror(P.block<9, 9>(at, at));
  const Eigen::Index before = at;
  const Eigen::Index after = P.rows() - at - 9;
  P.block(at, 0, 9, before) = P.block(0, at, before, 9).transpose();
  P.block(at, at + 9, 9, after) = P.block(at + 9, at, after, 9).transpose();
}

void predict_gauss_markov(Hypothesis& h, int at, int size, double sigma, double tau_s, double dt) {
  const double phi = std::exp(-std::abs(dt) / tau_s);
  h.x.segment(at, size) *= phi;
  h.P.middleRows(at, size) *= phi;
  h.P.middleCols(at, size) *= phi;
  h.P.block(at, at, size, size).diagonal().array() += sigma * sigma * (1 - phi * phi);
}

void predict_bias(Hypothesis& h, const BiasLayout& layout, double dt) {
  for (const RadarBlock& block : layout.radars) {
    for (int i = 0; i < block.terms; ++i) {
      const double drift = block.model.drift[index(block.term[static_cast<std::size_t>(i)])];
      h.P(block.at + i, block.at + i) += drift * drift * dt;
    }
    if (block.wanders())
      predict_gauss_markov(h, block.at + block.terms, 2, block.wander.sigma_rad, block.wander.tau_s, dt);
  }
}

PlotLinearisation linearise_plot(const Hypothesis& h, int motion_at, const MotionModel& model, const RadarModel& radar,
                                 const RadarBlock& block, const Polar& plot) {
  Vec<9> motion = h.x.segment<9>(motion_at);
  motion.tail<3>() = acceleration(model, motion);
  return linearise_plot(motion, motion_at, h.x, radar, block, plot);
}

PlotLinearisation linearise_plot(const Vec<9>& motion, int motion_at, const StateRef& x, const RadarModel& radar,
                                 const RadarBlock& block, const Polar& plot) {
  const PredictedPlot predicted = predict_plot(radar, motion, block.bias(x));
  PlotLinearisation l;
  Vec<3> q = predicted.q;
  q.tail<2>() += block.pointing_error(x, predicted.q[2]);
  l.nu = plot_residual(plot, q);
  l.H.motion_at = motion_at;
  l.H.of_motion.leftCols<9>() = predicted.d_motion;
  l.H.radar_at = block.at;
  l.H.radar_size = block.size();
  for (int i = 0; i < block.terms; ++i)
    l.H.of_radar.col(i) = predicted.d_bias.col(index(block.term[static_cast<std::size_t>(i)]));
  if (block.wanders()) {
    l.H.of_radar(1, block.terms) = azimuth_of_sky_angle(predicted.q[2]);
    l.H.of_radar(2, block.terms + 1) = 1;
  }
  return l;
}

bool bends(const Vec<3>& nu, const Vec<3>& variance, const Polar& plot) {
  constexpr double share = 0.1;
  const double across = std::hypot(nu[1] * std::cos(plot.elevation_rad), nu[2]);
  const double of_range = plot.range_m * across * across / 2;
  const double along = plot.range_m > 0 ? std::abs(nu[0]) / plot.range_m : 0;
  const double of_angles = across * (along + across * std::abs(std::tan(plot.elevation_rad)));
  return of_range > share * std::sqrt(variance[0]) || of_angles > share * std::sqrt(variance[2]);
}

Linearisation<1> linearise_range_rate(const Hypothesis& h, int motion_at, const MotionModel& model,
                                      const RadarModel& radar, const RadarBlock& block, const Plot& plot) {
  Vec<9> motion = h.x.segment<9>(motion_at);
  motion.tail<3>() = acceleration(model, motion);
  const PredictedRangeRate predicted = predict_range_rate(radar, motion, block.bias(h.x));
  Linearisation<1> l;
  l.nu[0] = plot.range_rate_m_s - predicted.m_s;
  l.H.motion_at = motion_at;
  l.H.of_motion.leftCols<9>() = predicted.d_motion;
  l.H.radar_at = block.at;
  l.H.radar_size = block.size();
  for (int i = 0; i < block.terms; ++i)
    l.H.of_radar[i] = predicted.d_bias[index(block.term[static_cast<std::size_t>(i)])];
  return l;
}

void open_bias(Bank& bank, const RadarBlock& block) {
  for (int i = 0; i < bank.count; ++i) reset_bias(bank.mode[static_cast<std::size_t>(i)], block);
}

Vec<3> combined_three(const Bank& bank, int at) {
  Vec<3> mean = Vec<3>::Zero();
  for (int i = 0; i < bank.count; ++i)
    mean += bank.probability[i] * bank.mode[static_cast<std::size_t>(i)].x.segment<3>(at);
  return mean;
}

Mat<3, 3> union_term(const Vec<3>& d) { return d * d.transpose() + d.squaredNorm() / 3 * Mat<3, 3>::Identity(); }

void give_error_to_motion(Bank& bank, int motion_at, int error_at, double sigma_m) {
  for (int i = 0; i < bank.count; ++i) {
    Hypothesis& h = bank.mode[static_cast<std::size_t>(i)];
    h.P.block<3, 3>(motion_at, motion_at) += union_term(h.x.segment<3>(error_at));
    reset_block(h, error_at, Vec<3>::Zero(), sigma_m * sigma_m * Mat<3, 3>::Identity());
  }
}

void tie_to_bias(Hypothesis& h, int motion_at, const RadarModel& radar, const RadarBlock& block) {
  // h(p, b) = q: dp/db = -(dh/dp)^-1 dh/db. At the radar's own place, and straight above it, dh/dp says nothing.
  const PlotLinearisation l = linearise_plot(h, motion_at, MotionModel{}, radar, block, Polar{});
  const Eigen::FullPivLU<Mat<3, 3>> by_position(l.H.of_motion.leftCols<3>());
  if (!by_position.isInvertible()) return;
  const Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, RadarBlock::max_size> dp_db =
      -by_position.solve(l.H.of_radar.leftCols(block.size()));
  h.P.middleRows<3>(motion_at) += dp_db * h.P.middleRows(block.at, block.size());
  h.P.middleCols<3>(motion_at) += h.P.middleCols(block.at, block.size()) * dp_db.transpose();
  mirror(h.P);
  // Where the target was within a time tag of unknown size, at a velocity that is not known either.
  const int tag = block.place_of(BiasTerm::TimeTag);
  if (tag >= 0) h.P.block<3, 3>(motion_at, motion_at) += h.P(tag, tag) * h.P.block<3, 3>(motion_at + 3, motion_at + 3);
}

void set_motion(Bank& bank, const ModelSet& set, int motion_at, const Gaussian<9>& motion) {
  for (int i = 0; i < bank.count; ++i) {
    const MotionModel& model = set.model[static_cast<std::size_t>(i)];
    Gaussian<9> own = motion;
    const auto third_part_is = [&own](double variance) {
      own.mean.tail<3>().setZero();
      own.cov.bottomRows<3>().setZero();
      own.cov.rightCols<3>().setZero();
      own.cov.diagonal().tail<3>().setConstant(variance);
    };
    if (model.gravity_aware)
      own.mean.tail<3>() -= free_fall_acceleration({own.mean.head<3>()}, {own.mean.segment<3>(3)});
    if (model.noise == MotionModel::Noise::WhiteAcceleration) third_part_is(0);
    if (i == set.ballistic) third_part_is(set.ballistic_sigma_m_s2 * set.ballistic_sigma_m_s2);
    reset_block(bank.mode[static_cast<std::size_t>(i)], motion_at, own.mean, own.cov);
  }
}

namespace {

/// What merging leaves out of the position's covariance (est/THEORY.md section 2, "merged onsets"). `apart`: of each
/// model from the merged mean, times the root of its weight.
Mat<3, 3> onset_unseen(const std::array<Columns<1>, ModelSet::max_models>& apart, int count, Eigen::Index force_at) {
  constexpr double unseen_s = 1;  // until the next fix tells the velocity
  constexpr double metres_per_force = unseen_s * unseen_s / 12;
  constexpr double mixings = 2;  // the next one keeps about half
  Mat<3, 3> cov = Mat<3, 3>::Zero();
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const Vec<3> force = apart[i].segment<3>(force_at);
    cov += force * force.transpose();
  }
  return mixings * metres_per_force * metres_per_force * cov;
}

}  // namespace

void mix(Bank& bank, const ModelSet& set, const Mat<3, 3>& switching, int motion_at, Bank& scratch) {
  if (bank.count == 1) return;
  const Eigen::Index n = bank.mode[0].x.size();
  const int force_at = motion_at + 6;
  const auto mixing = imm::mixing_weights<ModelSet::max_models>(bank.probability, switching);
  for (int to = 0; to < bank.count; ++to) {
    Hypothesis& out = scratch.mode[static_cast<std::size_t>(to)];
    out.x.setZero(n);
    out.P.resize(n, n);
    for (int from = 0; from < bank.count; ++from)
      out.x += mixing.weights(from, to) * bank.mode[static_cast<std::size_t>(from)].x;
    std::array<Columns<1>, ModelSet::max_models> apart;  // times the root of the weight
    for (int from = 0; from < bank.count; ++from) {
      const auto k = static_cast<std::size_t>(from);
      apart[k] = std::sqrt(mixing.weights(from, to)) * (bank.mode[k].x - out.x);
    }
    for (Eigen::Index j = 0; j < n; ++j) {
      out.P.col(j) = mixing.weights(0, to) * bank.mode[0].P.col(j) + apart[0] * apart[0][j];
      for (int from = 1; from < bank.count; ++from) {
        const auto k = static_cast<std::size_t>(from);
        out.P.col(j) += mixing.weights(from, to) * bank.mode[k].P.col(j) + apart[k] * apart[k][j];
      }
    }
    out.P.block<3, 3>(motion_at, motion_at) += onset_unseen(apart, bank.count, force_at);
    if (to == set.ballistic) {
      // The other models' specific force is nothing that a ballistic one could have: it enters as zero with its prior.
      const Hypothesis& mine = bank.mode[static_cast<std::size_t>(to)];
      const double own = mixing.weights(to, to);
      out.x.segment<3>(force_at) = own * mine.x.segment<3>(force_at);
      out.P.middleCols<3>(force_at) = own * mine.P.middleCols<3>(force_at);
      out.P.block<3, 3>(force_at, force_at).diagonal().array() +=
          (1 - own) * set.ballistic_sigma_m_s2 * set.ballistic_sigma_m_s2;
      out.P.middleRows<3>(force_at) = out.P.middleCols<3>(force_at).transpose();
    }
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(bank.count); ++i) std::swap(bank.mode[i], scratch.mode[i]);
  bank.probability = mixing.predicted;
}

void reweigh(Bank& bank, const Vec<ModelSet::max_models>& log_likelihoods) {
  if (bank.count == 1) return;
  // A model that explains nothing now must be able to come back.
  constexpr double least = 1e-12;
  const Vec<ModelSet::max_models> mu =
      imm::update_probabilities<ModelSet::max_models>(bank.probability, log_likelihoods).cwiseMax(least);
  bank.probability = mu / mu.sum();
}

int likeliest(const Bank& bank) {
  Eigen::Index best = 0;
  bank.probability.maxCoeff(&best);
  return static_cast<int>(best);
}

Gaussian<9> combined_motion(const Bank& bank, const ModelSet& set, int motion_at, double dt) {
  imm::Bank<9, ModelSet::max_models> modes;
  for (std::size_t i = 0; i < static_cast<std::size_t>(bank.count); ++i) {
    const Hypothesis& h = bank.mode[i];
    modes[i] =
        predict(set.model[i], {.mean = h.x.segment<9>(motion_at), .cov = h.P.block<9, 9>(motion_at, motion_at)}, dt);
    modes[i].mean.tail<3>() = acceleration(set.model[i], modes[i].mean);
  }
  return bank.count == 1 ? modes[0] : imm::combine<9, ModelSet::max_models>(modes, bank.probability);
}

BiasEstimate combined_bias(const Bank& bank, const RadarBlock& block) {
  BiasEstimate b;
  b.terms = block.terms;
  b.term = block.term;
  const auto value = b.value.head(block.terms);
  auto cov = b.cov.topLeftCorner(block.terms, block.terms);
  for (std::size_t i = 0; i < static_cast<std::size_t>(bank.count); ++i)
    b.value.head(block.terms) +=
        bank.probability[static_cast<Eigen::Index>(i)] * bank.mode[i].x.segment(block.at, block.terms);
  for (std::size_t i = 0; i < static_cast<std::size_t>(bank.count); ++i) {
    const Vec<BiasEstimate::max_terms> d = [&] {
      Vec<BiasEstimate::max_terms> all = Vec<BiasEstimate::max_terms>::Zero();
      all.head(block.terms) = bank.mode[i].x.segment(block.at, block.terms) - value;
      return all;
    }();
    cov += bank.probability[static_cast<Eigen::Index>(i)] *
           (bank.mode[i].P.block(block.at, block.at, block.terms, block.terms) +
            d.head(block.terms) * d.head(block.terms).transpose());
  }
  // A time tag that is held is known no better than before.
  for (int i = 0; i < block.terms; ++i) {
    const Eigen::Index k = index(block.term[static_cast<std::size_t>(i)]);
    if (b.cov(i, i) == 0) b.cov(i, i) = block.model.prior_cov(k, k);
  }
  return b;
}

}  // namespace downrange
