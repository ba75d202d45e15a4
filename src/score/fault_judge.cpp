#include "score/fault_judge.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>

namespace downrange::score {
namespace {

constexpr double deg = std::numbers::pi / 180;
/// Two positions further apart in time have a hole between them: there was no track.
constexpr Duration longest_gap = seconds(1);

/// 1-sigma of a command on the sky.
double sigma_on_sky(const SlavingCommand& command) {
  return std::hypot(command.sigma_azimuth_rad * std::cos(command.elevation_rad), command.sigma_elevation_rad);
}

/// None of its messages is accepted: a source that INTEGRITY never hears.
bool rejected(const SourceHealth& health) { return !health.qualified && health.why == Disqualification::Rejected; }

/// What a source's health says against it: rejected, or at odds with its model. Silence, or an operator's order,
/// accuses nobody.
bool accuses(const SourceHealth& health) {
  const bool excluded = !health.qualified && health.why == Disqualification::Excluded;
  return health.mismatch || health.suspect || excluded || rejected(health);
}

bool accuses(const SourceIntegrity& source) {
  return source.verdict == IntegrityVerdict::Suspect || source.verdict == IntegrityVerdict::Excluded;
}

std::string text(const char* format, double a, double b) {
  char buffer[120];
  std::snprintf(buffer, sizeof buffer, format, a, b);
  return buffer;
}

}  // namespace

FaultJudge::FaultJudge(const RangeConfig& range, FaultCase fault)
    : range_(range), fault_(std::move(fault)), sources_(range), air_(air_of_antennas(range)) {
  score_.recovers = fault_.end.has_value();
  for (const AntennaConfig& antenna : range_.antennas) {
    const Name& target = antenna.target.empty() ? range_.targets.front().id : antenna.target;
    if (target != fault_.target) continue;
    const auto air = air_.find(antenna.id);
    mounts_.try_emplace(antenna.id, antenna, fault_.truth, air == air_.end() ? nullptr : &air->second, fault_.begin);
  }
}

void FaultJudge::emit(const Result& result) {
  std::visit([this](const auto& r) { add(r); }, result);
}

FaultSecond& FaultJudge::second_of(Time t) {
  const double t_s = std::floor((t - fault_.begin).seconds());
  std::vector<FaultSecond>& all = score_.seconds;
  if (all.empty() || all.back().t_s < t_s) all.push_back({.t_s = t_s, .error_m = -1});
  return all.back();
}

void FaultJudge::add(const Trajectory& trajectory) {
  if (!trajectory.primary || trajectory.target != fault_.target) return;
  const std::optional<TrueState> truth = fault_.truth(trajectory.epoch);
  if (!truth) return;
  const Gaussian<3> x = position_at(trajectory, trajectory.epoch);
  const double error_m = (x.mean - truth->position.m).norm();
  errors_.push_back({trajectory.epoch, error_m});
  if (trajectory.bound_valid)
    score_.bound.add(error_m <= trajectory.bound_m);
  else
    ++score_.unbounded;

  FaultSecond& second = second_of(trajectory.epoch);
  second.accused.clear();
  for (const Accused& accused : accused_) second.accused.push_back(accused.source);
  second.chain = trajectory.chain;
  if (error_m <= second.error_m) return;
  second.error_m = error_m;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(x.cov, Eigen::EigenvaluesOnly);
  second.sigma_m = std::sqrt(std::max(0.0, axes.eigenvalues().maxCoeff()));
  second.bound_m = trajectory.bound_valid ? std::optional(trajectory.bound_m) : std::nullopt;
}

void FaultJudge::add(const SlavingCommand& command) {
  const auto mount = mounts_.find(command.antenna);
  if (mount != mounts_.end()) mount->second.take(command);
  const auto antenna = std::ranges::find(range_.antennas, command.antenna, &AntennaConfig::id);
  if (antenna == range_.antennas.end() || command.target != fault_.target) return;
  if ((command.limits & (LimitElevation | LimitAzimuth)) != 0) return;
  const std::optional<TrueState> truth = fault_.truth(command.apply_at);
  if (!truth) return;
  const auto air = air_.find(command.antenna);
  const Polar look = pointing_at(antenna->site, air == air_.end() ? nullptr : &air->second, truth->position);
  if (look.range_m <= wrong_beyond_m) return;
  ++score_.commands;
  const double error_rad = pointing_error(command, look);
  if (command.bound_valid) score_.pointing_bound.add(error_rad <= command.bound_rad);
  if (error_rad <= wrong_rad || error_rad <= wrong_sigmas * sigma_on_sky(command)) return;
  ++score_.wrong_by_sigma;
  if (!command.bound_valid || error_rad > command.bound_rad) ++score_.confidently_wrong;
}

void FaultJudge::add(const SourceHealth& health) {
  for (auto& [antenna, mount] : mounts_) mount.advance_to(health.time);
  if (sources_.find(health.sensor) == no_source) return;
  accuse(health.sensor, health.time, Accuser::Health, integrity_heard_ ? rejected(health) : accuses(health));
}

void FaultJudge::add(const Integrity& integrity) {
  if (integrity.target != fault_.target) return;
  if (!integrity_heard_) accused_.clear();  // what health said before counts no more
  integrity_heard_ = true;
  for (const SourceIntegrity& source : integrity.sources)
    accuse(source.sensor, integrity.time, Accuser::Integrity, accuses(source));
}

void FaultJudge::accuse(const Name& source, Time time, Accuser by, bool accused) {
  const auto known = std::ranges::find(accused_, source, &Accused::source);
  if (!accused) {
    if (known == accused_.end()) return;
    known->by &= ~static_cast<unsigned>(by);
    if (known->by == 0) accused_.erase(known);
    return;
  }
  if (known != accused_.end()) {
    known->by |= static_cast<unsigned>(by);
    return;
  }
  accused_.push_back({.source = source, .by = static_cast<unsigned>(by)});
  if (score_.accusation || time < fault_.begin) return;
  score_.accusation = {.source = source,
                       .delay_s = (time - fault_.begin).seconds(),
                       .right = std::ranges::find(fault_.liars, source) != fault_.liars.end()};
}

/// From the fault's end to the last error that is too large within the horizon; a hole in the track is one.
std::optional<double> FaultJudge::recovery() const {
  const Time end = *fault_.end;
  const Time horizon = end + recovery_horizon;
  Time last_bad = end;
  Time before = end;
  const auto hole_to = [&](Time t) {
    if (t - before > longest_gap) last_bad = t;
    before = t;
  };
  Time newest = end;
  for (const ErrorAt& e : errors_) {
    newest = std::max(newest, e.time);
    if (e.time < end || e.time > horizon) continue;
    hole_to(e.time);
    if (e.error_m > fault_.recovered_m) last_bad = e.time;
  }
  // Bad to the end of what there is: no recovery was seen.
  if (last_bad >= std::min(newest, horizon) - longest_gap || newest <= end) return std::nullopt;
  return (last_bad - end).seconds();
}

FaultScore FaultJudge::score() const {
  FaultScore score = score_;
  std::vector<double> whole;
  std::vector<double> during;
  for (const ErrorAt& e : errors_) {
    whole.push_back(e.error_m);
    if (e.time >= fault_.begin && (!fault_.end || e.time < *fault_.end)) during.push_back(e.error_m);
  }
  score.whole = spread_of(std::move(whole));
  score.during = spread_of(std::move(during));
  if (fault_.end) score.recovery_s = recovery();
  for (const auto& [antenna, mount] : mounts_) score.mounts.emplace(antenna, mount.score());
  return score;
}

MountScore FaultScore::all_mounts() const {
  MountScore all;
  for (const auto& [antenna, mount] : mounts) all += mount;
  return all;
}

bool is_too_far_off(const FaultScore& score, const FaultLimits& limits) {
  if (!limits.error_m) return false;
  return score.during.worst > std::max(*limits.error_m, as_without_ratio * score.without_liars_m.value_or(0));
}

std::vector<std::string> missed(const FaultScore& score, const FaultLimits& limits) {
  std::vector<std::string> all;
  if (!limits.majority_lies && score.confidently_wrong > 0)
    all.push_back(std::to_string(score.confidently_wrong) + " commands confidently wrong");
  if (is_too_far_off(score, limits)) {
    all.push_back(text("worst %.0f m, allowed %g m", score.during.worst, *limits.error_m));
    if (score.without_liars_m)
      all.back() += text(" or %g times the %.0f m without the liars", as_without_ratio, *score.without_liars_m);
  }
  if (limits.recovery_s && score.recovers) {
    if (!score.recovery_s)
      all.push_back("does not recover");
    else if (*score.recovery_s > *limits.recovery_s)
      all.push_back(text("recovers after %.1f s, allowed %g s", *score.recovery_s, *limits.recovery_s));
  }
  if (score.accusation && !score.accusation->right && !limits.majority_lies)
    all.push_back("accuses " + std::string(score.accusation->source.view()));
  if (limits.accusation_s) {
    if (!score.accusation)
      all.emplace_back("accuses nobody");
    else if (score.accusation->right && score.accusation->delay_s > *limits.accusation_s)
      all.push_back(text("accuses after %.1f s, allowed %g s", score.accusation->delay_s, *limits.accusation_s));
  }
  if (!limits.majority_lies && score.bound.count > 0 && score.bound.value() < limits.bound_share)
    all.push_back(
        text("bound covers %.2f %%, at least %g %% expected", 100 * score.bound.value(), 100 * limits.bound_share));
  const MountScore mounts = score.all_mounts();
  const double on_target = mounts.share_of(mounts.on_target);
  if (limits.on_target_share && on_target < *limits.on_target_share)
    all.push_back(text("mounts %.2f %% of the time on target, at least %g %% expected", 100 * on_target,
                       100 * *limits.on_target_share));
  if (limits.excursion_rad && mounts.worst_rad > *limits.excursion_rad)
    all.push_back(text("a mount %.2f deg off, allowed %g deg", mounts.worst_rad / deg, *limits.excursion_rad / deg));
  return all;
}

}  // namespace downrange::score
