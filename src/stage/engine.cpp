#include <downrange/stage/engine.hpp>
#include <limits>
#include <optional>

#include "ingest.hpp"
#include "methods.hpp"
#include "slave.hpp"
#include "source_monitor.hpp"

namespace downrange {

namespace {

/// Ticks end this long after the last event: longer than anything coasts (slave.coast_ms, at most 600 s), so that
/// nothing is lost, and a stamp that is years off does not hold the node up for hours.
constexpr Duration longest_silence = seconds(700);

}  // namespace

class Engine::Impl {
 public:
  Impl(const RangeConfig& config, const StageSet& stages, ResultSink& sink)
      : config_(config), stages_(stages), sink_(sink), ingest_(config), monitor_(config), slave_(config) {
    if (stages.align || stages.fuse) methods_.emplace(config);
  }

  void operator()(const MissionEvent& event) { ingest_.note(event); }
  void operator()(const OperatorCommand& command) { ingest_.note(command); }
  // Recorded and replayed; no stage depends on them yet.
  void operator()(const AntennaReport&) {}
  void operator()(const PlatformState&) {}
  void operator()(const RadarTspi& tspi) {
    if (stages_.ingest) pass_on(ingest_.judge(tspi));
  }
  void operator()(const GpsFix& fix) {
    if (stages_.ingest) pass_on(ingest_.judge(fix));
  }
  void operator()(const AngleTspi& tspi) {
    if (stages_.ingest) pass_on(ingest_.judge(tspi));
  }
  void operator()(const Observation& o) {
    if (!stages_.ingest) align_and_fuse(ingest_.judge(o));
  }
  void operator()(const ClockGap& gap) {
    if (!plausible(gap.epoch) || !last_tick_ || gap.epoch <= next_tick_) return;
    next_tick_ = ceil_to_grid(gap.epoch, config_.tick);
    last_tick_ = next_tick_ - config_.tick;
    last_event_ = gap.epoch;
  }

  /// The time of an event, before it is handled.
  void event_at(Time received) {
    if (!plausible(received)) return;  // not a time that could drive anything; ingest rejects what carries it
    advance_to(received);
    last_event_ = received;
  }

  void advance_to(Time now) {
    if (!plausible(now)) return;
    if (!last_tick_) {
      // The first tick is the first grid instant at or after the first time that this engine hears of.
      next_tick_ = ceil_to_grid(now, config_.tick);
      last_tick_ = Time{std::numeric_limits<std::int64_t>::min()};
      last_event_ = now;
    }
    while (next_tick_ <= now) {
      if (next_tick_ > last_event_ + longest_silence) {
        next_tick_ = ceil_to_grid(now + Duration{1}, config_.tick);
        last_tick_ = next_tick_ - config_.tick;
        return;
      }
      tick(next_tick_);
      last_tick_ = next_tick_;
      next_tick_ = next_tick_ + config_.tick;
    }
  }

  [[nodiscard]] Time last_tick() const { return last_tick_.value_or(Time{std::numeric_limits<std::int64_t>::min()}); }

 private:
  /// INGEST's result, and on to the next stage.
  void pass_on(const Observation& o) {
    sink_.emit(o);
    align_and_fuse(o);
  }

  /// ALIGN and FUSE.
  void align_and_fuse(const Observation& o) {
    monitor_.count(o);
    if (!methods_ || o.verdict != Reason::Accepted) return;
    methods_->process(o, ingest_.left_pad(o.target, o.epoch));
    if (stages_.align) methods_->emit_biases(o, sink_);
    if (stages_.fuse && config_.fuse.publish_on_data) methods_->emit_trajectories(o, sink_);
  }

  /// SLAVE, and what else goes out on the tick.
  void tick(Time t) {
    if (methods_ && stages_.fuse && !config_.fuse.publish_on_data) methods_->emit_trajectories_at(t, sink_);
    if (methods_ && stages_.slave) slave_.tick(t, methods_->primary(), methods_->newest(), sink_);
    if (t.ns % 1'000'000'000 == 0) monitor_.report(t, views(), sink_);
  }

  [[nodiscard]] SourceMonitor::Views views() const {
    SourceMonitor::Views views{.orders = &ingest_.orders()};
    if (methods_) {
      views.method = &methods_->primary();
      views.residuals = &methods_->residuals();
    }
    return views;
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
  Time last_event_;
};

Engine::Engine(const RangeConfig& config, const StageSet& stages, ResultSink& sink)
    : impl_(std::make_unique<Impl>(config, stages, sink)) {}
Engine::~Engine() = default;

Event Engine::admit(Event event) const {
  if (received_of(event) < impl_->last_tick()) set_received(event, impl_->last_tick());
  return event;
}

void Engine::handle(const Event& admitted) {
  impl_->event_at(received_of(admitted));
  std::visit(*impl_, admitted);
}

void Engine::advance_to(Time now) { impl_->advance_to(now); }

Time Engine::last_tick() const { return impl_->last_tick(); }

}  // namespace downrange
