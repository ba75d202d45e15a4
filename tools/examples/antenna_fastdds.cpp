// antenna_fastdds DOMAIN ANTENNA PROFILES SECONDS: an antenna's control program with Fast DDS. Follows
// downrange/slaving for some seconds. PROFILES is the service's dds-qos.xml. Exit status 1: no command to this antenna
// has come.

#include <downrangePubSubTypes.h>

#include <chrono>
#include <cstdlib>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <string>
#include <thread>

#include "steering.h"

namespace {

using namespace eprosima::fastdds::dds;
using eprosima::fastrtps::types::ReturnCode_t;

// Takes what has come for `antenna`; how many commands.
int take_commands(DataReader& reader, const std::string& antenna, steering& axes) {
  int taken = 0;
  downrange::wire::SlavingCommandV2 c;
  SampleInfo info;
  while (reader.take_next_sample(&c, &info) == ReturnCode_t::RETCODE_OK) {
    if (!info.valid_data || c.antenna_id().to_string() != antenna) continue;
    steering_take(&axes, {c.apply_at_ns(), c.valid_until_ns(), c.azimuth_rad(), c.elevation_rad(),
                          c.azimuth_rate_rad_s(), c.elevation_rate_rad_s()});
    ++taken;
  }
  return taken;
}

int follow(DataReader& reader, const std::string& antenna, int seconds) {
  steering axes{};
  int commands = 0;
  bool follows = false;
  for (int step = 0; step < 100 * seconds; ++step) {
    commands += take_commands(reader, antenna, axes);
    follows = steering_step(&axes, follows, step);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  std::printf("%d commands to %s\n", commands, antenna.c_str());
  return commands > 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) {
    std::fprintf(stderr, "usage: %s DOMAIN ANTENNA PROFILES SECONDS\n", argv[0]);
    return 2;
  }
  auto* factory = DomainParticipantFactory::get_instance();
  if (factory->load_XML_profiles_file(argv[3]) != ReturnCode_t::RETCODE_OK) return 2;
  DomainParticipant* participant =
      factory->create_participant_with_profile(static_cast<DomainId_t>(std::atoi(argv[1])), "downrange");
  if (participant == nullptr) return 2;
  const TypeSupport type(new downrange::wire::SlavingCommandV2PubSubType);
  type.register_type(participant);
  Topic* topic = participant->create_topic("downrange/slaving", type.get_type_name(), TOPIC_QOS_DEFAULT);
  // The profile asks for exclusive ownership (of several nodes the strongest alive is heard), 16 samples and the lease
  // by which a node that fell silent is left.
  Subscriber* subscriber = participant->create_subscriber(SUBSCRIBER_QOS_DEFAULT);
  DataReader* reader = subscriber->create_datareader_with_profile(topic, "slaving-client");
  const int status = reader == nullptr ? 2 : follow(*reader, argv[2], std::atoi(argv[4]));
  participant->delete_contained_entities();
  factory->delete_participant(participant);
  return status;
}
