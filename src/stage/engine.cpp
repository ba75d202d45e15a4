#include <downrange/stage/engine.hpp>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "impact.hpp"
#include "indices.hpp"
#include "ingest.hpp"
#include "methods.hpp"
#include "slave/slave.hpp"
#include "source_monitor.hpp"

namespace downrange {

namespace {

/// Ticks end this long after the last event: longer than anything coasts (slave.coast_ms, at most 600 s), so that
/// nothing is lost, and a stamp that is years off does not hold the node up for hours.
constexpr Duration longest_silence = seconds(700);

/// Passes results on; the monitor notes what INTEGRITY says of the sources.
class IntegrityTap final : public ResultSink {
 public:
  IntegrityTap(SourceMonitor& monitor, ResultSink& sink) : monitor_(monitor), sink_(sink) {}
  void emit(const Result& result) override {
    if (const auto* integrity = std::get_if<Integrity>(&result)) monitor_.note(*integrity);
    sink_.emit(result);
  }

 private:
  SourceMonitor& monitor_;
  ResultSink& sink_;
};

}  // namespace

std::string_view role_of(const StageSet& stages) {
  const bool tracks = stages.align && stages.fuse;
  if (stages.ingest && tracks && stages.slave) return "all";
  if (stages.ingest && !stages.align && !stages.fuse && !stages.slave) return "ingest";
  return !stages.ingest && tracks ? "centre" : "part";
}

class Engine::Impl {
 public:
  Impl(const RangeConfig& config, const StageSet& stages, ResultSink& sink)
      : config_(config),
        stages_(stages),
        sink_(sink),
        ingest_(config),
        monitor_(config),
        integrity_tap_(monitor_, sink),
        slave_(config),
        sources_(config),
        ordered_by_(sources_.size()),
        held_(config.targets.size()),
        held_by_(config.targets.size()),
        antenna_will_(config.antennas.size()) {
    if (stages.align || stages.fuse) methods_.emplace(config, impartial_judges());
    if (methods_ && stages.fuse) impact_.emplace(config, methods_->integrity());
  }

  void operator()(const MissionEvent& event) { ingest_.note(event); }
  void operator()(const OperatorCommand& command) {
    const Time reset_before = bias_reset_at(command.subject);
    ingest_.note(command);
    if (methods_ && bias_reset_at(command.subject) != reset_before)
      methods_->reset_bias(sources_.find(command.subject), command.received);
  }
  void operator()(const AntennaReport& report) { ingest_.note(report); }
  void operator()(const PlatformState& state) { slave_.note(state); }
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
  /// When it was last ordered that a sensor's bias begin anew.
  [[nodiscard]] Time bias_reset_at(const Name& sensor) const {
    const SourceId source = sources_.find(sensor);
    const StandingOrder* reset = source == no_source ? nullptr : ingest_.orders().bias_reset_of(source);
    return reset == nullptr ? Time{} : reset->since;
  }

  /// INGEST's result, and on to the next stage.
  void pass_on(const Observation& o) {
    sink_.emit(o);
    align_and_fuse(o);
  }

  /// ALIGN and FUSE.
  void align_and_fuse(const Observation& o) {
    monitor_.count(o);
    if (stages_.slave) slave_.note(o);
    const bool another_copy = o.verdict == Reason::Duplicate && std::holds_alternative<Fix>(o.measured);
    if (!methods_ || (o.verdict != Reason::Accepted && !another_copy)) return;
    const bool in_flight = ingest_.left_pad(o.target, o.epoch);
    const bool noise_held = !in_flight || monitor_.doubted(o);
    methods_->process(o, in_flight, noise_held);
    if (stages_.align) methods_->emit_biases(o, sink_);
    if (stages_.fuse && config_.fuse.publish_on_data) methods_->emit_trajectories(o, sink_);
  }

  /// What is in force at this tick.
  OperatorWill will() {
    OperatorWill will{
        .ordered_by = ordered_by_, .held = held_, .held_by = held_by_, .liftoff = ingest_.mission().liftoff()};
    for (SourceId id = 0; id < static_cast<SourceId>(sources_.size()) && id < max_sources_in_set; ++id) {
      const StandingOrder* order = ingest_.orders().of(id);
      ordered_by_[static_cast<std::size_t>(id)] = order == nullptr ? Name{} : order->by;
      if (ingest_.orders().forced(id)) will.forced |= set_of(id);
      if (ingest_.orders().inhibited(id)) will.inhibited |= set_of(id);
    }
    for (std::size_t i = 0; i < held_.size(); ++i) {
      const StandingOrder* hold = ingest_.orders().hold_of(static_cast<int>(i));
      held_[i] = ingest_.orders().held_chain(static_cast<int>(i));
      held_by_[i] = hold == nullptr ? Name{} : hold->by;
    }
    return will;
  }

  /// What operators want of each antenna at this tick.
  std::span<const AntennaWill> antenna_will(Time t) {
    const auto stands = [](const StandingOrder& order) { return order.order != OperatorOrder::Release; };
    for (std::size_t i = 0; i < antenna_will_.size(); ++i) {
      const AntennaOrders& orders = ingest_.orders().of_antenna(static_cast<int>(i));
      AntennaWill& will = antenna_will_[i];
      will = {.stopped = stands(orders.stop)};
      if (tells_accounts(t)) will.orders = words_of(orders);
      if (stands(orders.trim)) {
        will.azimuth_trim_rad = orders.trim.azimuth_trim_rad;
        will.elevation_trim_rad = orders.trim.elevation_trim_rad;
      }
      if (stands(orders.target)) will.target = index_of(config_.targets, orders.target.argument);
      if (!stands(orders.source)) continue;
      const Name& configured = config_.antennas[i].target;
      const int target = will.target.value_or(configured.empty() ? 0 : index_of(config_.targets, configured));
      will.pinned = methods_->on_chain(target, orders.source.argument);
    }
    return antenna_will_;
  }

  /// INTEGRITY, SLAVE, and what else goes out on the tick.
  void tick(Time t) {
    if (methods_) methods_->judge(t, will(), integrity_tap_);
    if (methods_ && stages_.fuse && !config_.fuse.publish_on_data) methods_->emit_trajectories_at(t, sink_);
    if (methods_ && stages_.slave)
      slave_.tick(t, methods_->followed(), ingest_.mission().liftoff(), sink_, antenna_will(t),
                  ingest_.mission().planned_liftoff());
    if (impact_) impact_->tick(t, ingest_.mission().liftoff(), methods_->integrity(), sink_);
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
  IntegrityTap integrity_tap_;
  std::optional<Methods> methods_;
  std::optional<ImpactStage> impact_;
  Slave slave_;
  SourceTable sources_;
  std::vector<Name> ordered_by_;  ///< by SourceId
  std::vector<Name> held_;        ///< by target
  std::vector<Name> held_by_;
  std::vector<AntennaWill> antenna_will_;  ///< by antenna
  std::optional<Time> last_tick_;          ///< unset before the first time heard of
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
