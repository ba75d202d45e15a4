#include "stage/slave/slave.hpp"

#include "stage/slave/antenna_pointing.hpp"

namespace downrange {

Slave::Slave(const RangeConfig& config)
    : config_(std::make_unique<const RangeConfig>(config)), paths_(config.targets.size()) {
  for (const AntennaConfig& antenna : config_->antennas)
    antennas_.push_back(std::make_unique<AntennaPointing>(antenna, *config_));
}

Slave::~Slave() = default;

void Slave::tick(Time tick, std::span<const Followed> followed, std::optional<Time> liftoff, ResultSink& sink,
                 std::span<const AntennaWill> will) {
  const AntennaWill nothing;
  for (std::size_t i = 0; i < antennas_.size(); ++i) {
    const auto& antenna = antennas_[i];
    const AntennaWill& wanted = will.empty() ? nothing : will[i];
    if (wanted.stopped) continue;
    antenna->obey(wanted);
    const auto target = static_cast<std::size_t>(antenna->target());
    std::optional<Aim> aim;
    if (wanted.pinned) aim = antenna->aim(*wanted.pinned, liftoff, tick);
    if (!aim || aim->origin.source == SlavingSource::Nominal) aim = antenna->aim(followed[target], liftoff, tick);
    if (!aim) continue;
    paths_[target].update(*aim, config_->targets[target].nominal, config_->slave, liftoff, tick);
    if (const auto command = antenna->command(*aim, followed[target], paths_[target], tick)) sink.emit(*command);
  }
}

}  // namespace downrange
