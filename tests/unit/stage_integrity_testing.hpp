#pragma once
/// A centre whose judge says what a test tells it to: INGEST, the methods with INTEGRITY, SLAVE.

#include <functional>
#include <map>

#include "../support/small_range.hpp"
#include "stage/ingest.hpp"
#include "stage/methods.hpp"
#include "stage/slave/slave.hpp"

namespace downrange::test {

/// Sources of small_range by SourceId.
inline constexpr SourceId goheung = 0;
inline constexpr SourceId jeju = 1;
inline constexpr SourceSet gps = set_of(2) | set_of(3);

/// Changes the verdicts (by SourceId, all Agrees before the first call) at the tick given; seconds after lift-off.
using Script = std::function<void(double t, std::vector<Judgement>& verdicts)>;

class ScriptedJudge final : public SourceJudge {
 public:
  ScriptedJudge(std::size_t sources, Script script) : verdicts_(sources), script_(std::move(script)) {}
  void note(SourceId, const Observation&) override {}
  std::span<const Judgement> judge(const JudgedTick& tick, std::span<const ChainState>,
                                   std::span<const BiasEstimate>) override {
    script_((tick.epoch - liftoff).seconds(), verdicts_);
    return verdicts_;
  }

 private:
  std::vector<Judgement> verdicts_;
  Script script_;
};

inline JudgeMaker scripted(Script script) {
  return [script = std::move(script)](const RangeConfig&, const SourceTable& sources, int) {
    return std::make_unique<ScriptedJudge>(sources.size(), script);
  };
}

inline void nobody_lies(double, std::vector<Judgement>&) {}

/// Excluded from `at` on, until `until`; its lie began at `onset`.
inline Script excluded(SourceSet liars, double at, double onset, double until = 1e9) {
  return [=](double t, std::vector<Judgement>& verdicts) {
    for (std::size_t i = 0; i < verdicts.size(); ++i) {
      if (!contains(liars, static_cast<int>(i)) || t < at) continue;
      verdicts[i].verdict = t < until ? IntegrityVerdict::Excluded : IntegrityVerdict::Agrees;
      verdicts[i].since = liftoff + seconds(at);
      verdicts[i].onset = verdicts[i].undone_from = liftoff + seconds(onset);
    }
  };
}

inline RangeConfig judged_range() {
  RangeConfig range = small_range();
  range.fuse.methods = {"joint"};
  return range;
}

class Centre {
 public:
  explicit Centre(const RangeConfig& range, Script script = nobody_lies)
      : range_(range), ingest_(range), methods_(range, scripted(std::move(script))), slave_(range) {}

  void handle(const Event& event) {
    advance_to(received_of(event));
    if (const auto* plot = std::get_if<RadarTspi>(&event)) process(ingest_.judge(*plot));
    if (const auto* fix = std::get_if<GpsFix>(&event)) process(ingest_.judge(*fix));
  }
  void handle(const std::vector<Event>& events) {
    for (const Event& e : events) handle(e);
  }
  void advance_to(Time now) {
    for (; next_tick_ <= now; next_tick_ = next_tick_ + range_.tick) {
      methods_.judge(next_tick_, {.forced = forced, .inhibited = inhibited, .held = held}, out);
      slave_.tick(next_tick_, methods_.followed(), {}, out);
      if (after_tick) after_tick((next_tick_ - liftoff).seconds());
    }
  }
  [[nodiscard]] const Methods& methods() const { return methods_; }
  [[nodiscard]] const Followed& followed() const { return methods_.followed()[0]; }
  /// Of what is followed, at `t` seconds after lift-off.
  [[nodiscard]] std::optional<TrackEstimate> estimate(double t) const {
    return followed().method->fused(followed().target, liftoff + seconds(t));
  }
  [[nodiscard]] double error_m(double t) const { return (estimate(t)->mean.head<3>() - vehicle_at(t).m).norm(); }

  Collector out;
  SourceSet forced = 0;
  SourceSet inhibited = 0;
  std::vector<Name> held;
  std::function<void(double t)> after_tick;

 private:
  void process(const Observation& o) {
    if (o.verdict != Reason::Accepted && o.verdict != Reason::Duplicate) return;
    methods_.process(o, true);
    methods_.emit_biases(o, out);
    methods_.emit_trajectories(o, out);
  }

  RangeConfig range_;
  Ingest ingest_;
  Methods methods_;
  Slave slave_;
  Time next_tick_ = liftoff;
};

/// `change` on every message of those sources whose epoch is `from` seconds after lift-off or later.
template <class Message, class Change>
std::vector<Event> with_lie(std::vector<Event> events, double from, const Change& change) {
  for (Event& e : events) {
    auto* message = std::get_if<Message>(&e);
    if (message != nullptr && message->epoch >= liftoff + seconds(from)) change(*message);
  }
  return events;
}

/// Without what a radar measured from `from` on, seconds after lift-off.
inline std::vector<Event> without_plots(std::vector<Event> events, const Name& radar, double from, double until = 1e9) {
  std::erase_if(events, [&](const Event& e) {
    const auto* plot = std::get_if<RadarTspi>(&e);
    return plot != nullptr && plot->sensor == radar && plot->epoch >= liftoff + seconds(from) &&
           plot->epoch < liftoff + seconds(until);
  });
  return events;
}

}  // namespace downrange::test
