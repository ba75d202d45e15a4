#include "stage/slave/nominal_aim.hpp"

#include <algorithm>
#include <cmath>

namespace downrange {

double position_sigma_m(const TrackEstimate& e) { return std::sqrt(e.cov.topLeftCorner<3, 3>().trace()); }

double planned_time_s(std::optional<Time> liftoff, Time at) {
  return liftoff ? std::max((at - *liftoff).seconds(), 0.0) : 0;
}

std::optional<TrackEstimate> nominal_aim(const NominalTrajectory& nominal, const SlaveConfig& config,
                                         std::optional<Time> liftoff, Time tick, Time at) {
  if (nominal.empty()) return std::nullopt;
  const NominalSample& first = nominal.samples().front();
  const double t_s = planned_time_s(liftoff, at);
  const bool flies = liftoff && at >= *liftoff && t_s >= first.t_s;
  const auto planned = nominal.at(std::max(t_s, first.t_s));
  if (!planned) return std::nullopt;
  TrackEstimate e;
  e.epoch = at;
  e.data_epoch = liftoff.value_or(tick);
  e.size = 9;
  e.mean.head<3>() = planned->position.m;
  if (flies) {
    constexpr double h_s = 0.25;
    e.mean.segment<3>(3) = planned->velocity.m_s;
    const auto later = nominal.at(t_s + h_s);
    const auto earlier = nominal.at(t_s - h_s);
    if (later && earlier) e.mean.tail<3>() = (later->velocity.m_s - earlier->velocity.m_s) / (2 * h_s);
  }
  const double way_m = (planned->position.m - first.state.position.m).norm();
  const double sigma_m = config.nominal_sigma_m + config.nominal_sigma_share * way_m;
  e.cov.topLeftCorner<3, 3>().diagonal().setConstant(sigma_m * sigma_m);
  const double sigma_m_s = config.nominal_sigma_share * std::max(e.mean.segment<3>(3).norm(), 1.0);
  e.cov.block<3, 3>(3, 3).diagonal().setConstant(sigma_m_s * sigma_m_s);
  e.cov.bottomRightCorner<3, 3>().setIdentity();
  return e;
}

bool keeps_to_plan(const TrackEstimate& vehicle, const TrackEstimate& plan) {
  constexpr double sigmas = 5;
  const double off_m = (vehicle.mean.head<3>() - plan.mean.head<3>()).norm();
  return off_m <= sigmas * (position_sigma_m(vehicle) + position_sigma_m(plan));
}

}  // namespace downrange
