#include "dds/qos.hpp"

#include <array>

#include "dds/topics.hpp"

namespace downrange::dds {
namespace {

using namespace eprosima::fastdds::dds;
using eprosima::fastrtps::c_TimeInfinite;

constexpr std::array<const char*, 13> topic_names{
    topics::radar_tspi, topics::angles,          topics::gps,         topics::mission, topics::clock,
    topics::clock_ack,  topics::ingest_progress, topics::observation, topics::bias,    topics::trajectory,
    topics::slaving,    topics::health,          topics::status};

/// A writer waits this long for slow readers before its write fails.
const eprosima::fastrtps::Duration_t range_blocking_time{10, 0};

/// A consumer that died holds the flight back no longer than this: shorter than the driver's timeout.
const eprosima::fastrtps::Duration_t range_lease{5, 0};

bool is_stream(std::string_view topic) {
  return topic != topics::clock_ack && topic != topics::health && topic != topics::status;
}

template <class Qos>
void make_timeless(Qos& qos) {
  qos.durability().kind = VOLATILE_DURABILITY_QOS;
  qos.deadline().period = c_TimeInfinite;
  qos.lifespan().duration = c_TimeInfinite;
  qos.liveliness().kind = AUTOMATIC_LIVELINESS_QOS;
  qos.liveliness().lease_duration = c_TimeInfinite;
  qos.liveliness().announcement_period = c_TimeInfinite;
}

}  // namespace

std::span<const char* const> all_topics() { return topic_names; }

void adapt_to_range_clock(DomainParticipantQos& qos) {
  qos.wire_protocol().builtin.discovery_config.leaseDuration = range_lease;
}

void adapt_to_range_clock(std::string_view topic, DataWriterQos& qos) {
  if (!is_stream(topic)) return;
  make_timeless(qos);
  qos.history().kind = KEEP_ALL_HISTORY_QOS;
  qos.reliability().kind = RELIABLE_RELIABILITY_QOS;
  qos.reliability().max_blocking_time = range_blocking_time;
}

void adapt_to_range_clock(std::string_view topic, bool lossless, DataReaderQos& qos) {
  if (!is_stream(topic)) return;
  make_timeless(qos);
  if (lossless) {
    qos.history().kind = KEEP_ALL_HISTORY_QOS;
    qos.reliability().kind = RELIABLE_RELIABILITY_QOS;
  } else {
    qos.reliability().kind = BEST_EFFORT_RELIABILITY_QOS;
  }
}

}  // namespace downrange::dds
