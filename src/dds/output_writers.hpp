#pragma once
/// Inside src/dds: the writers of the results, and what the range clock follower tells them.

#include <atomic>
#include <optional>

#include "dds/entities.hpp"
#include "dds/outputs.hpp"
#include "dds/range_clock.hpp"
#include "dds/result_writers.hpp"

namespace downrange::dds {

class OutputWriters::Impl {
 public:
  Impl(Participant& participant, const OutputOptions& options);

  void emit(const Result& result);
  void publish(const ServiceStatus& status);
  void release_silent(Time last_tick);
  [[nodiscard]] int slaving_readers() const { return results_ ? results_->slaving.readers() : 0; }
  [[nodiscard]] bool matched(int readers) const;

  /// Around the events of a step: its observations are stamped, then their number so far is reported.
  void begin_step(const RangeStep& step);
  void end_step();
  /// Between runs: tells every centre node once that its readers are met, so that nothing of the next run is lost.
  /// A reader of the progress reads the observations too, so it hears of the progress only when both are met.
  void greet_centres();

  Tally<WriteCounts> tally;

 private:
  struct ObservationOutput {
    ObservationOutput(Participant& participant, Tally<WriteCounts>& tally);
    TopicWriter<wire::ObservationPubSubType> observation;
    TopicWriter<wire::IngestProgressPubSubType> progress;
    wire::Observation sample;
    wire::IngestProgress report;
    std::uint64_t greeted = 0;  ///< readers of the progress met at the last greeting
  };
  struct ResultOutput {
    ResultOutput(Participant& participant, Tally<WriteCounts>& tally, const OutputOptions& options);
    ResultWriters<wire::SensorBiasPubSubType> bias;
    ResultWriters<wire::TrajectoryPubSubType> trajectory;
    ResultWriters<wire::SlavingCommandPubSubType> slaving;
    wire::SensorBias bias_sample;
    wire::Trajectory trajectory_sample;
    wire::SlavingCommand slaving_sample;
  };

  void write(const Observation& observation);
  void write(const SensorBias& bias);
  void write(const Trajectory& trajectory);
  void write(const SlavingCommand& command);
  void write(const SourceHealth& health);
  /// A failed write is counted by the writer, and shows in the node's status.
  template <class Writer, class Sample>
  static void send(Writer& writer, const Sample& sample) {
    static_cast<void>(writer.write(sample));
  }

  const ClockMode clock_;
  const Name node_;
  std::optional<ObservationOutput> observations_;
  std::optional<ResultOutput> results_;
  TopicWriter<wire::SourceHealthPubSubType> health_;
  TopicWriter<wire::ServiceStatusPubSubType> status_;
  wire::SourceHealth health_sample_;
};

}  // namespace downrange::dds
