// antenna_client DOMAIN ANTENNA PROFILES SECONDS: an antenna's control program with Fast DDS, to be copied. Follows
// downrange/slaving for some seconds, and tells range/antenna where it points. PROFILES is the service's dds-qos.xml.
// Exit status 1: no command to this antenna has come.

#include <downrangePubSubTypes.h>

#include <chrono>
#include <cstdlib>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
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
  downrange::wire::SlavingCommandV4 c;
  SampleInfo info;
  while (reader.take_next_sample(&c, &info) == ReturnCode_t::RETCODE_OK) {
    if (!info.valid_data || c.antenna_id().to_string() != antenna) continue;
    steering_take(&axes,
                  {c.tick_ns(), c.apply_at_ns(), c.valid_until_ns(), c.azimuth_rad(), c.elevation_rad(),
                   c.azimuth_rate_rad_s(), c.elevation_rate_rad_s(), c.acceleration_valid(),
                   c.azimuth_acceleration_rad_s2(), c.elevation_acceleration_rad_s2()},
                  utc_now_ns());
    ++taken;
  }
  return taken;
}

// Where the encoders say that it points. `simulated` stays false: a service that flies a rehearsal passes over it.
void report(DataWriter& writer, downrange::wire::AntennaReportV2& sample, const mount& axes) {
  sample.sequence_number(sample.sequence_number() + 1);
  sample.epoch_ns(utc_now_ns());
  sample.azimuth_rad(axes.azimuth_rad);
  sample.elevation_rad(axes.elevation_rad);
  sample.azimuth_valid(true);
  sample.elevation_valid(true);
  sample.mode(axes.follows ? downrange::wire::ANTENNA_SLAVED : downrange::wire::ANTENNA_MANUAL);
  sample.command_tick_ns(axes.tick_ns);
  if (!writer.write(&sample)) std::fprintf(stderr, "a report could not be written\n");
}

int follow(DataReader& reader, DataWriter& writer, const std::string& antenna, int seconds) {
  steering commands{};
  mount axes{};
  downrange::wire::AntennaReportV2 sample;
  sample.antenna_id(antenna.c_str());
  int taken = 0;
  for (int step = 0; step < 1000 / servo_step_ms * seconds; ++step) {
    taken += take_commands(reader, antenna, commands);
    mount_step(&axes, &commands, utc_now_ns(), step);
    if (step % report_every == 0) report(writer, sample, axes);
    std::this_thread::sleep_for(std::chrono::milliseconds(servo_step_ms));
  }
  std::printf("%d commands to %s\n", taken, antenna.c_str());
  return taken > 0 ? 0 : 1;
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
  const TypeSupport command_type(new downrange::wire::SlavingCommandV4PubSubType);
  const TypeSupport report_type(new downrange::wire::AntennaReportV2PubSubType);
  command_type.register_type(participant);
  report_type.register_type(participant);
  Topic* commands = participant->create_topic("downrange/slaving", command_type.get_type_name(), TOPIC_QOS_DEFAULT);
  Topic* reports = participant->create_topic("range/antenna", report_type.get_type_name(), TOPIC_QOS_DEFAULT);
  // The profile asks for exclusive ownership (of several nodes the strongest alive is heard), 16 samples and the lease
  // by which a node that fell silent is left.
  Subscriber* subscriber = participant->create_subscriber(SUBSCRIBER_QOS_DEFAULT);
  DataReader* reader = subscriber->create_datareader_with_profile(commands, "slaving-client");
  Publisher* publisher = participant->create_publisher(PUBLISHER_QOS_DEFAULT);
  DataWriter* writer = publisher->create_datawriter_with_profile(reports, "stream");
  const bool open = reader != nullptr && writer != nullptr;
  const int status = open ? follow(*reader, *writer, argv[2], std::atoi(argv[4])) : 2;
  participant->delete_contained_entities();
  factory->delete_participant(participant);
  return status;
}
