/// A radar or an antenna with Fast DDS as it comes: default participant, default lease, default announcements.
///
/// fast_range_peer DOMAIN radar NAME: a plot every 50 ms. fast_range_peer DOMAIN antenna NAME: prints
/// "heard NODE UTC_NS" for each command to that antenna. Until killed.

#include <downrangePubSubTypes.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <string>
#include <thread>

namespace {

using namespace eprosima::fastdds::dds;
using namespace downrange;

long long utc_now_ns() { return std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count(); }

Topic* topic(DomainParticipant& participant, const char* name, const TypeSupport& type) {
  type.register_type(&participant);
  return participant.create_topic(name, type.get_type_name(), TOPIC_QOS_DEFAULT);
}

void be_radar(DomainParticipant& participant, const char* name) {
  Publisher* publisher = participant.create_publisher(PUBLISHER_QOS_DEFAULT);
  DataWriter* writer = publisher->create_datawriter(
      topic(participant, "range/radar_tspi", TypeSupport(new wire::RadarTspiV2PubSubType)), DATAWRITER_QOS_DEFAULT);
  wire::RadarTspiV2 plot;
  plot.sensor_id() = name;
  plot.target_id() = "vehicle";
  plot.range_valid(true);
  plot.azimuth_valid(true);
  plot.elevation_valid(true);
  plot.mode(wire::TRACK_MODE_TRACK);
  while (true) {
    plot.sequence_number(plot.sequence_number() + 1);
    plot.epoch_ns(utc_now_ns());
    writer->write(&plot);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
}

/// What the profile `slaving-client` of config/dds-qos.xml asks for.
DataReaderQos antenna_qos() {
  DataReaderQos qos = DATAREADER_QOS_DEFAULT;
  qos.reliability().kind = RELIABLE_RELIABILITY_QOS;
  qos.history().depth = 16;
  qos.ownership().kind = EXCLUSIVE_OWNERSHIP_QOS;
  qos.deadline().period = {0, 100'000'000};
  qos.liveliness().kind = MANUAL_BY_TOPIC_LIVELINESS_QOS;
  qos.liveliness().lease_duration = {0, 200'000'000};
  qos.lifespan().duration = {1, 0};
  return qos;
}

void be_antenna(DomainParticipant& participant, const std::string& name) {
  Subscriber* subscriber = participant.create_subscriber(SUBSCRIBER_QOS_DEFAULT);
  DataReader* reader = subscriber->create_datareader(
      topic(participant, "downrange/slaving", TypeSupport(new wire::SlavingCommandV4PubSubType)), antenna_qos());
  wire::SlavingCommandV4 command;
  SampleInfo info;
  while (true) {
    while (reader->take_next_sample(&command, &info) == eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data || name != command.antenna_id().c_str()) continue;
      std::printf("heard %s %lld\n", command.target_id().c_str(), utc_now_ns());
      std::fflush(stdout);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  DomainParticipant* participant = DomainParticipantFactory::get_instance()->create_participant(
      static_cast<DomainId_t>(std::atoi(argv[1])), PARTICIPANT_QOS_DEFAULT);
  if (participant == nullptr) return 2;
  if (std::string(argv[2]) == "radar") {
    be_radar(*participant, argv[3]);
  } else {
    be_antenna(*participant, argv[3]);
  }
}
