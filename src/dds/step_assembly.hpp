#pragma once
/// Inside src/dds: puts the samples of a run together, step by step. Plain data: no DDS, no thread, no clock.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dds/inputs.hpp"
#include "dds/range_clock.hpp"
#include "dds/wire_catalogue.hpp"

namespace downrange::dds {

/// One step as the range clock announced it.
struct AnnouncedStep {
  Time time;
  bool end = false;
  std::map<std::pair<InputTopic, Name>, std::uint64_t> last_sequence;  ///< per source, cumulative
};

/// Samples of one run, in whatever order the topics deliver them.
class StepAssembly {
 public:
  /// `sensors`: radar plots, angles and GPS fixes are awaited; `ingest_nodes`: the observations of these are.
  StepAssembly(std::uint64_t run_id, bool sensors, const std::vector<Name>& ingest_nodes);

  void announce(std::uint64_t step, AnnouncedStep announced);
  /// `node`: of an observation.
  void add(const Event& event, std::uint64_t sequence, const Name& node);
  /// An ingest node has published `observations` in all with this step.
  void report(const Name& node, std::uint64_t step, std::uint64_t observations);

  /// First step announced so far, not yet taken; nothing when none is.
  [[nodiscard]] std::optional<std::uint64_t> first_announced() const;
  [[nodiscard]] std::uint64_t next_step() const { return next_; }
  /// What the next step lacks: topic, source, expected and received counts. Empty: it is complete. Nothing: it is not
  /// announced.
  [[nodiscard]] std::optional<std::string> missing() const;
  /// The next step, which is complete.
  [[nodiscard]] RangeStep take_next();

 private:
  /// Samples of one source, by their sequence in the run.
  struct Stream {
    std::map<std::uint64_t, Event> waiting;
    std::uint64_t taken = 0;  ///< all up to this sequence

    [[nodiscard]] std::uint64_t received(std::uint64_t last) const;
    void move_to(std::uint64_t last, std::vector<Event>& events);
  };
  struct IngestNode {
    Stream observations;
    std::map<std::uint64_t, std::uint64_t> reports;  ///< step -> observations so far
  };

  [[nodiscard]] bool awaited(InputTopic topic) const { return sensors_ || !input_info[topic].measurement; }

  std::uint64_t run_id_;
  bool sensors_;
  std::uint64_t next_ = 1;
  std::map<std::uint64_t, AnnouncedStep> steps_;
  std::map<std::pair<InputTopic, Name>, Stream> streams_;
  std::map<Name, IngestNode> ingest_nodes_;
};

}  // namespace downrange::dds
