#include "stage/integrity/integrity_stage.hpp"

#include <algorithm>
#include <downrange/est/method/method_table.hpp>
#include <limits>
#include <stdexcept>
#include <utility>

#include "stage/integrity/bound.hpp"
#include "stage/judged_ticks.hpp"

namespace downrange {
namespace {

/// States of every chain are kept so often, and so long.
constexpr Duration kept_every = milliseconds(5000);
constexpr Duration kept_for = milliseconds(60'000);
[[nodiscard]] constexpr SourceSet first_sources(std::size_t count) {
  return count >= max_sources_in_set ? ~SourceSet{0} : set_of(static_cast<int>(count)) - 1;
}

/// The bits of `set` as those of the sources in `reported` counted one after the other.
std::uint64_t among(SourceSet set, SourceSet reported) {
  std::uint64_t bits = 0;
  int place = 0;
  for (int id = 0; id < max_sources_in_set; ++id) {
    if (!contains(reported, id)) continue;
    if (contains(set, id)) bits |= std::uint64_t{1} << place;
    ++place;
  }
  return bits;
}

class ImpartialJudge final : public SourceJudge {
 public:
  ImpartialJudge(const RangeConfig& config, const SourceTable& sources, int target) : judge_(config, sources, target) {}
  void note(SourceId source, const Observation& o) override { judge_.note(source, o); }
  std::span<const Judgement> judge(const JudgedTick& tick, std::span<const ChainState> chains,
                                   std::span<const BiasEstimate> biases) override {
    return judge_.judge(tick, chains, biases);
  }

 private:
  Judge judge_;
};

}  // namespace

JudgeMaker impartial_judges() {
  return [](const RangeConfig& config, const SourceTable& sources, int target) {
    return std::make_unique<ImpartialJudge>(config, sources, target);
  };
}

IntegrityStage::IntegrityStage(const RangeConfig& config, const MethodSettings& settings, const JudgeMaker& make_judge)
    : sources_(config),
      history_(config.fuse.arbitration.history),
      coast_(config.fuse.coast),
      rerun_per_tick_(config.integrity.rerun_per_tick),
      units_(source_units(sources_, capabilities_of(config.fuse.methods.front().view()).partial_plots)),
      plans_(plan_chains(units_)),
      all_(
          {.name = {}, .sources = first_sources(sources_.size())}, std::nullopt, settings,
          [name = config.fuse.methods.front()](const MethodSettings& s) { return make_method(name.view(), s); },
          config.fuse.coast),
      targets_(config.targets.size()),
      followed_(config.targets.size()),
      biases_(sources_.size()) {
  if (sources_.size() > max_sources_in_set)
    throw std::invalid_argument("a range has at most 64 sources (radars, trackers and stations together)");
  judges_ = config.integrity.enabled && make_judge && units_.size() > 1;
  for (const TargetConfig& target : config.targets) names_.push_back(target.id);
  const ChainMethodMaker make = [name = config.fuse.methods.front()](const MethodSettings& s) {
    return make_method(name.view(), s);
  };
  for (std::size_t i = 0; i < targets_.size(); ++i) {
    Target& t = targets_[i];
    const int target = static_cast<int>(i);
    t.newest = before_all;
    if (judges_) {
      t.others.reserve(plans_.chains.size());
      for (const ChainPlan& plan : plans_.chains) t.others.emplace_back(plan, target, settings, make, coast_);
      t.judge = make_judge(config, sources_, target);
      t.verdicts.resize(sources_.size());
      t.first_told.assign(sources_.size(), Time{std::numeric_limits<std::int64_t>::max()});
      t.states.resize(1 + t.others.size());
      t.alternatives.reserve(2 * units_.size());
      ::downrange::Integrity record;
      record.target = names_[i];
      record.sources.reserve(sources_.size());
      t.record = std::move(record);
    }
    update_followed(target);
  }
}

bool IntegrityStage::process(const Observation& o, const Measurement& m) {
  Target& t = of(m.target);
  LoggedMeasurement logged{.m = m};
  if (!judges_)
    return o.verdict == Reason::Accepted && all_.process(logged, 0, o.received, exclusions_) == Verdict::Accepted;
  t.newest = std::max(t.newest, m.epoch);
  t.in_flight = m.in_flight;
  if (o.verdict == Reason::Duplicate) logged.copies_before = log_.copies_of(logged);
  t.reported |= set_of(m.source);
  Time& first_told = t.first_told[static_cast<std::size_t>(m.source)];
  first_told = std::min(first_told, m.epoch);
  t.judge->note(m.source, o);
  ++arrived_;
  const MeasurementLog::Position at = log_.insert(logged);
  bool accepted = false;
  for (int place = of_all; place <= static_cast<int>(t.others.size()); ++place) {
    const auto verdict = chain(t, place).process(logged, at, o.received, exclusions_);
    if (place == t.selected) accepted = verdict == Verdict::Accepted;
  }
  // The chains of other targets do not hear it, but what they are run again on has moved.
  for (std::size_t other = 0; runs_again_ && other < targets_.size(); ++other) {
    if (static_cast<int>(other) == m.target) continue;
    for (Chain& c : targets_[other].others) (void)c.process(logged, at, o.received, exclusions_);
  }
  return accepted;
}

void IntegrityStage::tick(Time tick, const OperatorWill& will, ResultSink& sink) {
  const std::optional<Time> last = std::exchange(last_tick_, tick);
  judged_ = judges_ && is_judged_tick(last, tick);
  if (judges_) {
    if (crosses(last, tick, kept_every)) keep_states(tick);
    if (judged_) {
      for (int target = 0; target < static_cast<int>(targets_.size()); ++target) judge(target, tick, will);
    }
    const bool run_ended = catch_up();
    for (int target = 0; target < static_cast<int>(targets_.size()); ++target) {
      if (run_ended) estimate_all(target, tick);
      if (judged_ || run_ended) choose(target, will);
    }
  }
  for (int target = 0; target < static_cast<int>(targets_.size()); ++target) {
    update_followed(target);
    if (judged_) report(target, tick, will, sink);
  }
}

void IntegrityStage::keep_states(Time tick) {
  if (log_.end() == kept_until_) return;  // nothing new
  kept_until_ = log_.end();
  const Time instant = tick - history_;
  const Time oldest = instant - kept_for;
  std::erase_if(instants_, [&](Time t) { return t < oldest; });
  instants_.push_back(instant);
  MeasurementLog::Position wanted = log_.end();
  bool runs = false;
  for_each_chain([&](Chain& c) {
    if (!c.alone()) c.keep(instant, oldest);
    if (!c.runs_again()) return;
    runs = true;
    wanted = std::min(wanted, c.cursor());
  });
  log_.forget_before(instants_.front(), wanted);
  if (!runs) exclusions_.forget_before(instants_.front());
}

void IntegrityStage::estimate_all(int target, Time tick) {
  Target& t = of(target);
  for (int place = of_all; place < static_cast<int>(t.states.size()); ++place) {
    const Chain& c = chain(t, place);
    t.states[static_cast<std::size_t>(place)] = {.sources = c.sources(), .estimate = c.estimate(target, tick)};
  }
}

void IntegrityStage::judge(int target, Time tick, const OperatorWill& will) {
  Target& t = of(target);
  estimate_all(target, tick);
  if (tick - t.newest > coast_) return;
  for (SourceId id = 0; id < static_cast<SourceId>(sources_.size()); ++id)
    biases_[static_cast<std::size_t>(id)] = selected(target).bias(id);
  const auto verdicts = t.judge->judge({.epoch = tick,
                                        .in_flight = t.in_flight,
                                        .liftoff = will.liftoff,
                                        .forced = will.forced,
                                        .inhibited = will.inhibited},
                                       t.states, biases_);

  SourceSet excluded = 0;
  SourceSet back = 0;
  for (SourceId id = 0; id < static_cast<SourceId>(sources_.size()); ++id) {
    const auto i = static_cast<std::size_t>(id);
    if (verdicts[i].true_from) back |= set_of(id);
    if (verdicts[i].verdict == IntegrityVerdict::Excluded && !contains(will.forced, id)) excluded |= set_of(id);
    if (verdicts[i].verdict != t.verdicts[i].verdict) t.changed = true;
    t.verdicts[i] = verdicts[i];
  }
  const SourceSet before = t.excluded | t.inhibited;
  const SourceSet convicted = excluded & ~t.excluded;
  const SourceSet acquitted = t.excluded & ~excluded;
  t.changed = t.changed || convicted != 0 || acquitted != 0 || will.inhibited != t.inhibited;
  t.excluded = excluded;
  t.inhibited = will.inhibited;
  const SourceSet out = excluded | will.inhibited;
  for (SourceId id = 0; id < static_cast<SourceId>(sources_.size()); ++id) {
    if (contains(convicted, id)) {
      exclude(target, id, t.verdicts[static_cast<std::size_t>(id)].undone_from);
    } else if (contains(out & ~before, id)) {
      exclusions_.open(target, id, tick);  // an operator says nothing of what it taught
    } else if (contains(before & ~out, id)) {
      exclusions_.close(target, id, tick);
    }
  }
  for (SourceId id = 0; id < static_cast<SourceId>(sources_.size()); ++id) {
    if (!contains(back & ~out, id)) continue;
    const Time from = *t.verdicts[static_cast<std::size_t>(id)].true_from;
    exclude(target, id, from - kept_for);
    exclusions_.close(target, id, from);
  }
  if (acquitted != 0) for_each_chain_of(t, [&](Chain& c) { c.believe(target, acquitted); });
}

void IntegrityStage::choose(int target, const OperatorWill& will) {
  Target& t = of(target);
  t.bound_m.reset();
  t.alternatives.clear();
  if (std::ranges::none_of(t.states, [](const ChainState& s) { return s.estimate.has_value(); })) return;
  const Name held = will.held.empty() ? Name{} : will.held[static_cast<std::size_t>(target)];
  const int selected = select(target, held);
  if (selected != t.selected) {
    t.selected = selected;
    t.runs_seen = chain(t, selected).runs();
    ++t.revision;
    t.changed = true;
  }
  find_alternatives(target);
}

void IntegrityStage::exclude(int target, SourceId source, Time undone_from) {
  const auto kept_before = [&](Time t) {
    Time newest = before_all;
    for (const Time instant : instants_) {
      if (instant < t) newest = instant;
    }
    return newest;
  };
  exclusions_.open(target, source, kept_before(undone_from));
  // Before it told anything it taught nothing: another station of a receiver that has been excluded for long.
  const Time from = kept_before(std::max(undone_from, of(target).first_told[static_cast<std::size_t>(source)]));
  for_each_chain_of(of(target), [&](Chain& c) {
    if (!c.alone() && contains(c.sources(), source)) c.roll_back(target, set_of(source), from, log_);
    runs_again_ = runs_again_ || c.runs_again();
  });
}

bool IntegrityStage::catch_up() {
  // With what has come since the last tick it never falls behind.
  int budget = rerun_per_tick_ + 2 * std::exchange(arrived_, 0);
  bool ended = false;
  if (!std::exchange(runs_again_, false)) return ended;
  for_each_chain([&](Chain& c) {
    if (c.runs_again() && budget > 0) {
      budget -= c.catch_up(log_, exclusions_, instants_, budget);
      ended = ended || !c.runs_again();
    }
    runs_again_ = runs_again_ || c.runs_again();
  });
  return ended;
}

int IntegrityStage::select(int target, const Name& held) const {
  const Target& t = of(target);
  const int count = static_cast<int>(t.states.size());
  const auto estimate = [&](int place) -> const auto& { return t.states[static_cast<std::size_t>(place)].estimate; };
  if (!held.empty()) {
    for (int place = of_all; place < count; ++place) {
      const bool meant = place == of_all ? held == Name("all") : held == chain(t, place).name();
      if (meant && estimate(place)) return place;
    }
  }
  const SourceSet out = t.excluded | t.inhibited;
  const SourceSet believed = t.reported & ~out;
  const auto usable = [&](int place) {
    const Chain& c = chain(t, place);
    return estimate(place) && c.taught_by(target) == 0 && (c.sources() & believed) != 0;
  };
  if (out == 0 && all_.taught_by(target) == 0) return of_all;
  // Whom of the others to believe cannot be told: the track stays where it was. Stations whose copies differ relay one
  // receiver: they are no tie.
  const bool is_tie = std::ranges::any_of(t.verdicts, [](const Judgement& j) {
    return j.verdict == IntegrityVerdict::Ambiguous && j.why != Finding::DifferingCopy;
  });
  if (is_tie && usable(t.selected)) return t.selected;
  for (int place = of_all; place < count; ++place) {
    if (usable(place) && !chain(t, place).alone()) return place;
  }
  // One alone: the one that is followed already, else the one that knows best.
  if (usable(t.selected)) return t.selected;
  int best = t.selected;
  double least = std::numeric_limits<double>::infinity();
  for (int place = of_all; place < count; ++place) {
    if (!usable(place)) continue;
    const double variance = estimate(place)->cov.template topLeftCorner<3, 3>().trace();
    if (variance < least) {
      least = variance;
      best = place;
    }
  }
  return best;
}

void IntegrityStage::find_alternatives(int target) {
  Target& t = of(target);
  const auto& followed = t.states[static_cast<std::size_t>(t.selected)].estimate;
  if (!followed) return;
  const SourceSet believed = t.reported & ~(t.excluded | t.inhibited);
  const auto add = [&](int other) {
    if (other == ChainPlans::none) return false;
    const ChainState& state = t.states[static_cast<std::size_t>(other) + 1];
    if (!state.estimate || (state.sources & believed) == 0) return false;
    t.alternatives.push_back({.from_selected_m = state.estimate->mean.head<3>() - followed->mean.head<3>(),
                              .cov = state.estimate->cov.topLeftCorner<3, 3>()});
    return true;
  };
  bool bounded = true;
  for (std::size_t u = 0; u < units_.size(); ++u) {
    if ((units_[u].sources & believed) != 0) bounded = add(plans_.without[u]) && bounded;
  }
  for (std::size_t u = 0; u < units_.size(); ++u) {
    bool ambiguous = false;
    for (SourceId id = 0; id < static_cast<SourceId>(sources_.size()); ++id) {
      const bool undecided = t.verdicts[static_cast<std::size_t>(id)].verdict == IntegrityVerdict::Ambiguous;
      ambiguous = ambiguous || (undecided && contains(units_[u].sources, id));
    }
    if (ambiguous) (void)add(plans_.alone[u]);
  }
  if (bounded && !t.alternatives.empty()) t.bound_m = bound_m(t.alternatives);
}

std::optional<TrackEstimate> IntegrityStage::selected_estimate(int target) const {
  const Target& t = of(target);
  if (judges_) return t.states[static_cast<std::size_t>(t.selected)].estimate;
  return last_tick_ ? all_.estimate(target, *last_tick_) : std::nullopt;
}

void IntegrityStage::update_followed(int target) {
  Target& t = of(target);
  const Chain& c = chain(t, t.selected);
  if (c.runs() != t.runs_seen) {
    t.runs_seen = c.runs();
    ++t.revision;
  }
  followed_[static_cast<std::size_t>(target)] = {.method = &c.method(),
                                                 .target = c.target_of_method(target),
                                                 .newest = c.newest(target),
                                                 .chain = c.name(),
                                                 .revision = t.revision,
                                                 .alternatives = t.alternatives,
                                                 .bounded = t.bound_m.has_value()};
}

void IntegrityStage::report(int target, Time tick, const OperatorWill& will, ResultSink& sink) {
  Target& t = of(target);
  const bool changed = std::exchange(t.changed, false);
  if (tick - t.newest > coast_) return;
  if (changed) ++t.events;
  auto& record = std::get<::downrange::Integrity>(t.record);
  record.time = tick;
  record.liftoff = will.liftoff.value_or(Time{});
  record.liftoff_valid = will.liftoff.has_value();
  record.chain = chain(t, t.selected).name();
  record.held_by = will.held_by.empty() ? Name{} : will.held_by[static_cast<std::size_t>(target)];
  record.bound_m = t.bound_m.value_or(0);
  record.bound_valid = t.bound_m.has_value();
  record.events = t.events;
  record.sources.clear();
  for (SourceId id = 0; id < static_cast<SourceId>(sources_.size()); ++id) {
    if (!contains(t.reported, id)) continue;
    const Judgement& j = t.verdicts[static_cast<std::size_t>(id)];
    SourceIntegrity source;
    source.sensor = sources_[id].name;
    source.verdict = j.verdict;
    source.why = j.why;
    source.since = j.since;
    source.onset = j.onset;
    source.test_value = j.test_value;
    source.against = among(j.against, t.reported);
    source.apart_m = j.apart_m;
    source.agree_m = j.agree_m;
    if (j.verdict != IntegrityVerdict::Agrees) source.by = "integrity";
    if (contains(will.forced | will.inhibited, id) && !will.ordered_by.empty())
      source.by = will.ordered_by[static_cast<std::size_t>(id)];
    record.sources.push_back(source);
  }
  sink.emit(t.record);
}

}  // namespace downrange
