/// Peers that are there and do not match are named: topic, policy, what is offered, what is asked, where from.
/// Domain 45.

#include <downrangePubSubTypes.h>
#include <gtest/gtest.h>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>

#include <algorithm>
#include <chrono>

#include "dds/entities.hpp"
#include "dds/inputs.hpp"
#include "dds/mismatch.hpp"
#include "dds/outputs.hpp"
#include "dds/topics.hpp"
#include "dds/wire_catalogue.hpp"
#include "dds_samples.hpp"

namespace downrange::dds {
namespace {

constexpr int domain = 45;

TEST(Mismatch, EveryPolicyThatDecidesIsNamed) {
  const WriterEndpoint writer{"range/gps", "Fix", true, {}};
  const ReaderEndpoint reader{"range/gps", "Fix", true, {}};
  const auto why = [&](const auto& change) {
    WriterEndpoint w = writer;
    ReaderEndpoint r = reader;
    change(w, r);
    return why_no_match(w, r);
  };
  const auto none = [](auto&, auto&) {};
  EXPECT_EQ(why(none), "");
  EXPECT_EQ(why([](auto& w, auto&) { w.type = "Fix2"; }), "type: Fix2 offered, Fix asked");
  EXPECT_EQ(why([](auto& w, auto&) { w.keyed = false; }), "key: no offered, yes asked");
  EXPECT_EQ(why([](auto& w, auto& r) {
              w.qos.m_reliability.kind = fdds::BEST_EFFORT_RELIABILITY_QOS;
              r.qos.m_reliability.kind = fdds::RELIABLE_RELIABILITY_QOS;
            }),
            "reliability: BEST_EFFORT offered, RELIABLE asked");
  EXPECT_EQ(why([](auto& w, auto& r) {
              w.qos.m_durability.kind = fdds::VOLATILE_DURABILITY_QOS;
              r.qos.m_durability.kind = fdds::TRANSIENT_LOCAL_DURABILITY_QOS;
            }),
            "durability: VOLATILE offered, TRANSIENT_LOCAL asked");
  EXPECT_EQ(why([](auto&, auto& r) { r.qos.m_ownership.kind = fdds::EXCLUSIVE_OWNERSHIP_QOS; }),
            "ownership: SHARED offered, EXCLUSIVE asked");
  EXPECT_EQ(why([](auto&, auto& r) {
              r.qos.m_deadline.period = {0, 100'000'000};
            }),
            "deadline: infinite offered, 0.1 s asked");
  EXPECT_EQ(why([](auto& w, auto& r) {
              w.qos.m_liveliness.lease_duration = {3, 0};
              r.qos.m_liveliness.kind = fdds::MANUAL_BY_TOPIC_LIVELINESS_QOS;
              r.qos.m_liveliness.lease_duration = {2, 0};
            }),
            "liveliness: AUTOMATIC offered, MANUAL_BY_TOPIC asked; liveliness lease: 3 s offered, 2 s asked");
  EXPECT_EQ(why([](auto& w, auto&) { w.qos.m_partition.push_back("east"); }), "partition: east offered, none asked");
  EXPECT_EQ(why([](auto&, auto& r) { r.qos.m_destinationOrder.kind = fdds::BY_SOURCE_TIMESTAMP_DESTINATIONORDER_QOS; }),
            "destination order: BY_RECEPTION_TIMESTAMP offered, BY_SOURCE_TIMESTAMP asked");
  EXPECT_EQ(why([](auto& w, auto&) {
              w.qos.m_latencyBudget.duration = {1, 0};
            }),
            "latency budget: 1 s offered, 0 s asked");
  EXPECT_EQ(why([](auto&, auto& r) { r.qos.m_presentation.access_scope = fdds::TOPIC_PRESENTATION_QOS; }),
            "presentation: INSTANCE offered, TOPIC asked");
  EXPECT_EQ(why([](auto& w, auto&) { w.qos.representation.m_value = {fdds::XCDR2_DATA_REPRESENTATION}; }),
            "data representation: XCDR2 offered, XCDR1 asked");
}

/// Another's participant.
class Stranger {
 public:
  Stranger() {
    fdds::DomainParticipantQos qos = fdds::PARTICIPANT_QOS_DEFAULT;
    qos.name("stranger");
    participant_ = fdds::DomainParticipantFactory::get_instance()->create_participant(domain, qos);
  }
  ~Stranger() {
    participant_->delete_contained_entities();
    fdds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }
  Stranger(const Stranger&) = delete;
  Stranger& operator=(const Stranger&) = delete;

  void write(const char* topic_name, const fdds::TypeSupport& type, const fdds::DataWriterQos& qos) {
    participant_->create_publisher(fdds::PUBLISHER_QOS_DEFAULT)->create_datawriter(topic(topic_name, type), qos);
  }
  void read(const char* topic_name, const fdds::TypeSupport& type, const fdds::DataReaderQos& qos) {
    participant_->create_subscriber(fdds::SUBSCRIBER_QOS_DEFAULT)->create_datareader(topic(topic_name, type), qos);
  }

 private:
  fdds::Topic* topic(const char* name, const fdds::TypeSupport& type) {
    type.register_type(participant_);
    return participant_->create_topic(name, type.get_type_name(), fdds::TOPIC_QOS_DEFAULT);
  }
  fdds::DomainParticipant* participant_;
};

TEST(Mismatch, PeersAreNamedWhileTheyAreThere) {
  Participant node(test_participant(domain, "node", ClockMode::Wall));
  const InputReader reader(node, {}, [](const Event&, const RangeStamp&, const Name&) {});
  const OutputWriters writers(node, {});
  const auto eventually = [&](const auto& condition) {
    return wait_until(std::chrono::seconds(30), [&] { return condition(node.mismatches()); });
  };
  {
    Stranger stranger;
    fdds::DataWriterQos best_effort = fdds::DATAWRITER_QOS_DEFAULT;
    best_effort.reliability().kind = fdds::BEST_EFFORT_RELIABILITY_QOS;
    stranger.write(topic_of<RadarTspi>, fdds::TypeSupport(new wire::RadarTspiV2PubSubType), best_effort);
    stranger.write(topic_of<GpsFix>, fdds::TypeSupport(new wire::RadarTspiV2PubSubType), fdds::DATAWRITER_QOS_DEFAULT);
    stranger.read(topic_of<SlavingCommand>, fdds::TypeSupport(new wire::SlavingCommandV4PubSubType),
                  fdds::DATAREADER_QOS_DEFAULT);
    stranger.read(topics::status, fdds::TypeSupport(new wire::ServiceStatusV4PubSubType), fdds::DATAREADER_QOS_DEFAULT);
    ASSERT_TRUE(eventually([](const auto& all) { return all.size() == 3; }));
    for (const auto& [begin, end] :
         {std::pair{"range/radar_tspi: writer 'stranger' at ", "): reliability: BEST_EFFORT offered, RELIABLE asked"},
          std::pair{"range/gps: writer 'stranger' at ",
                    "): type: downrange::wire::RadarTspiV2 offered, downrange::wire::GpsFixV2 asked"},
          std::pair{"downrange/slaving: reader 'stranger' at ", "): ownership: EXCLUSIVE offered, SHARED asked"}}) {
      const std::vector<std::string> all = node.mismatches();
      EXPECT_TRUE(std::ranges::any_of(
          all, [&](const std::string& text) { return text.starts_with(begin) && text.ends_with(end); }))
          << begin << all.front();
    }
  }
  EXPECT_TRUE(eventually([](const auto& all) { return all.empty(); }));
}

}  // namespace
}  // namespace downrange::dds
