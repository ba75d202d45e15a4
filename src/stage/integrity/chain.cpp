#include "stage/integrity/chain.hpp"

#include <algorithm>
#include <utility>

namespace downrange {

Chain::Chain(const ChainPlan& plan, std::optional<int> target, const MethodSettings& settings, ChainMethodMaker make,
             Duration coast)
    : name_(plan.name),
      sources_(plan.sources),
      alone_(plan.alone),
      independent_(plan.independent),
      target_(target),
      settings_(settings),
      make_(std::move(make)),
      coast_(coast) {
  settings_.radars.clear();
  settings_.stations = 0;
  const auto ground = static_cast<SourceId>(settings.radars.size());
  const SourceId sources = ground + settings.stations;
  source_of_method_.assign(static_cast<std::size_t>(sources), -1);
  for (SourceId id = 0; id < sources; ++id) {
    if (!contains(sources_, id)) continue;
    if (id < ground) {
      settings_.radars.push_back(settings.radars[static_cast<std::size_t>(id)]);
      ground_.push_back(id);
    } else {
      ++settings_.stations;
    }
  }
  int next = 0;
  for (SourceId id = 0; id < sources; ++id) {
    if (contains(sources_, id)) source_of_method_[static_cast<std::size_t>(id)] = next++;
  }
  if (target_) settings_.targets = 1;
  const auto targets = static_cast<std::size_t>(settings_.targets);
  newest_.assign(targets, before_all);
  taught_.assign(targets, 0);
  taught_for_good_.assign(targets, 0);
  method_ = make_(settings_);
}

bool Chain::hears(const LoggedMeasurement& measurement, const Exclusions& exclusions) const {
  if (target_ && *target_ != measurement.m.target) return false;
  if (!contains(sources_, measurement.m.source)) return false;
  return alone_ ? measurement.copies_before == 0 : exclusions.leave(measurement);
}

Outcome Chain::give(Method& method, const LoggedMeasurement& measurement, Time now) const {
  Measurement m = measurement.m;
  m.source = source_of_method_[static_cast<std::size_t>(m.source)];
  m.target = target_of_method(m.target);
  return method.process(m, now);
}

std::optional<Verdict> Chain::process(const LoggedMeasurement& measurement, MeasurementLog::Position at, Time now,
                                      const Exclusions& exclusions) {
  const bool heard = hears(measurement, exclusions);
  if (again_ && at < cursor_) {
    ++cursor_;
    if (heard) (void)give(*again_, measurement, again_at_);
  }
  if (!heard) return std::nullopt;
  Time& newest = newest_[index(measurement.m.target)];
  newest = std::max(newest, measurement.m.epoch);
  return give(*method_, measurement, now).verdict;
}

TrackEstimate Chain::with_source_ids(TrackEstimate estimate) const {
  std::uint64_t sources = 0;
  for (std::size_t id = 0; id < source_of_method_.size(); ++id) {
    const int of_method = source_of_method_[id];
    if (of_method >= 0 && contains(estimate.sources, of_method)) sources |= set_of(static_cast<SourceId>(id));
  }
  estimate.sources = sources;
  return estimate;
}

std::optional<TrackEstimate> Chain::estimate(int target, Time at) const {
  if (at - newest(target) > coast_) return std::nullopt;
  const int t = target_of_method(target);
  auto estimate = method_->fused(t, at);
  if (!estimate && ground_.empty()) estimate = method_->gps_track(t, at);
  const bool usable = estimate && at - estimate->data_epoch <= coast_ && estimate->mean.allFinite() &&
                      estimate->cov.topLeftCorner<6, 6>().allFinite();
  if (!usable) return std::nullopt;
  return with_source_ids(*estimate);
}

std::optional<TrackEstimate> Chain::fused(int target, std::optional<Time> at) const {
  const auto estimate = method_->fused(target_of_method(target), at);
  if (!estimate) return std::nullopt;
  return with_source_ids(*estimate);
}

BiasEstimate Chain::bias(SourceId source) const {
  const int known = source_of_method_[static_cast<std::size_t>(source)];
  return known < 0 || known >= static_cast<int>(ground_.size()) ? BiasEstimate{} : method_->bias(known);
}

void Chain::keep(Time instant, Time oldest) {
  const auto expired = std::ranges::find_if(kept_, [&](const Kept& k) { return k.instant >= oldest; });
  for (auto k = kept_.begin(); k != expired; ++k) spare_.push_back(std::move(k->state));
  kept_.erase(kept_.begin(), expired);
  if (!again_) keep_of(*method_, instant);  // else the run that catches up passes there
}

void Chain::keep_of(const Method& method, Time instant) {
  const auto* restorable = dynamic_cast<const RestorableMethod*>(&method);
  if (restorable == nullptr) return;  // cannot be copied
  std::unique_ptr<MethodState> room;
  if (spare_.empty()) {
    room = restorable->make_state();
  } else {
    room = std::move(spare_.back());
    spare_.pop_back();
  }
  restorable->save(instant, *room);
  kept_.push_back({.instant = instant, .state = std::move(room)});
}

void Chain::roll_back(int target, SourceSet liars, Time from, const MeasurementLog& log) {
  const SourceSet of_these = liars & sources_;
  taught_[index(target)] |= of_these;
  const auto later = std::ranges::find_if(kept_, [&](const Kept& k) { return k.instant > from; });
  const bool too_old = later == kept_.begin() && !log.complete();
  if (too_old) taught_for_good_[index(target)] |= of_these;
  // Other targets' older past is not given up for one.
  const bool one_target = settings_.targets == 1;
  const auto first_useless = too_old && !one_target && later != kept_.end() ? later + 1 : later;
  for (auto k = first_useless; k != kept_.end(); ++k) spare_.push_back(std::move(k->state));
  kept_.erase(first_useless, kept_.end());
  if (kept_.empty() && !log.complete() && !one_target) return;
  again_ = make_(settings_);
  again_at_ = before_all;
  cursor_ = log.begin();
  if (kept_.empty()) return;
  dynamic_cast<RestorableMethod&>(*again_).restore(*kept_.back().state);
  cursor_ = log.first_from(kept_.back().instant);
}

int Chain::catch_up(const MeasurementLog& log, const Exclusions& exclusions, std::span<const Time> instants, int most) {
  const auto keep_passed = [&](std::optional<Time> epoch) {
    for (const Time instant : instants) {
      const bool passed = !epoch || instant <= *epoch;
      if (passed && (kept_.empty() || kept_.back().instant < instant)) keep_of(*again_, instant);
    }
  };
  int given = 0;
  while (cursor_ < log.end() && given < most) {
    const LoggedMeasurement& next = log[cursor_];
    keep_passed(next.m.epoch);
    ++cursor_;
    if (!hears(next, exclusions)) continue;
    again_at_ = std::max(again_at_, next.m.epoch);
    (void)give(*again_, next, again_at_);
    ++given;
  }
  if (cursor_ < log.end()) return given;
  keep_passed(std::nullopt);
  method_ = std::move(again_);
  taught_ = taught_for_good_;
  ++runs_;
  return given;
}

void Chain::believe(int target, SourceSet sources) {
  taught_for_good_[index(target)] &= ~sources;
  if (!again_) taught_[index(target)] &= ~sources;
}

}  // namespace downrange
