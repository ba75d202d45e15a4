#pragma once
/// One recorded flight through one engine, and what is measured on the way.

#include <downrange/stage/event.hpp>
#include <downrange/stage/range_config.hpp>
#include <downrange/stage/result.hpp>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "experiment/residual_plot.hpp"
#include "score/errors.hpp"
#include "score/outliers.hpp"
#include "score/summary.hpp"
#include "score/truth.hpp"

namespace downrange::experiment::flights {

/// Messages as they arrived, the range they arrived at, and where the vehicle truly was.
struct RecordedFlight {
  std::string name;
  RangeConfig range;
  Name target;
  Time liftoff;
  std::vector<Event> events;  ///< in order of arrival
  std::vector<score::TruthSample> truth;
};

/// What is replayed, and how.
struct Replay {
  std::string label{};
  std::vector<Name> methods{};         ///< the first is the one whose gate and biases are looked at
  std::vector<Name> without{};         ///< radars and stations that are switched off
  std::vector<score::Phase> phases{};  ///< seconds after lift-off
  bool on_ticks = false;               ///< position on every tick of the engine; else with every measurement
  /// Every message arrives at its own epoch: each plot is the newest measurement when it comes, so that its own
  /// innovation shows. The estimate after the last event is that of the recorded order.
  bool in_order = false;
  bool points = false;  ///< the range's antennas are pointed and scored
};

/// What became of the plots that the radars sent, outliers apart.
struct GateCount {
  int outliers = 0;
  int outliers_rejected = 0;
  int plots = 0;           ///< good ones
  int plots_rejected = 0;  ///< likewise
};

/// Squares of position errors within one second; of what the covariance promises (its trace).
struct Second {
  double square = 0;
  double variance = 0;
  int count = 0;
};

struct Flown {
  Replay replay;
  score::Summary summary;
  GateCount gate;
  std::map<Name, SensorBias> bias;                       ///< of the first method, the last known
  std::map<Name, std::map<std::int64_t, Second>> error;  ///< by method and second after lift-off
  std::map<Name, score::Share> nis;  ///< per radar, in order only, of good plots; rejected ones are outside
  std::map<Name, std::map<Name, std::vector<Residual>>>
      residuals;  ///< by method and radar, likewise; azimuth on the sky

  /// Of a method, in phase `phase`. All zero where it had no track.
  [[nodiscard]] score::PositionScore position(const Name& method, std::size_t phase = 0) const;
};

/// Of its radars, told by its truth.
[[nodiscard]] std::set<score::MessageId> outliers_of(const RecordedFlight& flight);

[[nodiscard]] Flown fly(const RecordedFlight& flight, const Replay& replay);

}  // namespace downrange::experiment::flights
