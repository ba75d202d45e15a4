#include "nominal_test.hpp"

#include "difference.hpp"

namespace downrange::integrity {
namespace {

/// How far a flight may be from its plan: this, and a share of the way from where the plan begins.
constexpr double farthest_m = 2000;
constexpr double farthest_share = 0.03;

}  // namespace

double off_nominal(const Witness& witness, const NominalTrajectory& nominal, Time liftoff) {
  const Ring<Sample>& all = witness.series.samples();
  if (nominal.empty() || all.empty()) return 0;
  const Sample& now = all.newest();
  const auto planned = nominal.at((now.epoch - liftoff).seconds());
  const auto told = told_position(witness, now);
  if (!planned || !told) return 0;
  const double way_m = (planned->position.m - nominal.samples().front().state.position.m).norm();
  const double ratio = (told->m - planned->position.m).norm() / (farthest_m + farthest_share * way_m);
  return ratio * ratio;
}

}  // namespace downrange::integrity
