#include "bias_test.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <downrange/est/filter/consistency.hpp>

namespace downrange::integrity {
namespace {

constexpr double false_alarm = 1e-6;
/// A bias that so few plots taught is a guess.
constexpr std::uint64_t least_samples = 20;
constexpr double alike = 0.5;  ///< share of the larger by which two displacements may differ

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
    threshold_[dof] = chi2_quantile(1 - false_alarm, static_cast<int>(dof));
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

bool common_to_all(std::span<const Vec<3>> displacement) {
  if (displacement.size() < 2) return false;
  for (std::size_t i = 0; i < displacement.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double larger = std::max(displacement[i].norm(), displacement[j].norm());
      if ((displacement[i] - displacement[j]).norm() > alike * larger) return false;
    }
  }
  return true;
}

}  // namespace downrange::integrity
