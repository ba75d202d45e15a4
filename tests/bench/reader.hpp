#pragma once
/// For the benchmarks over DDS: a reader that tells when each sample was written and when it was here, from outside of
/// the library that is measured.

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <functional>
#include <utility>

namespace downrange::bench {

namespace fdds = eprosima::fastdds::dds;
using eprosima::fastrtps::types::ReturnCode_t;
using Ns = long long;

inline Ns utc_now_ns() { return std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count(); }

/// A node with the profiles of the service; ends the program where there is none to be had.
inline fdds::DomainParticipant& participant_in(const char* domain, const char* profiles) {
  auto* factory = fdds::DomainParticipantFactory::get_instance();
  if (factory->load_XML_profiles_file(profiles) == ReturnCode_t::RETCODE_OK) {
    auto* participant =
        factory->create_participant_with_profile(static_cast<fdds::DomainId_t>(std::atoi(domain)), "downrange");
    if (participant != nullptr) return *participant;
  }
  std::fprintf(stderr, "no participant in domain %s with the profiles of %s\n", domain, profiles);
  std::exit(2);
}

inline fdds::Topic* topic(fdds::DomainParticipant& participant, const char* name, const fdds::TypeSupport& type) {
  if (participant.find_type(type.get_type_name()).empty()) type.register_type(&participant);
  return participant.create_topic(name, type.get_type_name(), fdds::TOPIC_QOS_DEFAULT);
}

/// Calls `taken` with each sample, when it was written and when it is here, on the middleware's thread.
template <class Sample, class PubSubType>
class Reader final : public fdds::DataReaderListener {
 public:
  using Taken = std::function<void(const Sample&, Ns written, Ns here)>;

  Reader(fdds::DomainParticipant& participant, const char* name, const char* profile, Taken taken)
      : taken_(std::move(taken)) {
    fdds::Subscriber* subscriber = participant.create_subscriber(fdds::SUBSCRIBER_QOS_DEFAULT);
    reader_ = subscriber->create_datareader_with_profile(topic(participant, name, fdds::TypeSupport(new PubSubType)),
                                                         profile, this, fdds::StatusMask::data_available());
    if (reader_ == nullptr) {
      std::fprintf(stderr, "no reader of %s\n", name);
      std::exit(2);
    }
  }

  void on_data_available(fdds::DataReader* reader) override {
    fdds::SampleInfo info;
    while (reader->take_next_sample(&sample_, &info) == ReturnCode_t::RETCODE_OK) {
      const Ns here = utc_now_ns();
      if (info.valid_data) taken_(sample_, info.source_timestamp.to_ns(), here);
    }
  }

 private:
  Taken taken_;
  Sample sample_;
  fdds::DataReader* reader_ = nullptr;
};

}  // namespace downrange::bench
