#pragma once
/// Inside src/dds: the participant's parts, and one typed reader or writer of a topic.

#include <atomic>
#include <chrono>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "dds/convert.hpp"
#include "dds/mismatch.hpp"
#include "dds/participant.hpp"
#include "dds/wire_type.hpp"

namespace downrange::dds {

namespace fdds = eprosima::fastdds::dds;
using eprosima::fastrtps::rtps::GuidPrefix_t;

/// What one endpoint asks of DDS beyond the profile of its topic.
struct EndpointOptions {
  int strength = 0;      ///< writers of topics with exclusive ownership
  bool lossless = true;  ///< readers on the range clock: hold the writer back rather than lose a sample
};

class Participant::Impl {
 public:
  explicit Impl(const ParticipantOptions& options);
  ~Impl() = default;
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  /// Throw DdsError where the middleware refuses.
  [[nodiscard]] fdds::DataWriter* create_writer(const char* topic, const fdds::TypeSupport& type,
                                                const EndpointOptions& options, fdds::DataWriterListener& listener);
  [[nodiscard]] fdds::DataReader* create_reader(const char* topic, const fdds::TypeSupport& type,
                                                const EndpointOptions& options, fdds::DataReaderListener& listener);
  void delete_writer(fdds::DataWriter* writer);
  void delete_reader(fdds::DataReader* reader);

  Name node;
  ClockMode clock;
  std::vector<std::string> notes;
  Mismatches mismatches;  ///< outlives the participant, which calls it

 private:
  /// Deletes whatever of them was created.
  struct Entities {
    fdds::DomainParticipant* participant = nullptr;
    fdds::Publisher* publisher = nullptr;
    fdds::Subscriber* subscriber = nullptr;

    Entities() = default;
    ~Entities();
    Entities(const Entities&) = delete;
    Entities& operator=(const Entities&) = delete;
  };

  void open(int domain, const std::string& profiles);
  void read_profiles(const std::string& profiles);
  fdds::Topic* topic(const char* name, const fdds::TypeSupport& type);

  Entities entities_;
  std::mutex mutex_;                                     ///< of the next two
  std::chrono::steady_clock::time_point leaving_until_;  ///< writers that are deleted wait for their readers until then
  std::map<std::string, fdds::Topic*> topics_;
  std::map<std::string, fdds::DataWriterQos> writer_qos_;
  std::map<std::string, fdds::DataReaderQos> reader_qos_;
};

/// The participants whose endpoints an entity has met.
class Peers {
 public:
  void change(const eprosima::fastrtps::rtps::InstanceHandle_t& endpoint, int change) {
    const std::scoped_lock lock(mutex_);
    const GuidPrefix_t prefix = eprosima::fastrtps::rtps::iHandle2GUID(endpoint).guidPrefix;
    int& count = endpoints_[prefix];
    count += change;
    total_ += change;
    if (count <= 0) endpoints_.erase(prefix);
    if (change > 0) ++meetings_;
  }
  [[nodiscard]] bool has(const GuidPrefix_t& prefix) const {
    const std::scoped_lock lock(mutex_);
    return endpoints_.contains(prefix);
  }
  [[nodiscard]] int count() const {
    const std::scoped_lock lock(mutex_);
    return total_;
  }
  /// Endpoints met so far, those gone since included.
  [[nodiscard]] std::uint64_t meetings() const {
    const std::scoped_lock lock(mutex_);
    return meetings_;
  }
  [[nodiscard]] bool includes(const Peers& other) const {
    const std::scoped_lock lock(mutex_, other.mutex_);
    for (const auto& [prefix, count] : other.endpoints_) {
      if (!endpoints_.contains(prefix)) return false;
    }
    return true;
  }

 private:
  mutable std::mutex mutex_;
  std::map<GuidPrefix_t, int> endpoints_;
  int total_ = 0;
  std::uint64_t meetings_ = 0;
};

/// Counts shared by the endpoints of a group.
template <class Counts>
class Tally {
 public:
  template <class Change>
  void update(Change change) {
    const std::scoped_lock lock(mutex_);
    change(counts_);
  }
  [[nodiscard]] Counts get() const {
    const std::scoped_lock lock(mutex_);
    return counts_;
  }

 private:
  mutable std::mutex mutex_;
  Counts counts_;
};

/// Writes one topic. Thread-safe.
template <class PubSubType>
class TopicWriter final : private fdds::DataWriterListener {
 public:
  using Wire = typename PubSubType::type;

