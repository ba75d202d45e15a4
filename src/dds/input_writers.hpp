#pragma once
/// Inside src/dds: the writers of the inputs, whose readers the range clock driver must know.

#include <optional>

#include "dds/entities.hpp"
#include "dds/inputs.hpp"
#include "dds/wire_catalogue.hpp"

namespace downrange::dds {

class InputWriters::Impl {
 public:
  explicit Impl(Participant& participant) {
    Inputs::for_each(
        [&]<class Input>() { std::get<Output<Input>>(outputs_).writer.emplace(participant, topic_of<Input>, tally); });
  }

  [[nodiscard]] bool write(const Event& event, const RangeStamp& stamp);

  [[nodiscard]] const Peers& readers(InputTopic topic) const;

  Tally<WriteCounts> tally;

 private:
  template <class Record>
  struct Output {
    std::optional<TopicWriter<PubSubTypeOf<Record>>> writer;  ///< always there, made by the constructor
    Wire<Record> sample;
  };

  Inputs::Tuple<Output> outputs_;
};

}  // namespace downrange::dds
