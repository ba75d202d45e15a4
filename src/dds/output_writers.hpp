#pragma once
/// Inside src/dds: the writers of the results, and what the range clock follower tells them.

#include <optional>

#include "dds/entities.hpp"
#include "dds/outputs.hpp"
#include "dds/range_clock.hpp"
#include "dds/result_writers.hpp"
#include "dds/topics.hpp"
#include "dds/wire_catalogue.hpp"

namespace downrange::dds {

class OutputWriters::Impl {
 public:
  Impl(Participant& participant, const OutputOptions& options);

  void emit(const Result& result);
  void publish(const ServiceStatus& status);
  [[nodiscard]] int slaving_readers() const { return readers<SlavingCommand>(); }
  [[nodiscard]] bool matched(int least) const;

  /// Around the events of a step: its observations are stamped, then their number so far is reported.
  void begin_step(const RangeStep& step);
  void end_step();
  /// Between runs: tells every centre node once that its readers are met, so that nothing of the next run is lost.
  /// A reader of the progress reads the observations too, so it hears of the progress only when both are met.
  void greet_centres();

  Tally<WriteCounts> tally;

 private:
  /// What every node writes for itself.
  template <class Record>
  class PlainWriter {
   public:
    PlainWriter(Participant& participant, Tally<WriteCounts>& tally) : writer_(participant, topic_of<Record>, tally) {}

    [[nodiscard]] Wire<Record>& sample() { return sample_; }
    [[nodiscard]] const Peers& peers() const { return writer_.readers(); }
    [[nodiscard]] int readers() const { return writer_.readers().count(); }
    void send() { static_cast<void>(writer_.write(sample_)); }  // a failure is counted by the writer

   private:
    TopicWriter<PubSubTypeOf<Record>> writer_;
    Wire<Record> sample_;
  };
  template <class Record>
  static constexpr bool owned = MessageInfo<Record>::delivery == Delivery::Owned;
  /// None: this node does not publish it.
  template <class Record>
  using Output = std::optional<std::conditional_t<owned<Record>, ResultWriters<Record>, PlainWriter<Record>>>;

  /// Beside the observations: on the range clock, how many there are of each step.
  struct Progress {
    Progress(Participant& participant, Tally<WriteCounts>& tally)
        : writer(participant, topics::ingest_progress, tally) {}
    TopicWriter<wire::IngestProgressV2PubSubType> writer;
    wire::IngestProgressV2 report;
    std::uint64_t greeted = 0;  ///< readers of the progress met at the last greeting
  };

  template <class Record>
  [[nodiscard]] Output<Record>& output() {
    return std::get<Output<Record>>(outputs_);
  }
  template <class Record>
  [[nodiscard]] int readers() const {
    const auto& writer = std::get<Output<Record>>(outputs_);
    return writer ? writer->readers() : 0;
  }
  template <class Record>
  void write(const Record& record);
  /// On the range clock: which step and which of the node's observations it is.
  void stamp(Wire<Observation>& sample);

  const ClockMode clock_;
  const Name node_;
  Outputs::Tuple<Output> outputs_;
  std::optional<Progress> progress_;
  TopicWriter<wire::ServiceStatusV4PubSubType> status_;
};

}  // namespace downrange::dds
