#include "dds/qos.hpp"

#include <algorithm>

#include "dds/topics.hpp"

namespace downrange::dds {
namespace {

using namespace eprosima::fastdds::dds;
using eprosima::fastrtps::c_TimeInfinite;

/// A writer waits this long for slow readers before its write fails.
const eprosima::fastrtps::Duration_t range_blocking_time{10, 0};

/// A consumer that died holds the flight back no longer than this: shorter than the driver's timeout.
const eprosima::fastrtps::Duration_t range_lease{5, 0};

/// On the range clock: every sample is waited for.
bool is_stream(std::string_view topic) {
  const auto& all = all_topics();
  const auto found = std::ranges::find(all, topic, &Topic::name);
  return found == all.end() || found->delivery != Delivery::State;
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

const std::vector<Topic>& all_topics() {
  static const std::vector<Topic> topics = [] {
    std::vector<Topic> all{{topics::clock, Delivery::Stream},
                           {topics::clock_ack, Delivery::State},
                           {topics::ingest_progress, Delivery::Stream},
                           {topics::status, Delivery::State}};
    const auto add = [&]<class Record>() {
      all.push_back({MessageInfo<Record>::topic.data(), MessageInfo<Record>::delivery});
    };
    Inputs::for_each(add);
    Outputs::for_each(add);
    return all;
  }();
  return topics;
}

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
