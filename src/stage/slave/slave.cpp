#include "stage/slave/slave.hpp"

#include "stage/slave/antenna_pointing.hpp"

namespace downrange {

Slave::Slave(const RangeConfig& config)
    : config_(std::make_unique<const RangeConfig>(config)), paths_(config.targets.size()) {
  for (const AntennaConfig& antenna : config_->antennas)
    antennas_.push_back(std::make_unique<AntennaPointing>(antenna, *config_));
}

Slave::~Slave() = default;

void Slave::tick(Time tick, std::span<const Followed> followed, std::optional<Time> liftoff, ResultSink& sink) {
  for (const auto& antenna : antennas_) {
    // What an operator orders for an antenna takes effect here: which target, from which rung of the ladder on, an
    // angle that is added to the command, or no command at all.
    const auto target = static_cast<std::size_t>(antenna->target());
    const auto aim = antenna->aim(followed[target], liftoff, tick);
    if (!aim) continue;
    paths_[target].update(*aim, config_->targets[target].nominal, config_->slave, liftoff, tick);
    if (const auto command = antenna->command(*aim, followed[target], paths_[target], tick)) sink.emit(*command);
  }
}

}  // namespace downrange
