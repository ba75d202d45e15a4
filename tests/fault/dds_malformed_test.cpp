/// Payloads that no correct sender makes: dropped with a reason, never a crash, and the next good sample arrives.
/// Domains 50 and 51.

#include <gtest/gtest.h>

#include <vector>

#include "dds/convert.hpp"
#include "dds/entities.hpp"
#include "dds/inputs.hpp"
#include "dds/range_clock.hpp"
#include "dds/topics.hpp"
#include "dds/wire_type.hpp"
#include "dds_inbox.hpp"
#include "dds_samples.hpp"

namespace downrange::dds {
namespace {

using std::chrono::seconds;
using Bytes = std::vector<std::uint8_t>;
using Payload = eprosima::fastrtps::rtps::SerializedPayload_t;

/// Sends any bytes under the name of a type.
class RawType final : public fdds::TopicDataType {
 public:
  RawType(const char* name, bool keyed) {
    setName(name);
    m_typeSize = 4096;
    m_isGetKeyDefined = keyed;
  }
  bool serialize(void* data, Payload* payload) override {
    const Bytes& bytes = *static_cast<Bytes*>(data);
    std::copy(bytes.begin(), bytes.end(), payload->data);
    payload->length = static_cast<std::uint32_t>(bytes.size());
    return true;
  }
  bool deserialize(Payload*, void*) override { return false; }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<Bytes*>(data)->size()); };
  }
  void* createData() override { return new Bytes; }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void*, eprosima::fastrtps::rtps::InstanceHandle_t* handle, bool) override {
    for (unsigned i = 0; i < 16; ++i) handle->value[i] = static_cast<std::uint8_t>(i + 1);
    return true;
  }
};

class RawWriter {
 public:
  RawWriter(Participant& participant, const char* topic, const char* type, bool keyed)
      : participant_(participant.impl()),
        writer_(participant_.create_writer(topic, fdds::TypeSupport(new RawType(type, keyed)), {}, listener_)) {}
  ~RawWriter() { participant_.delete_writer(writer_); }
  RawWriter(const RawWriter&) = delete;
  RawWriter& operator=(const RawWriter&) = delete;
  [[nodiscard]] bool write(Bytes bytes) { return writer_->write(&bytes); }
  [[nodiscard]] bool matched() const {
    fdds::PublicationMatchedStatus status;
    writer_->get_publication_matched_status(status);
    return status.current_count > 0;
  }

 private:
  Participant::Impl& participant_;
  fdds::DataWriterListener listener_;
  fdds::DataWriter* writer_;
};

template <class PubSubType>
Bytes serialized(typename PubSubType::type& sample) {
  PubSubType type;
  Payload payload(type.m_typeSize);
  EXPECT_TRUE(type.serialize(&sample, &payload));
  return {payload.data, payload.data + payload.length};
}

TEST(DdsMalformed, EveryTruncationAndEveryBrokenByte) {
  Participant attacker(test_participant(50, "attacker", ClockMode::Wall));
  Participant service(test_participant(50, "service", ClockMode::Wall));
  Inbox<Event> inbox;
  InputReader reader(service, {}, [&](const Event& event, const RangeStamp&, const Name&) { inbox.add(event); });
  RawWriter writer(attacker, topic_of<RadarTspi>, "downrange::wire::RadarTspiV2", true);
  ASSERT_TRUE(wait_until(seconds(30), [&] { return writer.matched(); }));

  wire::RadarTspiV2 plot;
  to_wire(sample_plot(), plot);
  const Bytes good = serialized<wire::RadarTspiV2PubSubType>(plot);
  // Every sample is waited for: a reader that keeps the last ones only must not drop what is to be tested.
  std::uint64_t sent = 0;
  const auto send = [&](const Bytes& bytes) {
    ASSERT_TRUE(writer.write(bytes));
    ++sent;
    ASSERT_TRUE(wait_until(seconds(30),
                           [&] {
                             const ReadCounts counts = reader.counts();
                             return counts.samples + counts.malformed == sent;
                           }))
        << "sample " << sent;
  };
  for (std::size_t length = 4; length < good.size(); ++length) {
    send({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(length)});
  }
  EXPECT_EQ(reader.counts().malformed, good.size() - 4 - 3) << "DDS pads a payload to 4 bytes: 3 truncations are none";
  EXPECT_EQ(reader.counts().last_malformed, "range/radar_tspi: not in the type's format");
  for (std::size_t i = 0; i < good.size(); ++i) {
    Bytes broken = good;
    broken[i] = 0xff;
    send(broken);
  }
  send(good);
  ASSERT_TRUE(inbox.wait([](const auto& events) { return !events.empty(); }));
  RadarTspi arrived = std::get<RadarTspi>(inbox.items().back());
  arrived.received = sample_plot().received;
  EXPECT_TRUE(arrived == sample_plot());
}

