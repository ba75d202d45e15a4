// radar_sender DOMAIN SENSOR TARGET PROFILES SECONDS: a radar that tracks a made-up climb and sends 20 plots a second
// to range/radar_tspi, with Fast DDS. PROFILES is the service's dds-qos.xml. Exit status 1: nobody has heard it.

#include <downrangePubSubTypes.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <numbers>
#include <thread>

namespace {

using namespace eprosima::fastdds::dds;
using eprosima::fastrtps::types::ReturnCode_t;
using Clock = std::chrono::system_clock;

// What the radar measures of the climb, seconds after its start: east 100 m/s, north -300 m/s, up 400 m/s.
void measure(double t_s, downrange::wire::RadarTspiV2& plot) {
  const double east = 1000 + 100 * t_s;
  const double north = -5000 - 300 * t_s;
  const double up = 3000 + 400 * t_s;
  plot.range_m(std::hypot(east, north, up));
  plot.azimuth_rad(std::fmod(std::atan2(east, north) + 2 * std::numbers::pi, 2 * std::numbers::pi));
  plot.elevation_rad(std::atan2(up, std::hypot(east, north)));
}

bool send(DataWriter& writer, const char* sensor, const char* target, int seconds) {
  downrange::wire::RadarTspiV2 plot;
  plot.sensor_id(sensor);
  plot.target_id(target);
  plot.range_valid(true);
  plot.azimuth_valid(true);
  plot.elevation_valid(true);
  plot.mode(downrange::wire::TRACK_MODE_TRACK);
  bool heard = false;
  const auto start = Clock::now();
  for (int n = 1; n <= 20 * seconds; ++n) {
    // The instant at which the plot is true, not the one at which it is sent. A live sender leaves `stamp` at zero.
    const auto epoch = start + n * std::chrono::milliseconds(50);
    std::this_thread::sleep_until(epoch);
    plot.sequence_number(static_cast<std::uint64_t>(n));
    plot.epoch_ns(std::chrono::duration_cast<std::chrono::nanoseconds>(epoch.time_since_epoch()).count());
    measure(std::chrono::duration<double>(epoch - start).count(), plot);
    if (!writer.write(&plot)) std::fprintf(stderr, "plot %d could not be written\n", n);
    PublicationMatchedStatus matched;
    heard = heard ||
            (writer.get_publication_matched_status(matched) == ReturnCode_t::RETCODE_OK && matched.current_count > 0);
  }
  return heard;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 6) {
    std::fprintf(stderr, "usage: %s DOMAIN SENSOR TARGET PROFILES SECONDS\n", argv[0]);
    return 2;
  }
  auto* factory = DomainParticipantFactory::get_instance();
  if (factory->load_XML_profiles_file(argv[4]) != ReturnCode_t::RETCODE_OK) return 2;
  DomainParticipant* participant =
      factory->create_participant_with_profile(static_cast<DomainId_t>(std::atoi(argv[1])), "downrange");
  if (participant == nullptr) return 2;
  const TypeSupport type(new downrange::wire::RadarTspiV2PubSubType);
  type.register_type(participant);
  Topic* topic = participant->create_topic("range/radar_tspi", type.get_type_name(), TOPIC_QOS_DEFAULT);
  Publisher* publisher = participant->create_publisher(PUBLISHER_QOS_DEFAULT);
  DataWriter* writer = publisher->create_datawriter_with_profile(topic, "stream");
  int status = 2;
  if (writer != nullptr) {
    const bool heard = send(*writer, argv[2], argv[3], std::atoi(argv[5]));
    std::printf("%s\n", heard ? "heard" : "nobody reads range/radar_tspi in this domain");
    status = heard ? 0 : 1;
  }
  participant->delete_contained_entities();
  factory->delete_participant(participant);
  return status;
}
