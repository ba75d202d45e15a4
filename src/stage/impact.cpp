#include "stage/impact.hpp"

#include <algorithm>
#include <cmath>
#include <downrange/est/method/method_table.hpp>
#include <downrange/stage/source_table.hpp>
#include <utility>

#include "stage/indices.hpp"
#include "stage/judged_ticks.hpp"

namespace downrange {
namespace {

/// Nothing coasts longer (slave.coast_ms, fuse.coast_ms).
constexpr Duration longest_loss = seconds(600);
/// An impact point moves where its speed is this many of its sigmas; else its time to a boundary is that of noise.
constexpr double moving_sigmas = 3;

bool moves(const GroundVelocity& velocity) {
  const double speed2 = velocity.m_s.squaredNorm();
  return speed2 > 0 && speed2 * speed2 > moving_sigmas * moving_sigmas * velocity.m_s.dot(velocity.cov * velocity.m_s);
}

}  // namespace

std::optional<double> data_loss_limit_s(std::span<const DataLossLimit> table, double t_plus_s) {
  if (table.empty()) return std::nullopt;
  const auto after = std::ranges::find_if(table, [&](const DataLossLimit& row) { return row.t_plus_s > t_plus_s; });
  if (after == table.begin()) return table.front().limit_s;
  if (after == table.end()) return table.back().limit_s;
  const DataLossLimit& before = *std::prev(after);
  const double share = (t_plus_s - before.t_plus_s) / (after->t_plus_s - before.t_plus_s);
  return before.limit_s + share * (after->limit_s - before.limit_s);
}

std::vector<Name> impact_chains(const RangeConfig& config) {
  if (!config.impact.enabled) return {};
  std::vector<Name> chains{Name{}};
  for (const ChainPlan& plan : chains_of(config))
    if (plan.independent) chains.push_back(plan.name);
  return chains;
}

ImpactStage::ImpactStage(const RangeConfig& config, const IntegrityStage& integrity) : config_(config.impact) {
  if (!config_.enabled) return;
  for (const BoundaryConfig& boundary : config.boundaries)
    boundaries_.push_back({.id = boundary.id, .polygon = GroundPolygon(boundary.vertices)});
  for (std::size_t i = 0; i < config.targets.size(); ++i) {
    const Name& name = config.targets[i].id;
    Target target{.selected = line_of(name, {}), .others = {}};
    for (const Chain& chain : integrity.others(static_cast<int>(i)))
      target.others.push_back(line_of(name, chain.name()));
    targets_.push_back(std::move(target));
  }
}

ImpactStage::Line ImpactStage::line_of(const Name& target, const Name& chain) const {
  ImpactPoint record;
  record.target = target;
  record.chain = chain;
  record.boundaries.reserve(boundaries_.size());
  return {.record = std::move(record), .last_accepted = std::nullopt};
}

void ImpactStage::tick(Time tick, std::optional<Time> liftoff, const IntegrityStage& integrity, ResultSink& sink) {
  const std::optional<Time> last = std::exchange(last_tick_, tick);
  if (!is_judged_tick(last, tick)) return;
  for (std::size_t i = 0; i < targets_.size(); ++i) {
    const int target = static_cast<int>(i);
    say(targets_[i].selected, integrity.selected_estimate(target), tick, liftoff, sink);
    const auto chains = integrity.others(target);
    if (chains.empty()) continue;
    const auto states = integrity.states_of_others(target);
    for (std::size_t k = 0; k < chains.size(); ++k) {
      if (chains[k].independent()) say(targets_[i].others[k], states[k].estimate, tick, liftoff, sink);
    }
  }
}

void ImpactStage::say(Line& line, const std::optional<TrackEstimate>& estimate, Time tick, std::optional<Time> liftoff,
                      ResultSink& sink) const {
  if (estimate) line.last_accepted = estimate->data_epoch;
  if (!line.last_accepted || tick - *line.last_accepted > longest_loss) return;
  auto& record = std::get<ImpactPoint>(line.record);
  record.epoch = record.received = tick;
  record.data_loss_timer_s = (tick - *line.last_accepted).seconds();
  const bool in_flight = liftoff && tick >= *liftoff;
  const auto limit = in_flight ? data_loss_limit_s(config_.data_loss, (tick - *liftoff).seconds()) : std::nullopt;
  record.data_loss_limit_valid = limit.has_value();
  record.data_loss_limit_s = limit.value_or(0);
  record.data_age_s = estimate ? record.data_loss_timer_s : 0;
  record.impact_valid = false;
  record.point = {};
  record.time_to_impact_s = 0;
  record.covariance_m2 = {};
  record.boundaries.clear();
  if (estimate) add_fall(record, *estimate);
  sink.emit(line.record);
}

void ImpactStage::add_fall(ImpactPoint& record, const TrackEstimate& estimate) const {
  const std::optional<Impact> impact =
      impact_of({.mean = estimate.mean.head<6>(), .cov = estimate.cov.topLeftCorner<6, 6>()}, config_.fall);
  const Geodetic present = geodetic_from_ecef({estimate.mean.head<3>()});
  GroundVelocity velocity;
  bool moving = false;
  if (impact) {
    record.impact_valid = true;
    record.point = impact->point;
    record.time_to_impact_s = impact->time_s;
    pack_upper_triangle(impact->cov, 2, record.covariance_m2);
    // A track without acceleration does not tell what moves it.
    if (estimate.size == 9) velocity = velocity_of(*impact, {.mean = estimate.mean, .cov = estimate.cov});
    moving = moves(velocity);
  }
  for (const Boundary& boundary : boundaries_) {
    BoundaryDistance distance{
        .boundary = boundary.id,
        .present_distance_m = boundary.polygon.signed_distance_m({present.latitude_rad, present.longitude_rad})};
    if (impact) {
      distance.distance_m = boundary.polygon.signed_distance_m(impact->ground());
      distance.probability_outside = probability_outside(boundary.polygon, impact->ground(), impact->cov);
    }
    if (moving) {
      const double azimuth = std::atan2(velocity.m_s.x(), velocity.m_s.y());
      const auto way = boundary.polygon.distance_ahead_m(impact->ground(), azimuth);
      distance.time_valid = way.has_value();
      distance.time_s = way.value_or(0) / velocity.m_s.norm();
    }
    record.boundaries.push_back(distance);
  }
}

}  // namespace downrange