TEST(DdsMalformed, EnumeratorsOutOfRangeAndLiveSamplesFromARun) {
  wire::RadarTspiV2 plot;
  to_wire(sample_plot(), plot);
  plot.mode(static_cast<wire::TrackMode>(5));
  RadarTspi read_plot;
  EXPECT_EQ(from_wire(plot, read_plot), "mode holds enumerator 5");

  wire::AngleTspiV2 angles;
  to_wire(sample_angles(), angles);
  angles.mode(static_cast<wire::TrackMode>(7));
  AngleTspi read_angles;
  EXPECT_EQ(from_wire(angles, read_angles), "mode holds enumerator 7");

  wire::GpsFixV2 fix;
  to_wire(sample_fix(), fix);
  fix.fix(static_cast<wire::FixType>(0xffffffff));
  GpsFix read_fix;
  EXPECT_EQ(from_wire(fix, read_fix), "fix holds enumerator 4294967295");

  wire::ObservationV2 observation;
  to_wire(sample_observation(), observation);
  observation.verdict(reason_count);
  Observation read_observation;
  EXPECT_EQ(from_wire(observation, read_observation), "verdict holds enumerator " + std::to_string(reason_count));

  wire::SensorBiasV2 bias;
  to_wire(test::sample<SensorBias>(), bias);
  bias.terms(max_bias_terms + 1);
  SensorBias read_bias;
  EXPECT_EQ(from_wire(bias, read_bias), "terms is 14");

  wire::TrajectoryV2 trajectory;
  to_wire(test::sample<Trajectory>(), trajectory);
  trajectory.state_size(7);
  Trajectory read_trajectory;
  EXPECT_EQ(from_wire(trajectory, read_trajectory), "state_size is 7");

  wire::SlavingCommandV4 command;
  to_wire(sample_command(), command);
  command.antenna_id() = "";
  SlavingCommand read_command;
  EXPECT_EQ(from_wire(command, read_command), "antenna_id is empty");
}

TEST(DdsMalformed, AClockThatClaimsFourThousandMillionSources) {
  Participant attacker(test_participant(51, "attacker", ClockMode::Range));
  Participant service(test_participant(51, "service", ClockMode::Range));
  RangeClockFollower follower(service, {}, nullptr);
  RawWriter writer(attacker, topics::clock, "downrange::wire::RangeClockV2", false);
  ASSERT_TRUE(wait_until(seconds(30), [&] { return writer.matched(); }));
  wire::RangeClockV2 clock;
  clock.run_id(5);
  clock.step(1);
  clock.time_ns(99);
  const Bytes good = serialized<wire::RangeClockV2PubSubType>(clock);
  ASSERT_EQ(good.size(), 36U) << "encapsulation, 28 bytes, the length";
  Bytes huge = good;
  std::fill(huge.end() - 4, huge.end(), std::uint8_t{0xff});
  ASSERT_TRUE(writer.write(huge));
  ASSERT_TRUE(writer.write(good));
  std::optional<RangeStep> step;
  ASSERT_TRUE(
      wait_until(seconds(30), [&] { return (step = follower.next(std::chrono::milliseconds(10))).has_value(); }));
  EXPECT_EQ(step->time, Time{99});
  EXPECT_EQ(follower.counts().malformed, 1U);
}

/// As a reader reads it.
template <class PubSubType>
bool intact(const Bytes& bytes) {
  WireType<PubSubType> type;
  Payload payload(static_cast<std::uint32_t>(bytes.size()));
  std::copy(bytes.begin(), bytes.end(), payload.data);
  payload.length = static_cast<std::uint32_t>(bytes.size());
  payload.encapsulation = bytes[1] == 0 ? CDR_BE : CDR_LE;
  WireSample<typename PubSubType::type> sample;
  EXPECT_TRUE(type.deserialize(&payload, &sample));
  return sample.intact;
}

TEST(DdsMalformed, AnIntegrityRecordThatClaimsMoreSourcesThanThereAre) {
  using Type = wire::IntegrityV3PubSubType;
  for (const char* name : {"k", "ks", "ksl", "kslv"}) {  // each with other padding
    Integrity record = test::sample<Integrity>();
    record.target = name;
    record.chain = name;
    record.sources.clear();
    wire::IntegrityV3 sample;
    to_wire(record, sample);
    Bytes bytes = serialized<Type>(sample);
    EXPECT_TRUE(intact<Type>(bytes)) << name;
    ASSERT_TRUE(std::all_of(bytes.end() - 4, bytes.end(), [](auto b) { return b == 0; })) << "the length comes last";
    std::fill(bytes.end() - 4, bytes.end(), std::uint8_t{0xff});
    EXPECT_FALSE(intact<Type>(bytes)) << name;
    bytes.resize(bytes.size() - 4);
    EXPECT_FALSE(intact<Type>(bytes)) << name << ": no length";
  }
  wire::IntegrityV3 sample;
  to_wire(test::sample<Integrity>(), sample);
  const Bytes good = serialized<Type>(sample);
  EXPECT_TRUE(intact<Type>(good));
  for (std::size_t length = 4; length + 3 < good.size(); ++length)
    EXPECT_FALSE(intact<Type>({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(length)})) << length;
}

TEST(DdsMalformed, AnImpactPointThatClaimsMoreBoundariesThanThereAre) {
  using Type = wire::ImpactPointV3PubSubType;
  for (const char* name : {"k", "ks", "ksl", "kslv"}) {  // each with other padding
    ImpactPoint record = test::sample<ImpactPoint>();
    record.target = name;
    record.chain = name;
    record.boundaries.clear();
    wire::ImpactPointV3 sample;
    to_wire(record, sample);
    Bytes bytes = serialized<Type>(sample);
    EXPECT_TRUE(intact<Type>(bytes)) << name;
    ASSERT_TRUE(std::all_of(bytes.end() - 4, bytes.end(), [](auto b) { return b == 0; })) << "the length comes last";
    std::fill(bytes.end() - 4, bytes.end(), std::uint8_t{0xff});
    EXPECT_FALSE(intact<Type>(bytes)) << name;
  }
  wire::ImpactPointV3 sample;
  to_wire(test::sample<ImpactPoint>(), sample);
  const Bytes good = serialized<Type>(sample);
  EXPECT_TRUE(intact<Type>(good));
  for (std::size_t length = 4; length + 3 < good.size(); ++length)
    EXPECT_FALSE(intact<Type>({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(length)})) << length;
}

}  // namespace
}  // namespace downrange::dds
