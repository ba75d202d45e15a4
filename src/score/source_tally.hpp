#pragma once
/// What a flight's results say of one source: its messages and their verdicts, the errors of its plots, its health.

#include <array>
#include <cstdint>
#include <downrange/geo/time.hpp>
#include <downrange/stage/event.hpp>
#include <downrange/stage/result.hpp>
#include <map>
#include <utility>
#include <vector>

#include "score/summary.hpp"

namespace downrange::score {

/// Means of errors (range m, azimuth and elevation rad) over intervals of UTC: what noise leaves out.
class IntervalMeans {
 public:
  static constexpr Duration width = milliseconds(10'000);

  void add(Time t, const Eigen::Vector3d& error) {
    auto& [sum, count] = intervals_.try_emplace(t.ns / width.ns, Eigen::Vector3d::Zero(), 0).first->second;
    sum += error;
    ++count;
  }

  /// Per component, of the means of those intervals that have any.
  [[nodiscard]] SystematicError rms_of_means() const;

 private:
  std::map<std::int64_t, std::pair<Eigen::Vector3d, int>> intervals_;
};

/// Errors of a sensor's plots: as measured, and corrected for what was known of them.
struct PlotErrors {
  std::size_t plots = 0;
  IntervalMeans before;
  IntervalMeans after;
};

/// The same of one plot.
struct PlotError {
  Time epoch;
  Eigen::Vector3d before;
  Eigen::Vector3d after;

  void add_to(PlotErrors& errors) const {
    ++errors.plots;
    errors.before.add(epoch, before);
    errors.after.add(epoch, after);
  }
};

/// What health told of a source once a second.
struct HealthSample {
  std::uint64_t judged = 0;  ///< measurements by the method's gate since the start
  int window = 0;            ///< the last of these that the share is over
  double inside_95 = 1;
  bool mismatch = false;
};

/// Of plots.
struct Fates {
  std::size_t delivered = 0;
  std::size_t rejected = 0;
};

/// What one run says of one source.
struct SourceTally {
  std::array<std::uint64_t, reason_count> by_ingest{};
  std::uint64_t gated = 0;
  std::uint64_t frozen = 0;
  std::uint64_t excluded = 0;  ///< accepted by ingest, and not used: INTEGRITY had excluded the source
  Fates outliers;
  Fates good;
  PlotErrors of_ingest;  ///< accepted by ingest
  PlotErrors of_method;  ///< by the method too
  std::vector<HealthSample> health;
  SigmaRatios sigma_ratio{};
};

/// Adds to the score the share of NIS inside their 95 % region: of disjoint windows, from the end of the flight back.
void add_consistency(const std::vector<HealthSample>& health, SourceScore& score);

}  // namespace downrange::score