  TopicWriter(Participant& participant, const char* topic, Tally<WriteCounts>& tally,
              const EndpointOptions& options = {})
      : participant_(participant.impl()),
        topic_(topic),
        tally_(tally),
        writer_(participant_.create_writer(topic, fdds::TypeSupport(new WireType<PubSubType>), options, *this)) {}
  ~TopicWriter() override { participant_.delete_writer(writer_); }
  TopicWriter(const TopicWriter&) = delete;
  TopicWriter& operator=(const TopicWriter&) = delete;

  [[nodiscard]] bool write(const Wire& sample) {
    const auto code =
        writer_->write(const_cast<Wire*>(&sample), eprosima::fastrtps::rtps::InstanceHandle_t());  // not changed
    const bool written = code == eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK;
    tally_.update([&](WriteCounts& counts) {
      if (written) {
        ++counts.samples;
      } else {
        ++counts.failures;
        counts.last_failure = std::string(topic_) + ": write refused, code " + std::to_string(code());
      }
    });
    return written;
  }
  [[nodiscard]] const Peers& readers() const { return readers_; }

 private:
  void on_publication_matched(fdds::DataWriter*, const fdds::PublicationMatchedStatus& status) override {
    readers_.change(status.last_subscription_handle, status.current_count_change);
  }
  void on_offered_incompatible_qos(fdds::DataWriter*, const fdds::OfferedIncompatibleQosStatus&) override {
    tally_.update([](WriteCounts& counts) { ++counts.incompatible; });
  }
  void on_offered_deadline_missed(fdds::DataWriter*, const fdds::OfferedDeadlineMissedStatus& status) override {
    tally_.update([&](WriteCounts& counts) { counts.deadlines += status.total_count_change; });
  }

  Participant::Impl& participant_;
  const char* topic_;
  Tally<WriteCounts>& tally_;
  Peers readers_;
  fdds::DataWriter* writer_;
};

/// Reads one topic: hands every whole sample to the handler on the middleware's threads. The middleware holds the
/// reader's own lock around the callback, so there is no lock here that could be taken in the other order.
template <class PubSubType>
class TopicReader final : private fdds::DataReaderListener {
 public:
  using Wire = typename PubSubType::type;
  using Handler = std::function<Defect(const Wire&, const fdds::SampleInfo&)>;

  TopicReader(Participant& participant, const char* topic, Tally<ReadCounts>& tally, Handler handler,
              const EndpointOptions& options = {})
      : participant_(participant.impl()), topic_(topic), tally_(tally), handler_(std::move(handler)) {
    // The middleware may call before create_reader returns, so everything else is in place by now.
    reader_ = participant_.create_reader(topic, fdds::TypeSupport(new WireType<PubSubType>), options, *this);
  }
  ~TopicReader() override { participant_.delete_reader(reader_); }
  TopicReader(const TopicReader&) = delete;
  TopicReader& operator=(const TopicReader&) = delete;

  [[nodiscard]] const Peers& writers() const { return writers_; }

 private:
  void on_data_available(fdds::DataReader* reader) override {
    WireSample<Wire> sample;
    fdds::SampleInfo info;
    while (reader->take_next_sample(&sample, &info) == eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;  // an instance went away: no sample
      const Defect defect = sample.intact ? handler_(sample.value, info) : Defect("not in the type's format");
      tally_.update([&](ReadCounts& counts) {
        if (defect.empty()) {
          ++counts.samples;
        } else {
          ++counts.malformed;
          counts.last_malformed = std::string(topic_) + ": " + defect;
        }
      });
    }
  }
  void on_subscription_matched(fdds::DataReader*, const fdds::SubscriptionMatchedStatus& status) override {
    writers_.change(status.last_publication_handle, status.current_count_change);
  }
  void on_requested_incompatible_qos(fdds::DataReader*, const fdds::RequestedIncompatibleQosStatus&) override {
    tally_.update([](ReadCounts& counts) { ++counts.incompatible; });
  }
  void on_sample_lost(fdds::DataReader*, const fdds::SampleLostStatus& status) override {
    tally_.update([&](ReadCounts& counts) { counts.lost += status.total_count_change; });
  }

  Participant::Impl& participant_;
  const char* topic_;
  Tally<ReadCounts>& tally_;
  Handler handler_;
  Peers writers_;
  fdds::DataReader* reader_ = nullptr;
};

/// Looks every few milliseconds until `condition` holds or `timeout` has passed; whether it holds.
template <class Condition>
bool wait_until(std::chrono::milliseconds timeout, Condition condition) {
  const auto end = std::chrono::steady_clock::now() + timeout;
  while (!condition()) {
    if (std::chrono::steady_clock::now() >= end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

}  // namespace downrange::dds
