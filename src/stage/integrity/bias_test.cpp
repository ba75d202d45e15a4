#include "bias_test.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <downrange/est/filter/consistency.hpp>
#include <limits>

namespace downrange::integrity {
namespace {

constexpr double false_alarm = 1e-6;
/// What a filter's bias takes up of a mount's wander that the configuration does not know reaches three times the
/// quantile; lies reach 45 prior sigmas. Of one term this is 15.
constexpr double lenience = 10;
/// A bias that so few plots taught is a guess.
constexpr std::uint64_t least_samples = 20;
/// Posterior sigma over prior sigma below which a term is known, and can be held against another radar's.
constexpr double well_known = 0.5;
/// The same term of two radars is common to them where one is no smaller than this share of the other.
constexpr double alike_term = 0.5;
constexpr double alike_displacement = 0.3;
/// Of the mean of the radars' clocks, in its sigmas: the quantile at 1e-6 is 4.9.
constexpr double clock_beyond_belief = 6;
constexpr double sound = 2;  // prior sigmas: below, nothing is to be said against a bias

struct Block {
  BiasBlock name;
  BiasTerm first;
  int terms;
};
constexpr std::array<Block, 4> blocks{{{BiasBlock::SezOffset, BiasTerm::OffsetSouth, 3},
                                       {BiasBlock::SezScale, BiasTerm::ScaleSouth, 3},
                                       {BiasBlock::Polar, BiasTerm::OffsetRange, 6},
                                       {BiasBlock::Time, BiasTerm::TimeTag, 1}}};

}  // namespace

BiasTest::BiasTest() {
  for (std::size_t dof = 1; dof < threshold_.size(); ++dof)
    threshold_[dof] = lenience * chi2_quantile(1 - false_alarm, static_cast<int>(dof));
}

BiasPlausibility BiasTest::plausibility(const BiasModel& prior, const BiasEstimate& bias) const {
  BiasPlausibility worst;
  if (bias.reference != BiasReference::Gps || bias.samples < least_samples) return worst;
  for (const Block& block : blocks) {
    std::array<Eigen::Index, 6> at{};
    Vec<6> excess = Vec<6>::Zero();
    Mat<6, 6> P = Mat<6, 6>::Identity();
    int n = 0;
    for (int i = 0; i < bias.terms; ++i) {
      const auto term = static_cast<Eigen::Index>(bias.term[static_cast<std::size_t>(i)]);
      const Eigen::Index first = static_cast<Eigen::Index>(block.first);
      if (term < first || term >= first + block.terms) continue;
      at[static_cast<std::size_t>(n)] = term;
      excess[n++] = bias.value[i] - prior.prior_mean[term];
    }
    if (n == 0) continue;
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j)
        P(i, j) = prior.prior_cov(at[static_cast<std::size_t>(i)], at[static_cast<std::size_t>(j)]);
    }
    const Eigen::LLT<Mat<6, 6>> llt(P);
    if (llt.info() != Eigen::Success) continue;
    const double ratio = llt.matrixL().solve(excess).squaredNorm() / threshold_[static_cast<std::size_t>(n)];
    if (!(ratio > worst.ratio)) continue;
    worst = {.ratio = ratio, .block = block.name, .value = 0, .term = block.first};
    for (int i = 0; i < n; ++i) {
      const double sigmas = excess[i] / std::sqrt(P(i, i));
      if (std::abs(sigmas) > std::abs(worst.value)) {
        worst.value = sigmas;
        worst.term = static_cast<BiasTerm>(at[static_cast<std::size_t>(i)]);
      }
    }
  }
  return worst;
}

LearntBias BiasTest::operator()(const BiasModel& prior, const BiasEstimate& bias) const {
  LearntBias learnt;
  learnt.ignorance.fill(1);
  for (int i = 0; i < bias.terms; ++i) {
    const auto term = static_cast<std::size_t>(bias.term[static_cast<std::size_t>(i)]);
    const auto k = static_cast<Eigen::Index>(term);
    const double sigma = std::sqrt(prior.prior_cov(k, k));
    learnt.excess[term] = (bias.value[i] - prior.prior_mean[k]) / sigma;
    learnt.ignorance[term] = std::sqrt(std::max(bias.cov(i, i), 0.0)) / sigma;
  }
  learnt.plausibility = plausibility(prior, bias);
  return learnt;
}

BiasBlame blame(std::span<const LearntBias> radars) {
  BiasBlame result;
  for (const LearntBias& r : radars) {
    if (!r.implausible) continue;
    const auto term = static_cast<std::size_t>(r.plausibility.term);
    bool alike = false;
    bool different = false;
    for (const LearntBias& other : radars) {
      if (other.witness == r.witness || other.ignorance[term] > well_known) continue;
      const double share = other.excess[term] / r.excess[term];
      const double larger = std::max(r.displacement.norm(), other.displacement.norm());
      const bool same_term = share >= alike_term && share <= 1 / alike_term;
      const bool same_way = (r.displacement - other.displacement).norm() <= alike_displacement * larger &&
                            std::abs(other.excess[term]) >= sound;
      alike = alike || same_term || same_way;
      different = different || std::abs(other.excess[term]) < sound;
    }
    if (alike && !different) {
      result.receivers = true;
    } else if (different) {
      result.radars |= only(r.witness);
    } else {
      result.disputed |= only(r.witness);
    }
  }
  if (result.receivers) result.radars = result.disputed = 0;
  return result;
}

CommonClock common_clock(std::span<const LearntBias> radars) {
  constexpr auto clock = static_cast<std::size_t>(BiasTerm::TimeTag);
  double sum = 0;
  double least = std::numeric_limits<double>::infinity();
  double most = -least;
  double apart_m = 0;
  int known = 0;
  for (const LearntBias& r : radars) {
    if (r.ignorance[clock] > well_known) continue;
    ++known;
    sum += r.excess[clock];
    least = std::min(least, r.excess[clock]);
    most = std::max(most, r.excess[clock]);
    apart_m = std::max(apart_m, r.displacement.norm());
  }
  const bool alike = least * most > 0 && std::min(least / most, most / least) >= alike_term;
  if (known < 2 || !alike) return {};
  return {sum * sum / known / (clock_beyond_belief * clock_beyond_belief), apart_m};
}

}  // namespace downrange::integrity
