#pragma once
/// Inside src/dds: the writers of one topic with exclusive ownership.

#include <algorithm>
#include <map>
#include <vector>

#include "dds/entities.hpp"
#include "dds/wire_catalogue.hpp"

namespace downrange::dds {

/// Liveliness is a writer's, ownership an instance's. So on the wall clock every instance that the range is known to
/// have gets a writer of its own, which is alive while that instance is written: what a node says of one antenna does
/// not keep another one, of which it has nothing to say, from hearing the next node. Instances that nobody announced
/// share one writer, and on the range clock, which knows no lease, all do.
template <class Record>
class ResultWriters {
 public:
  using Info = MessageInfo<Record>;

  ResultWriters(Participant& participant, Tally<WriteCounts>& tally, const EndpointOptions& options,
                const std::vector<OwnedKey>& instances)
      : shared_(participant, topic_of<Record>, tally, options) {
    if (participant.clock() == ClockMode::Range) return;
    for (const OwnedKey& key : instances) own_.try_emplace(key, participant, topic_of<Record>, tally, options);
  }

  void write(const Record& record) {
    to_wire(record, sample_);
    static_cast<void>(writer_of(Info::key(record)).write(sample_));  // a failure is counted by the writer
  }

  /// Readers that every writer has met.
  [[nodiscard]] int readers() const {
    int least = shared_.readers().count();
    for (const auto& [key, writer] : own_) least = std::min(least, writer.readers().count());
    return least;
  }

 private:
  using Writer = TopicWriter<PubSubTypeOf<Record>>;

  Writer& writer_of(const OwnedKey& key) {
    const auto own = own_.find(key);
    return own == own_.end() ? shared_ : own->second;
  }

  Writer shared_;
  std::map<OwnedKey, Writer> own_;
  Wire<Record> sample_;
};

}  // namespace downrange::dds
