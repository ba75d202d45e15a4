#pragma once
/// Inside src/dds: the writers of one topic with exclusive ownership.

#include <downrange/geo/time.hpp>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "dds/entities.hpp"

namespace downrange::dds {

/// Liveliness is a writer's, ownership an instance's. So on the wall clock every instance that the range is known to
/// have gets a writer of its own, which is alive while that instance is written: what a node says of one antenna does
/// not keep another one, of which it has nothing to say, from hearing the next node. Instances that nobody announced
/// share one writer, and on the range clock, which knows no lease, all do.
template <class PubSubType>
class ResultWriters {
 public:
  using Wire = typename PubSubType::type;
  using Key = std::pair<Name, Name>;

  ResultWriters(Participant& participant, const char* topic, Tally<WriteCounts>& tally, const EndpointOptions& options,
                const std::vector<Key>& instances)
      : shared_(participant, topic, tally, options) {
    if (participant.clock() == ClockMode::Range) return;
    for (const Key& key : instances) own_.try_emplace(key, participant, topic, tally, options);
  }

  /// `now`: the engine's time.
  void write(const Key& key, const Wire& sample, Time now) {
    static_cast<void>(writer_of(key).write(sample));  // a failure is counted by the writer
    spoken_[key] = now;
  }

  /// Gives up the instances that were not written for longer than the topic's deadline; `set_key(key, sample)` makes a
  /// sample of one. A reader of Fast DDS lets go of them at once. Others cannot read the key out of its hash and let go
  /// when the lease ends.
  template <class SetKey>
  void release_silent(Time now, SetKey set_key) {
    const std::optional<Duration> deadline = shared_.deadline();
    if (!deadline) return;
    std::erase_if(spoken_, [&](const auto& instance) {
      const auto& [key, spoken_at] = instance;
      if (now - spoken_at <= *deadline) return false;
      Wire sample;
      set_key(key, sample);
      writer_of(key).release(sample);
      return true;
    });
  }

  /// Readers that every writer has met.
  [[nodiscard]] int readers() const {
    int least = shared_.readers().count();
    for (const auto& [key, writer] : own_) least = std::min(least, writer.readers().count());
    return least;
  }

 private:
  TopicWriter<PubSubType>& writer_of(const Key& key) {
    const auto own = own_.find(key);
    return own == own_.end() ? shared_ : own->second;
  }

  TopicWriter<PubSubType> shared_;
  std::map<Key, TopicWriter<PubSubType>> own_;
  std::map<Key, Time> spoken_;  ///< what this node speaks for, and when it last did
};

}  // namespace downrange::dds
