#include "score/impact_tally.hpp"

#include <algorithm>
#include <downrange/geo/free_fall.hpp>
#include <downrange/geo/ground_polygon.hpp>

namespace downrange::score {
namespace {

/// The least, or the greatest, and when it was.
void keep(std::optional<Extreme>& extreme, double value, double t_s, bool least) {
  if (!extreme || (least ? value < extreme->value : value > extreme->value)) extreme = {.value = value, .t_s = t_s};
}

}  // namespace

std::optional<ImpactError> impact_error(const ImpactPoint& told, const TrueState& truth, const FallSettings& fall) {
  const auto landing = fall_to(truth, fall.height_m, fall.horizon_s);
  if (!told.impact_valid || !landing) return std::nullopt;
  const Eigen::Vector2d away =
      ground_offset(ecef_from_geodetic(told.point), enu_from_ecef_at(told.point), landing->state.position);
  Eigen::Matrix2d cov;
  cov << told.covariance_m2[0], told.covariance_m2[1], told.covariance_m2[1], told.covariance_m2[2];
  return ImpactError{.off_m = -away, .nees = normalised_square<2>(away, cov)};
}

void ImpactTally::add(const ImpactPoint& point, const std::optional<TrueState>& truth) {
  const double t_s = (point.epoch - liftoff_).seconds();
  Chain& chain = chains_.try_emplace(point.chain, Chain{.score = {.chain = point.chain}}).first->second;
  ++(point.impact_valid ? chain.score.points : chain.score.without_point);
  keep(chain.score.longest_loss, point.data_loss_timer_s, t_s, false);
  if (point.data_loss_limit_valid && point.data_loss_timer_s > point.data_loss_limit_s) {
    ++chain.score.over_limit;
    if (!chain.score.first_over_limit_s) chain.score.first_over_limit_s = t_s;
  }
  if (const auto error = truth ? impact_error(point, *truth, fall_) : std::nullopt) {
    chain.errors_m.push_back(error->off_m.norm());
    chain.inside.add(inside_95(error->nees, 2));
  }
  if (point.chain.empty()) add_boundaries(point);
}

void ImpactTally::add_boundaries(const ImpactPoint& point) {
  const double t_s = (point.epoch - liftoff_).seconds();
  for (const BoundaryDistance& b : point.boundaries) {
    auto score = std::ranges::find(boundaries_, b.boundary, &BoundaryScore::boundary);
    if (score == boundaries_.end()) score = boundaries_.insert(score, {.boundary = b.boundary});
    keep(score->least_present_m, b.present_distance_m, t_s, true);
    if (!point.impact_valid) continue;
    keep(score->least_m, b.distance_m, t_s, true);
    keep(score->most_outside, b.probability_outside, t_s, false);
    if (b.distance_m < 0 && !score->first_outside_s) score->first_outside_s = t_s;
  }
}

std::vector<ImpactScore> ImpactTally::chains() const {
  std::vector<ImpactScore> scores;
  for (const auto& [name, chain] : chains_) {
    const Spread spread = spread_of(chain.errors_m);
    ImpactScore score = chain.score;
    score.judged = spread.count;
    score.rms_m = spread.rms;
    score.p95_m = spread.p95;
    score.worst_m = spread.worst;
    score.inside_95 = spread.count > 0 ? chain.inside.value() : 0;
    scores.push_back(score);
  }
  return scores;
}

}  // namespace downrange::score
