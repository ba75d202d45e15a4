#include "stage/slave/slave.hpp"

#include "stage/slave/antenna_pointing.hpp"

namespace downrange {

Slave::Slave(const RangeConfig& config)
    : config_(std::make_unique<const RangeConfig>(config)),
      paths_(config.targets.size()),
      pinned_paths_(config.antennas.size()) {
  for (const AntennaConfig& antenna : config_->antennas)
    antennas_.push_back(std::make_unique<AntennaPointing>(antenna, *config_));
}

Slave::~Slave() = default;

void Slave::note(const Observation& o) {
  const Plot plot = std::holds_alternative<Fix>(o.measured) ? Plot{.angles_valid = false} : plot_of(o.measured);
  if (o.verdict != Reason::Accepted || !plot.angles_valid) return;
  for (const auto& antenna : antennas_) {
    const auto target = static_cast<std::size_t>(antenna->target());
    if (antenna->antenna().sensor == o.sensor && config_->targets[target].id == o.target)
      antenna->note_reading(o.epoch, plot.measured.azimuth_rad, plot.measured.elevation_rad);
  }
}

void Slave::note(const PlatformState& state) {
  if (state.simulated != config_->ingest.expect_simulated) return;
  for (const auto& antenna : antennas_)
    if (antenna->antenna().id == state.antenna) antenna->note(state);
}

const TargetPath* Slave::command(std::size_t i, const AntennaWill& wanted, std::span<const Followed> followed,
                                 std::optional<Time> liftoff, Time tick, ResultSink& sink) {
  AntennaPointing& antenna = *antennas_[i];
  antenna.obey(wanted);
  const auto target = static_cast<std::size_t>(antenna.target());
  std::optional<Aim> aim;
  if (wanted.pinned) aim = antenna.aim(*wanted.pinned, liftoff, tick);
  const bool pinned = aim && aim->origin.source != SlavingSource::Nominal;
  if (!pinned) aim = antenna.aim(followed[target], liftoff, tick);
  if (!aim) return nullptr;
  // Where a chain that an operator chose for one antenna has the target is no matter of the others.
  TargetPath& path = pinned ? pinned_paths_[i] : paths_[target];
  path.update(*aim, config_->targets[target].nominal, config_->slave, liftoff, tick);
  if (const auto command = antenna.command(*aim, followed[target], path, tick)) sink.emit(*command);
  return &path;
}

void Slave::tick(Time tick, std::span<const Followed> followed, std::optional<Time> liftoff, ResultSink& sink,
                 std::span<const AntennaWill> will, std::optional<Time> planned_liftoff) {
  const AntennaWill nothing;
  for (std::size_t i = 0; i < antennas_.size(); ++i) {
    const auto& antenna = antennas_[i];
    const AntennaWill& wanted = will.empty() ? nothing : will[i];
    const TargetPath* path = nullptr;
    if (!wanted.stopped) path = command(i, wanted, followed, liftoff, tick, sink);
    if (tells_accounts(tick)) sink.emit(antenna->account(wanted, path, planned_liftoff, tick));
  }
}

}  // namespace downrange
