#pragma once
/// How good a flight was, against the truth: position error per phase, systematic error left per radar, pointing error
/// per antenna; what became of each source's messages, and what was found of each bias. Fed with the engine's results
/// in the order the engine made them.

#include <array>
#include <cstddef>
#include <cstdint>
#include <downrange/geo/refraction.hpp>
#include <downrange/stage/range_config.hpp>
#include <downrange/stage/result.hpp>
#include <list>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "score/phase.hpp"
#include "score/truth.hpp"

namespace downrange::score {

/// Position errors |estimate - truth| of one run and method within one phase. All zero when there was no estimate.
struct PositionScore {
  std::size_t samples = 0;
  double rms_m = 0;
  double p95_m = 0;  ///< smallest error that 95 % of the samples do not exceed
  double worst_m = 0;
  double inside_95 = 0;  ///< share of errors inside the reported 95 % ellipsoid
};

struct TrajectoryScore {
  std::string label;                  ///< "fused (song2015)", "goheung alone"
  std::vector<PositionScore> phases;  ///< one per phase of the summary
};

/// Systematic error: rms of the 10 s means of measured - true, plots within the phases that are not outliers.
struct SystematicError {
  double range_m = 0;
  double azimuth_rad = 0;  ///< times cos elevation: on the sky
  double elevation_rad = 0;
};

struct RadarScore {
  Name sensor;
  std::size_t plots = 0;     ///< accepted by ingest, within a phase, truth known, planted outliers left out
  std::size_t rejected = 0;  ///< by ingest, for whatever reason
  SystematicError before;    ///< as measured
  SystematicError after;     ///< with the bias known when the plot arrived, and refraction, taken out
};

/// Angle between the commanded and the true direction at the instant of application.
struct PointingScore {
  Name antenna;
  SlavingSource source = SlavingSource::Fused;
  std::size_t commands = 0;
  std::size_t held = 0;  ///< of these, held at the end of the antenna's travel: counted, not scored
  double rms_rad = 0;
  double p95_rad = 0;
  double worst_rad = 0;
  double inside_2_sigma = 0;  ///< share of azimuth and elevation errors within 2 sigma (right: 0.954)
  double mean_age_s = 0;
  double worst_age_s = 0;
};

/// What became of one source's messages in the whole flight, whatever their target, and how they fit the first method.
struct SourceScore {
  Name sensor;
  ObservationKind kind = ObservationKind::Radar;
  /// By Reason: ingest's, and of the newest health record the method's. [Accepted] stood after both.
  std::array<std::uint64_t, reason_count> count{};
  std::size_t outliers = 0;  ///< planted: marked, and delivered
  /// Of these, by ingest or, when they arrived, by the method. None: not told, for the first method answers no plot (no
  /// biases, and trajectories on the tick).
  std::optional<std::size_t> outliers_rejected = 0;
  /// NIS inside their 95 % region: of as many disjoint windows of health records as the flight holds. Between two of
  /// them up to a second's messages are left out, and nothing is counted twice.
  std::uint64_t nis_count = 0;
  double nis_inside_95 = 0;                     ///< share of these
  std::optional<double> least_nis_inside_95{};  ///< of a full window of the mismatch alarm; none: none was filled
  int mismatch_s = 0;                           ///< how long the alarm rang
};

struct Summary {
  std::vector<Phase> phases;
  std::vector<TrajectoryScore> trajectories;  ///< as open_run says
  std::vector<RadarScore> radars;             ///< of the first run, in the range's order
  std::vector<PointingScore> pointing;        ///< of the first run, in the range's order, by source
  Name method;                                ///< whose the rest is: the range's first
  std::vector<SourceScore> sources;           ///< of the first run: radars, trackers, stations, in the range's order
  std::vector<SensorBias> biases;             ///< the last of the first run; radars, trackers, in the range's order
};

class Scorer {
 public:
  /// Results of other targets than `target` are left out, as are results at times without truth. `liftoff` anchors the
  /// phases.
  Scorer(const RangeConfig& range, const Name& target, TruthFunction truth, Time liftoff, std::vector<Phase> phases);
  ~Scorer();
  Scorer(const Scorer&) = delete;
  Scorer& operator=(const Scorer&) = delete;

  /// Opens a run and returns where its results go; valid as long as the scorer. The first run is the service's own: its
  /// primary method is a row "label (method)", a method beside it a row "method"; its radars and antennas are scored.
  /// Runs to compare follow ("goheung alone"): of those the primary method's trajectory counts.
  [[nodiscard]] ResultSink& open_run(const std::string& label);

  /// This plot of a radar is a planted outlier: no part of its systematic error. Before the plot is emitted.
  void mark_outlier(const Name& sensor, std::uint64_t sequence) { outliers_.emplace(sensor, sequence); }

  [[nodiscard]] Summary summary() const;

 private:
  class Run;
  [[nodiscard]] bool in_a_phase(Time t) const;
  [[nodiscard]] Name first_method() const;

  RangeConfig range_;
  Name target_;
  TruthFunction truth_;
  Time liftoff_;
  std::vector<Phase> phases_;
  std::map<Name, RefractionTable> air_;  ///< of radars whose refraction the range models
  std::set<std::pair<Name, std::uint64_t>> outliers_;
  std::list<Run> runs_;
};

/// Plain text tables of at most 100 columns for a range engineer.
[[nodiscard]] std::string format_text(const Summary& summary);

/// The same numbers, SI and radians.
[[nodiscard]] std::string format_json(const Summary& summary);

}  // namespace downrange::score
