#pragma once
/// Inside src/dds: how long a node remembers a peer that has fallen silent.

#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>

namespace downrange::dds {

/// A node forgets a silent peer after the lease that the peer announces, a peer forgets the node after the node's.
/// Where these differ, as they do between vendors, an outage that is longer than one of them leaves a side that forgot
/// and one that did not; and then discovery, which the one takes for done and the other has not begun, may never end
/// (Cyclone DDS numbers its acknowledgements anew, Fast DDS takes them for old ones). So a node goes by its own lease
/// on both sides: of every announcement that comes in over UDP the lease is replaced by nine tenths of the node's own.
/// It forgets a peer shortly before the peer forgets it, which every vendor's discovery mends.
void remember_peers_by_own_lease(eprosima::fastdds::dds::DomainParticipantQos& qos);

}  // namespace downrange::dds
