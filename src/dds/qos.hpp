#pragma once
/// Inside src/dds: how the profiles are changed for the range clock.

#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>
#include <string_view>

namespace downrange::dds {

/// The lease of participants: that of the wall clock outlives outages, which a run on the range clock does not.
void adapt_to_range_clock(eprosima::fastdds::dds::DomainParticipantQos& qos);
/// Topics whose newest sample says all (Delivery::State) keep their profile on the range clock. The others
/// are a stream: keep all, bounded blocking, volatile, neither deadline, lifespan nor lease.
void adapt_to_range_clock(std::string_view topic, eprosima::fastdds::dds::DataWriterQos& qos);
/// `lossless` false: best effort with the history of the profile. The writer never waits for this reader.
void adapt_to_range_clock(std::string_view topic, bool lossless, eprosima::fastdds::dds::DataReaderQos& qos);

}  // namespace downrange::dds
