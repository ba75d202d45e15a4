/// dds_outage_node DOMAIN: a node's DDS without its engine. Prints "heard SOURCE UTC_NS" for each input and commands
/// the antennas "cyclone" and "fast" at 40 Hz, until it is killed.

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "dds/inputs.hpp"
#include "dds/outputs.hpp"

int main(int argc, char** argv) {
  using namespace downrange;
  if (argc != 2) return 2;
  const auto utc_now = [] {
    return Time{std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count()};
  };
  dds::Participant participant({std::atoi(argv[1]), {}, "node", dds::ClockMode::Wall});
  dds::OutputOptions options;
  options.owned_keys<SlavingCommand>() = {{"cyclone", {}}, {"fast", {}}};
  dds::OutputWriters writers(participant, options);
  const dds::InputReader reader(participant, {}, [&](const Event& event, const dds::RangeStamp&, const Name&) {
    const auto* plot = std::get_if<RadarTspi>(&event);
    if (plot == nullptr) return;
    std::printf("heard %s %lld\n", plot->sensor.c_str(), static_cast<long long>(plot->received.ns));
    std::fflush(stdout);
  });
  while (true) {
    for (const auto& [antenna, none] : options.owned_keys<SlavingCommand>()) {
      SlavingCommand command;
      command.antenna = antenna;
      command.target = "node";
      command.tick = utc_now();
      command.apply_at = command.tick;
      command.valid_until = command.tick + seconds(0.2);
      writers.emit(command);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(25));
  }
}
