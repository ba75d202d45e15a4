/// dds_owner_node DOMAIN PROFILES NODE STRENGTH: commands one antenna, the node's name as target, until it is killed.

#include <chrono>
#include <cstdlib>
#include <thread>

#include "dds/outputs.hpp"

int main(int argc, char** argv) {
  using namespace downrange;
  if (argc != 5) return 2;
  dds::Participant participant({std::atoi(argv[1]), argv[2], argv[3], dds::ClockMode::Wall});
  dds::OutputWriters writers(participant, {std::atoi(argv[4]), false, true});
  SlavingCommand command;
  command.antenna = "antenna";
  command.target = argv[3];
  while (true) {
    ++command.tick.ns;
    writers.emit(command);
    std::this_thread::sleep_for(std::chrono::milliseconds(25));
  }
}
