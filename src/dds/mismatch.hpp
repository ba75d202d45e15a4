#pragma once
/// Inside src/dds: peers that are there, on a topic of this node's, and do not match it.

#include <fastdds/rtps/common/Guid.h>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/publisher/qos/WriterQos.hpp>
#include <fastdds/dds/subscriber/qos/ReaderQos.hpp>

#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace downrange::dds {

/// One side of a topic, as discovery tells of it.
template <class Qos>
struct Endpoint {
  std::string topic;
  std::string type;
  bool keyed = true;
  Qos qos;
};
using WriterEndpoint = Endpoint<eprosima::fastdds::dds::WriterQos>;
using ReaderEndpoint = Endpoint<eprosima::fastdds::dds::ReaderQos>;

/// Why the two do not match: "reliability: BEST_EFFORT offered, RELIABLE asked", one after the other; empty: they do.
[[nodiscard]] std::string why_no_match(const WriterEndpoint& writer, const ReaderEndpoint& reader);

/// Keeps what discovery tells of others, and compares it with this node's own endpoints. Thread-safe.
class Mismatches final : public eprosima::fastdds::dds::DomainParticipantListener {
 public:
  /// One endpoint of this node's for each topic and direction is enough: the others are alike.
  void add_own(const WriterEndpoint& writer);
  void add_own(const ReaderEndpoint& reader);

  /// Each in words: topic, who and where from, policy, what is offered and what is asked.
  [[nodiscard]] std::vector<std::string> texts() const;

 private:
  using Guid = eprosima::fastrtps::rtps::GUID_t;
  using Prefix = eprosima::fastrtps::rtps::GuidPrefix_t;
  template <class Qos>
  struct Remote {
    Endpoint<Qos> endpoint;
    std::string address;
  };

  void on_participant_discovery(eprosima::fastdds::dds::DomainParticipant* participant,
                                eprosima::fastrtps::rtps::ParticipantDiscoveryInfo&& info) override;
  void on_subscriber_discovery(eprosima::fastdds::dds::DomainParticipant* participant,
                               eprosima::fastrtps::rtps::ReaderDiscoveryInfo&& info) override;
  void on_publisher_discovery(eprosima::fastdds::dds::DomainParticipant* participant,
                              eprosima::fastrtps::rtps::WriterDiscoveryInfo&& info) override;
  /// "'radar-1' at 10.0.0.2 (01.0f.45.d2...)".
  [[nodiscard]] std::string who_locked(const Guid& guid, const std::string& address) const;

  mutable std::mutex mutex_;
  std::map<std::string, WriterEndpoint> own_writers_;  ///< by topic
  std::map<std::string, ReaderEndpoint> own_readers_;
  std::map<Guid, Remote<eprosima::fastdds::dds::WriterQos>> writers_;
  std::map<Guid, Remote<eprosima::fastdds::dds::ReaderQos>> readers_;
  std::map<Prefix, std::string> names_;
};

}  // namespace downrange::dds
