#include <downrange/stage/engine.hpp>
#include <limits>
#include <optional>

#include "ingest.hpp"
#include "methods.hpp"
#include "slave.hpp"
#include "source_monitor.hpp"

namespace downrange {

namespace {

/// After a silence longer than this the ticks in between are skipped: nothing is published that long after the last
/// measurement, and a stamp that is years off must not hold the node up for hours.
constexpr Duration longest_silence = seconds(600);

}  // namespace

class Engine::Impl {
 public:
  Impl(const RangeConfig& config, const StageSet& stages, ResultSink& sink)
      : config_(config), stages_(stages), sink_(sink), ingest_(config), monitor_(config), slave_(config) {
    if (stages.align || stages.fuse) methods_.emplace(config);
  }

  void operator()(const MissionEvent&) {}  // recorded and replayed; no stage depends on the mission clock yet
  void operator()(const RadarTspi& tspi) {
    if (stages_.ingest) take(ingest_.judge(tspi));
  }
  void operator()(const GpsFix& fix) {
    if (stages_.ingest) take(ingest_.judge(fix));
  }
  void operator()(const Observation& o) {
    if (!stages_.ingest) follow(ingest_.judge(o));
  }

  void advance_to(Time now) {
    if (!last_tick_) {
      // The first tick is the first grid instant at or after the first time that this engine hears of.
      next_tick_ = ceil_to_grid(now, config_.tick);
      last_tick_ = Time{std::numeric_limits<std::int64_t>::min()};
    }
    if (now - next_tick_ > longest_silence) next_tick_ = ceil_to_grid(now - longest_silence, config_.tick);
    while (next_tick_ <= now) {
      tick(next_tick_);
      last_tick_ = next_tick_;
      next_tick_ = next_tick_ + config_.tick;
    }
  }

  [[nodiscard]] Time last_tick() const { return last_tick_.value_or(Time{std::numeric_limits<std::int64_t>::min()}); }

 private:
  /// INGEST's result, and on to the next stage.
  void take(const Observation& o) {
    sink_.emit(o);
    follow(o);
  }

  /// ALIGN and FUSE.
  void follow(const Observation& o) {
    monitor_.count(o);
    if (!methods_ || o.verdict != Reason::Accepted) return;
    methods_->process(o);
    if (stages_.align) methods_->emit_biases(o, sink_);
    if (stages_.fuse && config_.fuse.publish_on_data) methods_->emit_trajectories(o, sink_);
  }

  /// SLAVE, and what else goes out on the tick.
  void tick(Time t) {
    if (methods_ && stages_.fuse && !config_.fuse.publish_on_data) methods_->emit_trajectories_at(t, sink_);
    if (methods_ && stages_.slave) slave_.tick(t, methods_->primary(), sink_);
    if (t.ns % 1'000'000'000 == 0) monitor_.report(t, methods_ ? &methods_->primary() : nullptr, sink_);
  }

  RangeConfig config_;
  StageSet stages_;
  ResultSink& sink_;
  Ingest ingest_;
  SourceMonitor monitor_;
  std::optional<Methods> methods_;
  Slave slave_;
  std::optional<Time> last_tick_;  ///< unset before the first time heard of
  Time next_tick_;
};

Engine::Engine(const RangeConfig& config, const StageSet& stages, ResultSink& sink)
    : impl_(std::make_unique<Impl>(config, stages, sink)) {}
Engine::~Engine() = default;

Event Engine::admit(Event event) const {
  if (received_of(event) < impl_->last_tick()) set_received(event, impl_->last_tick());
  return event;
}

void Engine::handle(const Event& admitted) {
  impl_->advance_to(received_of(admitted));
  std::visit(*impl_, admitted);
}

void Engine::advance_to(Time now) { impl_->advance_to(now); }

Time Engine::last_tick() const { return impl_->last_tick(); }

}  // namespace downrange
