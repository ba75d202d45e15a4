#include "dds/mismatch.hpp"

#include <fastdds/rtps/participant/ParticipantDiscoveryInfo.h>
#include <fastdds/rtps/reader/ReaderDiscoveryInfo.h>
#include <fastdds/rtps/writer/WriterDiscoveryInfo.h>
#include <fastrtps/utils/IPLocator.h>

#include <algorithm>
#include <array>
#include <sstream>
#include <string_view>

#include "dds/topics.hpp"

namespace downrange::dds {
namespace {

using namespace eprosima::fastdds::dds;
using eprosima::fastrtps::Duration_t;
using eprosima::fastrtps::rtps::IPLocator;
using eprosima::fastrtps::rtps::ParticipantDiscoveryInfo;
using eprosima::fastrtps::rtps::ReaderDiscoveryInfo;
using eprosima::fastrtps::rtps::WriterDiscoveryInfo;

/// A stranger could announce endpoints without end.
constexpr std::size_t most_remotes = 4096;

template <std::size_t Size, class Kind>
std::string name_of(const std::array<const char*, Size>& names, Kind kind) {
  const auto index = static_cast<std::size_t>(kind);
  return index < Size ? names[index] : "kind " + std::to_string(index);
}

std::string name_of(ReliabilityQosPolicyKind kind) {
  return kind == RELIABLE_RELIABILITY_QOS ? "RELIABLE" : "BEST_EFFORT";
}
std::string name_of(DurabilityQosPolicyKind_t kind) {
  return name_of(std::array{"VOLATILE", "TRANSIENT_LOCAL", "TRANSIENT", "PERSISTENT"}, kind);
}
std::string name_of(OwnershipQosPolicyKind kind) { return name_of(std::array{"SHARED", "EXCLUSIVE"}, kind); }
std::string name_of(LivelinessQosPolicyKind kind) {
  return name_of(std::array{"AUTOMATIC", "MANUAL_BY_PARTICIPANT", "MANUAL_BY_TOPIC"}, kind);
}
std::string name_of(DestinationOrderQosPolicyKind kind) {
  return name_of(std::array{"BY_RECEPTION_TIMESTAMP", "BY_SOURCE_TIMESTAMP"}, kind);
}
std::string name_of(PresentationQosPolicyAccessScopeKind kind) {
  return name_of(std::array{"INSTANCE", "TOPIC", "GROUP"}, kind);
}
std::string name_of(const Duration_t& duration) {
  if (duration == eprosima::fastrtps::c_TimeInfinite) return "infinite";
  std::ostringstream text;
  text << static_cast<double>(duration.to_ns()) * 1e-9 << " s";
  return text.str();
}
std::string name_of(const PartitionQosPolicy& partition) {
  std::string text;
  for (const std::string& name : partition.names()) text += (text.empty() ? "" : ",") + name;
  return text.empty() ? "none" : text;
}
/// An empty list means XCDR1.
std::string name_of(const DataRepresentationQosPolicy& representation) {
  std::string text;
  for (const auto id : representation.m_value)
    text += (text.empty() ? "" : ",") + name_of(std::array{"XCDR1", "XML", "XCDR2"}, id);
  return text.empty() ? "XCDR1" : text;
}
std::string name_of(bool yes) { return yes ? "yes" : "no"; }

/// The writer's first representation must be one of the reader's.
bool represented(const DataRepresentationQosPolicy& offered, const DataRepresentationQosPolicy& asked) {
  const auto id = offered.m_value.empty() ? XCDR_DATA_REPRESENTATION : offered.m_value.front();
  if (asked.m_value.empty()) return id == XCDR_DATA_REPRESENTATION;
  return std::ranges::find(asked.m_value, id) != asked.m_value.end();
}

/// Without wild cards, which nobody on a range needs.
bool share_partition(const PartitionQosPolicy& a, const PartitionQosPolicy& b) {
  const std::vector<std::string> of_a = a.names();
  const std::vector<std::string> of_b = b.names();
  const auto only_default = [](const std::vector<std::string>& names) {
    return names.empty() || std::ranges::find(names, std::string()) != names.end();
  };
  if (only_default(of_a) && only_default(of_b)) return true;
  return std::ranges::any_of(of_a,
                             [&](const std::string& name) { return std::ranges::find(of_b, name) != of_b.end(); });
}

template <class Locators>
std::string address_of(const Locators& locators) {
  return locators.unicast.empty() ? std::string() : IPLocator::ip_to_string(*locators.unicast.begin());
}

bool is_ours(const std::string& topic) {
  return std::ranges::any_of(all_topics(), [&](const Topic& known) { return topic == known.name; });
}

template <class Map, class Info>
void keep(Map& remotes, const Info& info, const auto& qos, bool removed) {
  const std::string topic = info.topicName().to_string();
  if (removed) {
    remotes.erase(info.guid());
  } else if (is_ours(topic) && remotes.size() < most_remotes) {
    const bool keyed = info.topicKind() == eprosima::fastrtps::rtps::WITH_KEY;
    remotes[info.guid()] = {{topic, info.typeName().to_string(), keyed, qos}, address_of(info.remote_locators())};
  }
}

}  // namespace

std::string why_no_match(const WriterEndpoint& writer, const ReaderEndpoint& reader) {
  std::string why;
  const auto require = [&](bool holds, const char* policy, const auto& offered, const auto& asked) {
    if (holds) return;
    why += std::string(why.empty() ? "" : "; ") + policy + ": " + offered + " offered, " + asked + " asked";
  };
  const auto require_policy = [&](bool holds, const char* policy, const auto& offered, const auto& asked) {
    require(holds, policy, name_of(offered), name_of(asked));
  };
  const WriterQos& o = writer.qos;
  const ReaderQos& a = reader.qos;
  require(writer.type == reader.type, "type", writer.type, reader.type);
  require_policy(writer.keyed == reader.keyed, "key", writer.keyed, reader.keyed);
  require_policy(o.m_reliability.kind >= a.m_reliability.kind, "reliability", o.m_reliability.kind,
                 a.m_reliability.kind);
  require_policy(o.m_durability.kind >= a.m_durability.kind, "durability", o.m_durability.kind, a.m_durability.kind);
  require_policy(o.m_ownership.kind == a.m_ownership.kind, "ownership", o.m_ownership.kind, a.m_ownership.kind);
  require_policy(o.m_deadline.period <= a.m_deadline.period, "deadline", o.m_deadline.period, a.m_deadline.period);
  require_policy(o.m_liveliness.kind >= a.m_liveliness.kind, "liveliness", o.m_liveliness.kind, a.m_liveliness.kind);
  require_policy(o.m_liveliness.lease_duration <= a.m_liveliness.lease_duration, "liveliness lease",
                 o.m_liveliness.lease_duration, a.m_liveliness.lease_duration);
  require_policy(share_partition(o.m_partition, a.m_partition), "partition", o.m_partition, a.m_partition);
  require_policy(o.m_destinationOrder.kind >= a.m_destinationOrder.kind, "destination order", o.m_destinationOrder.kind,
                 a.m_destinationOrder.kind);
  require_policy(o.m_latencyBudget.duration <= a.m_latencyBudget.duration, "latency budget", o.m_latencyBudget.duration,
                 a.m_latencyBudget.duration);
  require_policy(o.m_presentation.access_scope >= a.m_presentation.access_scope, "presentation",
                 o.m_presentation.access_scope, a.m_presentation.access_scope);
  require_policy(represented(o.representation, a.representation), "data representation", o.representation,
                 a.representation);
  return why;
}

void Mismatches::add_own(const WriterEndpoint& writer) {
  const std::scoped_lock lock(mutex_);
  own_writers_.try_emplace(writer.topic, writer);
}

void Mismatches::add_own(const ReaderEndpoint& reader) {
  const std::scoped_lock lock(mutex_);
  own_readers_.try_emplace(reader.topic, reader);
}

std::vector<std::string> Mismatches::texts() const {
  const std::scoped_lock lock(mutex_);
  std::vector<std::string> texts;
  const auto add = [&](const char* side, const Guid& guid, const auto& remote, const std::string& why) {
    if (!why.empty())
      texts.push_back(remote.endpoint.topic + ": " + side + " " + who_locked(guid, remote.address) + ": " + why);
  };
  for (const auto& [guid, remote] : writers_) {
    const auto own = own_readers_.find(remote.endpoint.topic);
    if (own != own_readers_.end()) add("writer", guid, remote, why_no_match(remote.endpoint, own->second));
  }
  for (const auto& [guid, remote] : readers_) {
    const auto own = own_writers_.find(remote.endpoint.topic);
    if (own != own_writers_.end()) add("reader", guid, remote, why_no_match(own->second, remote.endpoint));
  }
  return texts;
}

void Mismatches::on_participant_discovery(DomainParticipant*, ParticipantDiscoveryInfo&& info) {
  const bool gone = info.status == ParticipantDiscoveryInfo::REMOVED_PARTICIPANT ||
                    info.status == ParticipantDiscoveryInfo::DROPPED_PARTICIPANT;
  const std::scoped_lock lock(mutex_);
  const Prefix& prefix = info.info.m_guid.guidPrefix;
  if (!gone) {
    if (names_.size() < most_remotes) names_[prefix] = info.info.m_participantName.to_string();
    return;
  }
  names_.erase(prefix);
  const auto of_it = [&](const auto& remote) { return remote.first.guidPrefix == prefix; };
  std::erase_if(writers_, of_it);
  std::erase_if(readers_, of_it);
}

void Mismatches::on_subscriber_discovery(DomainParticipant*, ReaderDiscoveryInfo&& info) {
  const std::scoped_lock lock(mutex_);
  keep(readers_, info.info, info.info.m_qos, info.status == ReaderDiscoveryInfo::REMOVED_READER);
}

void Mismatches::on_publisher_discovery(DomainParticipant*, WriterDiscoveryInfo&& info) {
  const std::scoped_lock lock(mutex_);
  keep(writers_, info.info, info.info.m_qos, info.status == WriterDiscoveryInfo::REMOVED_WRITER);
}

std::string Mismatches::who_locked(const Guid& guid, const std::string& address) const {
  std::ostringstream text;
  const auto name = names_.find(guid.guidPrefix);
  if (name != names_.end() && !name->second.empty()) text << '\'' << name->second << "' ";
  if (!address.empty()) text << "at " << address << ' ';
  text << '(' << guid.guidPrefix << ')';
  return text.str();
}

}  // namespace downrange::dds
