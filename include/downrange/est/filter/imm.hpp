#pragma once
/// Interacting multiple models (Blom, Bar-Shalom 1988, doi 10.1109/9.1299): what is common to every bank of filters.
///
/// One cycle: mixing_weights -> mix -> predict and update each model -> update_probabilities -> combine. Models share
/// one state of size N; a state that one model lacks enters with its own prior (`augmented`), never with zero variance.
/// Likelihoods are logarithms throughout: nothing underflows however far a model is off.

#include <algorithm>
#include <array>
#include <cmath>
#include <downrange/est/filter/gaussian.hpp>
#include <limits>
#include <numbers>

namespace downrange::imm {

/// Filters of M models over one state.
template <int N, int M>
using Bank = std::array<Gaussian<N>, static_cast<std::size_t>(M)>;

/// Switching probabilities over `dt` seconds of the Markov chain with generator `rates` (1/s, rows sum to zero,
/// off-diagonal non-negative): exp(rates dt), rows sum to one, no entry negative. dt >= 0.
template <int M>
[[nodiscard]] Mat<M, M> switching_over(const Mat<M, M>& rates, double dt) {
  const double fastest = -rates.diagonal().minCoeff();
  if (!(fastest * dt > 0)) return Mat<M, M>::Identity();
  // Uniformisation: exp(G t) = e^-(L t) sum (L t)^k / k! (I + G/L)^k has no negative term; squared back from a short t.
  const int halvings = std::max(0, static_cast<int>(std::ceil(std::log2(fastest * dt))));
  const double steps = std::ldexp(fastest * dt, -halvings);  // <= 1: 18 terms leave below 1e-16
  const Mat<M, M> jump = Mat<M, M>::Identity() + rates / fastest;
  Mat<M, M> term = std::exp(-steps) * Mat<M, M>::Identity();
  Mat<M, M> sum = term;
  for (int k = 1; k <= 18; ++k) {
    term = (term * jump * (steps / k)).eval();
    sum += term;
  }
  for (int i = 0; i < halvings; ++i) sum = (sum * sum).eval();
  for (int i = 0; i < M; ++i) sum.row(i) /= sum.row(i).sum();
  return sum;
}

/// Probabilities of the models before the next measurement, and where each comes from.
template <int M>
struct Mixing {
  Vec<M> predicted;   ///< c_j = sum_i switching(i, j) mu_i
  Mat<M, M> weights;  ///< (i, j): probability that model i was right, given that model j is; columns sum to one
};

/// `probabilities` mu_i >= 0, sum 1; `switching` (i, j) from model i to j, rows sum to one.
template <int M>
[[nodiscard]] Mixing<M> mixing_weights(const Vec<M>& probabilities, const Mat<M, M>& switching) {
  Mixing<M> mixing{.predicted = switching.transpose() * probabilities, .weights = Mat<M, M>::Identity()};
  for (int j = 0; j < M; ++j) {
    if (mixing.predicted[j] > 0)  // a model that nothing leads to keeps its own state
      mixing.weights.col(j) = switching.col(j).cwiseProduct(probabilities) / mixing.predicted[j];
  }
  return mixing;
}

/// Mean and covariance of the mixture (moment matching), `weights` >= 0, sum 1. A model of weight zero is not looked
/// at, whatever is in it.
template <int N, int M>
[[nodiscard]] Gaussian<N> combine(const Bank<N, M>& models, const Vec<M>& weights) {
  Gaussian<N> sum{.mean = Vec<N>::Zero(), .cov = Mat<N, N>::Zero()};
  for (int i = 0; i < M; ++i) {
    if (weights[i] > 0) sum.mean += weights[i] * models[static_cast<std::size_t>(i)].mean;
  }
  for (int i = 0; i < M; ++i) {
    if (!(weights[i] > 0)) continue;
    const Gaussian<N>& model = models[static_cast<std::size_t>(i)];
    const Vec<N> apart = model.mean - sum.mean;
    sum.cov += weights[i] * (model.cov + apart * apart.transpose());
  }
  sum.cov = (sum.cov + sum.cov.transpose().eval()) / 2;
  return sum;
}

/// The state each model starts the next step from.
template <int N, int M>
[[nodiscard]] Bank<N, M> mix(const Bank<N, M>& models, const Mixing<M>& mixing) {
  Bank<N, M> mixed;
  for (int j = 0; j < M; ++j) mixed[static_cast<std::size_t>(j)] = combine<N, M>(models, mixing.weights.col(j));
  return mixed;
}

/// Log of the innovation's density, N(nu; 0, S). Minus infinity where S is not positive definite.
template <int M>
[[nodiscard]] double log_likelihood(const Vec<M>& innovation, const Mat<M, M>& S) {
  const Eigen::LLT<Mat<M, M>> llt(S);
  if (llt.info() != Eigen::Success) return -std::numeric_limits<double>::infinity();
  const Vec<M> whitened = llt.matrixL().solve(innovation);
  double log_det = 0;
  for (int i = 0; i < M; ++i) log_det += 2 * std::log(llt.matrixLLT()(i, i));
  return -0.5 * (whitened.squaredNorm() + log_det + M * std::log(2 * std::numbers::pi));
}

/// mu_j proportional to predicted_j times its likelihood. When no model has a finite likelihood (the measurement told
/// nothing: NaN, or no S positive definite) the predicted probabilities stay.
template <int M>
[[nodiscard]] Vec<M> update_probabilities(const Vec<M>& predicted, const Vec<M>& log_likelihoods) {
  Vec<M> log_weight;
  double best = -std::numeric_limits<double>::infinity();
  for (int j = 0; j < M; ++j) {
    log_weight[j] = std::log(predicted[j]) + log_likelihoods[j];
    if (log_weight[j] > best) best = log_weight[j];  // NaN is never the best
  }
  if (!std::isfinite(best)) return predicted;
  Vec<M> mu;
  for (int j = 0; j < M; ++j) mu[j] = std::isnan(log_weight[j]) ? 0 : std::exp(log_weight[j] - best);
  return mu / mu.sum();
}

/// A model of K states among models of N: the states it lacks, the last N - K, with their own prior, uncorrelated.
template <int N, int K>
[[nodiscard]] Gaussian<N> augmented(const Gaussian<K>& model, const Gaussian<N - K>& prior) {
  Gaussian<N> all{.mean = Vec<N>::Zero(), .cov = Mat<N, N>::Zero()};
  all.mean << model.mean, prior.mean;
  all.cov.template topLeftCorner<K, K>() = model.cov;
  all.cov.template bottomRightCorner<N - K, N - K>() = prior.cov;
  return all;
}

}  // namespace downrange::imm
